//! Every method has its order: exact on polynomials, and halving the step divides the error by 2^p.

use stillpoint::integrate::{ImplicitProblem, Method, Start};

use super::problems::{Body, Scalar};
use super::{METHODS, adaptive, distance, fixed, run};

pub(super) fn order(method: Method) -> i32 {
    match method {
        Method::GeneralizedAlpha => 2,
        Method::Rk4 | Method::Sdirk4 => 4,
        Method::Dopri5 | Method::Radau5 => 5,
        Method::Gauss => 6,
        Method::Dop853 => 8,
        Method::Radau9 => 9,
        Method::Adams => unreachable!("its order varies"),
    }
}

/// The methods that have one.
pub(super) fn of_one_order() -> impl Iterator<Item = Method> {
    METHODS.into_iter().filter(|method| *method != Method::Adams)
}

/// The longer of two steps whose errors tell the order: short enough for the first term of the error to rule, long
/// enough for rounding not to.
fn coarse_step(method: Method) -> f64 {
    match order(method) {
        ..=2 => 0.02,
        3..=5 => 0.1,
        6..=8 => 0.5,
        _ => 0.7,
    }
}

/// Observed order from two runs whose steps differ by a factor 2.
fn observed(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2()
}

/// The observed order is at least the promised one less 0.25 (the next term of the error, at the steps used here) and
/// not more than one above.
pub(super) fn assert_order(method: Method, promised: i32, coarse: f64, fine: f64) {
    let order = observed(coarse, fine);
    let band = f64::from(promised) - 0.25..f64::from(promised) + 1.0;
    assert!(band.contains(&order), "{method:?}: order {order:.2}, errors {coarse:e} and {fine:e}");
}

/// State at the end of a run with a fixed step.
fn end_state<P: ImplicitProblem>(method: Method, problem: &mut P, step: f64, start: Start<'_>) -> Vec<f64> {
    let reached = run(method, problem, &fixed(step), start);
    [reached.position(), reached.velocity()].concat()
}

#[test]
fn a_method_of_order_p_is_exact_on_polynomials_of_degree_p() {
    for method in of_one_order() {
        let p = order(method);
        let coefficient = f64::from(p * (p - 1));
        // q = t^p − t, q̈ = p (p − 1) t^(p − 2)
        let mut problem = Scalar::oscillator(0.0, 0.0, move |t| coefficient * t.powi(p - 2));
        let start = Start { time: 0.0, position: &[0.0], velocity: &[-1.0], end: 1.0 };
        let state = end_state(method, &mut problem, 0.25, start);
        // Rounding of four steps with stage weights up to 12.
        assert!(distance(&state, &[0.0, f64::from(p) - 1.0]) < 1e-13, "{method:?}: {state:?}");
    }
}

#[test]
fn damped_oscillator_halving_the_step_divides_the_error_by_two_to_the_order() {
    let exact = |t: f64| {
        let (decay, frequency) = (0.1_f64, 0.99_f64.sqrt());
        let (envelope, (sin, cos)) = ((-decay * t).exp(), (frequency * t).sin_cos());
        [envelope * (cos + decay / frequency * sin), -envelope * sin / frequency]
    };
    for method in of_one_order() {
        let error = |step: f64| {
            let mut problem = Scalar::oscillator(1.0, 0.2, |_| 0.0);
            let start = Start { time: 0.0, position: &[1.0], velocity: &[0.0], end: 4.0 };
            distance(&end_state(method, &mut problem, step, start), &exact(4.0))
        };
        let step = coarse_step(method);
        assert_order(method, order(method), error(step), error(0.5 * step));
    }
}

#[test]
fn torque_free_symmetric_body_keeps_the_order_with_a_quaternion() {
    let spin = nalgebra::Vector3::new(0.7, -0.4, 1.5);
    let exact = Body::symmetric_attitude(2.0, 1.2, spin, 3.0);
    for method in of_one_order() {
        let error = |step: f64| {
            let mut body = Body::new([2.0, 2.0, 1.2], [0.0; 3]);
            let start = Start { time: 0.0, position: &[1.0, 0.0, 0.0, 0.0], velocity: spin.as_slice(), end: 3.0 };
            distance(&end_state(method, &mut body, step, start)[..4], &exact)
        };
        let step = coarse_step(method);
        assert_order(method, order(method), error(step), error(0.5 * step));
    }
}

#[test]
fn heavy_asymmetric_body_keeps_the_order_with_a_quaternion() {
    let body = || Body::new([1.0, 1.6, 2.2], [0.5, 0.3, -0.8]);
    let start = Start { time: 0.0, position: &[0.8, 0.6, 0.0, 0.0], velocity: &[0.5, 1.0, -0.7], end: 5.0 };
    let reference = run(Method::Dopri5, &mut body(), &adaptive(1e-13), start);
    let reference = [reference.position(), reference.velocity()].concat();
    for method in of_one_order() {
        let error = |step: f64| distance(&end_state(method, &mut body(), step, start), &reference);
        let step = coarse_step(method);
        assert_order(method, order(method), error(step), error(0.5 * step));
    }
}

#[test]
fn between_the_ends_the_error_falls_with_its_order() {
    let worst = |method: Method, step: f64| {
        let mut problem = Scalar::oscillator(1.0, 0.0, |_| 0.0);
        let start = Start { time: 0.0, position: &[1.0], velocity: &[0.0], end: 4.0 };
        let mut stepper = method.start(&mut problem, &fixed(step), start).expect("the run starts");
        let mut worst = 0.0_f64;
        while !stepper.finished() {
            stepper.step(&mut problem).expect("the step is made");
            for part in 0..=8 {
                let t = stepper.previous_time() + f64::from(part) / 8.0 * (stepper.time() - stepper.previous_time());
                let (mut q, mut v) = ([0.0], [0.0]);
                stepper.interpolate(&mut problem, t, &mut q, &mut v).expect("a state");
                worst = worst.max(distance(&[q[0], v[0]], &[t.cos(), -t.sin()]));
            }
        }
        worst
    };
    // The extensions of the explicit pairs have a local error of the order of the whole run's; cubics stay at the fourth.
    // The polynomials of collocation methods are one order above the number of their stages.
    for method in of_one_order() {
        let promised = match method {
            Method::Radau5 | Method::Gauss => 4,
            Method::Radau9 => 6,
            _ => order(method),
        };
        let step = coarse_step(method);
        assert_order(method, promised, worst(method, step), worst(method, 0.5 * step));
    }
}

#[test]
fn interpolation_meets_both_ends_and_gives_unit_quaternions_between() {
    for method in METHODS {
        let mut body = Body::new([1.0, 1.6, 2.2], [0.5, 0.3, -0.8]);
        let start = Start { time: 0.0, position: &[0.8, 0.6, 0.0, 0.0], velocity: &[0.5, 1.0, -0.7], end: 1.0 };
        let mut stepper = method.start(&mut body, &fixed(0.3), start).expect("the run starts");
        let (mut q, mut v) = ([0.0; 4], [0.0; 3]);
        stepper.step(&mut body).expect("the step is made");

        stepper.interpolate(&mut body, 0.3, &mut q, &mut v).expect("the end");
        assert_eq!((&q[..], &v[..]), (stepper.position(), stepper.velocity()));
        stepper.interpolate(&mut body, 0.12, &mut q, &mut v).expect("a state");
        assert!((q.iter().map(|p| p * p).sum::<f64>() - 1.0).abs() < 1e-15);
        stepper.interpolate(&mut body, 0.0, &mut q, &mut v).expect("the start");
        // Normalising the start once more may round.
        assert!(distance(&q, start.position) < 1e-15);
        assert_eq!(v, start.velocity);
    }
}

/// Six digits more cost a method of order p `10^(6/p)` times the evaluations: below 4.6 at an order of 9.
#[test]
fn adams_rises_to_high_orders_where_digits_are_asked_for() {
    let start = Start { time: 0.0, position: &[0.8, 0.6, 0.0, 0.0], velocity: &[0.5, 1.0, -0.7], end: 10.0 };
    let work = |tolerance: f64| {
        let mut body = Body::new([1.0, 1.6, 2.2], [0.5, 0.3, -0.8]);
        run(Method::Adams, &mut body, &adaptive(tolerance), start).statistics().acceleration_evaluations as f64
    };
    let ratio = work(1e-12) / work(1e-6);
    assert!(ratio < 4.6, "{ratio}");
}

/// Between the ends Adams is as exact as at them, and one evaluation per step is all it takes.
#[test]
fn adams_between_its_ends_is_as_good_as_there_and_costs_nothing_more() {
    for tolerance in [1e-4, 1e-7, 1e-10] {
        let mut problem = Scalar::oscillator(1.0, 0.0, |_| 0.0);
        let start = Start { time: 0.0, position: &[1.0], velocity: &[0.0], end: 10.0 };
        let mut stepper = Method::Adams.start(&mut problem, &adaptive(tolerance), start).expect("the run starts");
        let (mut at_ends, mut between) = (0.0_f64, 0.0_f64);
        while !stepper.finished() {
            stepper.step(&mut problem).expect("the step is made");
            let (from, to) = (stepper.previous_time(), stepper.time());
            for part in 0..=8 {
                let t = from + f64::from(part) / 8.0 * (to - from);
                let (mut q, mut v) = ([0.0], [0.0]);
                stepper.interpolate(&mut problem, t, &mut q, &mut v).expect("a state");
                let error = distance(&[q[0], v[0]], &[t.cos(), -t.sin()]);
                if part == 8 { at_ends = at_ends.max(error) } else { between = between.max(error) }
            }
        }
        // The polynomial of low order while the run starts is the poorest.
        assert!(between < 2.0 * at_ends + tolerance, "{tolerance:e}: {between:e} between, {at_ends:e} at the ends");
        let statistics = stepper.statistics();
        // The first rate, and the one that the first step was chosen by.
        assert_eq!(statistics.acceleration_evaluations, statistics.steps + statistics.rejected_steps + 2);
    }
}
