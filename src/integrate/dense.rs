//! Dense output: the solution between the two ends of the last step.
//!
//! With `θ = (t − t₀) / h` every method writes its interpolant in the nested form of
//! Hairer, Nørsett, Wanner, *Solving ODEs I*, II.6,
//!
//! ```text
//! x(θ) = r₀ + θ (r₁ + (1 − θ) (r₂ + θ (r₃ + (1 − θ) r₄)))
//! ```
//!
//! with `r₀ = x₀` and `r₁ = x₁ − x₀`, so that both ends are met whatever the rest is.

use crate::integrate::rates::weighted_sum;

/// Coefficients of the last step's interpolant.
#[derive(Debug)]
pub(crate) struct Dense {
    /// `r₀ … r₄`, each as long as the state.
    coefficients: [Vec<f64>; 5],
}

impl Dense {
    /// The interpolant that stays at `state`.
    pub(crate) fn at_rest(state: &[f64]) -> Self {
        let zeros = || vec![0.0; state.len()];
        Self { coefficients: [state.to_vec(), zeros(), zeros(), zeros(), zeros()] }
    }

    /// The cubic through both ends with the rates there: local error `O(h⁴)`.
    pub(crate) fn hermite(&mut self, step: f64, ends: [&[f64]; 2], rates: [&[f64]; 2]) {
        let [r0, r1, r2, r3, _] = &mut self.coefficients;
        for i in 0..r0.len() {
            r0[i] = ends[0][i];
            r1[i] = ends[1][i] - ends[0][i];
            r2[i] = step * rates[0][i] - r1[i];
            r3[i] = r1[i] - step * rates[1][i] - r2[i];
        }
    }

    /// Raises the Hermite cubic to degree 4 with `r₄ = step Σ weights_j rates_j`.
    pub(crate) fn quartic_term(&mut self, step: f64, weights: &[f64], rates: &[Vec<f64>]) {
        weighted_sum(&mut self.coefficients[4], step, weights, rates);
    }

    /// The cubic `x₀ + … + θ² h Σ squares_j k_j + θ³ h Σ cubes_j k_j`, its linear term such that it ends at `ends(1)`.
    pub(crate) fn cubic(&mut self, step: f64, ends: [&[f64]; 2], squares: &[f64], cubes: &[f64], rates: &[Vec<f64>]) {
        let [r0, r1, r2, r3, _] = &mut self.coefficients;
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
        let [r0, r1, r2, r3, r4] = &self.coefficients;
        let rest = 1.0 - theta;
        for (offset, value) in values.iter_mut().enumerate() {
            let i = first + offset;
            *value = r0[i] + theta * (r1[i] + rest * (r2[i] + theta * (r3[i] + rest * r4[i])));
        }
    }
}
