//! Stages beside drives that move: whatever happens, drives are where their laws have them then, and what they put into an exchange of
//! momentum is work.

use super::{OPTIONS, bodies, given, ran, stage};
use crate::common::{Options, Random, build, random_scene};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::model::couplings::{CoordinateName, DriveDescription, MotionDescription};
use stillpoint::model::description::{
    BodyDescription, Description, HingeDescription, HingeKind, StageDescription, When,
};
use stillpoint::model::prescribed::Prescribed;
use stillpoint::record::Fanout;
use stillpoint::simulate::{self, State, Summary};

/// A motion that begins at a position.
fn motion(random: &mut Random, from: f64) -> MotionDescription {
    let rate = random.between(-3.0, 3.0);
    match random.below(5) {
        0 => MotionDescription::Rate { rate },
        1 => MotionDescription::Ramp { to: from + rate, begin: random.between(0.0, 0.1), duration: 0.2 },
        2 => MotionDescription::Sine { offset: None, amplitude: 0.4 * rate, frequency: 1.5, phase: 0.0 },
        3 => MotionDescription::Table {
            times: vec![0.0, 0.1, 0.3],
            values: vec![from, from + 0.2 * rate, from - 0.1 * rate],
        },
        _ => MotionDescription::Expression { text: format!("{from} + {rate}*t + sin({rate}*t)^2") },
    }
}

fn drive(name: &str, body: &str, motion: MotionDescription) -> DriveDescription {
    let coordinate = CoordinateName { body: body.to_owned(), index: 0 };
    DriveDescription { name: name.to_owned(), coordinate, motion }
}

/// What goes wrong in a run.
fn refused(description: &Description, duration: f64) -> String {
    let model = build(description);
    let settings = super::settings(duration);
    let run = simulate::run(&model, &settings, 1.0, &given(&model), &mut Fanout::new(), &mut |_, _| true);
    run.expect_err("it cannot come").to_string()
}

/// Random trees in which a hinge is driven, whatever law it follows: another one opens, is locked or let go. No body jumps, and nothing
/// that opens changes a velocity or an energy; the drive goes on as its law says.
#[test]
fn anything_may_open_and_lock_beside_drives_that_move() {
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let mut description = random_scene(seed + 12_000, &Options { bodies: 4, welds: false, ..OPTIONS });
        let (driven, other) = (random.below(2), 2 + random.below(2));
        let kinds: [fn(Vector3<f64>) -> HingeKind; 2] =
            [|axis| HingeKind::Revolute { axis }, |axis| HingeKind::Prismatic { axis }];
        for body in [driven, other] {
            let hinge = &mut description.bodies[body].hinge;
            hinge.kind = kinds[random.below(2)](random.unit());
            (hinge.position, hinge.velocity) = (vec![random.between(-0.5, 0.5)], random.list(1, -1.0, 1.0));
            hinge.force = Vec::new();
        }
        let from = description.bodies[driven].hinge.position[0];
        let law = motion(&mut random, from);
        description.drives.push(drive("d", &description.bodies[driven].name, law.clone()));
        let name = description.bodies[other].name.clone();
        let when = random.between(0.05, 0.25);
        let mut change = stage(when);
        let verb = random.below(3);
        [&mut change.open, &mut change.lock, &mut change.release][verb].push(name.clone());
        let mut staged = description.clone();
        staged.stages.push(change);
        // Just before and just after: what comes at the end of a run comes.
        let model = build(&staged);
        let before = ran(&model, &assembled(&model), when * (1.0 - 1e-12));
        let after = ran(&model, &assembled(&model), when);
        assert_eq!((before.events.len(), after.events.len()), (0, 1), "seed {seed}");
        let [one, two] = [&before, &after].map(|found| bodies(&description, &found.model, &found.state));
        for (one, two) in one.iter().zip(&two) {
            assert!((one.center - two.center).norm() < 1e-9, "seed {seed}: {}", (one.center - two.center).norm());
            let jump = (one.velocity - two.velocity).norm() + (one.turning - two.turning).norm();
            assert!(verb == 1 || jump < 1e-8, "seed {seed}: {jump}");
        }
        let size = 10.0 + before.energy_end.abs() + before.work.abs();
        let lost = before.energy_end - after.energy_end + after.work - before.work;
        assert!(verb == 1 || lost.abs() < 1e-9 * size, "seed {seed}: {lost}");
        assert!(
            (after.dissipated - before.dissipated - lost).abs() < 1e-9 * size && lost > -1e-9 * size,
            "seed {seed}"
        );
        let later = ran(&model, &assembled(&model), when + 0.2);
        // The power of the drive is integrated along the interpolant of each step.
        assert!(later.energy_drift < 1e-6 * (size + later.work.abs()), "seed {seed}: {:e}", later.energy_drift);
        let hinge = &later.model.bodies[later.model.body(&description.bodies[driven].name).unwrap()].hinge;
        let there = Prescribed::compile(&law, from).unwrap().at(later.end_time);
        let found = [later.state.position[hinge.position], later.state.velocity[hinge.velocity]];
        let apart = (found[0] - there.position).abs() + (found[1] - there.velocity).abs();
        assert!(apart < 1e-9, "seed {seed}: {found:?} {there:?}");
    }
}

/// Where a scene begins: on its drives.
fn assembled(model: &Arc<Model>) -> State {
    let (model, _) = stillpoint::constraint::assemble(Arc::clone(model)).unwrap_or_else(|all| panic!("{all:?}"));
    given(&model)
}

/// Rings about one axis, each on the one before it, without anything that acts.
fn rings(random: &mut Random, count: usize) -> (Description, Vec<f64>) {
    let inertia = random.list(count, 0.5, 3.0);
    let mut description = Description::new("rings").gravity([0.0; 3]);
    for (index, inertia) in inertia.iter().enumerate() {
        let hinge = HingeDescription::revolute([0.0, 0.0, 1.0]);
        let hinge = if index > 0 { hinge.on(&format!("r{}", index - 1), [0.0; 3]) } else { hinge };
        let hinge = hinge.position([random.between(-1.0, 1.0)]).velocity([random.between(-2.0, 2.0)]);
        description =
            description.body(BodyDescription::new(&format!("r{index}"), hinge).mass(1.0).inertia([*inertia; 3]));
    }
    (description, inertia)
}

/// A ring that turns freely meets a drive at an instant, with another rate: by hand, the drive's impulse is `I Δω`, its work that times
/// its rate, and `½ I Δω²` is lost.
#[test]
fn a_drive_that_meets_puts_in_its_impulse_times_its_rate() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let (mut description, inertia) = rings(&mut random, 1);
        let hinge = &description.bodies[0].hinge;
        let (from, speed) = (hinge.position[0], hinge.velocity[0]);
        let (when, rate) = (random.between(0.1, 0.5), if seed % 4 == 0 { speed } else { random.between(-2.0, 2.0) });
        let there = from + speed * when;
        let law = MotionDescription::Expression { text: format!("{there} + {rate}*(t - {when})") };
        description.drives.push(drive("d", "r0", law));
        let mut close = stage(when);
        close.close.push("d".to_owned());
        description.stages.push(close);
        let found = ran(&build(&description), &given(&build(&description)), when + 0.3);
        let change = rate - speed;
        let [work, lost] = [inertia[0] * change * rate, 0.5 * inertia[0] * change * change];
        assert!((found.work - work).abs() < 1e-9, "seed {seed}: {} {work}", found.work);
        assert!((found.dissipated - lost).abs() < 1e-9, "seed {seed}: {} {lost}", found.dissipated);
        assert!((found.events[0].value - lost).abs() < 1e-9 && found.energy_drift < 1e-9, "seed {seed}");
        assert!((found.state.position[0] - there - 0.3 * rate).abs() < 1e-10, "seed {seed}");
    }
}

/// A ring on a ring that a sine drives is locked: the drive takes both along.
#[test]
fn a_lock_on_what_a_drive_moves_books_loss_and_work() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let (mut description, inertia) = rings(&mut random, 2);
        let (amplitude, frequency) = (random.between(0.2, 0.8), random.between(0.3, 1.0));
        let law = MotionDescription::Sine { offset: None, amplitude, frequency, phase: 0.0 };
        let rate = |t: f64| amplitude * TAU * frequency * (TAU * frequency * t).cos();
        let from = description.bodies[0].hinge.position[0];
        description.bodies[0].hinge.velocity = vec![rate(0.0)];
        let own = rate(0.0) + description.bodies[1].hinge.velocity[0];
        description.drives.push(drive("d", "r0", law.clone()));
        let when = random.between(0.1, 1.0);
        let mut lock = stage(when);
        lock.lock.push("r1".to_owned());
        description.stages.push(lock);
        let model = build(&description);
        let found = ran(&model, &given(&model), when);
        assert_eq!((found.end_time, found.events.len(), found.pending.len()), (when, 1, 0), "seed {seed}");
        let change = rate(when) - own;
        let lost = 0.5 * inertia[1] * change * change;
        let before = 0.5 * inertia[0] * (rate(when).powi(2) - rate(0.0).powi(2));
        let work = before + inertia[1] * change * rate(when);
        assert!((found.work - work).abs() < 1e-8, "seed {seed}: {} {work}", found.work);
        assert!((found.dissipated - lost).abs() < 1e-8, "seed {seed}: {} {lost}", found.dissipated);
        assert!((found.state.position[0] - Prescribed::compile(&law, from).unwrap().at(when).position).abs() < 1e-12);
        assert!(found.energy_drift < 1e-9, "seed {seed}: {:e}", found.energy_drift);
    }
}

/// A drive goes and comes again, beside another one that moves all the time: a ring without moments goes on at its rate and meets it again;
/// where it has been slowed down since, it does not, and that is told with the drive and its gap in rad or m.
#[test]
fn drives_open_and_close_again_where_they_meet() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let (mut description, _) = rings(&mut random, 2);
        let (moves, rate) = (motion(&mut random, description.bodies[0].hinge.position[0]), random.between(0.5, 2.0));
        let slides = random.below(2) == 1;
        description.bodies[1].hinge = HingeDescription::revolute([0.0, 0.0, 1.0]).position([0.2]).velocity([rate]);
        if slides {
            description.bodies[1].hinge.kind = HingeKind::Prismatic { axis: Vector3::z() };
        }
        description.drives.push(drive("moves", "r0", moves));
        description.drives.push(drive("again", "r1", MotionDescription::Rate { rate }));
        let mut stages = [0.1, 0.25].map(|when| StageDescription::new(&format!("at {when}"), When::Time(when)));
        stages[0].open.push("again".to_owned());
        stages[1].close.push("again".to_owned());
        description.stages.extend(stages);
        let model = build(&description);
        let found: Summary = ran(&model, &assembled(&model), 0.4);
        assert!((found.state.position[1] - 0.2 - 0.4 * rate).abs() < 1e-10, "seed {seed}: {:?}", found.state);
        assert!(found.dissipated < 1e-12 && found.energy_drift < 1e-9, "seed {seed}: {}", found.dissipated);
        let pull = random.between(1.0, 3.0);
        description.bodies[1].hinge.force = vec![-pull];
        let said = refused(&description, 0.4);
        let mass = if slides { 1.0 } else { description.bodies[1].mass.inertia[(0, 0)] };
        let gap = 0.5 * pull / mass * 0.15 * 0.15;
        let told = format!("drive `again` is open by {}", stillpoint::model::problem::rounded(gap));
        let allowed = if slides { " m, allowed: " } else { " rad, allowed: 1e-9 rad; let the parts meet" };
        // The last digit told may be another one.
        assert!(said.contains(&told[..told.len() - 2]) && said.contains(allowed), "seed {seed}: {said}, {told}");
    }
}

/// What a drive would have jumped by is told, wherever it was at t = 0.
#[test]
fn a_drive_that_met_at_the_start_alone_is_refused() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let (mut description, _) = rings(&mut random, 1);
        let hinge = &description.bodies[0].hinge;
        let (there, when) = (hinge.position[0] + 0.3 * hinge.velocity[0], 0.3);
        let rate = random.between(1.0, 3.0);
        description.drives.push(drive(
            "d",
            "r0",
            MotionDescription::Expression { text: format!("{there} + {rate}*t") },
        ));
        let mut close = stage(when);
        close.close.push("d".to_owned());
        description.stages.push(close);
        let said = refused(&description, 1.0);
        assert!(
            said.contains("at t = 0.3 s stage `change` cannot come: drive `d` is open by 0."),
            "seed {seed}: {said}"
        );
    }
}

/// A ramp starts and stops a ring: the largest energy of the run is that between, and neither end has any.
#[test]
fn the_largest_energy_of_a_run_is_that_on_the_way() {
    for seed in 0..10 {
        let mut random = Random::new(seed);
        let (mut description, inertia) = rings(&mut random, 1);
        let from = description.bodies[0].hinge.position[0];
        description.bodies[0].hinge.velocity = vec![0.0];
        let ramp = MotionDescription::Ramp { to: from + 0.4, begin: 0.1, duration: 0.2 };
        description.drives.push(drive("d", "r0", ramp));
        let model = build(&description);
        let found = ran(&model, &given(&model), 0.5);
        // The fastest of the polynomial is 15/8 of its mean.
        let peak = 0.5 * inertia[0] * (1.875_f64 * 0.4 / 0.2).powi(2);
        assert!(found.energy_start == 0.0 && found.energy_end.abs() < 1e-12, "seed {seed}");
        assert!(
            found.energy_largest > 0.5 * peak && found.energy_largest < 1.000_001 * peak,
            "{}",
            found.energy_largest
        );
    }
}
