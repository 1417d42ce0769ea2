//! How far a step reaches in the motion, for errors that are of higher order than their estimates.
//!
//! If the solution behaves like `exp(λt)` an error of order `h^m` is smaller than one of order `h^k` by `(h|λ|)^{m−k}`. The rate is
//! that of all steps together,
//!
//! ```text
//! |λ|² = Σ ‖k' − k‖² / Σ ‖x' − x‖²
//! ```
//!
//! with the states `x`, `x'` and their rates `k`, `k'` at both ends: a single step may be where one of the two vanishes.

use crate::integrate::step::norm::ErrorNorm;

/// The sums of a run.
#[derive(Debug, Default)]
pub(crate) struct Reach {
    rates: f64,
    states: f64,
}

impl Reach {
    /// Takes in a step from the first to the second of `states`, with their `rates`.
    pub(crate) fn see(&mut self, norm: &ErrorNorm, states: [&[f64]; 2], rates: [&[f64]; 2]) {
        self.rates += norm.distance(rates[1], rates[0]).powi(2);
        self.states += norm.distance(states[1], states[0]).powi(2);
    }

    /// `h |λ|` of a step of length `h` (s); infinite where nothing has moved.
    pub(crate) fn of(&self, h: f64) -> f64 {
        if self.states > 0.0 { h * (self.rates / self.states).sqrt() } else { f64::INFINITY }
    }
}
