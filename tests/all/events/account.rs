//! The energy account of recordings: what a summary says of it holds at every sample.

use super::{go_watched, run};
use crate::scenarios::{found, names, shipped};
use stillpoint::record::Memory;
use stillpoint::simulate::{self, Start, State};

/// Largest imbalance of the samples (J).
fn worst(memory: &Memory) -> f64 {
    memory.samples.iter().map(|sample| sample.energy.error.abs()).fold(0.0, f64::max)
}

/// In every shipped scene; long runs are cut.
#[test]
fn samples_are_as_well_accounted_for_as_steps() {
    for name in names() {
        let (mut scenario, model) = shipped(&name, &[]);
        scenario.simulate.duration = scenario.simulate.duration.min(2.0);
        let start = match scenario.simulate.start {
            Start::Given => State { position: model.start_position.clone(), velocity: model.start_velocity.clone() },
            Start::Equilibrium => {
                State { position: found(&scenario, &model).position, velocity: vec![0.0; model.velocity_count()] }
            }
        };
        let still = simulate::scene(&model);
        let opening = stillpoint::record::Opening { scene: &still, scenario: &scenario.text, statics: None };
        let mut memory = Memory::new(&opening);
        let rate = scenario.record.rate;
        let summary = simulate::run(&model, &scenario.simulate, rate, &start, &mut memory, &mut |_, _| true)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let worst = worst(&memory);
        assert!(worst <= summary.energy_drift, "{name}: {worst:e} J, {:e} J", summary.energy_drift);
    }
}

/// A ball on a shaken table: from one contact to the next all is in closed form, so that what the table has put in is the
/// energy that the ball has gained, whatever the method.
#[test]
fn a_drive_is_told_what_it_puts_in_across_contacts() {
    let text = |method: &str, stop: &str| {
        format!(
            "[simulate]\nduration = 2.0\nstart = \"given\"\nintegrator = \"{method}\"\n[[body]]\nname = \"table\"\nmass = 1.0\n\
             hinge = {{ type = \"prismatic\", axis = [0, 0, 1] }}\n[[body]]\nname = \"ball\"\nmass = 1.0\n\
             hinge = {{ type = \"prismatic\", parent = \"table\", axis = [0, 0, 1], position = 0.01, \
             limits = {{ low = 0.0, {stop} }} }}\n[[drive]]\nname = \"shaker\"\nhinge = \"table\"\ntype = \"sine\"\n\
             amplitude = 0.02\nfrequency = 5.0\n"
        )
    };
    for stop in ["stiffness = 1e4", "restitution = 1.0", "restitution = 0.6", "stiffness = 1e4, damping = 20.0"] {
        for method in ["dop853", "dopri5", "adams", "sdirk4", "radau5", "radau9", "rk4", "gauss"] {
            // Of methods with a fixed step the one that is taken where none is given is short enough for the stop.
            let (summary, memory) = run(&text(method, stop));
            // The tolerance of 1e-8 in speeds of metres per second.
            assert!(summary.energy_drift < 1e-6, "{stop} {method}: {:e}", summary.energy_drift);
            assert!(worst(&memory) < 1e-6, "{stop} {method}: {:e}", worst(&memory));
            let lossless = stop == "stiffness = 1e4" || stop == "restitution = 1.0";
            // Blows and pads take out; a drive gives back nothing to them.
            let dissipated = summary.dissipated;
            assert!(
                if lossless { dissipated.abs() < 1e-9 } else { dissipated > 1e-3 },
                "{stop} {method}: {dissipated}"
            );
        }
    }
}

/// A blow against a driven body is answered by the drive: its impulse times its speed is its work.
#[test]
fn a_blow_against_a_driven_body_is_work() {
    let text = "gravity = [0, 0, 0]\n[simulate]\nduration = 1.0\nstart = \"given\"\n[[body]]\nname = \"bat\"\nmass = 5.0\n\
        hinge = { type = \"prismatic\", axis = [1, 0, 0], velocity = 2.0 }\n[[body]]\nname = \"ball\"\nmass = 0.5\n\
        hinge = { type = \"prismatic\", parent = \"bat\", axis = [1, 0, 0], position = 1.0, velocity = -5.0, \
        limits = { low = 0.0, restitution = 0.8 } }\n[[drive]]\nname = \"arm\"\nhinge = \"bat\"\ntype = \"rate\"\nrate = 2.0\n";
    let (summary, _) = run(text);
    // The ball comes at −3 m/s and leaves at 2 + 0.8 · 5 = 6 m/s: an impulse of 0.5 · 9 Ns, at 2 m/s.
    assert!((summary.work - 0.5 * 9.0 * 2.0).abs() < 1e-9, "{}", summary.work);
    assert!((summary.dissipated - 0.5 * 0.5 * 25.0 * (1.0 - 0.64)).abs() < 1e-9, "{}", summary.dissipated);
    assert!(summary.energy_drift < 1e-9, "{:e}", summary.energy_drift);
}

/// Numbers that are not finite are refused before they are recorded.
#[test]
fn nothing_is_recorded_that_is_not_a_number() {
    let text = "[simulate]\nstart = \"given\"\nduration = 0.1\n[[body]]\nname = \"rod\"\nmass = 1.0\ncenter = [0, 0, -1]\n\
        inertia = [1.0, 1.0, 0.1]\nhinge = { type = \"revolute\", axis = [0, 1, 0], position = 0.5 }\n";
    let scenario = stillpoint::scenario::parse("rod.toml", text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
    let model = crate::common::build(&scenario.description);
    for velocity in [1e154, 1e200, 1e300] {
        let start = State { position: vec![0.5], velocity: vec![velocity] };
        let mut nobody = stillpoint::record::Fanout::new();
        let run =
            simulate::run(&model, &scenario.simulate, scenario.record.rate, &start, &mut nobody, &mut |_, _| true);
        let error = run.expect_err("numbers that overflow").to_string();
        assert!(error.contains("`rod`"), "{velocity}: {error}");
    }
}

#[test]
fn an_angle_without_digits_is_refused_by_name() {
    let text = "[simulate]\nstart = \"given\"\n[[body]]\nname = \"rod\"\nmass = 1.0\ncenter = [0, 0, -1]\n\
        hinge = { type = \"revolute\", axis = [0, 1, 0], position = 1e17 }\n";
    let scenario = stillpoint::scenario::parse("rod.toml", text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
    let error = go_watched(&scenario, &crate::common::build(&scenario.description)).expect_err("refused").to_string();
    assert!(error.contains("`rod`") && error.contains("whole turns"), "{error}");
}

#[test]
fn more_samples_than_a_disk_holds_are_refused_before_the_run() {
    let text = "[record]\nrate = 1e12\n[[body]]\nname = \"rod\"\nmass = 1.0\ncenter = [0, 0, -1]\n\
        hinge = { type = \"revolute\", axis = [0, 1, 0] }\n";
    let found = stillpoint::scenario::parse("rod.toml", text, &[]).expect_err("refused");
    assert!(format!("{found:?}").contains("more than 1e8"), "{found:?}");
}

/// A step that is full of samples is left when it is asked to stop.
#[test]
fn a_run_is_stopped_between_samples() {
    let text = "[record]\nrate = 1e6\n[simulate]\nstart = \"given\"\nduration = 50.0\n[[body]]\nname = \"ball\"\nmass = 1.0\n\
        hinge = { type = \"prismatic\", axis = [0, 0, 1] }\n";
    let scenario = stillpoint::scenario::parse("ball.toml", text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
    let model = crate::common::build(&scenario.description);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let began = std::time::Instant::now();
    let mut nobody = stillpoint::record::Fanout::new();
    let summary = simulate::run(&model, &scenario.simulate, scenario.record.rate, &start, &mut nobody, &mut |_, _| {
        began.elapsed().as_millis() < 100
    });
    let summary = summary.unwrap_or_else(|error| panic!("{error}"));
    assert!(summary.interrupted && summary.samples < 10_000_000, "{}", summary.samples);
}
