//! One scene in other units: nothing depends on whether lengths are given in metres, millimetres or kilometres.
//!
//! The factors are powers of two near a thousand, so that scaling itself rounds nothing: what differs is a constant that
//! knows a unit.

use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::record::Fanout;
use stillpoint::simulate::{self, State, Summary};
use stillpoint::statics;

use crate::common::build;
use std::sync::Arc;

const FACTORS: [f64; 2] = [1024.0, 1.0 / 1024.0];

/// An arm with a slide and a ball on it, a spring to the ground, dampers; lengths times `s`, times and masses as they are.
fn scene(s: f64, method: Method) -> (stillpoint::scenario::Scenario, Arc<Model>) {
    let square = s * s;
    // Tolerances that a second-order method meets in time as well.
    let step = if method.needs_step() { "step = 0.005\n" } else { "" };
    let text = format!(
        r#"
gravity = [0.0, 0.0, {g:?}]
[simulate]
start = "given"
duration = 0.5
integrator = "{method}"
tolerance = 1e-6
absolute_tolerance = 1e-6
{step}
[[body]]
name = "arm"
mass = 2.0
center = [{half:?}, 0.0, 0.0]
inertia = [{i1:?}, {i2:?}, {i2:?}]
markers = {{ tip = [{one:?}, 0.0, 0.0] }}
hinge = {{ type = "revolute", axis = [0.0, 1.0, 0.0], position = 0.3, velocity = 0.5, stiffness = {turn:?}, damping = {slow:?} }}
[[body]]
name = "slide"
mass = 0.5
inertia = [{i1:?}, {i1:?}, {i1:?}]
hinge = {{ type = "prismatic", parent = "arm", at = "tip", axis = [1.0, 0.0, 0.0], position = {small:?}, velocity = {half:?}, stiffness = 80.0, damping = 1.5 }}
[[body]]
name = "ball"
mass = 1.0
center = [0.0, {small:?}, {below:?}]
inertia = [{i2:?}, {i1:?}, {i2:?}]
markers = {{ low = [0.0, 0.0, {below:?}] }}
hinge = {{ type = "spherical", parent = "slide", velocity = [0.5, -1.0, 2.0], damping = {slow:?} }}
[[force]]
type = "spring"
between = ["ball.low", {{ body = "ground", at = [{one:?}, {half:?}, 0.0] }}]
stiffness = 30.0
length = {half:?}
damping = 0.25
"#,
        g = -9.75 * s,
        half = 0.5 * s,
        one = s,
        small = 0.125 * s,
        below = -0.25 * s,
        i1 = 0.0625 * square,
        i2 = 0.09375 * square,
        turn = 4.0 * square,
        slow = 0.125 * square,
        method = method.name(),
    );
    let scenario = stillpoint::scenario::parse("scene.toml", &text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
    let model = build(&scenario.description);
    (scenario, model)
}

fn go(s: f64, method: Method) -> (Arc<Model>, Summary) {
    let (scenario, model) = scene(s, method);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let summary = simulate::run(&model, &scenario.simulate, 10.0, &start, &mut Fanout::new(), &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{method:?} at {s}: {error}"));
    (model, summary)
}

#[test]
fn a_run_is_the_same_in_millimetres_and_in_kilometres() {
    for method in Method::ALL {
        let (model, metres) = go(1.0, method);
        let slide = model.bodies[model.body("slide").expect("a body")].hinge.position;
        for s in FACTORS {
            let (_, other) = go(s, method);
            assert_eq!(other.statistics, metres.statistics, "{method:?} at {s}");
            for (i, (a, b)) in metres.state.position.iter().zip(&other.state.position).enumerate() {
                let b = if i == slide { b / s } else { *b };
                // Sums over all coordinates (time scales, mean inertias) may round anew.
                assert!((a - b).abs() < 1e-12, "{method:?} at {s}: coordinate {i} is {a} and {b}");
            }
            let drift = other.energy_drift / (s * s);
            assert!((drift - metres.energy_drift).abs() < 1e-9, "{method:?} at {s}: {drift:e}");
        }
    }
}

#[test]
fn an_equilibrium_is_the_same_in_millimetres_and_in_kilometres() {
    let find = |s: f64| {
        let (scenario, model) = scene(s, Method::Dop853);
        let found = statics::equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
        assert!(found.converged, "at {s}: {:?}", found.notes);
        (model, found)
    };
    let (model, metres) = find(1.0);
    let slide = model.bodies[model.body("slide").expect("a body")].hinge.position;
    for s in FACTORS {
        let (_, other) = find(s);
        assert_eq!(other.iterations, metres.iterations, "at {s}");
        for (i, (a, b)) in metres.position.iter().zip(&other.position).enumerate() {
            let b = if i == slide { b / s } else { *b };
            assert!((a - b).abs() < 1e-11, "at {s}: coordinate {i} is {a} and {b}");
        }
        let hertz = |found: &statics::Equilibrium| -> Vec<f64> {
            found.stability.as_ref().expect("modes").modes.iter().map(|mode| mode.frequency_hz).collect()
        };
        for (a, b) in hertz(&metres).iter().zip(hertz(&other)) {
            assert!((a / b - 1.0).abs() < 1e-9, "at {s}: {a} Hz and {b} Hz");
        }
    }
}
