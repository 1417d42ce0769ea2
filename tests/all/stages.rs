//! Changes of structure in a run, by the laws that hold through them whatever the integrator: momentum, Carnot's theorem, and
//! that what is open is not there.

use crate::common::{Options, Random, build, random_scene};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::collections::BTreeSet;
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::model::couplings::{Closure, LoopDescription};
use stillpoint::model::description::{
    Attachment, Description, HingeDescription, HingeKind, Point, StageDescription, When,
};
use stillpoint::record::Fanout;
use stillpoint::scenario::{self, Scenario};
use stillpoint::simulate::events::Kind;
use stillpoint::simulate::{self, Integrator, Settings, State, Summary};

mod cables;
mod drives;
mod ends;
mod flying;
mod input;
mod latches;
mod launcher;
mod together;

const OPTIONS: Options = Options { bodies: 5, springs: false, welds: true };

fn settings(duration: f64) -> Settings {
    Settings {
        duration,
        integrator: Integrator::Method(Method::Dop853),
        tolerance: 1e-12,
        absolute_tolerance: 1e-13,
        ..Settings::default()
    }
}

fn given(model: &Model) -> State {
    State { position: model.start_position.clone(), velocity: model.start_velocity.clone() }
}

fn ran(model: &Arc<Model>, start: &State, duration: f64) -> Summary {
    simulate::run(model, &settings(duration), 1.0, start, &mut Fanout::new(), &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// One body at an instant.
#[derive(Debug, Clone, Copy)]
struct Moving {
    mass: f64,
    center: Vector3<f64>,
    velocity: Vector3<f64>,
    turning: Vector3<f64>,
    inertia: Matrix3<f64>,
}

impl Moving {
    /// Angular momentum about the origin.
    fn spin(&self) -> Vector3<f64> {
        self.mass * self.center.cross(&self.velocity) + self.inertia * self.turning
    }

    fn kinetic(velocity: &Vector3<f64>, turning: &Vector3<f64>, of: &Self) -> f64 {
        0.5 * of.mass * velocity.norm_squared() + 0.5 * turning.dot(&(of.inertia * turning))
    }
}

/// The bodies of a scene by its description, moving as a model says.
fn bodies(description: &Description, model: &Arc<Model>, state: &State) -> Vec<Moving> {
    let mut system = System::new(model);
    let at = system.at(0.0, &state.position, &state.velocity);
    let mut poses = Vec::new();
    at.poses(&mut poses);
    let body = |body: &stillpoint::model::description::BodyDescription| {
        let index = model.bodies.iter().position(|one| one.name == body.name).expect("the body");
        let (pose, link) = (&poses[index], &at.motion().links[model.bodies[index].link]);
        let turn = pose.rotation.to_rotation_matrix().into_inner();
        let center = pose.translation.vector + turn * body.mass.center;
        let velocity = link.velocity + link.angular_velocity.cross(&(center - link.position));
        let inertia = turn * body.mass.inertia * turn.transpose();
        Moving { mass: body.mass.mass, center, velocity, turning: link.angular_velocity, inertia }
    };
    description.bodies.iter().map(body).collect()
}

/// Mass, centre, momentum, and angular momentum about the centre.
fn whole(of: &[Moving]) -> (f64, Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let mass: f64 = of.iter().map(|one| one.mass).sum();
    let center = of.iter().map(|one| one.mass * one.center).sum::<Vector3<f64>>() / mass;
    let momentum: Vector3<f64> = of.iter().map(|one| one.mass * one.velocity).sum();
    let spin: Vector3<f64> = of.iter().map(Moving::spin).sum();
    (mass, center, momentum, spin - center.cross(&momentum))
}

/// The bodies that hang on one, itself first.
fn subtree(description: &Description, root: usize) -> BTreeSet<usize> {
    let mut found = BTreeSet::from([root]);
    for (index, body) in description.bodies.iter().enumerate() {
        if found.iter().any(|one| description.bodies[*one].name == body.hinge.parent) {
            found.insert(index);
        }
    }
    found
}

fn stage(when: f64) -> StageDescription {
    StageDescription::new("change", When::Time(when))
}

/// What opens flies: its centre along a parabola, with the angular momentum that it has. What stays moves as if the other had
/// never been there, from the state at that instant on.
#[test]
fn what_opens_flies_and_what_stays_does_not_feel_it() {
    for seed in 0..60 {
        let description = random_scene(seed + 9000, &OPTIONS);
        let mut random = Random::new(seed);
        let (when, after) = (random.between(0.02, 0.1), 0.1);
        let root = random.below(OPTIONS.bodies);
        let mut staged = description.clone();
        let mut open = stage(when);
        open.open.push(description.bodies[root].name.clone());
        staged.stages.push(open);
        let plain = build(&description);
        let model = build(&staged);
        let then = ran(&plain, &given(&plain), when).state;
        let found = ran(&model, &given(&model), when + after);
        assert_eq!((found.events.len(), found.end_time), (1, when + after), "seed {seed}");
        let size = found.energy_start.abs() + 10.0;
        assert!(found.energy_drift < 1e-10 * size, "seed {seed}: {:e} J unaccounted for", found.energy_drift);
        let free = subtree(&description, root);
        let part = |all: &[Moving]| -> Vec<Moving> { free.iter().map(|body| all[*body]).collect() };
        let (mass, center, momentum, spin) = whole(&part(&bodies(&description, &plain, &then)));
        let (_, at, now, turning) = whole(&part(&bodies(&description, &found.model, &found.state)));
        let fall = center + momentum / mass * after + 0.5 * after * after * description.gravity;
        assert!((at - fall).norm() < 1e-10, "seed {seed}: the centre is {:e} m beside", (at - fall).norm());
        assert!((now - momentum - after * mass * description.gravity).norm() < 1e-9, "seed {seed}");
        assert!((turning - spin).norm() < 1e-9 * (1.0 + spin.norm()), "seed {seed}: {turning} {spin}");
        if free.len() == OPTIONS.bodies {
            continue;
        }
        let mut left = description.clone();
        left.bodies =
            (0..OPTIONS.bodies).filter(|b| !free.contains(b)).map(|b| description.bodies[b].clone()).collect();
        let alone = build(&left);
        let mut start = given(&alone);
        for body in &alone.bodies {
            let other = &plain.bodies[plain.body(&body.name).expect("the body")].hinge;
            let (p, v) = body.hinge.kind.counts();
            start.position[body.hinge.position..][..p].copy_from_slice(&then.position[other.position..][..p]);
            start.velocity[body.hinge.velocity..][..v].copy_from_slice(&then.velocity[other.velocity..][..v]);
        }
        let expected = ran(&alone, &start, after);
        let [stays, alone] =
            [(&found.model, &found.state), (&alone, &expected.state)].map(|(m, s)| bodies(&left, m, s));
        for (one, other) in stays.iter().zip(&alone) {
            let apart = (one.center - other.center).norm() + (one.velocity - other.velocity).norm();
            assert!(apart < 1e-8, "seed {seed}: {apart:e}");
        }
    }
}

/// Bodies that fly freely and are joined in a point that they share: momentum and angular momentum stay, and the energy that is
/// lost is that of the velocities that are lost (Carnot).
#[test]
fn what_closes_exchanges_momentum_and_loses_what_carnot_says() {
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let mut description = random_scene(seed + 9500, &Options { bodies: 3, ..OPTIONS });
        description.gravity = Vector3::zeros();
        for body in &mut description.bodies {
            let turn = random.turn();
            let at = random.vector(1.0);
            body.hinge = HingeDescription {
                position: vec![at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k],
                velocity: random.list(6, -1.0, 1.0),
                ..HingeDescription::new(HingeKind::Free)
            };
        }
        let when = random.between(0.1, 0.4);
        let plain = build(&description);
        let then = ran(&plain, &given(&plain), when).state;
        // A point that two bodies have in common then.
        let (mut poses, mut system) = (Vec::new(), System::new(&plain));
        system.at(0.0, &then.position, &then.velocity).poses(&mut poses);
        let on = random.vector(0.5);
        let meets = poses[1].inverse_transform_point(&poses[0].transform_point(&on.into())).coords;
        let kind =
            [HingeKind::Fixed, HingeKind::Spherical, HingeKind::Revolute { axis: Vector3::x() }][random.below(3)];
        let end = |body: usize, at: Vector3<f64>| Attachment {
            body: description.bodies[body].name.clone(),
            point: Point::At(at),
        };
        let mut staged = description.clone();
        staged.loops.push(LoopDescription {
            name: "joint".to_owned(),
            closure: Closure::Hinge(kind),
            between: [end(0, on), end(1, meets)],
            frame: random.turn(),
            second_frame: None,
        });
        let mut close = stage(when);
        close.close.push("joint".to_owned());
        staged.stages.push(close);
        let model = Model::build(&staged).unwrap_or_else(|problems| panic!("seed {seed}: {problems:?}"));
        let found = ran(&model, &given(&model), when + 1e-9);
        let before = bodies(&description, &plain, &then);
        let after = bodies(&description, &found.model, &found.state);
        let [(_, _, momentum, _), (_, _, now, _)] = [whole(&before), whole(&after)];
        let [spin, spins] = [&before, &after].map(|all| all.iter().map(Moving::spin).sum::<Vector3<f64>>());
        assert!((now - momentum).norm() < 1e-10 && (spins - spin).norm() < 1e-8, "seed {seed}");
        let lost: f64 = before
            .iter()
            .zip(&after)
            .map(|(a, b)| Moving::kinetic(&(a.velocity - b.velocity), &(a.turning - b.turning), a))
            .sum();
        let told = found.events.iter().map(|event| event.value).sum::<f64>();
        assert!((told - lost).abs() < 1e-8 * (1.0 + lost), "seed {seed}: {told} J, by Carnot {lost} J");
        assert!((found.dissipated - told).abs() < 1e-10 * (1.0 + lost), "seed {seed}");
        // They go on together.
        let speed = |one: &Moving, at: Vector3<f64>| one.velocity + one.turning.cross(&(at - one.center));
        let at = poses[0].transform_point(&on.into()).coords;
        assert!((speed(&after[0], at) - speed(&after[1], at)).norm() < 1e-7, "seed {seed}");
        if kind == HingeKind::Fixed {
            assert!((after[0].turning - after[1].turning).norm() < 1e-9, "seed {seed}");
        }
    }
}

/// A hinge that is locked stays where it is, bit for bit of what is told, and until it is released the scene moves as one with a
/// weld in its place.
#[test]
fn what_is_locked_is_a_weld_until_it_is_released() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let mut description = random_scene(seed + 9900, &Options { welds: false, ..OPTIONS });
        let body = random.below(OPTIONS.bodies);
        let axis = nalgebra::Unit::new_normalize(random.unit());
        let hinge = &mut description.bodies[body].hinge;
        hinge.kind = HingeKind::Revolute { axis: *axis };
        (hinge.position, hinge.velocity, hinge.force) = (vec![0.3], vec![0.0], vec![random.between(-1.0, 1.0)]);
        let name = description.bodies[body].name.clone();
        let mut welded = description.clone();
        let hinge = &mut welded.bodies[body].hinge;
        hinge.frame *= UnitQuaternion::from_axis_angle(&axis, 0.3);
        hinge.kind = HingeKind::Fixed;
        (hinge.position, hinge.velocity, hinge.force) = (Vec::new(), Vec::new(), Vec::new());
        let mut staged = description.clone();
        let mut release = stage(0.1);
        release.release.push(name.clone());
        staged.stages.push(release);
        let [model, weld] = [&staged, &welded].map(build);
        let (held, expected) = (ran(&model, &given(&model), 0.05), ran(&weld, &given(&weld), 0.05));
        let [one, other] = [(&held.model, &held.state), (&weld, &expected.state)].map(|(m, s)| bodies(&welded, m, s));
        for (one, other) in one.iter().zip(&other) {
            let apart = (one.center - other.center).norm() + (one.velocity - other.velocity).norm();
            assert!(apart < 1e-9, "seed {seed}: {apart:e}");
        }
        let free = ran(&model, &given(&model), 0.2);
        let hinge = &free.model.bodies[free.model.body(&name).expect("the body")].hinge;
        assert!(free.state.position[hinge.position] != 0.3, "seed {seed}: released, it moves");
        assert!(free.energy_drift < 1e-9 * (10.0 + free.energy_start.abs()), "seed {seed}: {:e}", free.energy_drift);
        assert_eq!(free.events[0].value, 0.0, "seed {seed}: nothing is lost in a release");
    }
}

fn shipped(name: &str) -> (Scenario, Summary) {
    let path = format!("{}/scenarios/stages/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let scenario = scenario::load(path.as_ref()).unwrap_or_else(|error| panic!("{error}"));
    let model = build(&scenario.description);
    let mut found =
        simulate::run(&model, &scenario.simulate, 1.0, &given(&model), &mut Fanout::new(), &mut |_, _| true)
            .unwrap_or_else(|error| panic!("{error}"));
    found.events.retain(|event| event.kind != Kind::Switch);
    (scenario, found)
}

fn place(found: &Summary, body: &str) -> Vector3<f64> {
    found.poses[found.model.body(body).expect("the body")].translation.vector
}

/// A weight on the edge of a trapdoor falls freely when the door is let go.
#[test]
fn the_sack_on_the_trapdoor_falls_freely() {
    let (_, found) = shipped("trapdoor");
    let fall = place(&found, "sack").z + 0.5 * 9.80665 * 0.25;
    assert!(fall.abs() < 1e-12, "{fall:e} m beside 1/2 g t²");
    // The flap, a rod about its end: ω² = 3 g / L sin φ.
    let flap = &found.model.bodies[found.model.body("flap").expect("the flap")].hinge;
    let (angle, rate) = (found.state.position[flap.position], found.state.velocity[flap.velocity]);
    let (inertia, arm) = (0.64 + 12.0 * 0.16, 12.0 * 9.80665 * 0.4);
    assert!((0.5 * inertia * rate * rate - arm * angle.sin()).abs() < 1e-9 * arm, "{angle} {rate}");
}

/// Two free bodies that latch on to each other: μ v² / 2 is lost, the momentum is not.
#[test]
fn docking_keeps_the_momentum_and_loses_the_energy_of_the_approach() {
    let (_, found) = shipped("docking");
    let tug = &found.model.bodies[found.model.body("tug").expect("the tug")].hinge;
    assert!((found.state.velocity[tug.velocity] - 0.075).abs() < 1e-12);
    assert!((found.dissipated - 67.5).abs() < 1e-9, "{}", found.dissipated);
    let [event, docking] = [&found.events[0], &found.events[1]];
    assert!((event.time - 30.0).abs() < 1e-9 && (docking.value - 67.5).abs() < 1e-9, "{event} {docking}");
    assert!((place(&found, "tug").x + 3.5 - 0.075 * 30.0).abs() < 1e-8, "{}", place(&found, "tug").x);
}

/// Angular momentum about the centre of mass through releases and locks, and panels that lie flat at the end.
#[test]
fn a_satellite_that_unfolds_keeps_its_angular_momentum() {
    let (scenario, found) = shipped("satellite");
    let model = build(&scenario.description);
    let [(_, _, _, before), (_, _, p, after)] = [(&model, &given(&model)), (&found.model, &found.state)]
        .map(|(model, state)| whole(&bodies(&scenario.description, model, state)));
    assert!(p.norm() < 1e-9 && (after - before).norm() < 1e-8 * before.norm(), "{before} {after}");
    for panel in ["left", "right"] {
        let hinge = &found.model.bodies[found.model.body(panel).expect("a panel")].hinge;
        assert!(
            found.state.position[hinge.position].abs() < 1e-11 && found.state.velocity[hinge.velocity].abs() < 1e-11
        );
    }
    let stages: Vec<&str> = found.events.iter().map(|event| event.name.as_str()).collect();
    assert_eq!(stages, ["first panel", "left is flat", "second panel", "right is flat", "unfolded"]);
    assert!(found.dissipated > 1.0 && found.energy_drift < 1e-9, "{} {:e}", found.dissipated, found.energy_drift);
}

/// The bead leaves the wire with the speed of its fall, and rises to 2 m.
#[test]
fn a_bead_leaves_the_end_of_its_parabola() {
    let (_, found) = shipped("bead_on_parabola");
    let [leaves, top] = [0, 2].map(|event: usize| &found.events[event]);
    assert!((leaves.speed - (2.0 * 9.80665 * 1.25_f64).sqrt()).abs() < 1e-9, "{leaves}");
    let rise = leaves.speed * 2.0 / 5.0_f64.sqrt();
    assert!((top.time - leaves.time - rise / 9.80665).abs() < 1e-9, "{top}");
    let ahead = found.end_time - top.time;
    assert!(
        (place(&found, "bead").z - (2.0 - 0.5 * 9.80665 * ahead * ahead)).abs() < 1e-9,
        "{}",
        place(&found, "bead")
    );
    assert_eq!(found.model.bodies[0].hinge.kind, HingeKind::Free);
}
