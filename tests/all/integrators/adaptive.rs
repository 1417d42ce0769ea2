//! Steps chosen by the error: accuracy follows the tolerance, work stays what it was.

use stillpoint::integrate::{Method, Options, Start, Statistics};

use super::problems::{Body, Scalar};
use super::{METHODS, adaptive, distance, fixed, run};

fn counters(statistics: &Statistics) -> String {
    let Statistics { steps, rejected_steps, acceleration_evaluations, residual_evaluations, .. } = statistics;
    let Statistics { jacobian_evaluations, solves, newton_iterations, .. } = statistics;
    format!(
        "steps {steps}, rejected {rejected_steps}, accelerations {acceleration_evaluations}, residuals \
         {residual_evaluations}, jacobians {jacobian_evaluations}, solves {solves}, iterations {newton_iterations}"
    )
}

#[test]
fn the_error_follows_the_tolerance_on_a_smooth_system() {
    for method in [Method::Dopri5, Method::Sdirk4] {
        for exponent in 4..=11 {
            let tolerance = 10.0_f64.powi(-exponent);
            let mut problem = Scalar::oscillator(1.0, 0.0, |_| 0.0);
            let start = Start { time: 0.0, position: &[1.0], velocity: &[0.0], end: 10.0 };
            let reached = run(method, &mut problem, &adaptive(tolerance), start);
            let error =
                distance(&[reached.position()[0], reached.velocity()[0]], &[10.0_f64.cos(), -10.0_f64.sin()]);
            // Errors of some dozens of steps add up; a few estimates are above the true error.
            let band = tolerance / 30.0..30.0 * tolerance;
            println!("{method:?} {tolerance:e} {error:e} ratio {} {:?}", error/tolerance, reached.statistics());
            assert!(band.contains(&error), "{method:?}: error {error:e} at tolerance {tolerance:e}");
        }
    }
}
