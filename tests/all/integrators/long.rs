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
fn the_sum_of_the_errors_bounds_the_error_and_is_within_a_hundred_or_two_of_it() {
    let methods = [Method::Dop853, Method::Dopri5, Method::Radau5, Method::Radau9, Method::Adams];
    for seed in 0..3 {
        for method in methods {
            for tolerance in [1e-6, 1e-8, 1e-10] {
                let (told, truth) = told_and_true(method, tolerance, &mut Random::new(seed));
                // What rounding leaves of an angle of 8000 rad, and adds in a million steps.
                let rounding = 4e-12;
                let case = format!("{method:?} at {tolerance:e}, seed {seed}: told {told:e}, true {truth:e}");
                assert!(truth <= told + rounding, "{case}");
                // What iterations leave has another sign in other steps.
                let most = if method == Method::Radau9 { 200.0 } else { 100.0 };
                assert!(told <= most * (truth + rounding), "{case}");
            }
        }
    }
}

/// Its estimate is that of the rule of order 3, and told whole: in a stiff system the error is of that order.
#[test]
fn the_sum_of_the_errors_of_sdirk4_bounds_the_error_by_far() {
    for seed in 0..3 {
        for tolerance in [1e-6, 1e-8] {
            let (told, truth) = told_and_true(Method::Sdirk4, tolerance, &mut Random::new(seed));
            let case = format!("at {tolerance:e}, seed {seed}: told {told:e}, true {truth:e}");
            assert!(truth <= told && told <= 1e4 * truth, "{case}");
        }
    }
}
