//! The stages of a step, and the integrals that go with them.

/// The stages of the last step of an implicit Runge–Kutta method, and the weights with which it integrates what follows from
/// them.
///
/// ```text
/// (1)  ∫ P dt from the start of the step to its part θ = h Σ_i w_i(θ) P(t + c_i h, X_i)
/// ```
///
/// is what the method would make of one more equation `Ẇ = P`: at the end of the step (`θ = 1`) as exact as its states, in
/// between as exact as its interpolant. The states `X_i` solve the stage equations, so stiff forces at them are those of the
/// solution; at an interpolated state a small error is multiplied by their stiffness.
#[derive(Debug, Clone, Copy)]
pub struct StepStages<'a> {
    pub(crate) nodes: &'a [f64],
    pub(crate) states: &'a [Vec<f64>],
    pub(crate) weights: &'a [f64],
    /// Beyond the line with `weights`, in the nested form of `dense.rs`: of `r₂, r₃, …`.
    pub(crate) nested: &'a [Vec<f64>],
    pub(crate) position_count: usize,
}

impl StepStages<'_> {
    /// Number of stages.
    pub fn count(&self) -> usize {
        self.nodes.len()
    }

    /// `c_i`: where stage `i` is, as a part of the step.
    pub fn node(&self, i: usize) -> f64 {
        self.nodes[i]
    }

    /// Coordinates (quaternions not normalised) and velocities of stage `i`.
    pub fn state(&self, i: usize) -> (&[f64], &[f64]) {
        self.states[i].split_at(self.position_count)
    }

    /// `w_i(θ)` of (1).
    pub fn weight(&self, i: usize, theta: f64) -> f64 {
        // x(θ) = θ (r₁ + (1 − θ) (r₂ + θ (r₃ + …)))
        let nested = self.nested.iter().enumerate().rev().fold(0.0, |sum, (k, row)| {
            let factor = if k % 2 == 0 { 1.0 - theta } else { theta };
            factor * (row[i] + sum)
        });
        theta * (self.weights[i] + nested)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::implicit::collocation::Collocation;

    #[test]
    fn a_part_of_a_step_is_integrated_exactly_up_to_the_degree_of_the_stages() {
        for method in [Collocation::radau(3), Collocation::radau(5), Collocation::gauss(3)] {
            let Collocation { nodes, weights, nested, .. } = &method;
            let stages = StepStages { nodes, states: &[], weights, nested, position_count: 0 };
            let s = stages.count();
            for (theta, degree) in (0..s as i32).flat_map(|degree| [0.0, 0.3, 0.8, 1.0].map(|theta| (theta, degree))) {
                let sum: f64 = (0..s).map(|i| stages.weight(i, theta) * stages.node(i).powi(degree)).sum();
                let exact = f64::powi(theta, degree + 1) / f64::from(degree + 1);
                assert!((sum - exact).abs() < 1e-14, "{s} stages, degree {degree} up to {theta}: {sum} for {exact}");
            }
        }
    }

    #[test]
    fn at_the_end_radau_integrates_to_its_own_order() {
        let Collocation { nodes, weights, nested, .. } = &Collocation::radau(3);
        let stages = StepStages { nodes, states: &[], weights, nested, position_count: 0 };
        let sum = |degree: i32| -> f64 { (0..3).map(|i| stages.weight(i, 1.0) * stages.node(i).powi(degree)).sum() };
        assert!((sum(4) - 1.0 / 5.0).abs() < 1e-15);
        assert!((sum(5) - 1.0 / 6.0).abs() > 1e-4, "order 2s − 1 and no more");
    }
}
