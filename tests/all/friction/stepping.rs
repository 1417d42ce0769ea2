//! Random trees and gears with dry friction in every hinge, against Moreau's time stepping: velocities and bounded impulses
//! of fixed steps, of order 1, solved by projected Gauss–Seidel sweeps. Its own error is told by halving its step.

use std::sync::Arc;

use stillpoint::dynamics::System;
use stillpoint::hinge::HingeKind;
use stillpoint::model::Model;
use stillpoint::model::couplings::{CoordinateName, GearDescription, GearKind};
use stillpoint::model::description::Description;
use stillpoint::record::{Memory, Opening};
use stillpoint::simulate::events::Kind;
use stillpoint::simulate::{self, Integrator, Settings, Start, State, Summary};

use crate::common::{Options, Random, build, random_scene};

const DURATION: f64 = 0.3;

/// Positions at the end by steps of the same length.
fn moreau(model: &Arc<Model>, steps: usize) -> Vec<f64> {
    let h = DURATION / steps as f64;
    let n = model.velocity_count();
    let smooth = {
        let mut smooth = Model::clone(model);
        smooth.hinge_friction.clear();
        Arc::new(smooth)
    };
    let mut system = System::new(&smooth);
    let (mut q, mut v) = (model.start_position.clone(), model.start_velocity.clone());
    system.settle(0.0, &mut q, &mut v).expect("a regular state");
    let mut a = vec![0.0; n];
    let coordinates: Vec<usize> = model
        .hinge_friction
        .iter()
        .flat_map(|friction| friction.velocity..friction.velocity + friction.count)
        .collect();
    let mut columns = vec![vec![0.0; n]; coordinates.len()];
    let mut impulses = vec![0.0; coordinates.len()];
    for step in 0..steps {
        let time = h * step as f64;
        let mut at = system.at(time, &q, &v);
        let mut mass = at.accelerations(&mut a).expect("a regular state");
        let mut unit = vec![0.0; n];
        for (column, i) in columns.iter_mut().zip(&coordinates) {
            unit[*i] = 1.0;
            mass.answer_impulse(&unit, column);
            unit[*i] = 0.0;
        }
        let mut next: Vec<f64> = v.iter().zip(&a).map(|(v, a)| v + h * a).collect();
        for (column, impulse) in columns.iter().zip(&impulses) {
            next.iter_mut().zip(column).for_each(|(v, c)| *v += c * impulse);
        }
        for _ in 0..5000 {
            let mut changed = 0.0_f64;
            let mut first = 0;
            for friction in &model.hinge_friction {
                let rows = first..first + friction.count;
                first = rows.end;
                let own = rows.clone().map(|row| columns[row][coordinates[row]]).fold(0.0, f64::max);
                let own = if friction.count == 1 { own } else { 3.0 * own };
                let wanted: Vec<f64> = rows.clone().map(|row| impulses[row] - next[coordinates[row]] / own).collect();
                let size = wanted.iter().map(|x| x * x).sum::<f64>().sqrt();
                let scale = (h * friction.friction.slide / size).min(1.0);
                for (row, wanted) in rows.zip(wanted) {
                    let change = scale * wanted - impulses[row];
                    impulses[row] += change;
                    next.iter_mut().zip(&columns[row]).for_each(|(v, c)| *v += c * change);
                    changed = changed.max(change.abs());
                }
            }
            if changed < 1e-15 {
                break;
            }
        }
        v = next;
        let by: Vec<f64> = v.iter().map(|v| h * v).collect();
        System::displace(model, &mut q, &by);
        system.settle(time + h, &mut q, &mut v).expect("a regular state");
    }
    q
}

fn go(model: &Arc<Model>, integrator: Integrator) -> Summary {
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let still = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &still, scenario: "", statics: None });
    let settings = Settings {
        start: Start::Given,
        duration: DURATION,
        integrator,
        tolerance: 1e-9,
        absolute_tolerance: 1e-9,
        ..Settings::default()
    };
    simulate::run(model, &settings, 50.0, &start, &mut memory, &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A tree with every kind of hinge, dry friction in all of them; of half of the scenes some start at rest.
fn scene(seed: u64) -> Description {
    let mut random = Random::new(seed ^ 0x5151);
    let mut scene =
        random_scene(seed, &Options { bodies: 1 + random.below(4), springs: seed.is_multiple_of(2), welds: false });
    for body in &mut scene.bodies {
        let velocities = body.hinge.kind.counts().1;
        let most = [0.5, 3.0, 15.0][random.below(3)];
        body.hinge = body.hinge.clone().friction(random.list(velocities, 0.1, most));
        if random.below(2) == 0 {
            body.hinge.velocity = vec![0.0; velocities];
        }
    }
    scene
}

fn compare(scenes: impl Iterator<Item = (String, Arc<Model>)>, least: usize) {
    let methods = ["dop853", "dopri5", "radau5", "sdirk4", "auto"];
    let (mut slips, mut sticks) = (0, 0);
    for (at, (name, model)) in scenes.enumerate() {
        let method = methods[at % methods.len()];
        let summary = go(&model, Integrator::named(method).expect("a method"));
        slips += summary.events.iter().filter(|event| event.kind == Kind::Slip).count();
        sticks += summary.events.iter().filter(|event| event.kind == Kind::Stick).count();
        let [coarse, fine] = [1000, 2000].map(|steps| moreau(&model, steps));
        let (off, own) = (farthest(&summary.state.position, &fine), farthest(&coarse, &fine));
        if std::env::var("FRICTION_TELL").is_ok() {
            eprintln!("{name} {method} {off:.1e} {own:.1e} {:?}", summary.events.len());
        }
        assert!(
            off < 3.0 * own + 1e-7,
            "{name} with {method}: {off:e} apart, {own:e} by halving the step; {:?}",
            summary.events
        );
        let size = summary.energy_start.abs() + summary.dissipated + 1.0;
        assert!(summary.energy_drift < 1e-6 * size, "{name} with {method}: {:e}", summary.energy_drift);
    }
    assert!(slips >= least && sticks >= least, "{slips} slips, {sticks} sticks");
}

fn cases(usual: u64) -> u64 {
    std::env::var("EVENT_CASES").map_or(usual, |cases| cases.parse().expect("EVENT_CASES is a number"))
}

#[test]
fn random_trees_slide_and_stick_as_time_stepping_says() {
    compare((0..cases(100)).map(|seed| (format!("seed {seed}"), build(&scene(seed)))), 30);
}

/// The same beside gears between the scalar coordinates of neighbours.
#[test]
fn random_geared_trees_slide_and_stick_as_time_stepping_says() {
    let geared = |seed: u64| {
        let mut random = Random::new(seed ^ 0x6ea5);
        let mut scene = scene(seed);
        let turns = |kind: &HingeKind| matches!(kind, HingeKind::Revolute { .. });
        let mut turning = scene.bodies.iter().filter(|body| turns(&body.hinge.kind)).map(|body| body.name.clone());
        let between = [turning.next()?, turning.next()?].map(|body| CoordinateName { body, index: 0 });
        drop(turning);
        let kind = GearKind::Ratio { ratio: random.between(0.5, 2.0) };
        scene.gears.push(GearDescription { name: "gear".to_owned(), between, kind, offset: None });
        Some((format!("seed {seed}"), build(&scene)))
    };
    compare((0..cases(600)).filter_map(geared), 8);
}

/// Four-bars with dry friction in the three hinges of the tree: one motion, whose friction is shared while it sticks.
#[test]
fn random_four_bars_slide_and_stick_as_time_stepping_says() {
    let four_bar = |seed: u64| {
        let mut random = Random::new(seed ^ 0xb0a7);
        let (a, d, turn) = (random.between(0.15, 0.3), random.between(0.3, 0.5), random.between(0.5, 2.5));
        let b = [a * turn.cos(), a * turn.sin()];
        let c = [random.between(0.2, 0.5), random.between(0.25, 0.5)];
        let between = |from: [f64; 2], to: [f64; 2]| {
            let [x, z] = [to[0] - from[0], to[1] - from[1]];
            (x.hypot(z), z.atan2(x))
        };
        let ((coupler, coupler_angle), (rocker, rocker_angle)) = (between(b, c), between([d, 0.0], c));
        let strongest = [0.3, 2.0, 6.0][random.below(3)];
        let mut text = format!("gravity = [{}, 0, -9.8]\n", random.between(-5.0, 5.0));
        for (name, length, hinge) in [
            ("crank", a, format!("position = {turn}")),
            ("coupler", coupler, format!("parent = \"crank\", at = \"end\", position = {}", coupler_angle - turn)),
            ("rocker", rocker, format!("at = [{d}, 0, 0], position = {rocker_angle}")),
        ] {
            let (mass, stick) = (random.between(0.3, 2.0), random.between(0.05, strongest));
            let velocity = if name == "crank" && seed.is_multiple_of(2) { random.between(-8.0, 8.0) } else { 0.0 };
            let inertia = mass * length * length / 12.0;
            text += &format!(
                "[[body]]\nname = \"{name}\"\nmass = {mass}\ncenter = [{}, 0, 0]\ninertia = [{}, {inertia}, {inertia}]\nmarkers = {{ end = \
                 [{length}, 0, 0] }}\nhinge = {{ type = \"revolute\", axis = [0, -1, 0], velocity = {velocity}, friction = {stick}, {hinge} }}\n",
                0.5 * length,
                0.1 * inertia
            );
        }
        text += "[[loop]]\nname = \"joint\"\ntype = \"revolute\"\nbetween = [\"coupler.end\", \"rocker.end\"]\naxis = [0, 1, 0]\n";
        let scenario = stillpoint::scenario::parse("four_bar.toml", &text, &[]);
        let scenario = scenario.unwrap_or_else(|found| panic!("{found:?}"));
        (format!("seed {seed}: {text}"), build(&scenario.description))
    };
    compare((0..cases(40)).map(four_bar), 8);
}
