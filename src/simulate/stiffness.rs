//! How fast the fastest motion of a system is, at one state: what holds the step of an explicit method.
//!
//! The largest rate of change `ρ` of the rate of `(q, v)` near a state, by the power iteration
//!
//! ```text
//! (δq, δv) → (δv, [a(q ⊞ ε δq, v + ε δv) − a(q, v)] / ε)
//! ```
//!
//! two applications at a time, so that an oscillation (`−ω²`) counts like a decay (`λ²`). A damped oscillation turns the
//! direction in every round, and grows in one a thousand times what it shrinks in another: `ρ` is the mean growth of the last
//! rounds. It costs two accelerations per round, and no tangent: what it sees is what an explicit method sees.

use crate::integrate::{ImplicitProblem, Problem};
use crate::simulate::problem::Equations;

/// Rounds of two applications. Twelve of them find a rate that is twice the next one to a part in a thousand.
const ROUNDS: usize = 12;
/// The last of them, whose growth counts.
const COUNTED: usize = 6;
/// Size of the perturbation, in scales of the coordinates; less where friction asks for that.
const PERTURBATION: f64 = 1e-7;

/// The fastest motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fastest {
    /// Its angular frequency or decay rate (1/s).
    pub(super) rate: f64,
    /// The velocity coordinate that takes part most, in its scale.
    pub(super) coordinate: usize,
}

/// The fastest motion near a state; `None` if the system cannot be evaluated there.
pub(super) fn fastest(motion: &mut Equations, time: f64, q: &[f64], v: &[f64]) -> Option<Fastest> {
    let n = v.len();
    if n == 0 {
        return None;
    }
    let (scales, period) = {
        let (positions, velocities) = motion.scales();
        let largest = |scales: &[f64]| scales.iter().copied().fold(0.0, f64::max);
        (velocities.to_vec(), largest(positions) / largest(velocities))
    };
    let mut base = vec![0.0; n];
    motion.acceleration(time, q, v, &mut base).ok()?;
    let mut sizes: Vec<f64> = scales.iter().map(|scale| PERTURBATION * scale).collect();
    motion.refine(&mut sizes);
    let perturbation = sizes.iter().zip(&scales).map(|(size, scale)| size / scale).fold(PERTURBATION, f64::min);
    // In scales of velocities: δq takes the scene's time to count as much. No direction is left out by a pattern.
    let mut shift: Vec<f64> = (0..n).map(|i| 1.0 + 0.5 * (1.7 * i as f64).sin()).collect();
    let mut speed: Vec<f64> = (0..n).map(|i| 1.0 - 0.5 * (2.3 * i as f64).cos()).collect();
    let (mut moved_q, mut moved_v, mut change) = (q.to_vec(), v.to_vec(), vec![0.0; n]);
    let mut growth = 0.0;
    normalize(&mut shift, &mut speed);
    for round in 0..ROUNDS {
        for _ in 0..2 {
            let scaled: Vec<f64> = (0..n).map(|i| perturbation * period * scales[i] * shift[i]).collect();
            motion.displace(q, &scaled, &mut moved_q);
            for i in 0..n {
                moved_v[i] = v[i] + perturbation * scales[i] * speed[i];
            }
            motion.acceleration(time, &moved_q, &moved_v, &mut change).ok()?;
            for i in 0..n {
                let acceleration = (change[i] - base[i]) / (perturbation * scales[i]);
                shift[i] = speed[i] / period;
                speed[i] = acceleration;
            }
            // Each by itself: what is fast grows beyond where the system is linear within two of them.
            let size = normalize(&mut shift, &mut speed);
            if !size.is_finite() {
                return None;
            }
            growth += if round >= ROUNDS - COUNTED { size.ln() } else { 0.0 };
        }
    }
    // Two applications a round.
    let rate = (growth / (2 * COUNTED) as f64).exp();
    let largest = |x: &[f64]| (0..n).max_by(|i, j| x[*i].abs().total_cmp(&x[*j].abs()));
    let coordinate = largest(&shift)?;
    rate.is_finite().then_some(Fastest { rate, coordinate })
}

fn length(x: &[f64], y: &[f64]) -> f64 {
    x.iter().chain(y).map(|x| x * x).sum::<f64>().sqrt()
}

fn normalize(x: &mut [f64], y: &mut [f64]) -> f64 {
    let size = length(x, y);
    x.iter_mut().chain(y).for_each(|x| *x /= size);
    size
}
