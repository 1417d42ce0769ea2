//! Long runs: what the errors of many steps add up to is told, and neither less nor far more than they do.

use super::problems::Scalar;
use super::{adaptive, run};
use crate::common::Random;
use stillpoint::integrate::{Method, Start};

/// Where `q = A cos(ωt)` ends at an angle of some thousand radians, told and true, in parts of the state.
fn told_and_true(method: Method, tolerance: f64, random: &mut Random) -> (f64, f64) {
    let omega = 10_f64.powf(random.between(-0.3, 1.5));
    let amplitude = 10_f64.powf(random.between(-0.5, 0.5));
    let end = random.between(2e3, 8e3) / omega;
    let start = Start { time: 0.0, position: &[amplitude], velocity: &[0.0], end };
    let mut oscillator = Scalar::oscillator(omega * omega, 0.0, |_| 0.0);
    let reached = run(method, &mut oscillator, &adaptive(tolerance), start);
    let angle = omega * end;
    let position = (reached.position()[0] - amplitude * angle.cos()).abs() / (1.0 + amplitude);
    let velocity = (reached.velocity()[0] + amplitude * omega * angle.sin()).abs() / (1.0 + amplitude * omega);
    (reached.statistics().error_sum, position.max(velocity))
}

#[test]
fn the_sum_of_the_errors_bounds_the_error_and_is_within_a_factor_of_a_hundred() {
    let methods = [Method::Dop853, Method::Dopri5, Method::Radau5, Method::Adams];
    for seed in 0..3 {
        for method in methods {
            for tolerance in [1e-6, 1e-8, 1e-10] {
                let (told, truth) = told_and_true(method, tolerance, &mut Random::new(seed));
                // What rounding leaves of an angle of 8000 rad, and adds in a million steps.
                let rounding = 4e-12;
                let case = format!("{method:?} at {tolerance:e}, seed {seed}: told {told:e}, true {truth:e}");
                assert!(truth <= told + rounding, "{case}");
                assert!(told <= 100.0 * (truth + rounding), "{case}");
            }
        }
    }
}
