//! The error norm, one for all methods.
//!
//! ```text
//! ‖e‖ = max_i |e_i| / (absolute · scale_i + relative · max(|x_i|, |x_i'|))
//! ```
//!
//! `x` and `x'` are the states at both ends of the step, `scale_i` is the size at which an absolute error of component
//! `i` counts (1 for the numbers of a quaternion). A step is good enough where `‖e‖ ≤ 1`.
//!
//! Why the maximum and not the root mean square that is usual elsewhere: in a chain of a thousand links of which one
//! moves, the mean would forgive this one an error 30 times the tolerance. With the maximum every component keeps its
//! tolerance, whatever else the scene contains.

use crate::integrate::problem::Problem;

/// Tolerances and scales of a run.
#[derive(Debug)]
pub(crate) struct ErrorNorm {
    relative: f64,
    absolute: f64,
    /// Per component of the state `(q, v)`.
    scales: Vec<f64>,
}

/// The norm of an error and the component that decides it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measured {
    /// The norm; not finite where a component is not.
    pub(crate) value: f64,
    /// Index into the state `(q, v)`.
    pub(crate) worst: usize,
}

impl ErrorNorm {
    pub(crate) fn new<P: Problem>(problem: &P, relative: f64, absolute: f64) -> Self {
        let (positions, velocities) = problem.scales();
        Self { relative, absolute, scales: [positions, velocities].concat() }
    }

    /// The coarser of the two tolerances.
    pub(crate) fn tolerance(&self) -> f64 {
        self.relative.max(self.absolute)
    }

    /// The norm of `error` on a step between the states `from` and `to`.
    pub(crate) fn measure(&self, error: &[f64], from: &[f64], to: &[f64]) -> Measured {
        let mut largest = Measured { value: 0.0, worst: 0 };
        for (index, &error) in error.iter().enumerate() {
            let value = error.abs() / self.weight(index, from[index], to[index]);
            if !value.is_finite() {
                return Measured { value: f64::INFINITY, worst: index };
            }
            if value > largest.value {
                largest = Measured { value, worst: index };
            }
        }
        largest
    }

    /// What an error of each component is multiplied with on a step between the states `from` and `to`.
    pub(crate) fn inverse_weights(&self, from: &[f64], to: &[f64], weights: &mut [f64]) {
        for (index, weight) in weights.iter_mut().enumerate() {
            *weight = 1.0 / self.weight(index, from[index], to[index]);
        }
    }

    /// The norm of one rounding error in every component of `state`.
    pub(crate) fn rounding(&self, state: &[f64]) -> f64 {
        let weighed = state.iter().enumerate().map(|(i, &x)| f64::EPSILON * x.abs() / self.weight(i, x, x));
        weighed.fold(0.0, f64::max)
    }

    /// The Euclidean length of `x − y`, each component in its scale, for ratios of lengths.
    pub(crate) fn distance(&self, x: &[f64], y: &[f64]) -> f64 {
        let squares = x.iter().zip(y).enumerate().map(|(i, (x, y))| ((x - y) / self.scales[i]).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// The time in which things happen: the largest scale of the positions by the largest of the velocities, in s.
    pub(crate) fn time_scale(&self, position_count: usize) -> f64 {
        let (positions, velocities) = self.scales.split_at(position_count);
        let largest = |scales: &[f64]| scales.iter().copied().fold(0.0, f64::max);
        largest(positions) / largest(velocities)
    }

    fn weight(&self, index: usize, from: f64, to: f64) -> f64 {
        self.absolute * self.scales[index] + self.relative * from.abs().max(to.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn norm() -> ErrorNorm {
        ErrorNorm { relative: 0.1, absolute: 0.01, scales: vec![1.0, 2.0] }
    }

    #[test]
    fn the_worst_component_decides() {
        // Weights 0.01 + 0.1·3 and 0.02 + 0.1·1.
        let measured = norm().measure(&[0.31, -0.24], &[3.0, 1.0], &[-2.0, 0.5]);
        assert_eq!(measured.worst, 1);
        assert!((measured.value - 2.0).abs() < 1e-14);
    }

    #[test]
    fn an_undefined_component_is_not_lost_in_the_maximum() {
        let measured = norm().measure(&[f64::NAN, 100.0], &[1.0, 1.0], &[1.0, 1.0]);
        assert_eq!(measured, Measured { value: f64::INFINITY, worst: 0 });
    }
}
