//! Mechanisms of hinges in place of single equations: order, symmetry and long-time behaviour.

use std::collections::BTreeMap;

use stillpoint::integrate::{Method, Options, Problem, Start};
use stillpoint::model::Model;
use stillpoint::simulate::problem::Equations;

use super::order::{assert_order, of_one_order, order};
use super::{adaptive, distance, fixed};
use crate::common::build;
use std::sync::Arc;

/// Three links on a ball, a universal hinge and a revolute one, sprung and damped, thrown.
const CHAIN: &str = r#"
[[body]]
name = "upper"
mass = 1.0
center = [0.0, 0.0, -0.25]
inertia = [0.03, 0.02, 0.01]
markers = { tip = [0.0, 0.1, -0.5] }
hinge = { type = "spherical", position = [0.9, 0.3, 0.3, -0.1], velocity = [1.0, -0.5, 2.0], damping = 0.05 }

[[body]]
name = "middle"
mass = 0.7
center = [0.1, 0.0, -0.2]
inertia = [0.02, 0.02, 0.01]
markers = { tip = [0.0, 0.0, -0.4] }
hinge = { type = "universal", parent = "upper", at = "tip", axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], position = [0.4, -0.3], velocity = [-1.0, 0.7], stiffness = 1.0 }

[[body]]
name = "lower"
mass = 0.5
center = [0.0, 0.05, -0.2]
inertia = [0.01, 0.01, 0.005]
hinge = { type = "revolute", parent = "middle", at = "tip", axis = [0.0, 0.6, 0.8], position = 0.5, velocity = -2.0 }
"#;

fn model(text: &str) -> Arc<Model> {
    let scenario = stillpoint::scenario::parse("chain.toml", text, &[]).expect("a scenario");
    build(&scenario.description)
}

fn start(model: &Model, end: f64) -> Start<'_> {
    Start { time: 0.0, position: &model.start_position, velocity: &model.start_velocity, end }
}

/// State at the end of a run.
fn end_state(method: Method, model: &Arc<Model>, options: &Options, start: Start<'_>) -> Vec<f64> {
    let mut motion = Equations::new(model);
    let mut stepper = method.start(&mut motion, options, start).expect("the run starts");
    while !stepper.finished() {
        stepper.step(&mut motion).unwrap_or_else(|error| panic!("{method:?}: {error}"));
    }
    [stepper.position(), stepper.velocity()].concat()
}

#[test]
fn every_method_keeps_its_order_on_a_chain_with_balls() {
    let model = model(CHAIN);
    let start = start(&model, 0.5);
    let reference = end_state(Method::Dopri5, &model, &adaptive(1e-13), start);
    // Short enough for the first term of the error, long enough for rounding.
    let steps = BTreeMap::from([(2, 0.002), (4, 0.005), (5, 0.01), (6, 0.025), (8, 0.02), (9, 0.0625)]);
    for method in of_one_order() {
        let step = steps[&order(method)];
        let error = |step: f64| {
            // Tighter than the residual of a mechanism rounds: what stalls there is taken for solved.
            distance(&end_state(method, &model, &fixed(step), start), &reference)
        };
        assert_order(method, order(method), error(step), error(0.5 * step));
    }
}

/// A double pendulum that swings without turning over: its motion is regular.
const SWING: &str = r#"
[[body]]
name = "upper"
mass = 1.0
center = [0.0, 0.0, -0.5]
inertia = [0.08, 0.08, 0.001]
markers = { tip = [0.0, 0.0, -1.0] }
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], position = 0.5 }

[[body]]
name = "lower"
mass = 1.0
center = [0.0, 0.0, -0.5]
inertia = [0.08, 0.08, 0.001]
hinge = { type = "revolute", parent = "upper", at = "tip", axis = [0.0, 1.0, 0.0], position = 0.2 }
"#;

#[test]
fn gauss_runs_back_to_where_it_came_from() {
    let model = model(CHAIN.replace(", damping = 0.05", "").as_str());
    let there = end_state(Method::Gauss, &model, &fixed(0.02), start(&model, 2.0));
    let (position, velocity) = there.split_at(model.position_count());
    let turned: Vec<f64> = velocity.iter().map(|v| -v).collect();
    let back = Start { time: 0.0, position, velocity: &turned, end: 2.0 };
    let back = end_state(Method::Gauss, &model, &fixed(0.02), back);
    let home: Vec<f64> =
        [&model.start_position[..], &model.start_velocity.iter().map(|v| -v).collect::<Vec<_>>()].concat();
    let mut home = home;
    let count = model.position_count();
    Equations::new(&model).normalize(&mut home[..count]);
    // Rounding of a hundred steps there and a hundred back, grown by the chain's own sensitivity.
    let off = distance(&back, &home);
    assert!(off < 1e-11, "{off:e}");
    // A method that is not symmetric ends elsewhere: by twice the error of its order.
    let there = end_state(Method::Rk4, &model, &fixed(0.02), start(&model, 2.0));
    let turned: Vec<f64> = there[count..].iter().map(|v| -v).collect();
    let back = Start { time: 0.0, position: &there[..count], velocity: &turned, end: 2.0 };
    assert!(distance(&end_state(Method::Rk4, &model, &fixed(0.02), back), &home) > 1e-7);
}

/// A heavy top with three different moments of inertia, spinning and nodding: its mass matrix, in velocities that are no
/// derivatives of coordinates, is that of a body on a ball.
const TOP: &str = r#"
[[body]]
name = "top"
mass = 1.0
center = [0.0, 0.0, 0.2]
inertia = [0.02, 0.025, 0.01]
hinge = { type = "spherical", position = [0.96, 0.28, 0.0, 0.0], velocity = [0.3, 0.5, 20.0] }
"#;

/// The largest |E − E₀| / (energy above that of the coordinates at zero) in each of four quarters of a run.
fn energy_swings(scene: &str, method: Method, step: f64, steps: u32) -> [f64; 4] {
    let model = model(scene);
    let mut motion = Equations::new(&model);
    let energy = |motion: &mut Equations, q: &[f64], v: &[f64]| {
        let energies = motion.at(0.0, q, v).energies();
        energies.kinetic + energies.potential
    };
    let start = start(&model, step * f64::from(steps));
    let mut stepper = method.start(&mut motion, &fixed(step), start).expect("the run starts");
    let mut zeros = vec![0.0; model.position_count()];
    if zeros.len() > model.velocity_count() {
        zeros[0] = 1.0;
    }
    let at_start = energy(&mut motion, start.position, start.velocity);
    let lowest = energy(&mut motion, &zeros, &vec![0.0; model.velocity_count()]);
    let mut swings = [0.0_f64; 4];
    for index in 0..steps {
        stepper.step(&mut motion).expect("the step is made");
        let now = energy(&mut motion, stepper.position(), stepper.velocity());
        let quarter = &mut swings[(4 * index / steps) as usize];
        *quarter = quarter.max((now - at_start).abs() / (at_start - lowest));
    }
    swings
}

/// The energy error of `gauss` is as large in the first quarter as in the last; that of `dopri5` at the same step grows.
fn assert_bounded(scene: &str, step: f64, steps: u32) {
    let [first, .., last] = energy_swings(scene, Method::Gauss, step, steps);
    assert!(last < 1.5 * first && first < 1e-5, "{first:e} {last:e}");
}

#[test]
fn the_energy_error_of_gauss_does_not_grow() {
    assert_bounded(SWING, 0.05, 4_000);
    assert_bounded(TOP, 0.02, 2_000);
    let [first, .., last] = energy_swings(SWING, Method::Dopri5, 0.05, 4_000);
    assert!(last > 3.0 * first, "{first:e} {last:e}");
}

#[test]
// A million steps: only an optimised build (`cargo test --release`) has this test.
#[cfg(not(debug_assertions))]
fn the_energy_error_of_gauss_does_not_grow_in_a_million_steps() {
    assert_bounded(SWING, 0.05, 1_000_000);
    assert_bounded(TOP, 0.02, 1_000_000);
}

/// A hundred links let go straight out, where steps resolve the motion they find: force balances per step.
#[test]
fn steps_on_a_falling_chain_take_few_sweeps() {
    let chain = r#"
[[body]]
name = "link"
repeat = 100
mass = 0.05
center = [0.025, 0.0, 0.0]
inertia = [1.0e-6, 1.1e-5, 1.1e-5]
markers = { tip = [0.05, 0.0, 0.0] }
hinge = { type = "revolute", next = "tip", axis = [0.0, 1.0, 0.0] }
"#;
    let model = model(chain);
    // Stages times sweeps, and one for the error estimate: 10.4, 20.3 and 15.4. The triangular factors of the coefficients,
    // each stage with a tangent of its own, took half as much again.
    let runs = [
        (Method::Radau5, adaptive(1e-5), 11.5),
        (Method::Radau9, adaptive(1e-5), 22.5),
        (Method::Gauss, fixed(1e-3), 17.0),
    ];
    for (method, options, most) in runs {
        let mut motion = Equations::new(&model);
        let mut stepper = method.start(&mut motion, &options, start(&model, 0.1)).expect("the run starts");
        while !stepper.finished() {
            stepper.step(&mut motion).unwrap_or_else(|error| panic!("{method:?}: {error}"));
        }
        let counters = stepper.statistics();
        let per_step = counters.residual_evaluations as f64 / counters.steps as f64;
        println!("{method:?}: {per_step:.1}");
        assert!(per_step < most, "{method:?}: {per_step}");
    }
}
