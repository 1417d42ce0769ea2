//! Many contacts to a given accuracy: sweeps with momentum.
//!
//! ```text
//! (3)  λ_k = S(μ_k),   μ_{k+1} = λ_k + β_k (λ_k − λ_{k−1}),   β_k = min((θ_k − 1) / θ_{k+1}, β),   θ_{k+1} = ½ (1 + √(1 + 4 θ_k²))
//! ```
//!
//! `S` is one sweep over the contacts (Nesterov, "A method of solving a convex programming problem with convergence rate O(1/k²)", 1983; for
//! contacts: Mazhar, Heyn, Negrut, Tasora, 2015). Momentum begins anew where it leads against the sweeps, or where more is missing than before
//! (O'Donoghue, Candès, "Adaptive restart for accelerated gradient schemes", 2015). What is returned are forces of a sweep: each of them obeys
//! its law.

use super::{ConeState, FIRST_ATTEMPT, Own, Problem};
use nalgebra::Vector3;

/// β in (3): without a bound, forces of thousands of contacts grow again after a hundred sweeps.
const MOST: f64 = 0.8;
/// More is missing than this many times the least so far: momentum begins anew.
const GROWN: f64 = 4.0;
/// Sweeps over which the rate of convergence is measured, and what is taken for it before.
const SPAN: usize = 8;
const EARLY: f64 = 0.9;
const SLOWEST: f64 = 0.999;
/// As many sweeps are cheap: they go on to this part of what is wanted.
const CHEAP: usize = 24;
const FINER: f64 = 1e-3;
/// Islands up to this size try the equations of their states (`states`), too: a few points on one body are slow to sweep and quick to solve.
const FEW: usize = 20;
/// What may be left of rates if sweeps end, in parts of what is wanted.
const ENOUGH: f64 = 10.0;

/// Forces of a sweep.
#[derive(Debug, Clone)]
pub(crate) struct Swept {
    /// λ, from the first body on the second.
    pub(crate) forces: Vec<Vector3<f64>>,
    /// Whether the rates that they leave are as near as is wanted to those of the solution.
    pub(crate) found: bool,
}

impl Problem {
    /// Sweeps with momentum, `most` times at most, until the rates of what touches each other are within `rates` of where they
    /// lead, as far as the rate at which they converge tells.
    pub(crate) fn sweep_to(&self, guess: &[Vector3<f64>], rates: f64, most: usize) -> Swept {
        let own: Vec<Own> = (0..self.rates.len()).map(|i| self.alone(i)).collect();
        let mut swept = Swept { forces: guess.to_vec(), found: true };
        for island in self.islands() {
            swept.found &= self.sweep_island(&island, &own, &mut swept.forces, rates, most);
        }
        swept
    }

    fn sweep_island(
        &self,
        island: &[usize],
        own: &[Own],
        forces: &mut [Vector3<f64>],
        rates: f64,
        most: usize,
    ) -> bool {
        let mut momentum = Momentum::new(island.iter().map(|i| forces[*i]).collect());
        let mut before = [f64::INFINITY; SPAN];
        let mut left = f64::INFINITY;
        let mut states = vec![ConeState::Open; island.len()];
        let mut attempt = if island.len() <= FEW { FIRST_ATTEMPT } else { usize::MAX };
        for sweep in 0..most {
            let (missed, steady) = self.sweep(island, own, forces, &mut states);
            let slot = &mut before[sweep % SPAN];
            let then = std::mem::replace(slot, missed);
            let converges = if sweep < SPAN { EARLY } else { (missed / then).powf(1.0 / SPAN as f64).min(SLOWEST) };
            left = missed / (1.0 - converges);
            if left <= FINER * rates || !left.is_finite() || (sweep >= CHEAP && left <= rates) {
                break;
            }
            if sweep >= attempt && steady {
                attempt = 3 * sweep;
                if self.polish_island(island, forces, &states) {
                    return true;
                }
            }
            if sweep + 1 < most {
                momentum.carry(island, forces);
            }
        }
        left <= ENOUGH * rates
    }

    /// Solves the equations of the states of an island, if these are the right ones.
    fn polish_island(&self, island: &[usize], forces: &mut [Vector3<f64>], states: &[ConeState]) -> bool {
        let near: Vec<Vector3<f64>> = island.iter().map(|i| forces[*i]).collect();
        let Some(found) = self.of_island(island).polished(&near, states) else { return false };
        island.iter().zip(found).for_each(|(i, force)| forces[*i] = force);
        true
    }

    /// One sweep; returns the largest change of a rate by that of its own force, and whether no state has changed.
    fn sweep(
        &self,
        island: &[usize],
        own: &[Own],
        forces: &mut [Vector3<f64>],
        states: &mut [ConeState],
    ) -> (f64, bool) {
        let (mut missed, mut steady) = (0.0_f64, true);
        for (&i, before) in island.iter().zip(states) {
            let (force, state) = self.answer(i, &own[i], forces);
            let change = (own[i].block * (force - forces[i])).amax();
            // What is no number is kept: `max` would lose it.
            missed = if change > missed || change.is_nan() { change } else { missed };
            steady &= *before == state;
            (forces[i], *before) = (force, state);
        }
        (missed, steady)
    }
}

/// (3) on one island.
struct Momentum {
    /// μ_k and λ_{k−1}.
    from: Vec<Vector3<f64>>,
    last: Vec<Vector3<f64>>,
    theta: f64,
    /// The least that was missing.
    least: f64,
}

impl Momentum {
    fn new(from: Vec<Vector3<f64>>) -> Self {
        Self { last: from.clone(), from, theta: 1.0, least: f64::INFINITY }
    }

    /// From λ_k to μ_{k+1}.
    fn carry(&mut self, island: &[usize], forces: &mut [Vector3<f64>]) {
        let (mut along, mut missing) = (0.0, 0.0);
        for (k, i) in island.iter().enumerate() {
            let change = forces[*i] - self.from[k];
            along += change.dot(&(forces[*i] - self.last[k]));
            missing += change.norm_squared();
        }
        let missing = missing.sqrt();
        let grown = missing > GROWN * self.least;
        self.least = if grown { missing } else { self.least.min(missing) };
        let mut beta = 0.0;
        if along < 0.0 || grown {
            self.theta = 1.0;
        } else {
            let next = 0.5 * (1.0 + (1.0 + 4.0 * self.theta * self.theta).sqrt());
            beta = ((self.theta - 1.0) / next).min(MOST);
            self.theta = next;
        }
        for (k, i) in island.iter().enumerate() {
            let found = forces[*i];
            forces[*i] += (found - self.last[k]) * beta;
            (self.last[k], self.from[k]) = (found, forces[*i]);
        }
    }
}
