//! The filter that makes the error estimate of an implicit method blind to what the method damps anyway.
//!
//! A plain difference of two rules does not vanish for stiff parts and would force them to be resolved. Multiplied by
//! `(I − g J)⁻¹`, `J` the Jacobian of the rate of `x = (q, v)` and `g` of the size of the step, the slow parts pass and
//! the fast ones are damped: Hairer, Wanner, *Solving ODEs II*, IV.8. In terms of the residual, with
//! `K = ∂r/∂a / g² + ∂r/∂v / g + ∂r/∂q` and `w` the filtered error in velocity coordinates,
//!
//! ```text
//! K w = (1/g) M e_v − (∂r/∂q) e_q,    filtered e_q = e_q + N(q) w,    filtered e_v = w / g.
//! ```
//!
//! `r` is affine in `a` and zero at the end of the step, so the right side is `r(t', q' − e_q, v', a' + e_v / g)`: the
//! filter costs one residual and one solve.

use crate::integrate::{
    implicit::stage::correct, problem::ImplicitProblem, step::error::Limit, step::statistics::Statistics,
};

/// The end of a step, where the residual vanishes; `K` is factorized.
#[derive(Debug, Clone, Copy)]
pub(crate) struct End<'a> {
    pub(crate) time: f64,
    /// `g`.
    pub(crate) step: f64,
    /// `(q', v')`.
    pub(crate) state: &'a [f64],
}

/// `error ← (I − g J)⁻¹ error`. The scratch is a state, and the acceleration `a'` that is lost; `w` is left in `filtered`.
pub(crate) fn filter<P: ImplicitProblem>(
    problem: &mut P,
    end: End<'_>,
    error: &mut [f64],
    (displaced, acceleration): (&mut [f64], &mut [f64]),
    filtered: &mut [f64],
    statistics: &mut Statistics,
) -> Result<(), Limit> {
    let position_count = problem.position_count();
    let (error_q, error_v) = error.split_at_mut(position_count);
    displaced.copy_from_slice(end.state);
    displaced.iter_mut().zip(&*error_q).for_each(|(q, error)| *q -= error);
    acceleration.iter_mut().zip(&*error_v).for_each(|(a, error)| *a += error / end.step);
    correct(problem, end.time, displaced, acceleration, filtered, statistics)?;

    let turned = &mut displaced[..position_count];
    problem.position_rate(&end.state[..position_count], filtered, turned);
    error_q.iter_mut().zip(turned).for_each(|(error, by)| *error += *by);
    error_v.iter_mut().zip(filtered).for_each(|(error, by)| *error = *by / end.step);
    Ok(())
}
