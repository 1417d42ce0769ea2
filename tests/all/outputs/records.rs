//! Outputs of runs and of statics against what is recorded and reported of the same numbers elsewhere.

use crate::common::build;
use crate::scenarios::file;
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::model::description::*;
use stillpoint::record::{Memory, Opening, Recorder};
use stillpoint::scenario::{Scenario, load};
use stillpoint::simulate::outputs::OutputRanges;
use stillpoint::simulate::{self, State, Summary};
use stillpoint::statics;

/// A shipped scenario with the force of everything that has one, all reactions, and all energies as outputs.
fn asked(name: &str) -> (Scenario, Arc<Model>) {
    let mut scenario = load(&file(name)).unwrap_or_else(|problem| panic!("{name}: {problem}"));
    let description = &mut scenario.description;
    let mut add = |name: String, of| description.outputs.push(OutputDescription { name, of });
    let force = |of: &str| QuantityDescription::Force { of: of.to_owned(), component: None };
    let lists: [(&str, usize); 5] = [
        ("drive", description.drives.len()),
        ("motor", description.motors.len()),
        ("gear", description.gears.len()),
        ("loop", description.loops.len()),
        ("force", description.forces.len()),
    ];
    for (list, count) in lists {
        (0..count).for_each(|index| add(format!("{list} {index}"), force(&format!("{list}[{index}]"))));
    }
    for body in &description.bodies {
        let of = QuantityDescription::Reaction { body: body.name.clone(), component: None, axes: Axes::Inertial };
        add(format!("reaction {}", body.name), of);
    }
    let energies = [EnergyKind::Kinetic, EnergyKind::Potential, EnergyKind::Input, EnergyKind::Dissipated];
    energies.into_iter().for_each(|kind| add(format!("{kind:?}"), QuantityDescription::Energy(kind)));
    let powers = [("power in", PowerKind::Input), ("power out", PowerKind::Dissipated)];
    powers.into_iter().for_each(|(name, kind)| add(name.to_owned(), QuantityDescription::Power(kind)));
    let (model, _) = assemble(Model::build(&scenario.description).unwrap()).unwrap();
    (scenario, model)
}

fn run(scenario: &Scenario, model: &Arc<Model>, state: &State) -> (Memory, Summary) {
    let scene = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    let mut settings = scenario.simulate.clone();
    settings.duration = settings.duration.min(0.3);
    let summary = simulate::run(model, &settings, 50.0, state, &mut memory, &mut |_, _| true).unwrap();
    (memory, summary)
}

/// Where `/couplings` has the same numbers, bit for bit; reactions and energies too.
#[test]
fn outputs_of_runs_are_what_other_channels_record() {
    let mut compared = 0;
    for name in ["four_bar", "double_wishbone", "rope_over_pulleys", "winch", "slider_crank", "excavator"] {
        let (scenario, model) = asked(name);
        let state = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let (memory, summary) = run(&scenario, &model, &state);
        let of = |name: &str| model.outputs.iter().find(|output| output.name == name).unwrap().range();
        for sample in &memory.samples {
            for (index, channel) in memory.scene.couplings.iter().enumerate().filter(|(_, one)| one.name != "gap") {
                let list = |name: &str, found: Option<usize>| found.map(|index| format!("{name} {index}"));
                let output = list("drive", model.drives.iter().position(|one| one.name == channel.body))
                    .or_else(|| list("motor", model.motors.iter().position(|one| one.name == channel.body)))
                    .or_else(|| list("gear", model.gears.iter().position(|one| one.name == channel.body)))
                    .or_else(|| list("loop", model.loops.iter().position(|one| one.name == channel.body)))
                    .or_else(|| list("force", model.forces.iter().position(|one| one.name == channel.body)))
                    .unwrap();
                let parts = ["force.x", "force.y", "force.z", "moment.x", "moment.y", "moment.z"];
                let part = parts.iter().position(|part| *part == channel.name).unwrap_or(0);
                assert_eq!(sample.outputs[of(&output)][part], sample.couplings[index], "{name}: {output}");
                compared += 1;
            }
            for (body, reaction) in model.bodies.iter().zip(&sample.reactions) {
                let found = &sample.outputs[of(&format!("reaction {}", body.name))];
                let expected: Vec<f64> = reaction.force.iter().chain(reaction.moment.iter()).copied().collect();
                assert_eq!(found, expected, "{name}: {}", body.name);
            }
            let energy = sample.energy;
            let expected = [energy.kinetic, energy.potential, energy.work, energy.dissipated];
            for (name, expected) in ["Kinetic", "Potential", "Input", "Dissipated"].into_iter().zip(expected) {
                assert_eq!(sample.outputs[of(name)], [expected]);
            }
        }
        let last = memory.samples.last().unwrap();
        assert_eq!(summary.outputs, last.outputs, "{name}");
        assert_eq!(summary.outputs[of("Input")], [summary.work], "{name}");
    }
    assert!(compared > 100, "{compared}");
}

/// The rate of what was put in is the power, to the accuracy of the ledger's quadrature between samples.
#[test]
fn powers_are_rates_of_the_ledger() {
    let (scenario, model) = asked("double_wishbone");
    let state = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    let settings = simulate::Settings { duration: 0.2, ..scenario.simulate };
    simulate::run(&model, &settings, 2000.0, &state, &mut memory, &mut |_, _| true).unwrap();
    let of = |name: &str| model.outputs.iter().find(|output| output.name == name).unwrap().first;
    let (power, energy) = (of("power out"), of("Dissipated"));
    let largest = memory.samples.iter().map(|sample| sample.outputs[power].abs()).fold(0.0, f64::max);
    for window in memory.samples.windows(3) {
        let rate = (window[2].outputs[energy] - window[0].outputs[energy]) / (window[2].time - window[0].time);
        assert!((rate - window[1].outputs[power]).abs() < 2e-3 * largest, "at {}", window[1].time);
    }
}

/// Reactions, drives, motors and loops of the certificate.
#[test]
fn outputs_of_statics_are_those_of_the_certificate() {
    for name in ["four_bar", "double_wishbone", "rope_over_pulleys"] {
        let (scenario, model) = asked(name);
        let found = statics::equilibrium(&model, &scenario.statics, &model.start_position).unwrap();
        assert!(found.balanced, "{name}");
        let values = statics::outputs(&model, &found).unwrap();
        let of = |name: &str| &values[model.outputs.iter().find(|output| output.name == name).unwrap().range()];
        for (body, reaction) in model.bodies.iter().zip(&found.reactions) {
            let expected: Vec<f64> = reaction.force.iter().chain(reaction.moment.iter()).copied().collect();
            assert_eq!(of(&format!("reaction {}", body.name)), expected, "{name}: {}", body.name);
        }
        for (index, (_, force)) in found.drive_forces.iter().enumerate() {
            let push = of(&format!("drive {index}"))[0];
            assert!((push - force).abs() <= 1e-12 * force.abs().max(1.0), "{name}: {push} for {force}");
        }
        for (index, reaction) in found.loops.iter().enumerate() {
            let passed = of(&format!("loop {index}"));
            let expected: Vec<f64> = match reaction.pull {
                Some(pull) => vec![pull],
                None => reaction.force.iter().chain(reaction.moment.iter()).copied().collect(),
            };
            let size = expected.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            for (passed, expected) in passed.iter().zip(&expected) {
                assert!((passed - expected).abs() < 1e-12 * size, "{name}: {passed} for {expected}");
            }
        }
    }
}

/// A block on a stop, in statics and in a run: the stop carries what gravity pulls with.
#[test]
fn a_stop_pushes_with_what_rests_on_it() {
    let weight = 2.5 * 9.80665;
    for law in [StopLaw::Rigid { restitution: 0.0 }, StopLaw::Compliant { stiffness: 1e5, damping: 2e3 }] {
        let mut hinge = HingeDescription::prismatic([0.0, 0.0, 1.0]);
        hinge.limits = vec![LimitDescription { coordinate: 0, low: 0.0, high: 1.0, law }];
        let of = QuantityDescription::Force { of: "block".to_owned(), component: None };
        let scene = Description::new("A block on a stop")
            .body(BodyDescription::new("block", hinge).mass(2.5))
            .output(OutputDescription::new("floor", of));
        let model = build(&scene);
        let found = statics::equilibrium(&model, &statics::Settings::default(), &model.start_position).unwrap();
        let push = statics::outputs(&model, &found).unwrap()[0];
        assert!((push - weight).abs() < 1e-9 * weight, "{law:?}: {push}");
        let state = State { position: found.position.clone(), velocity: vec![0.0] };
        let mut ranges = OutputRanges::default();
        let settings = simulate::Settings { duration: 0.5, ..simulate::Settings::default() };
        let summary = simulate::run(&model, &settings, 100.0, &state, &mut ranges, &mut |_, _| true).unwrap();
        assert!((summary.outputs[0] - weight).abs() < 1e-7 * weight, "{law:?}: {}", summary.outputs[0]);
        for (name, value) in ranges.columns(&model, &summary.outputs) {
            assert!((value - weight).abs() < 1e-7 * weight, "{law:?}: {name} is {value}");
        }
    }
}

/// The mean square of a line from −1 to 2 over 3 s is 1, whatever the times of the samples.
#[test]
fn ranges_are_means_over_time() {
    let of = QuantityDescription::Expression { text: "t - 1".to_owned(), unit: "1".to_owned() };
    let scene = Description::new("A line")
        .body(BodyDescription::new("block", HingeDescription::prismatic([1.0, 0.0, 0.0])).mass(1.0))
        .output(OutputDescription::new("line", of));
    let model = build(&scene);
    let state = State { position: vec![0.0], velocity: vec![0.0] };
    let mut ranges = OutputRanges::default();
    let settings = simulate::Settings { duration: 3.0, ..simulate::Settings::default() };
    let summary = simulate::run(&model, &settings, 0.7, &state, &mut ranges, &mut |_, _| true).unwrap();
    let columns = ranges.columns(&model, &summary.outputs);
    let expected = [("line.end", 2.0), ("line.min", -1.0), ("line.max", 2.0), ("line.rms", 1.0)];
    for ((name, value), (called, is)) in columns.iter().zip(expected) {
        assert_eq!(name, called);
        assert!((value - is).abs() < 1e-12, "{name} is {value}");
    }
    ranges.finish(&stillpoint::record::Outcome { summary: String::new() }).unwrap();
}
