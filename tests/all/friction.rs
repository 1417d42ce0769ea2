//! Dry friction of hinges in motion: closed forms, and random scenes against time stepping with impulses, which knows nothing of
//! events.

mod geared;
mod stepping;
mod struck;

use std::f64::consts::PI;

use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::Scenario;
use stillpoint::simulate::events::{Kind, Occurrence};
use stillpoint::simulate::{self, State, Summary};

use crate::common::build;
use crate::scenarios::shipped;

const METHODS: [&str; 7] = ["adams", "dop853", "dopri5", "radau5", "radau9", "sdirk4", "auto"];

fn go(scenario: &Scenario) -> Summary {
    let model = build(&scenario.description);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let still = simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &still, scenario: &scenario.text, statics: None });
    simulate::run(&model, &scenario.simulate, 100.0, &start, &mut memory, &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{error}: {}", scenario.text))
}

fn parse(text: &str) -> Scenario {
    stillpoint::scenario::parse("scene.toml", text, &[]).unwrap_or_else(|found| panic!("{found:?}"))
}

fn of(summary: &Summary, kind: Kind) -> Vec<&Occurrence> {
    summary.events.iter().filter(|event| event.kind == kind).collect()
}

/// Each half swing takes π √(I/k) and loses 2 τ/k; the seventh ends where 2 N m/rad pull with less than 0.15 N m.
#[test]
fn a_wheel_stops_for_good_after_seven_half_swings() {
    for method in METHODS {
        let (scenario, _) = shipped("dry_wheel", &[&format!("simulate.integrator={method:?}")]);
        let summary = go(&scenario);
        let (slips, sticks) = (of(&summary, Kind::Slip), of(&summary, Kind::Stick));
        assert_eq!((slips.len(), sticks.len()), (7, 1), "{method}: {:?}", summary.events);
        let half = PI * 0.01_f64.sqrt();
        for (turn, slip) in slips.iter().enumerate() {
            let angle = (1.0 - 0.15 * turn as f64) * if turn % 2 == 0 { 1.0 } else { -1.0 };
            assert!((slip.time - half * turn as f64).abs() < 1e-9, "{method}: {slip:?}");
            assert!((slip.value - angle).abs() < 1e-9, "{method}: {slip:?} {angle}");
        }
        assert!((sticks[0].time - 7.0 * half).abs() < 1e-9, "{method}: {sticks:?}");
        assert!((summary.state.position[0] - 0.05).abs() < 1e-9, "{method}: {:?}", summary.state);
        assert_eq!(summary.state.velocity[0], 0.0, "{method}");
        // ½ k (1 − 0.05²): the account closes.
        assert!((summary.dissipated - 0.9975).abs() < 1e-9 && summary.energy_drift < 1e-9, "{method}");
    }
}

/// Reference case C10: 25 half swings, 51 J.
#[test]
fn a_mass_on_a_spring_decays_by_the_same_amount_each_half_swing() {
    let text = "gravity = [0, 0, 0]\nsimulate = { start = \"given\", duration = 10, tolerance = 1e-10 }\n[[body]]\nname = \"mass\"\n\
                mass = 1.0\nhinge = { type = \"prismatic\", axis = [1, 0, 0], position = 1.01, stiffness = 100, friction = 2 }\n";
    let summary = go(&parse(text));
    let (slips, sticks) = (of(&summary, Kind::Slip), of(&summary, Kind::Stick));
    assert_eq!((slips.len(), sticks.len()), (25, 1), "{:?}", summary.events);
    assert!((sticks[0].time - 2.5 * PI).abs() < 1e-9, "{sticks:?}");
    assert!((summary.state.position[0] + 0.01).abs() < 1e-9, "{:?}", summary.state);
    assert!((summary.dissipated - 51.0).abs() < 1e-7, "{}", summary.dissipated);
}

/// Reference case C09: 3 N are reached after 0.3 s on the belt, then half an oscillation about 2 N/k and back.
#[test]
fn a_block_on_a_belt_sticks_and_slips_with_an_exact_period() {
    for method in METHODS {
        let (scenario, _) = shipped("stick_slip", &[&format!("simulate.integrator={method:?}")]);
        let summary = go(&scenario);
        let (slips, sticks) = (of(&summary, Kind::Slip), of(&summary, Kind::Stick));
        assert_eq!((slips.len(), sticks.len()), (5, 5), "{method}: {:?}", summary.events);
        for (cycle, (slip, stick)) in slips.iter().zip(&sticks).enumerate() {
            let begins = 0.3 + 0.671_238_898_038_469 * cycle as f64;
            // A tenth of a nanonewton late each time: the round-off of what holds.
            assert!((slip.time - begins).abs() < 1e-8, "{method}: {slip:?} {begins}");
            assert!((stick.time - begins - 0.471_238_898_038_469).abs() < 1e-8, "{method}: {stick:?}");
        }
    }
}

/// What holds at 0.999 of its friction does not move, not even in the last bit, and costs next to nothing; at 1.001 it slides as
/// the closed form says.
#[test]
fn on_an_incline_what_holds_stays_and_what_does_not_slides() {
    let slope = 0.4_f64;
    for (factor, seconds) in [(0.999, 10.0), (0.999, 1000.0), (1.001, 10.0), (1.0 - 1e-6, 10.0), (1.0 + 1e-6, 10.0)] {
        let load = 9.81 * slope.sin();
        let text = format!(
            "gravity = [0, 0, -9.81]\nsimulate = {{ start = \"given\", duration = {seconds}, tolerance = 1e-10 }}\n[[body]]\nname = \
             \"block\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", axis = [{}, 0, {}], friction = {} }}\n",
            slope.cos(),
            -slope.sin(),
            load / factor
        );
        let summary = go(&parse(&text));
        let slid = summary.state.position[0];
        if factor < 1.0 {
            assert_eq!((slid, summary.events.len()), (0.0, 0), "{factor}");
            assert!(summary.statistics.acceleration_evaluations < 300, "{:?}", summary.statistics);
        } else {
            let expected = 0.5 * (load - load / factor) * seconds * seconds;
            assert!((slid - expected).abs() < 1e-9, "{factor}: {slid} {expected}");
        }
    }
}

/// The norm of the torque counts in a spherical hinge: a ball that spins about any axis loses speed at the same rate, and stops.
#[test]
fn a_spinning_ball_stops_when_its_momentum_is_spent() {
    let text = "gravity = [0, 0, 0]\nsimulate = { start = \"given\", duration = 3, tolerance = 1e-10, integrator = METHOD }\n[[body]]\n\
                name = \"ball\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nhinge = { type = \"spherical\", velocity = [1, -2, 2], \
                friction = { stick = 0.3, slide = 0.2 } }\n";
    for method in METHODS {
        let summary = go(&parse(&text.replace("METHOD", &format!("{method:?}"))));
        // ω = 3 − 2 t rad/s.
        let sticks = of(&summary, Kind::Stick);
        assert_eq!(sticks.len(), 1, "{method}: {:?}", summary.events);
        assert!((sticks[0].time - 1.5).abs() < 1e-8, "{method}: {sticks:?}");
        assert_eq!(summary.state.velocity, [0.0; 3], "{method}");
        assert!((summary.dissipated - 0.45).abs() < 1e-8 && summary.energy_drift < 1e-8, "{method}: {summary:?}");
        // The angle 2.25 rad about (1, −2, 2)/3.
        let expected = [(1.125_f64).cos(), (1.125_f64).sin() / 3.0];
        let [w, x] = [0, 1].map(|k| summary.state.position[k]);
        assert!(
            (w.abs() - expected[0].abs()).abs() < 1e-8 && (x.abs() - expected[1]).abs() < 1e-8,
            "{method}: {w} {x}"
        );
    }
}

/// A coordinate that rests on a stop and has friction lets go when what pulls exceeds the friction.
#[test]
fn friction_holds_what_rests_on_a_stop_until_more_pulls() {
    let text = "gravity = [0, 0, 0]\nsimulate = { start = \"given\", duration = 2, tolerance = 1e-10 }\n[[body]]\nname = \"cart\"\nmass = 1\n\
                hinge = { type = \"prismatic\", axis = [1, 0, 0], friction = 2, limits = [0, 9] }\n[[motor]]\nname = \"pull\"\nhinge = \"cart\"\n\
                type = \"expression\"\nexpression = \"4*t - 3\"\n";
    let summary = go(&parse(text));
    // 3 N press at first; 2 N pull at 5/4 s; then v̇ = 4 (t − 5/4).
    let slips = of(&summary, Kind::Slip);
    assert_eq!(slips.len(), 1, "{:?}", summary.events);
    assert!((slips[0].time - 1.25).abs() < 1e-8, "{slips:?}");
    let expected = 4.0 / 6.0 * 0.75_f64.powi(3);
    assert!((summary.state.position[0] - expected).abs() < 1e-8, "{:?} {expected}", summary.state);
}
