//! Contact beside compliant stops that push already when a run starts: what contact does is decided with what stops push.

use crate::contact_in_motion::{exact, kinds};

const G: f64 = 9.80665;
const FLOOR: &str = "[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n\
                     [[contact]]\nbetween = [\"floor\", \"box\"]\n";

/// A box of mass m on the floor, guided upwards, whose stop pushes with k p > m g from the start: it leaves the floor at once and
/// moves as m z̈ = k (l − z) − m g, so that z = z₀ + (l − m g / k) (1 − cos ωt) with ω² = k / m.
#[test]
fn a_stop_lifts_what_stands_on_the_floor() {
    let (mass, stiffness, low) = (2.0, 800.0, 0.05);
    let text = format!(
        "{FLOOR}friction = 0.4\n[[body]]\nname = \"box\"\nmass = {mass:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ box = [0.2, \
         0.2, 0.2] }}\nhinge = {{ type = \"prismatic\", at = [0, 0, 0.1], axis = [0, 0, 1], limits = {{ low = {low:?}, stiffness = \
         {stiffness:?} }} }}\n"
    );
    let (rise, omega) = (low - mass * G / stiffness, (stiffness / mass).sqrt());
    // The stop lets go at z = l, where cos ωt = 1 − l / (l − m g / k) < 0: not before ωt = π / 2.
    for angle in [0.01, 0.3, 1.5] {
        let summary = exact(&text, angle / omega);
        let expected = rise * (1.0 - f64::cos(angle));
        assert!((summary.state.position[0] - expected).abs() < 1e-10 * low, "{angle}: {:?} {expected}", summary.state);
        assert!(!kinds(&summary).contains(&"slips"), "{:?}", summary.events);
    }
}

/// A box on a cart that slides up and down stands on the floor with both their weight and is pushed along it with k p > μ N: it slides
/// from the start, m ẍ = k (l − x) − μ N.
#[test]
fn a_stop_pushes_what_would_stick() {
    let (cart, mass, stiffness, low, friction) = (0.5, 2.0, 800.0, 0.05, 0.3);
    let text = format!(
        "{FLOOR}friction = {friction:?}\n[[body]]\nname = \"cart\"\nmass = {cart:?}\ninertia = [0.01, 0.01, 0.01]\nhinge = {{ type = \
         \"prismatic\", at = [0, 0, 0.1], axis = [0, 0, 1] }}\n[[body]]\nname = \"box\"\nmass = {mass:?}\ninertia = [0.01, 0.01, \
         0.01]\nshape = {{ box = [0.2, 0.2, 0.2] }}\nhinge = {{ type = \"prismatic\", parent = \"cart\", axis = [1, 0, 0], limits = \
         {{ low = {low:?}, stiffness = {stiffness:?} }} }}\n"
    );
    let (rubs, omega) = (friction * (cart + mass) * G, (stiffness / mass).sqrt());
    let push = low - rubs / stiffness;
    for angle in [0.01, 0.3, 1.5] {
        let summary = exact(&text, angle / omega);
        let expected = push * (1.0 - f64::cos(angle));
        assert!((summary.state.position[1] - expected).abs() < 1e-10 * low, "{angle}: {:?} {expected}", summary.state);
        assert_eq!(kinds(&summary), [""; 0], "{:?}", summary.events);
    }
}
