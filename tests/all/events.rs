//! Events against closed forms: when a pendulum hits a wall, how deep a pad gives way, what rests and what lets go.

mod account;
mod expressions;
mod generated;
mod mixed;
mod pressed;

use std::f64::consts::{FRAC_PI_2, PI};

use stillpoint::model::{Model, StopLaw};
use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::Scenario;
use stillpoint::simulate::events::{Kind, Occurrence};
use stillpoint::simulate::{self, RunError, State, Summary};

use crate::common::build;
use crate::scenarios::shipped;
use std::sync::Arc;

fn go(scenario: &Scenario, model: &Arc<Model>) -> Result<(Summary, Memory), RunError> {
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let still = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &still, scenario: &scenario.text, statics: None });
    let rate = scenario.record.rate;
    simulate::run(model, &scenario.simulate, rate, &start, &mut memory, &mut |_, _| true).map(|done| (done, memory))
}

/// As [`go`], and how far the state was beyond a rigid stop at worst at any step or event.
fn go_watched(scenario: &Scenario, model: &Arc<Model>) -> Result<(Summary, Memory, f64), RunError> {
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let still = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &still, scenario: &scenario.text, statics: None });
    let mut deepest = 0.0_f64;
    let mut look = |_: f64, state: &State| {
        for stop in model.stops.iter().filter(|stop| matches!(stop.law, StopLaw::Rigid { .. })) {
            let value = state.position[stop.position];
            deepest = deepest.max(value - stop.range[1]).max(stop.range[0] - value);
        }
        true
    };
    let summary = simulate::run(model, &scenario.simulate, scenario.record.rate, &start, &mut memory, &mut look)?;
    Ok((summary, memory, deepest))
}

fn run(text: &str) -> (Summary, Memory) {
    let scenario = stillpoint::scenario::parse("scene.toml", text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
    go(&scenario, &build(&scenario.description)).unwrap_or_else(|error| panic!("{error}"))
}

fn of<'a>(summary: &'a Summary, name: &str) -> Vec<&'a Occurrence> {
    summary.events.iter().filter(|event| event.name == name).collect()
}

/// K(k) by the arithmetic–geometric mean.
fn complete_elliptic_integral(modulus: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - modulus * modulus).sqrt());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    FRAC_PI_2 / a
}

/// The swing from the wall and back takes half a period of the amplitude that is left: sin(φ/2) loses a fifth per impact.
#[test]
fn pendulum_hits_its_wall_at_the_times_of_the_elliptic_integral() {
    for method in ["dop853", "dopri5", "radau9"] {
        let (scenario, model) =
            shipped("stops", &[&format!("simulate.integrator={method:?}"), "simulate.tolerance=1e-11"]);
        let (summary, _) = go(&scenario, &model).expect("a run");
        let impacts = of(&summary, "pendulum");
        let frequency = 9.81_f64.sqrt();
        let mut modulus = 0.5_f64.sin();
        let mut expected = complete_elliptic_integral(modulus) / frequency;
        let mut count = 0;
        while expected < 3.0 {
            let impact = impacts[count];
            assert_eq!(impact.kind, Kind::Impact);
            // Tolerances of 1e-11 a step, a hundred steps.
            assert!((impact.time - expected).abs() < 1e-9, "{method}: {} {expected}", impact.time);
            // Energy: the speed before is that of the fall.
            assert!((impact.speed + 2.0 * frequency * modulus).abs() < 1e-8, "{method}: {}", impact.speed);
            modulus *= 0.8;
            expected += 2.0 * complete_elliptic_integral(modulus) / frequency;
            count += 1;
        }
        assert_eq!(impacts.len(), count, "{method}");
        // What the three-point rule for the powers of the damped hinges misses.
        assert!(count >= 3 && summary.energy_drift < 1e-6, "{method}: {:e}", summary.energy_drift);
    }
}

#[test]
fn a_point_crosses_a_height_where_the_geometry_says() {
    let (scenario, model) = shipped("stops", &[]);
    let (summary, _) = go(&scenario, &model).expect("a run");
    let crossings = of(&summary, "bob at half height");
    // Down and up, twice: after the second impact the bob stays below, for 0.64 (1 − cos 1) < 0.25.
    let height = |impacts: i32| (1.0 - 1.0_f64.cos()) * 0.64_f64.powi(impacts);
    assert!(height(1) > 0.25 && height(2) < 0.25);
    assert_eq!(crossings.len(), 3, "{crossings:?}");
    for (crossing, (sign, impacts)) in crossings.iter().zip([(-1.0, 0), (1.0, 1), (-1.0, 1)]) {
        assert_eq!(crossing.kind, Kind::Crossing);
        // ½ v² = g (h − ¼), of which the vertical part at the angle acos ¾.
        let speed = (2.0 * 9.81 * (height(impacts) - 0.25)).sqrt() * 0.75_f64.acos().sin();
        assert!((crossing.speed - sign * speed).abs() < 1e-8, "{crossing:?} {speed}");
    }
    let fall = of(&summary, "hammer falls past 0.1");
    assert!((fall[0].time - (2.0 * 0.4 / 9.81_f64).sqrt()).abs() < 1e-10, "{fall:?}");
    assert!((fall[0].speed + (2.0 * 9.81 * 0.4_f64).sqrt()).abs() < 1e-9, "{fall:?}");
}

/// On an elastic pad the hammer swings for part of a period about the level where the pad would carry it.
#[test]
fn an_elastic_pad_gives_back_all_and_takes_the_time_of_its_swing() {
    let text = r#"
gravity = [0.0, 0.0, -10.0]
simulate = { start = "given", duration = 2.0, integrator = "dop853", tolerance = 1e-11 }
[[body]]
name = "hammer"
mass = 2.0
hinge = { type = "prismatic", axis = [0.0, 0.0, 1.0], position = 0.2, limits = { low = 0.0, stiffness = 800.0 } }
"#;
    let implicit = text.replace("dop853", "radau9");
    for text in [text, implicit.as_str()] {
        let (summary, _) = run(text);
        let (frequency, sag, fall) = (20.0_f64, 10.0 / 400.0, (2.0 * 0.2 / 10.0_f64).sqrt());
        let speed = 10.0 * fall;
        // x = −sag + sag cos ωt − (v/ω) sin ωt is zero again after this time.
        let contact = (2.0 * PI - 2.0 * (speed / frequency).atan2(sag)) / frequency;
        let expected = [fall, fall + contact, 3.0 * fall + contact, 3.0 * fall + 2.0 * contact];
        let kinds = [Kind::Contact, Kind::Separation, Kind::Contact, Kind::Separation];
        for ((event, time), kind) in of(&summary, "hammer").iter().zip(expected).zip(kinds) {
            assert_eq!(event.kind, kind);
            assert!((event.time - time).abs() < 1e-9, "{event:?} {time}");
        }
        assert!(summary.energy_drift < 1e-8, "{:e}", summary.energy_drift);
    }
}

/// A damped pad never pulls: it lets go before the spring is relaxed, and what it took out stands in the ledger.
#[test]
fn a_damped_pad_lets_go_before_it_is_relaxed() {
    let (scenario, model) = shipped("stops", &[]);
    let (summary, _) = go(&scenario, &model).expect("a run");
    let hammer = of(&summary, "hammer");
    assert_eq!((hammer[0].kind, hammer[1].kind), (Kind::Contact, Kind::Separation));
    assert!(hammer[1].speed > 0.0 && hammer[1].speed < -hammer[0].speed);
    // What the three-point rule for the damper's power misses, of 10 J.
    assert!(summary.energy_drift < 1e-6, "{:e}", summary.energy_drift);
}

#[test]
fn what_reaches_a_plain_limit_rests_there_bit_for_bit() {
    for method in ["dop853", "radau9", "sdirk4", "generalized-alpha"] {
        let changes = [format!("simulate.integrator={method:?}"), "simulate.tolerance=1e-7".to_owned()];
        let (scenario, model) = shipped("stops", &[&changes[0], &changes[1]]);
        let (summary, memory) = go(&scenario, &model).expect("a run");
        let tray = of(&summary, "tray");
        assert_eq!((tray.len(), tray[0].kind), (1, Kind::Rest), "{method}: {tray:?}");
        let last = memory.samples.last().expect("samples");
        let index = model.bodies[model.body("tray").expect("a body")].hinge.position;
        assert_eq!((last.positions[index], last.velocities[index]), (-0.2, 0.0), "{method}");
        assert_eq!(last.accelerations[index], 0.0, "{method}");
    }
}

/// A ball that bounces ever lower comes to rest in finite time, Zeno's: 2 v/g e/(1 − e) after the first impact.
#[test]
fn a_bouncing_mass_comes_to_rest_when_zeno_says() {
    let (summary, _) = run(r#"
gravity = [0.0, 0.0, -10.0]
simulate = { start = "given", duration = 2.0, integrator = "dopri5", tolerance = 1e-9 }
[[body]]
name = "ball"
mass = 1.0
hinge = { type = "prismatic", axis = [0.0, 0.0, 1.0], position = 0.2, limits = { low = 0.0, restitution = 0.5 } }
"#);
    let last = summary.events.last().expect("events");
    assert_eq!(last.kind, Kind::Rest);
    // t₁ + 2 t₁ (e + e² + …) = 3 t₁; the bounces below ten tolerances of speed are left out.
    assert!((last.time - 3.0 * 0.2).abs() < 1e-7, "{}", last.time);
    assert_eq!((summary.state.position[0], summary.state.velocity[0]), (0.0, 0.0));
    assert!(summary.events.len() > 20 && summary.energy_drift < 1e-9);
}

/// A lever pressed onto its stop by gravity lets go when a swinging mass on it pulls it up.
#[test]
fn a_resting_hinge_is_let_go_when_nothing_presses_it_on() {
    let text = r#"
gravity = [0.0, 0.0, -10.0]
simulate = { start = "given", duration = 1.0, integrator = "METHOD", tolerance = 1e-9 }
[[body]]
name = "lift"
mass = 1.0
hinge = { type = "prismatic", axis = [0.0, 0.0, 1.0], position = 0.0, velocity = 0.0, limits = { low = 0.0 } }
[[body]]
name = "arm"
mass = 1.0
center = [0.5, 0.0, 0.0]
hinge = { type = "revolute", parent = "lift", axis = [0.0, 1.0, 0.0], velocity = -12.0 }
"#;
    for method in ["dop853", "radau9"] {
        let (summary, _) = run(&text.replace("METHOD", method));
        let lift = of(&summary, "lift");
        assert_eq!((lift[0].kind, lift[1].kind), (Kind::Rest, Kind::Release), "{method}: {lift:?}");
        // On the stop the arm is a pendulum: the point mass at r = ½ pulls up with m (r φ̇² sin φ − r φ̈ cos φ …) − 2 m g = 0,
        // that is r φ̇² s + g c² = 2 g with s = sin φ, c = cos φ, r φ̇² = r·144 − 2 g s.
        let pull = |s: f64| (72.0 - 20.0 * s) * s + 10.0 * (1.0 - s * s) - 20.0;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if pull(middle) > 0.0 { high = middle } else { low = middle }
        }
        // dt = dφ / φ̇ by Simpson's rule.
        let angle = low.asin();
        let rate = |phi: f64| 1.0 / (144.0 - 40.0 * phi.sin()).sqrt();
        let n = 200;
        let h = angle / f64::from(n);
        let weight = |i: i32| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
        let expected: f64 = (0..=n).map(|i| weight(i) * rate(f64::from(i) * h)).sum::<f64>() * h / 3.0;
        assert!((lift[1].time - expected).abs() < 1e-7, "{method}: {} {expected}", lift[1].time);
        assert!(summary.energy_drift < 1e-6, "{method}: {:e}", summary.energy_drift);
    }
}

#[test]
fn an_event_ends_the_run_and_is_the_last_sample() {
    let (summary, memory) = run(r#"
gravity = [0.0, 0.0, -10.0]
simulate = { start = "given", duration = 5.0, integrator = "dop853", tolerance = 1e-10 }
[[body]]
name = "ball"
mass = 1.0
hinge = { type = "prismatic", axis = [0.0, 0.0, 1.0], position = 5.0 }
[[event]]
name = "ground"
hinge = "ball"
direction = "down"
action = "stop"
"#);
    assert_eq!(summary.stopped_by.as_deref(), Some("ground"));
    assert!(!summary.interrupted);
    // Free fall is a parabola, which the method has exactly; the rest is rounding and the bisection.
    assert!((summary.end_time - 1.0).abs() < 2e-12, "{}", summary.end_time);
    assert_eq!(memory.samples.last().expect("samples").time, summary.end_time);
}

#[test]
fn a_start_beyond_a_limit_is_refused() {
    let (mut scenario, _) = shipped("stops", &[]);
    let pendulum = scenario.description.bodies.iter_mut().find(|body| body.name == "pendulum");
    pendulum.expect("a pendulum").hinge.position = vec![-0.1];
    let model = build(&scenario.description);
    let error = go(&scenario, &model).expect_err("beyond").to_string();
    assert!(error.contains("`pendulum` starts at -0.1, beyond its limits 0 to inf"), "{error}");
}

/// Nothing is watched where there is nothing to watch.
#[test]
fn a_scene_without_events_makes_none() {
    let (scenario, model) = shipped("double_pendulum", &["simulate.duration=0.5"]);
    assert!(model.stops.is_empty() && model.events.is_empty());
    assert!(go(&scenario, &model).expect("a run").0.events.is_empty());
}

/// Every event is marked in the recording, between the samples before it and those after.
#[test]
fn events_are_in_the_recording_in_order_of_time() {
    let (scenario, model) = shipped("stops", &[]);
    let (summary, memory) = go(&scenario, &model).expect("a run");
    assert_eq!(memory.events.len(), summary.events.len());
    assert!(memory.events.windows(2).all(|pair| pair[0].time <= pair[1].time));
    for (event, occurrence) in memory.events.iter().zip(&summary.events) {
        assert_eq!((event.time, &event.name), (occurrence.time, &occurrence.name));
        assert!(event.text.contains(&occurrence.name) && event.text.contains(occurrence.kind.name()), "{event:?}");
    }
}

/// What the program changes of the integrator is an event as well.
#[test]
fn a_change_of_the_integrator_is_an_event() {
    let (scenario, model) = shipped("stiff_chain", &["simulate.tolerance=1e-6", "simulate.duration=0.1"]);
    let (summary, memory) = go(&scenario, &model).expect("a run");
    let [switch] = &summary.events[..] else { panic!("{:?}", summary.events) };
    assert_eq!((switch.kind, switch.name.as_str()), (Kind::Switch, "radau9"));
    let held = summary.choice.as_ref().expect("a choice");
    assert!(held.contains("adams was held by stability"), "{held}");
    assert_eq!((memory.events[0].name.as_str(), memory.events[0].time), ("integrator", switch.time));
}
