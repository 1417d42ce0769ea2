//! The error norm, one for all methods.
//!
//! ```text
//! ‖e‖ = max_i |e_i| / (absolute · scale_i + relative · max(|x_i|, |x_i'|))
//! ```
//!
//! `x` and `x'` are the states at both ends of the step, `scale_i` is the size at which an absolute error of component
//! `i` counts (1 for the numbers of a quaternion). A step is good enough where `‖e‖ ≤ 1`.
//!
//! **Shares**: the user's tolerances are for the whole run, of duration `T`, and the errors of its steps add up. So a step
//! of length `h` has its share of them,
//!
//! ```text
//! absolute, relative = share · (those of the run),   smallest ≤ share = h / T ≤ 1,
//! ```
//!
//! and what the run ends with is about its tolerances, times what the motion itself makes of an error. The smallest share
//! is the method's own (`1/300` of the explicit pairs): runs of more steps than that pay for the sum, but a short transient
//! does not ask for digits that are lost again. Implicit methods ask for less: what they damp does not add up. No
//! share takes a tolerance below [`FLOOR`], where estimates would be rounding and steps shrink for nothing; a method of low
//! order has no floor, and steps so short that their rounding is small too. The estimate per share
//! is one order lower: that changes no step by more than a few per cent, and the controller ignores it.
//!
//! Why the maximum and not the root mean square that is usual elsewhere: in a chain of a thousand links of which one
//! moves, the mean would forgive this one an error 30 times the tolerance. With the maximum every component keeps its
//! tolerance, whatever else the scene contains.

use crate::integrate::{
    problem::Problem,
    step::options::{Options, Start},
};

/// Tolerances and scales of a run.
#[derive(Debug)]
pub(crate) struct ErrorNorm {
    /// Relative and absolute tolerance of the run.
    whole: [f64; 2],
    /// Relative and absolute tolerance of the step that is tried.
    local: [f64; 2],
    shares: Option<Shares>,
    /// Per component of the state `(q, v)`.
    scales: Vec<f64>,
}

/// Shares of the tolerance bring it no lower than this: four hundred roundings, what the accelerations of ordinary scenes
/// are uncertain by.
const FLOOR: f64 = 400.0 * f64::EPSILON;

/// How steps share the tolerance of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shares {
    /// Of the run, in s.
    duration: f64,
    smallest: f64,
    /// No tolerance of the run is taken below this, unless it is below.
    floor: f64,
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
    /// A norm with constant tolerances.
    pub(crate) fn new<P: Problem>(problem: &P, relative: f64, absolute: f64) -> Self {
        let (positions, velocities) = problem.scales();
        let whole = [relative, absolute];
        Self { whole, local: whole, shares: None, scales: [positions, velocities].concat() }
    }

    /// A share of the run's tolerances for every step, at least `smallest` of them. Fixed steps have no share.
    pub(crate) fn shared<P: Problem>(problem: &P, options: &Options, start: &Start<'_>, smallest: f64) -> Self {
        let duration = options.duration.unwrap_or(start.end - start.time);
        let shares = (!options.fixed).then_some(Shares { duration, smallest, floor: FLOOR });
        Self { shares, ..Self::new(problem, options.relative, options.absolute) }
    }

    /// Shares may take the tolerance below what rounding of ordinary steps is.
    pub(crate) fn without_floor(mut self) -> Self {
        self.shares.iter_mut().for_each(|shares| shares.floor = 0.0);
        self
    }

    /// From here on the norm is that of a step of length `step`, in s.
    pub(crate) fn allow(&mut self, step: f64) {
        let Some(Shares { duration, smallest, floor }) = self.shares else { return };
        let share = if step < duration { (step / duration).max(smallest) } else { 1.0 };
        self.local = self.whole.map(|whole| (share * whole).max(floor.min(whole)));
    }

    /// The coarser of the two tolerances of the step.
    pub(crate) fn tolerance(&self) -> f64 {
        self.local[0].max(self.local[1])
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
        let [relative, absolute] = self.local;
        absolute * self.scales[index] + relative * from.abs().max(to.abs())
    }
}

/// The largest component of `x − y`, each multiplied with its weight; infinite where one is not a number.
pub(crate) fn largest_difference(x: &[f64], y: &[f64], weights: &[f64]) -> f64 {
    let (mut largest, mut undefined) = ([0.0_f64; 4], false);
    for ((x, y), weights) in x.chunks(4).zip(y.chunks(4)).zip(weights.chunks(4)) {
        for (((largest, x), y), weight) in largest.iter_mut().zip(x).zip(y).zip(weights) {
            let size = (x - y).abs() * weight;
            undefined |= size.is_nan();
            *largest = largest.max(size);
        }
    }
    if undefined { f64::INFINITY } else { largest.into_iter().fold(0.0, f64::max) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn norm() -> ErrorNorm {
        let whole = [0.1, 0.01];
        ErrorNorm { whole, local: whole, shares: None, scales: vec![1.0, 2.0] }
    }

    #[test]
    fn a_step_has_its_share_between_the_smallest_and_the_whole() {
        let mut norm = ErrorNorm { shares: Some(Shares { duration: 4.0, smallest: 0.01, floor: FLOOR }), ..norm() };
        let mut tolerance = |step: f64| {
            norm.allow(step);
            norm.local
        };
        assert_eq!(tolerance(1.0), [0.025, 0.0025]);
        assert_eq!(tolerance(1e-3), [0.001, 0.0001]);
        assert_eq!(tolerance(5.0), [0.1, 0.01]);
    }

    #[test]
    fn no_share_asks_for_less_than_rounding_but_the_run_may() {
        let shares = Some(Shares { duration: 1.0, smallest: 0.01, floor: FLOOR });
        let mut norm = ErrorNorm { whole: [1e-12, 1e-15], shares, ..norm() };
        norm.allow(1e-3);
        assert_eq!(norm.local, [FLOOR, 1e-15]);
    }

    #[test]
    fn the_worst_component_decides() {
        // Weights 0.01 + 0.1·3 and 0.02 + 0.1·1.
        let measured = norm().measure(&[0.31, -0.24], &[3.0, 1.0], &[-2.0, 0.5]);
        assert_eq!(measured.worst, 1);
        assert!((measured.value - 2.0).abs() < 1e-14);
    }

    #[test]
    fn the_largest_difference_is_that_of_the_norm() {
        let (from, to) = ([3.0, 1.0, -2.0, 0.5, 7.0], [2.0, 1.5, -2.0, 0.4, 7.5]);
        let weights = [1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(largest_difference(&from, &to, &weights), 2.5);
        assert_eq!(largest_difference(&from, &[f64::NAN, 1.5, -2.0, 0.4, 7.5], &weights), f64::INFINITY);
    }

    #[test]
    fn an_undefined_component_is_not_lost_in_the_maximum() {
        let measured = norm().measure(&[f64::NAN, 100.0], &[1.0, 1.0], &[1.0, 1.0]);
        assert_eq!(measured, Measured { value: f64::INFINITY, worst: 0 });
    }
}
