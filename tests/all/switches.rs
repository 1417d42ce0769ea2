//! Formulas of motors that jump or have kinks at a place or a speed: steps end there, whatever the method.

use crate::common::Random;
use crate::contact_in_motion::{read, tried};
use crate::integrators::adaptive::ADAPTIVE;
use stillpoint::integrate::Method;
use stillpoint::simulate::{RunError, Summary};

/// A slide of 1 kg under a formula, from a place and a speed.
fn scene(formula: &str, [place, speed]: [f64; 2]) -> String {
    format!(
        "gravity = [0, 0, 0]\n[[body]]\nname = \"slide\"\nmass = 1\ninertia = [1, 1, 1]\n\
         hinge = {{ type = \"prismatic\", axis = [1, 0, 0], position = {place}, velocity = {speed} }}\n\
         [[motor]]\nhinge = \"slide\"\ntype = \"expression\"\nexpression = \"{formula}\"\n"
    )
}

fn slide(formula: &str, start: [f64; 2], duration: f64, tolerance: f64, method: Method) -> Summary {
    tried(&read(&scene(formula, start)), duration, tolerance, method)
        .unwrap_or_else(|error| panic!("{formula} by {method:?}: {error}"))
}

/// Under `−F sign(q)` a slide goes along parabolas: from rest at `q₀` it takes `√(2 q₀ / F)` for a quarter of its period.
#[test]
fn a_force_that_jumps_is_followed_by_every_method() {
    let mut random = Random::new(0x516e);
    for case in 0..8 {
        let [start, force] = [random.between(0.1, 1.5), random.between(0.5, 8.0)];
        let quarter = (2.0 * start / force).sqrt();
        let duration = quarter * random.between(5.0, 30.0);
        let turns = duration / quarter;
        let (passed, rest) = ((turns / 2.0 + 0.5).floor(), turns - 2.0 * (turns / 2.0 + 0.5).floor());
        let sign = if passed as i64 % 2 == 0 { 1.0 } else { -1.0 };
        let exact = sign * start * (1.0 - rest * rest);
        for method in ADAPTIVE {
            let summary = slide(&format!("-{force}*sign(q)"), [start, 0.0], duration, 1e-9, method);
            let off = (summary.state.position[0] - exact).abs();
            // Parabolas are exact for every method but for the place of each crossing, which is known to its digits.
            assert!(off < 1e-8 * start, "case {case} by {method:?}: {off}");
            assert!(summary.across.is_empty(), "case {case} by {method:?}");
        }
    }
}

/// Jumps and kinks of every kind: what a method misses is a matter of its tolerance.
#[test]
fn every_way_to_switch_ends_a_step() {
    for formula in [
        "-4*floor(5*q)/5",
        "-4*q + (1 if v > 0 else -0.5)",
        "-4*q - 0.3*sign(sin(20*q))",
        "-10*q if q > 0 else -q",
        "-3*max(0, q - 0.2) - 2*min(0, q + 0.1)",
        "-3*sign(q)*(t < 5) - q",
        "-2*round(3*q)/3 - 0.1*v",
        "-5*(q % 0.5) - 3*trunc(2*q)",
        "-4*abs(q)*sign(q - 0.1) - 0.2*v",
        "-3*sign(q - 0.2*(v > 0.5))",
    ] {
        let exact = slide(formula, [0.7, 0.1], 6.0, 1e-12, Method::Dop853);
        for method in ADAPTIVE {
            let summary = slide(formula, [0.7, 0.1], 6.0, 1e-8, method);
            let off = (summary.state.position[0] - exact.state.position[0]).abs();
            // Six seconds at 1e-8: jumps turn what came before into ten to a hundred times as much; generalized-alpha is of order two.
            let allowed = if method == Method::GeneralizedAlpha { 1e-4 } else { 3e-6 };
            assert!(off < allowed, "{formula} by {method:?}: {off}");
        }
    }
}

/// Where both sides of a switch drive back to it a formula has no value: an adaptive run says so when it comes there, fixed steps go across.
#[test]
fn what_both_sides_drive_back_to_is_told() {
    for (formula, ends) in [("-3*sign(v)", 0.8 / 3.0), ("-5*sign(q + 0.3*v)", f64::NAN)] {
        let model = read(&scene(formula, [0.7, 0.8]));
        let Err(RunError::Chatters { time, motor }) = tried(&model, 30.0, 1e-6, Method::Dop853) else {
            panic!("{formula} has no value there")
        };
        assert_eq!(motor, "motor[0]", "{formula}");
        assert!(ends.is_nan() || (time - ends).abs() < 1e-4, "{formula}: {time} s");
        let summary = tried(&model, 2.0, 1e-6, Method::Rk4).unwrap();
        assert_eq!(summary.across, ["motor[0]"], "{formula}");
        if !ends.is_nan() {
            let rests = 0.7 + 0.5 * 0.8 * ends;
            assert!((summary.state.position[0] - rests).abs() < 1e-2, "{formula}: {:?}", summary.state);
        }
    }
}

/// Swings that get ever shorter take more and more switches: as long as there is no end of them they do not hold a run up.
#[test]
fn swings_about_a_switch_may_get_ever_shorter() {
    for (formula, duration) in [("-3*sign(q) - 2*v", 10.0), ("-3*sign(q) - 30*v", 5.0), ("-3*sign(q) - 0.2*v", 20.0)] {
        let summary = slide(formula, [0.7, 0.0], duration, 1e-6, Method::Dop853);
        assert!(summary.state.position[0].abs() < 0.3, "{formula}: {:?}", summary.state);
        assert!(summary.statistics.steps < 50_000, "{formula}: {} steps", summary.statistics.steps);
    }
}

/// Where every swing is shorter by the same part they end within a finite time: in with `F − R`, out with `F + R`, each takes
/// `√(2 q/(F − R)) + √(2 q (F − R))/(F + R)` from its turning point at `q`, and the next turns at `q (F − R)/(F + R)`. That is told as the time comes.
#[test]
fn swings_that_accumulate_are_told() {
    let mut random = Random::new(0x7a11);
    for case in 0..12 {
        let (start, force) = (random.between(0.1, 1.0), random.between(1.0, 5.0));
        let rubs = force * random.between(0.1, 0.7);
        let (inward, outward) = (force - rubs, force + rubs);
        let first = (2.0 * start / inward).sqrt() + (2.0 * start * inward).sqrt() / outward;
        let ends = first / (1.0 - (inward / outward).sqrt());
        let by_formula = scene(&format!("-{force}*sign(q) - {rubs}*sign(v)"), [start, 0.0]);
        let of_hinge = scene(&format!("-{force}*sign(q)"), [start, 0.0])
            .replace("velocity", &format!("friction = {rubs}, velocity"));
        for (what, text) in [("formula", by_formula), ("friction", of_hinge)] {
            for (method, tolerance) in [(Method::Dop853, 1e-6), (Method::Dopri5, 1e-8), (Method::Radau9, 1e-7)] {
                let Err(RunError::Chatters { time, motor }) = tried(&read(&text), 2.0 * ends, tolerance, method) else {
                    panic!("case {case}: {what} by {method:?} does not end")
                };
                assert_eq!(motor, "motor[0]");
                // It is told in a swing of at most a hundred tolerances, 1e-4: from there the rest takes a part of the whole that goes with the root.
                assert!((time - ends).abs() < 0.02 * ends, "case {case}: {what} by {method:?}: {time} s, {ends} s");
            }
        }
    }
}
