//! The rate of the state `x = (q, v)` and sums of such rates.

use crate::integrate::{
    problem::{Failure, Problem},
    step::error::{Component, Limit},
    step::statistics::Statistics,
};

/// `rate ← (N(q) v, a(t, q, v))`.
///
/// # Errors
/// If the system cannot be evaluated or a rate is not finite.
pub(crate) fn state_rate<P: Problem>(
    problem: &mut P,
    time: f64,
    state: &[f64],
    rate: &mut [f64],
    statistics: &mut Statistics,
) -> Result<(), Limit> {
    rate_by(problem, state, rate, statistics, |problem, q, v, a| problem.acceleration(time, q, v, a))
}

/// As [`state_rate`], with accelerations that `evaluate` writes.
///
/// # Errors
/// What `evaluate` says, and a rate that is not finite.
pub(crate) fn rate_by<P: Problem>(
    problem: &mut P,
    state: &[f64],
    rate: &mut [f64],
    statistics: &mut Statistics,
    evaluate: impl FnOnce(&mut P, &[f64], &[f64], &mut [f64]) -> Result<(), Failure>,
) -> Result<(), Limit> {
    let position_count = problem.position_count();
    let (q, v) = state.split_at(position_count);
    let (position_rate, acceleration) = rate.split_at_mut(position_count);
    problem.position_rate(q, v, position_rate);
    statistics.acceleration_evaluations += 1;
    evaluate(problem, q, v, acceleration).map_err(Limit::Failure)?;
    require_finite(rate, position_count)
}

/// Brings the end of a step onto the manifold: quaternions to unit length, then what else binds the coordinates; true
/// where the latter changed the state.
///
/// # Errors
/// Where there is no such state nearby.
pub(crate) fn settle<P: Problem>(
    problem: &mut P,
    time: f64,
    state: &mut [f64],
    position_count: usize,
) -> Result<bool, Limit> {
    let (q, v) = state.split_at_mut(position_count);
    problem.normalize(q);
    problem.project(time, q, v).map_err(Limit::Failure)
}

/// `sum ← start + step Σ weights_j rates_j`.
pub(crate) fn combine(sum: &mut [f64], start: &[f64], step: f64, weights: &[f64], rates: &[Vec<f64>]) {
    let factors = weights.iter().map(|weight| step * weight);
    let mut terms = factors.zip(rates).filter(|(factor, _)| *factor != 0.0);
    sum.copy_from_slice(start);
    // Two at a time: sums of long states wait for memory.
    while let Some((factor, rate)) = terms.next() {
        match terms.next() {
            Some((other, more)) => {
                for ((sum, rate), more) in sum.iter_mut().zip(rate).zip(more) {
                    *sum = (*sum + factor * rate) + other * more;
                }
            }
            None => sum.iter_mut().zip(rate).for_each(|(sum, rate)| *sum += factor * rate),
        }
    }
}

/// `sum ← step Σ weights_j rates_j`.
pub(crate) fn weighted_sum(sum: &mut [f64], step: f64, weights: &[f64], rates: &[Vec<f64>]) {
    sum.fill(0.0);
    for (weight, rate) in weights.iter().zip(rates) {
        for (sum, rate) in sum.iter_mut().zip(rate) {
            *sum += step * weight * rate;
        }
    }
}

/// Names the first component that is not finite.
pub(crate) fn require_finite(state: &[f64], position_count: usize) -> Result<(), Limit> {
    match state.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(Limit::NotFinite(Component::of_state(index, position_count))),
        None => Ok(()),
    }
}
