//! Events at the ends of what a body can do: the end of a curve, a rigid limit. The event comes, and what follows from it.

use super::{given, ran, stage};
use crate::common::{Random, build};
use nalgebra::Vector3;
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::model::description::{
    AlongTurn, BodyDescription, Description, Direction, EventDescription, GuideCurve, HingeDescription, HingeKind,
    WatchedDescription, When,
};
use stillpoint::model::stop::{LimitDescription, StopLaw};

fn curve(random: &mut Random) -> GuideCurve {
    match random.below(4) {
        0 => GuideCurve::Straight { length: random.between(0.3, 3.0) },
        1 => {
            let mut at = Vector3::zeros();
            let mut next = |random: &mut Random| {
                at += Vector3::new(random.between(0.3, 0.9), random.between(-0.4, 0.4), random.between(-0.4, 0.4));
                at
            };
            GuideCurve::Points { points: (0..7).map(|_| next(random)).collect() }
        }
        2 => GuideCurve::Helix { radius: random.between(0.2, 1.0), pitch: random.between(0.1, 0.5), turns: 1.3 },
        _ => {
            let [a, b] = [0; 2].map(|_| random.between(-1.0, 1.0));
            let place = [format!("v + {a}*sin(v)/2"), format!("{b}*v^2"), "cos(2*v)".to_owned()];
            GuideCurve::Formulas { parameter: "v".to_owned(), place, range: [-1.0, random.between(1.0, 3.0)] }
        }
    }
}

fn event(value: f64, stops: bool) -> EventDescription {
    let of = WatchedDescription::Hinge { body: "bead".to_owned(), coordinate: 0 };
    EventDescription { name: "end".to_owned(), of, value, direction: Direction::Both, stops }
}

/// Without forces, from a place on its curve towards one of its ends.
fn scene(random: &mut Random, limits: bool) -> (Description, f64, f64) {
    let mut hinge = HingeDescription::along(curve(random), AlongTurn::Held);
    let scene = |hinge: &HingeDescription| {
        Description::new("bead")
            .gravity([0.0; 3])
            .body(BodyDescription::new("bead", hinge.clone()).mass(1.0).inertia([0.1; 3]))
    };
    let model: Arc<Model> = build(&scene(&hinge));
    let ends: Vec<f64> = model.curve_ends.iter().map(|end| end.at).collect();
    let (side, [low, high]) = (random.below(2), [ends[0].min(ends[1]), ends[0].max(ends[1])]);
    let (end, speed) = ([low, high][side], random.between(0.5, 20.0));
    let from = low + (high - low) * random.between(0.2, 0.8);
    hinge = hinge.position([from]).velocity([if side == 1 { speed } else { -speed }]);
    if limits {
        hinge.limits.push(LimitDescription { coordinate: 0, low, high, law: StopLaw::Rigid { restitution: 0.5 } });
    }
    (scene(&hinge), end, (end - from).abs() / speed)
}

/// The event at the end of a curve ends the run, or opens the hinge: then the bead flies on with what it had.
#[test]
fn the_event_at_the_end_of_a_curve_comes() {
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let (mut description, end, time) = scene(&mut random, seed % 3 == 0);
        // As it is, and as another sum may round it.
        let value = [end, end.next_up(), end.next_down()][random.below(3)];
        let mut stops = description.clone();
        stops.events.push(event(value, true));
        let model = build(&stops);
        let found = ran(&model, &given(&model), 2.0 * time);
        assert_eq!(found.stopped_by.as_deref(), Some("end"), "seed {seed}");
        let speed = description.bodies[0].hinge.velocity[0];
        assert!((found.end_time - time).abs() < 1e-9 * time && found.state.velocity[0] * speed > 0.0, "seed {seed}");
        description.events.push(event(value, false));
        let mut open = stage(0.0);
        open.when = When::Event("end".to_owned());
        open.open.push("bead".to_owned());
        description.stages.push(open);
        let model = build(&description);
        let found = ran(&model, &given(&model), 2.0 * time);
        assert_eq!(found.model.bodies[0].hinge.kind, HingeKind::Free, "seed {seed}");
        let velocity = Vector3::from_column_slice(&found.state.velocity[..3]);
        assert!((velocity.norm() - speed.abs()).abs() < 1e-9 * speed.abs(), "seed {seed}: {velocity}");
        assert!(found.dissipated < 1e-12 && found.energy_drift < 1e-9, "seed {seed}");
    }
}

/// An event at a rigid limit comes before the impact; where the run goes on with the stop, that follows.
#[test]
fn the_event_at_a_rigid_limit_comes_before_the_impact() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let (limit, speed) = (random.between(0.2, 2.0), random.between(0.5, 20.0));
        let law = StopLaw::Rigid { restitution: 0.5 };
        let hinge = HingeDescription::prismatic([0.0, 0.0, 1.0]).velocity([speed]);
        let hinge = hinge.limit(LimitDescription { coordinate: 0, low: -1e3, high: limit, law });
        let bead = BodyDescription::new("bead", hinge).mass(1.0).inertia([0.1; 3]);
        let ring =
            BodyDescription::new("ring", HingeDescription::revolute([0.0, 0.0, 1.0])).mass(1.0).inertia([0.1; 3]);
        let mut description = Description::new("bead").gravity([0.0; 3]).body(bead).body(ring);
        let mut other = description.clone();
        description.events.push(event(limit, true));
        let model = build(&description);
        let found = ran(&model, &given(&model), 3.0 * limit / speed);
        assert_eq!(found.stopped_by.as_deref(), Some("end"), "seed {seed}");
        assert!(found.state.velocity[0] > 0.999 * speed && found.state.position[0] == limit, "seed {seed}");
        // A stage that has nothing to do with the stop.
        other.events.push(event(limit, false));
        let mut lock = stage(0.0);
        lock.when = When::Event("end".to_owned());
        lock.lock.push("ring".to_owned());
        other.stages.push(lock);
        let model = build(&other);
        let found = ran(&model, &given(&model), 3.0 * limit / speed);
        assert_eq!((found.impacts, found.pending.len()), (1, 0), "seed {seed}: {:?}", found.events);
        assert!((found.state.position[0] - limit + 0.5 * 2.0 * limit).abs() < 1e-9 * limit, "seed {seed}");
        assert!((found.state.velocity[0] + 0.5 * speed).abs() < 1e-9 * speed, "seed {seed}");
    }
}

/// A body that flies is caught onto a curve by a shoe that waits there. Along the curve momentum is kept, across it what comes goes; the
/// event watches the very distance that its stage closes.
#[test]
fn what_flies_is_caught_onto_a_curve_by_a_shoe() {
    let (_, found) = super::shipped("caught_on_rail");
    let caught = found.events.iter().find(|event| event.name == "caught").expect("the stage");
    assert!((caught.time - 0.75).abs() < 1e-9, "{caught}");
    let (car, shoe, gravity) = (2.0, 0.1, 9.80665);
    let velocity = Vector3::new(2.0, 0.0, -0.25 * gravity);
    let along = Vector3::new(1.0, 0.0, -0.9).normalize();
    // z = 0.3 u² - 0.9 u at u = 0.
    let curvature = 0.6 / (1.0 + 0.81_f64).powf(1.5);
    let whole = car + shoe + 1e-4 * curvature * curvature;
    let speed = car * velocity.dot(&along) / whole;
    let lost = 0.5 * car * velocity.norm_squared() - 0.5 * whole * speed * speed;
    assert!((caught.value - lost).abs() < 1e-8 * lost, "{} {lost}", caught.value);
    assert!(found.energy_drift < 1e-9, "{:e} J", found.energy_drift);
}
