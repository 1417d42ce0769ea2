//! Contact that moves, against closed forms of the reference that `contact_in_motion` does not have.

use crate::contact_in_motion::{FLOOR, exact, read, tried};
use stillpoint::integrate::Method;
use stillpoint::simulate::Summary;

const G: f64 = 9.80665;
/// Gravity as on a slope that falls towards x.
fn slope(angle: f64) -> String {
    format!("gravity = [{:?}, 0.0, {:?}]\n", G * angle.sin(), -G * angle.cos())
}

fn contact(friction: f64) -> String {
    format!("[[contact]]\nbetween = [\"*\", \"*\"]\nfriction = {friction:?}\n")
}

/// Reference `incline_slides`: at 1.001 of its cone, for ten seconds.
#[test]
fn a_box_slides_for_ten_seconds() {
    let body = "[[body]]\nname = \"box\"\nmass = 2.0\ninertia = [0.0133, 0.0333, 0.0333]\nshape = { box = [0.4, 0.2, 0.2] }\n\
                hinge = { type = \"free\", position = [0, 0, 0.1, 1, 0, 0, 0] }\n";
    let summary = exact(&(slope(0.464_047_528_995_482_35) + FLOOR + body + &contact(0.5)), 10.0);
    assert!((summary.state.position[0] - 0.219_239_494_880_835_8).abs() < 1e-9, "{:?}", summary.state.position);
    assert!(summary.state.position[1].abs() < 1e-12 && summary.capture_steps == 0, "{summary:?}");
}

/// Reference `sphere_on_incline`: below (2/7) tan φ it slides and spins up, above it rolls.
#[test]
fn a_sphere_rolls_or_slides_down_a_slope() {
    let body = "[[body]]\nname = \"ball\"\nmass = 1.0\ninertia = [0.004, 0.004, 0.004]\nshape = { sphere = 0.1 }\n\
                hinge = { type = \"free\", position = [0, 0, 0.1, 1, 0, 0, 0] }\n";
    let spin = |summary: &Summary| summary.state.velocity[3..6].iter().map(|w| w * w).sum::<f64>().sqrt();
    for (friction, far, fast) in
        [(0.3, 6.716_512_083_075_582, 67.165_120_830_755_82), (0.1, 7.681_887_910_193_37, 43.030_725_152_811_11)]
    {
        let summary = exact(&(slope(0.5) + FLOOR + body + &contact(friction)), 2.0);
        assert!((summary.state.position[0] - far).abs() < 1e-8, "{friction}: {:?}", summary.state.position);
        assert!((spin(&summary) - fast).abs() < 1e-8, "{friction}: {:?}", summary.state.velocity);
    }
}

/// Reference `spool_29deg`, `spool_74deg`: a thread that leaves the under side rolls a spool towards the hand below acos(r/R), and away above.
#[test]
fn a_spool_rolls_to_or_from_the_hand() {
    let (mass, inner, outer, tension) = (3.0, 0.1, 0.2, 4.0);
    let axial = 0.5 * mass * outer * outer;
    for (angle, acceleration) in [(0.5_f64, 0.335_628_943_902_553_54), (1.3, -0.206_667_707_889_255_7)] {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let text = FLOOR.to_owned()
            + &format!(
                "[[body]]\nname = \"spool\"\nmass = {mass:?}\ninertia = [0.04, 0.04, {axial:?}]\nshape = {{ cylinder = [{outer:?}, 0.3] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, {outer:?}, {half:?}, {half:?}, 0, 0] }}\n\
                 [[force]]\ntype = \"load\"\non = \"spool\"\nforce = [{:?}, 0.0, {:?}]\ntorque = [0.0, {:?}, 0.0]\n",
                tension * angle.cos(),
                tension * angle.sin(),
                -tension * inner
            )
            + &contact(0.4);
        let summary = exact(&text, 1.0);
        assert!((2.0 * summary.state.position[0] - acceleration).abs() < 1e-9, "{angle}: {:?}", summary.state.position);
    }
}

/// Reference `painleve_rod`: between two angles of a rod that is dragged tip first, pressing harder does not lift its end; this is said.
#[test]
fn painleves_rod_is_named() {
    let dragged = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let half = 0.5 * (std::f64::consts::FRAC_PI_2 - angle);
        let body = format!(
            "[[body]]\nname = \"rod\"\nmass = 1.0\ninertia = [{0:?}, {0:?}, 0.001]\nshape = {{ capsule = [0, 1.0] }}\n\
             hinge = {{ type = \"free\", position = [0, 0, {1:?}, {2:?}, 0, {3:?}, 0], velocity = [-1.0, 0, 0, 0, 0, 0] }}\n",
            1.0 / 12.0,
            0.5 * sin,
            half.cos(),
            half.sin()
        );
        assert!(cos > 0.0);
        tried(&read(&(FLOOR.to_owned() + &body + &contact(1.5))), 1e-8, 1e-11, Method::Dop853)
    };
    for (angle, paradox) in [
        (0.883_862_626 - 1e-5, false),
        (0.883_862_626 + 1e-5, true),
        (1.274_936_304 - 1e-5, true),
        (1.274_936_304 + 1e-5, false),
    ] {
        match dragged(angle) {
            Ok(_) => assert!(!paradox, "{angle}"),
            Err(error) => assert!(paradox && error.to_string().contains("Painlevé"), "{angle}: {error}"),
        }
    }
}
