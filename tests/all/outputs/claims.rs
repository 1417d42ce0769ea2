//! What the outputs of shipped scenarios say, against mechanics done by hand.

use crate::scenarios::file;
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::{Override, Scenario, load_with};
use stillpoint::simulate::{self, State};
use stillpoint::statics;
use stillpoint::statics::path::follow;

fn load(name: &str, set: &[&str]) -> (Scenario, Arc<Model>) {
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).unwrap()).collect();
    let scenario = load_with(&file(name), &set).unwrap_or_else(|problem| panic!("{name}: {problem}"));
    let (model, _) = assemble(Model::build(&scenario.description).unwrap()).unwrap();
    (scenario, model)
}

fn place(model: &Model, name: &str) -> usize {
    model.outputs.iter().find(|output| output.name == name).unwrap_or_else(|| panic!("no `{name}`")).first
}

/// The counterweight's weight pulls the rope, on both sides of the hook: `2 T sin(slope) = m g`.
#[test]
fn the_rope_carries_the_counterweight_and_the_load() {
    let (scenario, model) = load("rope_over_pulleys", &[]);
    let found = statics::equilibrium(&model, &scenario.statics, &model.start_position).unwrap();
    let values = statics::outputs(&model, &found).unwrap();
    let tension = values[place(&model, "tension")];
    assert!((tension - 30.0 * 9.80665).abs() < 1e-9 * tension, "{tension}");
    let stretched = values[place(&model, "path")] - 6.0;
    assert!((4e4 * stretched - tension).abs() < 1e-6 * tension, "{stretched}");
    let hook = &values[place(&model, "hook")..][..3];
    let (across, down) = (1.0 - hook[0], 2.0 - hook[2]);
    let sine = down / across.hypot(down);
    assert!((2.0 * tension * sine - 36.0 * 9.80665).abs() < 1e-6 * tension, "{sine}");
}

/// The bar that closes the loop keeps its length for all of the run, and the coupler's speed is the rate of its place.
#[test]
fn the_coupler_point_of_the_four_bar_moves_on_its_curve() {
    let (scenario, model) = load("four_bar", &[]);
    let scene = simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    let settings = simulate::Settings { duration: 1.0, ..scenario.simulate };
    let state = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    simulate::run(&model, &settings, 2000.0, &state, &mut memory, &mut |_, _| true).unwrap();
    let (length, point, speed) =
        (place(&model, "rocker length"), place(&model, "coupler point"), place(&model, "coupler speed"));
    for window in memory.samples.windows(3) {
        assert!((window[1].outputs[length] - 0.3).abs() < 1e-12);
        for axis in 0..3 {
            // Central differences over 1 ms of a motion of 14 rad/s and its harmonics.
            let rate = (window[2].outputs[point + axis] - window[0].outputs[point + axis]) * 1000.0;
            assert!((rate - window[1].outputs[speed + axis]).abs() < 2e-3, "at {}", window[1].time);
        }
    }
}

/// Camber against travel as the chassis gets heavier: by the circles that the ball joints move on in their plane.
#[test]
fn camber_against_travel_is_that_of_two_circles() {
    let path = r#"statics.path={ parameter = "chassis.mass", from = 250.0, to = 350.0, at = [300.0, 350.0] }"#;
    let (scenario, model) = load("double_wishbone", &[path]);
    let settings = scenario.path.clone().unwrap();
    let path = follow(&scenario.description, &scenario.statics, &settings, &mut |_| true).unwrap();
    let (camber, travel) = (place(&model, "camber"), place(&model, "travel"));
    let points = &path.branches[0].points;
    assert!(points.len() > 5 && path.complete, "{:?}", path.notes);
    let mut before: Option<[f64; 2]> = None;
    for point in points {
        let hinge = &model.bodies[model.body("lower arm").unwrap()].hinge;
        let angle = point.position[hinge.position];
        // Lower ball, upper pivot and the lengths of upright and upper arm, seen along x.
        let lower = [0.35 + 0.36 * angle.cos(), 0.25 + 0.36 * angle.sin()];
        let upper = [0.42, 0.5];
        let (arm, upright) = (0.26_f64.hypot(0.02), 0.03_f64.hypot(0.27));
        let (dy, dz) = (upper[0] - lower[0], upper[1] - lower[1]);
        let apart = dy.hypot(dz);
        let along = (apart * apart + upright * upright - arm * arm) / (2.0 * apart);
        let off = (upright * upright - along * along).sqrt();
        // Of the two crossings the outer one.
        let top = [lower[0] + (along * dy - off * dz) / apart, lower[1] + (along * dz + off * dy) / apart];
        let other = [lower[0] + (along * dy + off * dz) / apart, lower[1] + (along * dz - off * dy) / apart];
        let top = if top[0] > other[0] { top } else { other };
        let lean = (top[0] - lower[0]).atan2(top[1] - lower[1]) - (-0.03_f64).atan2(0.27);
        // The tie rod turns the wheel about the leaning kingpin by less than a degree: of second order in the camber.
        let found = point.outputs[camber];
        assert!((found - lean).abs() < 2e-4, "{found} for {lean}");
        if let Some([was, at]) = before {
            assert!(point.outputs[travel] > at && found < was, "the wheel leans in as it comes up");
        }
        before = Some([found, point.outputs[travel]]);
    }
}
