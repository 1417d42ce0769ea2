//! What bounces: beside what has to be captured, hundreds of times at once; and what cannot.

use crate::contact_in_motion::{FLOOR, exact, go, read, tried};
use stillpoint::integrate::Method;

const G: f64 = 9.80665;

/// A ball that bounces, e = 0.8, and a fan with dry friction far away, as a shape of it or none is.
fn beside_a_fan(shape: &str) -> (String, f64) {
    let text = FLOOR.to_owned()
        + "[[body]]\nname = \"ball\"\nmass = 0.6\ninertia = [0.0006, 0.0006, 0.0006]\nshape = { sphere = 0.05 }\n"
        + "hinge = { type = \"free\", position = [0, 0, 1.05, 1, 0, 0, 0] }\n"
        + "[[body]]\nname = \"fan\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n"
        + "hinge = { type = \"revolute\", axis = [0, 0, 1], at = [5, 0, 0], velocity = 30.0, friction = 0.01 }\n"
        + shape
        + "[[contact]]\nbetween = [\"floor\", \"*\"]\nrestitution = 0.8\n";
    // Three impacts, and where it is then.
    let (first, mut time, mut speed) = ((2.0 * G).sqrt(), (2.0 / G).sqrt(), 0.0);
    for bounce in 1..=3 {
        time += 2.0 * speed / G;
        speed = first * 0.8_f64.powi(bounce);
    }
    let left = 2.0 - time;
    (text, 0.05 + speed * left - 0.5 * G * left * left)
}

#[test]
fn a_ball_bounces_beside_what_has_nothing_to_do_with_it() {
    let (text, expected) = beside_a_fan("");
    let summary = exact(&text, 2.0);
    assert!((summary.state.position[2] - expected).abs() < 1e-8 && summary.capture_steps == 0, "{:?}", summary.state);
    // The fan slows down by τ/I.
    assert!((summary.state.velocity[6] - 29.8).abs() < 1e-9, "{:?}", summary.state);
}

/// What bounces by captured steps does so with its restitution, whatever is captured with it: the fan might touch something.
#[test]
fn a_ball_bounces_beside_what_has_to_be_captured() {
    let (text, expected) = beside_a_fan("shape = { sphere = 0.1, at = [0, 0, 3] }\n");
    let model = read(&text);
    for tolerance in [1e-5, 1e-6, 1e-7, 1e-8, 1e-9] {
        let summary = go(&model, 2.0, tolerance, Method::Dop853);
        // Of order 1: a part of the way of one step at each impact.
        let off = summary.state.position[2] - expected;
        assert!(off.abs() < 0.02, "{tolerance:e}: {off}");
    }
}

/// A light ball between two heavy ones that close in on it: hundreds of impacts, and everything goes back as it came.
#[test]
fn a_light_ball_between_heavy_ones_gives_back_all_of_their_motion() {
    let ball = |name: &str, mass: f64, at: f64, speed: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ninertia = [1e-3, 1e-3, 1e-3]\nshape = {{ sphere = 0.05 }}\n\
             hinge = {{ type = \"prismatic\", axis = [1, 0, 0], position = {at:?}, velocity = {speed:?} }}\n"
        )
    };
    let text = "gravity = [0, 0, 0]\n".to_owned()
        + &ball("b0", 1.0, 0.0, 1.0)
        + &ball("b1", 1e-5, 0.3, 0.0)
        + &ball("b2", 1.0, 0.6, -1.0)
        + "[[contact]]\nbetween = [\"*\", \"*\"]\nrestitution = 1.0\n";
    let summary = exact(&text, 0.5);
    let v = &summary.state.velocity;
    assert!((v[0] + 1.0).abs() < 1e-5 && (v[2] - 1.0).abs() < 1e-5, "{v:?} after {} impacts", summary.impacts);
    assert!(summary.impacts > 500 && summary.dissipated.abs() < 1e-9, "{} {}", summary.impacts, summary.dissipated);
}

/// Two half spaces overlap wherever they are.
#[test]
fn a_half_space_that_moves_over_another_is_refused() {
    let text = FLOOR.to_owned()
        + "[[body]]\nname = \"sled\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nshape = { plane = [0, 0, -1] }\n"
        + "hinge = { type = \"prismatic\", axis = [0, 0, 1], position = 1.0 }\n[[contact]]\nbetween = [\"*\", \"*\"]\n";
    let refused = tried(&read(&text), 1.0, 1e-6, Method::Dop853).expect_err("refused").to_string();
    assert!(refused.contains("half space") && refused.contains("floor") && refused.contains("sled"), "{refused}");
}
