//! Dense output: the solution between the two ends of the last step.
//!
//! With `θ = (t − t₀) / h` every method writes its interpolant in the nested form of
//! Hairer, Nørsett, Wanner, *Solving ODEs I*, II.6,
//!
//! ```text
//! x(θ) = r₀ + θ (r₁ + (1 − θ) (r₂ + θ (r₃ + (1 − θ) (r₄ + …))))
//! ```
//!
//! with `r₀ = x₀` and `r₁ = x₁ − x₀`, so that both ends are met whatever the rest is.

use crate::integrate::problem::Problem;
use crate::integrate::step::rates::weighted_sum;

/// Coefficients of the last step's interpolant.
#[derive(Debug)]
pub(crate) struct Dense {
    /// `r₀, r₁, …`, four or more, each as long as the state.
    coefficients: Vec<Vec<f64>>,
    /// Scratch of [`Dense::follow_velocities`].
    rate: Vec<f64>,
}

/// Terms of a cubic.
const CUBIC: usize = 4;

impl Dense {
    /// The interpolant that stays at `state`.
    pub(crate) fn at_rest(state: &[f64]) -> Self {
        let mut coefficients = vec![vec![0.0; state.len()]; CUBIC];
        coefficients[0].copy_from_slice(state);
        Self { coefficients, rate: state.to_vec() }
    }

    /// Makes room for `count` terms above the cubic.
    pub(crate) fn with_higher_terms(&mut self, count: usize) {
        self.with_terms(CUBIC + count);
    }

    /// Makes room for a polynomial of `count` terms.
    pub(crate) fn with_terms(&mut self, count: usize) {
        let size = self.coefficients[0].len();
        self.coefficients.resize(count, vec![0.0; size]);
    }

    /// The line through both ends and one more degree per row of weights: `r_{2+i} = step Σ_j weights_ij rates_j`.
    pub(crate) fn nested(&mut self, step: f64, ends: [&[f64]; 2], weights: &[Vec<f64>], rates: &[Vec<f64>]) {
        let [r0, r1, higher @ ..] = &mut self.coefficients[..] else { return };
        for i in 0..r0.len() {
            r0[i] = ends[0][i];
            r1[i] = ends[1][i] - ends[0][i];
        }
        for (term, weights) in higher.iter_mut().zip(weights) {
            weighted_sum(term, step, weights, rates);
        }
    }

    /// The cubic through both ends with the rates there: local error `O(h⁴)`. Higher terms become zero.
    pub(crate) fn hermite(&mut self, step: f64, ends: [&[f64]; 2], rates: [&[f64]; 2]) {
        let [r0, r1, r2, r3, higher @ ..] = &mut self.coefficients[..] else { return };
        higher.iter_mut().for_each(|term| term.fill(0.0));
        // All as long as the first, and known to be: nothing is checked number by number.
        let n = r0.len();
        let [r1, r2, r3] = [r1, r2, r3].map(|term| &mut term[..n]);
        let ([from, to], [first, last]) = (ends.map(|end| &end[..n]), rates.map(|rate| &rate[..n]));
        for i in 0..n {
            r0[i] = from[i];
            r1[i] = to[i] - from[i];
            r2[i] = step * first[i] - r1[i];
            r3[i] = r1[i] - step * last[i] - r2[i];
        }
    }

    /// Gives the positions of a step from `ends[0]` to `ends[1]` the slopes at both ends that its velocities are, the rest of
    /// their interpolant kept: what moves away from a limit at the start of a step does so between its ends. (Of the velocities
    /// themselves the rates may be huge where a fast transient begins.) The change is of the order of the interpolant's error.
    pub(crate) fn follow_velocities<P: Problem>(
        &mut self,
        problem: &P,
        step: f64,
        ends: [&[f64]; 2],
        position_count: usize,
    ) {
        let Self { coefficients, rate } = self;
        let [_, r1, r2, r3, ..] = &mut coefficients[..] else { return };
        let rate = &mut rate[..position_count];
        let rate_at = |end: &[f64], rate: &mut [f64]| {
            let (q, v) = end.split_at(position_count);
            problem.position_rate(q, v, rate);
        };
        rate_at(ends[0], rate);
        for i in 0..position_count {
            r2[i] = step * rate[i] - r1[i];
        }
        rate_at(ends[1], rate);
        for i in 0..position_count {
            r3[i] = r1[i] - step * rate[i] - r2[i];
        }
    }

    /// Raises the Hermite cubic by one degree per row of weights: `r_{4+i} = step Σ_j weights_ij rates_j`.
    pub(crate) fn higher_terms(&mut self, step: f64, weights: &[&[f64]], rates: &[Vec<f64>]) {
        for (term, weights) in self.coefficients[CUBIC..].iter_mut().zip(weights) {
            weighted_sum(term, step, weights, rates);
        }
    }

    /// The cubic `x₀ + … + θ² h Σ squares_j k_j + θ³ h Σ cubes_j k_j`, its linear term such that it ends at `ends(1)`.
    pub(crate) fn cubic(&mut self, step: f64, ends: [&[f64]; 2], squares: &[f64], cubes: &[f64], rates: &[Vec<f64>]) {
        let [r0, r1, r2, r3, ..] = &mut self.coefficients[..] else { return };
        weighted_sum(r2, -step, squares, rates);
        weighted_sum(r3, -step, cubes, rates);
        for i in 0..r0.len() {
            r0[i] = ends[0][i];
            r1[i] = ends[1][i] - ends[0][i];
            r2[i] += r3[i];
        }
    }

    /// `values ← x(θ)` for the components from `first` on.
    pub(crate) fn evaluate(&self, theta: f64, first: usize, values: &mut [f64]) {
        values.fill(0.0);
        for (index, term) in self.coefficients.iter().enumerate().rev() {
            let factor = if index % 2 == 0 { theta } else { 1.0 - theta };
            for (value, term) in values.iter_mut().zip(&term[first..]) {
                *value = term + factor * *value;
            }
        }
    }
}
