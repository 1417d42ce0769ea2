//! Stops beside loops and gears: a blow goes through all that they tie together, and what rests is carried through them.

use crate::common::build;
use crate::scenarios::{found, shipped};
use std::sync::Arc;
use stillpoint::model::{Model, Side};
use stillpoint::record::Fanout;
use stillpoint::scenario::Scenario;
use stillpoint::simulate::events::Kind;
use stillpoint::simulate::{self, RunError, State, Summary};
use stillpoint::statics::{Settings, StabilityVerdict, equilibrium};

const G: f64 = 9.80665;
/// Of the parallelogram: the weights' lever, and the inertia that all of it has about the rods' hinges.
const LEVER: f64 = 2.0 * 0.25 + 2.0 * 0.5;
const INERTIA: f64 = 2.0 * (0.02 + 0.0625) + 2.0 * 0.25;

fn go(scenario: &Scenario, model: &Arc<Model>) -> Result<Summary, RunError> {
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    simulate::run(model, &scenario.simulate, 100.0, &start, &mut Fanout::new(), &mut |_, _| true)
}

fn read(text: &str) -> (Scenario, Arc<Model>) {
    let scenario = stillpoint::scenario::parse("scene.toml", text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
    let model = build(&scenario.description);
    (scenario, model)
}

/// The shipped scene with other limits.
fn parallelogram(limits: &str, integrator: &str) -> (Scenario, Arc<Model>) {
    let text = shipped("parallelogram_on_stop", &[]).0.text;
    read(&text.replace("{ low = 0.2, restitution = 0.5 }", limits).replace("dop853", integrator))
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected} within {tolerance:e}");
}

#[test]
fn a_blow_halves_the_speed_of_all_bars_until_they_rest() {
    for method in ["dop853", "radau9"] {
        let (scenario, model) = shipped("parallelogram_on_stop", &[&format!("simulate.integrator={method:?}")]);
        let summary = go(&scenario, &model).unwrap_or_else(|error| panic!("{error}"));
        let lost = LEVER * G * (0.2_f64.cos() - 1.0_f64.cos());
        let mut speed = (2.0 * lost / INERTIA).sqrt();
        let (last, blows) = summary.events.split_last().expect("events");
        assert!(blows.len() > 5);
        for blow in blows.iter().take(5) {
            assert_eq!((blow.kind, blow.name.as_str()), (Kind::Impact, "right"));
            // Tolerances of 1e-10 a step, some hundred steps.
            near(blow.speed, -speed, 1e-7);
            speed *= 0.5;
        }
        assert_eq!(last.kind, Kind::Rest, "{method}");
        for (found, expected) in summary.state.position.iter().zip([0.2, -0.2, 0.2]) {
            near(*found, expected, 1e-12);
        }
        assert!(summary.state.velocity.iter().all(|v| v.abs() < 1e-12), "{:?}", summary.state.velocity);
        near(summary.dissipated, lost, 1e-7);
        assert!(summary.energy_drift < 1e-7 && summary.constraint_error < 1e-12, "{summary:?}");
    }
}

#[test]
fn the_stop_of_one_rod_bears_the_moments_of_all_bars() {
    let (scenario, model) = shipped("parallelogram_on_stop", &[]);
    let rest = found(&scenario, &model);
    let [stop] = &rest.stops[..] else { panic!("{:?}", rest.stops) };
    assert!(stop.side == Side::Low && stop.depth == 0.0 && stop.hinge == "`right`");
    near(stop.load, LEVER * G * 0.2_f64.sin(), 1e-9);
    for (found, expected) in rest.position.iter().zip([0.2, -0.2, 0.2]) {
        near(*found, expected, 1e-12);
    }
    // Nothing is left that could move.
    let stability = rest.stability.expect("a verdict");
    assert_eq!((stability.verdict, stability.modes.len()), (StabilityVerdict::Stable, 0));
    // From there a run goes nowhere.
    let start = State { position: rest.position.clone(), velocity: vec![0.0; 3] };
    let summary = simulate::run(&model, &scenario.simulate, 100.0, &start, &mut Fanout::new(), &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(summary.events[0].kind, Kind::Rest);
    for (now, before) in summary.state.position.iter().zip(&rest.position) {
        near(*now, *before, 1e-12);
    }
}

/// The moment of the rubber is that of the weights: in statics, and where the swinging ends.
#[test]
fn a_rubber_stop_gives_way_as_far_as_the_weights_push_it() {
    let (stiffness, limits) = (60.0, "{ low = 0.2, stiffness = 60.0, damping = 6.0 }");
    let (_, model) = parallelogram(limits, "dop853");
    let rest = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
    assert!(rest.converged, "{:?}", rest.notes);
    let depth = rest.stops[0].depth;
    near(stiffness * depth, LEVER * G * (0.2 - depth).sin(), 1e-9);
    near(rest.position[0], 0.2 - depth, 1e-12);
    for method in ["dop853", "radau9"] {
        let (mut scenario, model) = parallelogram(limits, method);
        scenario.simulate.duration = 8.0;
        let summary = go(&scenario, &model).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(summary.events[0].kind, Kind::Contact);
        near(summary.state.position[2], 0.2 - depth, 1e-6);
        assert!(summary.energy_drift < 1e-6, "{method} {:e}", summary.energy_drift);
    }
}

/// Two fingers that a gear ties together, each with its limits: they reach them at once.
fn fingers(more: &str) -> (Scenario, Arc<Model>) {
    let finger = |name: &str, axis: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = 0.1\nhinge = {{ type = \"prismatic\", axis = {axis}, position = 0.03, \
             force = -0.05, limits = [0.0, 0.04] }}\n"
        )
    };
    let (left, right) = (finger("left", "[1.0, 0.0, 0.0]"), finger("right", "[-1.0, 0.0, 0.0]"));
    read(&format!(
        "[simulate]\nstart = \"given\"\nduration = 1.0\nintegrator = \"dop853\"\n{left}{right}\
         [[gear]]\nname = \"mimic\"\ntype = \"ratio\"\nratio = 1.0\nbetween = [\"right\", \"left\"]\n{more}"
    ))
}

#[test]
fn fingers_of_one_gear_come_to_their_stops_together() {
    let (scenario, model) = fingers("");
    let rest = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
    assert!(rest.converged, "{:?}", rest.notes);
    // Gears are closed to 1e-14 m in a scene without lengths of its own.
    near(rest.position[0], 0.0, 1e-14);
    near(rest.position[1], 0.0, 1e-14);
    // One of the stops, or both: together they bear both pushes.
    near(rest.stops.iter().map(|stop| stop.load).sum(), 0.1, 1e-12);
    let summary = go(&scenario, &model).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(summary.events[0].kind, Kind::Rest);
    // From 30 mm with half a metre per second squared.
    near(summary.events[0].time, (2.0 * 0.03_f64 / 0.5).sqrt(), 1e-9);
    assert!(summary.state.position.iter().all(|x| x.abs() < 1e-12), "{:?}", summary.state);
    let closed = State { position: vec![0.0; 2], velocity: vec![0.0; 2] };
    let summary = simulate::run(&model, &scenario.simulate, 100.0, &closed, &mut Fanout::new(), &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(summary.state.position.iter().all(|x| x.abs() < 1e-12), "{:?}", summary.state);
}

/// On a swinging arm the gear balances both fingers exactly: what is left of the forces is rounding, which changes its sign
/// in every step and moves nothing.
#[test]
fn fingers_that_nothing_pulls_stay_on_their_stops() {
    let finger = |name: &str, axis: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = 0.1\ninertia = [1e-5, 1e-5, 1e-5]\n\
             hinge = {{ type = \"prismatic\", parent = \"arm\", at = [0.0, 0.0, -0.5], axis = {axis}, limits = [0.0, 0.04] }}\n"
        )
    };
    let (left, right) = (finger("left", "[1.0, 0.0, 0.0]"), finger("right", "[-1.0, 0.0, 0.0]"));
    let (scenario, model) = read(&format!(
        "[simulate]\nstart = \"given\"\nduration = 2.0\nintegrator = \"dop853\"\n\
         [[body]]\nname = \"arm\"\nmass = 1.0\ncenter = [0.0, 0.0, -0.25]\ninertia = [0.02, 0.02, 0.001]\n\
         hinge = {{ type = \"revolute\", axis = [0.0, 1.0, 0.0], position = 0.7 }}\n{left}{right}\
         [[gear]]\nname = \"mimic\"\ntype = \"ratio\"\nratio = 1.0\nbetween = [\"right\", \"left\"]\n"
    ));
    let summary = go(&scenario, &model).unwrap_or_else(|error| panic!("{error}"));
    assert!(summary.events.iter().all(|event| event.kind == Kind::Rest && event.time == 0.0), "{:?}", summary.events);
    assert!(summary.statistics.steps < 200, "{}", summary.statistics.steps);
    near(summary.state.position[1], 0.0, 1e-12);
}

#[test]
fn a_drive_that_runs_through_a_stop_is_told() {
    let drive = "[[drive]]\nname = \"close\"\nhinge = \"left\"\ntype = \"rate\"\nrate = -0.1\n";
    let (scenario, model) = fingers(drive);
    let error = go(&scenario, &model).expect_err("the drive cannot go on").to_string();
    assert!(error.contains("`close` leave") && error.contains("is driven through its limit 0"), "{error}");
}
