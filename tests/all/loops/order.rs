//! Every method keeps its order on a closed loop.

use super::{FOUR_BAR, read};
use std::sync::Arc;
use stillpoint::integrate::{Method, Options, Start};
use stillpoint::model::Model;
use stillpoint::simulate::problem::Equations;

const END: f64 = 0.32;

fn end_state(model: &Arc<Model>, method: Method, options: &Options) -> Vec<f64> {
    let mut motion = Equations::new(model);
    let start = Start { time: 0.0, position: &model.start_position, velocity: &model.start_velocity, end: END };
    let mut stepper = method.start(&mut motion, options, start).expect("the run starts");
    while !stepper.finished() {
        stepper.step(&mut motion).expect("a step");
    }
    [stepper.position(), stepper.velocity()].concat()
}

/// Halving the step divides the error by 2 to the order: projection after the step, and multipliers that are eliminated
/// in implicit stages, cost none of it.
#[test]
fn steps_on_a_loop_keep_their_order() {
    let (_, model) = read(FOUR_BAR);
    let reference =
        end_state(&model, Method::Dop853, &Options { relative: 1e-13, absolute: 1e-13, ..Options::default() });
    for (method, order, step) in [
        (Method::Rk4, 4, 0.004),
        (Method::Dopri5, 5, 0.008),
        (Method::Dop853, 8, 0.02),
        (Method::Sdirk4, 4, 0.008),
        (Method::Radau9, 9, 0.04),
        (Method::Gauss, 6, 0.008),
        (Method::GeneralizedAlpha, 2, 0.002),
    ] {
        let error = |step: f64| {
            let options =
                Options { relative: 1e-12, absolute: 1e-12, step: Some(step), fixed: true, ..Options::default() };
            let end = end_state(&model, method, &options);
            end.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(step), error(0.5 * step));
        let seen = (coarse / fine).log2();
        println!("{method:?}: {coarse:.1e} {fine:.1e} order {seen:.2}");
        // Not asymptotic yet, and symmetric methods gain: within a half below, and not a constant.
        assert!(seen > f64::from(order) - 0.5, "{method:?}: order {seen} of {order}, errors {coarse:e} {fine:e}");
    }
}
