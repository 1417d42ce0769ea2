//! What comes to rest against dry friction at the instant at which an impact sets it in motion.

use super::{METHODS, go, of, parse};
use crate::common::Random;
use stillpoint::simulate::events::Kind;

/// A slider on a cart that nears a wall: at the instant at which the slider comes to rest on the cart, this touches the wall.
struct Scene {
    cart: f64,
    slider: f64,
    friction: f64,
    restitution: f64,
    /// Of the slider on the cart at the start (m/s), and of the cart at the instant.
    slides: f64,
    strikes: f64,
}

impl Scene {
    fn new(random: &mut Random) -> Self {
        Self {
            cart: random.between(0.3, 3.0),
            slider: random.between(0.3, 3.0),
            friction: random.between(0.5, 2.0),
            restitution: random.between(0.2, 0.9),
            slides: random.between(0.5, 1.5),
            strikes: random.between(0.05, 0.2),
        }
    }

    /// How fast the slider slows down on the cart (m/s²).
    fn slowing(&self) -> f64 {
        self.friction * (1.0 / self.cart + 1.0 / self.slider)
    }

    /// When the slider is at rest on the cart, and for how long it slides back after that before the run ends (s).
    fn times(&self) -> [f64; 2] {
        let back = (1.0 + self.restitution) * self.strikes;
        [self.slides / self.slowing(), 0.3 * back / self.slowing()]
    }

    /// The cart is `gap` before the wall when the slider comes to rest (m).
    fn text(&self, method: &str, gap: f64) -> String {
        let ([rest, after], pushed) = (self.times(), self.friction / self.cart);
        let speed = -self.strikes - pushed * rest;
        let position = gap - (speed * rest + 0.5 * pushed * rest * rest);
        let Self { cart, slider, friction, restitution, slides, .. } = self;
        format!(
            "gravity = [0, 0, 0]\n\
             simulate = {{ start = \"given\", duration = {}, integrator = \"{method}\", tolerance = 1e-10 }}\n\
             [[body]]\nname = \"cart\"\nmass = {cart}\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], position = {position}, \
             velocity = {speed}, limits = {{ low = 0, high = 100, restitution = {restitution} }} }}\n\
             [[body]]\nname = \"slider\"\nmass = {slider}\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], parent = \"cart\", \
             velocity = {slides}, friction = {friction} }}\n",
            rest + after
        )
    }

    /// Velocities of the cart, and of the slider on it, at the end: the wall turns the cart, and the slider goes on from it backwards.
    fn end(&self) -> [f64; 2] {
        let [_, after] = self.times();
        let turned = self.restitution * self.strikes - self.friction / self.cart * after;
        [turned, -(1.0 + self.restitution) * self.strikes + self.slowing() * after]
    }
}

#[test]
fn what_an_impact_sets_in_motion_slides_even_if_it_came_to_rest_at_that_instant() {
    let mut random = Random::new(31);
    for case in 0..6 {
        let scene = Scene::new(&mut random);
        for method in METHODS {
            // Within what touches (10⁻¹² m), just before and just behind what is an impact by itself.
            for gap in [-5e-13, 5e-13] {
                let summary = go(&parse(&scene.text(method, gap)));
                for (found, expected) in summary.state.velocity.iter().zip(scene.end()) {
                    // Accelerations are constant between events, whose times are known to 10⁻¹² s or so.
                    assert!((found - expected).abs() < 1e-10, "case {case}, {method}, {gap:e}: {found} for {expected}");
                }
                assert_eq!(of(&summary, Kind::Impact).len(), 1, "case {case}, {method}: {:?}", summary.events);
                assert!(of(&summary, Kind::Stick).is_empty(), "case {case}, {method}: {:?}", summary.events);
            }
        }
    }
}
