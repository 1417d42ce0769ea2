//! Time stepping, proved on systems with known solutions.

pub(crate) mod adaptive;
mod failures;
mod long;
mod mechanisms;
mod order;
mod problems;
mod projection;
mod stiff;

use stillpoint::integrate::{ImplicitProblem, Method, Options, Start, Stepper};

const METHODS: [Method; Method::ALL.len()] = Method::ALL;

/// A finished run.
fn run<P: ImplicitProblem>(
    method: Method,
    problem: &mut P,
    options: &Options,
    start: Start<'_>,
) -> Box<dyn Stepper<P>> {
    let mut stepper = method.start(problem, options, start).expect("the run starts");
    while !stepper.finished() {
        stepper.step(problem).expect("the step is made");
    }
    stepper
}

/// Steps of one length; the tolerance serves only the stage equations, which it makes as exact as rounding allows.
fn fixed(step: f64) -> Options {
    Options { relative: 1e-12, absolute: 1e-12, step: Some(step), fixed: true, ..Options::default() }
}

/// Steps chosen for a tolerance.
fn adaptive(tolerance: f64) -> Options {
    Options { relative: tolerance, absolute: tolerance, ..Options::default() }
}

/// The largest difference of two states.
fn distance(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}
