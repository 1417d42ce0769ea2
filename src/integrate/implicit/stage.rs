//! Newton's iteration for one implicit stage.
//!
//! The unknown is the stage acceleration `a`. With the known part `(q*, v*)` of the stage and `g = h γ`
//!
//! ```text
//! v = v* + g a,   q = q* + g N(q) v,   solve  r(t, q, v, a) = 0.
//! ```
//!
//! Linearised in velocity coordinates, `δv = g δa` and `δq = g δv`, so with `c₁ = 1/g`, `c₂ = 1/g²`
//!
//! ```text
//! K δq = −r,   K = c₂ ∂r/∂a + c₁ ∂r/∂v + ∂r/∂q,   a ← a + c₂ δq.
//! ```
//!
//! For quaternions `δq = g δv` holds up to `O(g)`, which slows the iteration a little; what it converges to is exact.
//!
//! **Reuse**: `K` is kept over stages and steps while the step is the same and each correction is at most 0.3 of the one
//! before (`tangent.rs`); otherwise it is renewed before the next step.
//!
//! **Stopping**: by the rule of `contraction.rs`, when the error left is below the fraction `κ = min(1/200, √tolerance)` of the
//! step's share of the tolerance, in the norm of the error estimate. Two reasons: the table's coefficients carry a
//! stage's error into the result up to 50-fold (`a₅₃/γ`, `a₅₄/γ`); and these errors all have the same sign, so they add
//! up over the steps, of which a tight tolerance makes many. The first correction of a stage is judged by the
//! contraction of the stages before it in the same step.

use crate::integrate::{
    implicit::care::Care,
    implicit::contraction::{Accuracy, Iteration},
    implicit::tangent::{Shift, TangentCache},
    problem::{ImplicitProblem, Point},
    step::error::{Component, Limit},
    step::norm::ErrorNorm,
    step::statistics::Statistics,
};

/// Largest κ.
const LARGEST_FRACTION: f64 = 0.005;
const MAX_ITERATIONS: u32 = 12;
/// The contraction of another stage is trusted a little less: it counts with this power.
const TRUST: f64 = 0.8;
/// Corrections below this many roundings of the state are none.
pub(crate) const NO_CORRECTION: f64 = 8.0;
/// Corrections that stall below this many times that are what the rounding of the residual leaves.
const STALLED: f64 = 32.0;
/// If the residual rounds worse than the state (trees whose forces cancel), corrections may stall below this part of
/// the tolerance, of which the table makes half a tolerance at most (see above); of a fixed step, which has no error to hide, below all
/// of it.
const STALLED_PARTS: [f64; 2] = [1e-2, 1.0];

/// Newton's iteration for single stages, its tangent and buffers.
#[derive(Debug)]
pub(crate) struct Newton {
    /// Corrections that stall below this are rounding, in tolerances.
    stalled: f64,
    tangent: TangentCache,
    care: Care,
    /// Contraction last seen in this step.
    contraction: Option<f64>,
    /// Residual, then correction; in velocity coordinates.
    correction: Vec<f64>,
    /// The correction as a change of the state `(q, v)`.
    displacement: Vec<f64>,
}

/// The known part of a stage.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stage<'a> {
    /// The stage's time.
    pub(crate) time: f64,
    /// `h γ`.
    pub(crate) step: f64,
    /// `(q*, v*)`.
    pub(crate) known: &'a [f64],
    /// State at the start of the step, for the error norm.
    pub(crate) start: &'a [f64],
}

impl Newton {
    /// For steps of a problem that are `fixed` or not, from a start with this `rate`.
    pub(crate) fn new<P: ImplicitProblem>(problem: &P, fixed: bool, rate: &[f64]) -> Self {
        let (velocity_count, state_count) = (rate.len() - problem.position_count(), rate.len());
        Self {
            care: Care::of(problem),
            stalled: STALLED_PARTS[usize::from(fixed)],
            tangent: TangentCache::default(),
            contraction: None,
            correction: vec![0.0; velocity_count],
            displacement: vec![0.0; state_count],
        }
    }

    /// Makes sure of a factorization that serves `step` = `h γ`: a new one at `point` where the last one does not.
    pub(crate) fn prepare<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        point: Point<'_>,
        step: f64,
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        if self.tangent.serves(step) {
            return Ok(());
        }
        self.contraction = None;
        let c1 = 1.0 / step;
        self.tangent.renew(problem, point, Shift { step, c1, c2: c1 * c1 }, statistics)
    }

    /// The step of this length (s) is accepted: the tangent is no longer of the start of the next one.
    pub(crate) fn advance(&mut self, step: f64, statistics: &Statistics) {
        self.tangent.advance();
        self.care.advance(step, statistics);
        self.contraction = None;
    }

    /// Gives up the tangent if it is old, or takes more of them if the problem asks for that; false if neither would help.
    pub(crate) fn discard_old(&mut self, statistics: &Statistics) -> bool {
        self.tangent.discard_old() || self.care.take_if_asked(statistics)
    }

    /// Solves a stage: `acceleration` holds the guess and then the solution, `state` the stage's `(q, v)`.
    ///
    /// # Errors
    /// [`Limit::Newton`] where the iteration diverges or is too slow; where the residual cannot be evaluated.
    pub(crate) fn solve<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        norm: &ErrorNorm,
        stage: Stage<'_>,
        state: &mut [f64],
        acceleration: &mut [f64],
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        let shift = self.tangent.shift()?;
        let Shift { c1, c2, .. } = shift;
        let fraction = norm.tolerance().sqrt().min(LARGEST_FRACTION);
        place(problem, stage, acceleration, state);
        let rounding = NO_CORRECTION * norm.rounding(state);
        let left = fraction.max(rounding);
        let stalled = self.stalled.max(STALLED * rounding).max(left);
        let accuracy = Accuracy { left, stalled, least_contraction: f64::EPSILON };
        let prior = self.contraction.map(|contraction| contraction.powf(TRUST));
        let mut iteration = Iteration::new(accuracy, MAX_ITERATIONS).expecting(prior);
        loop {
            if self.care.is_taken() {
                let (q, v) = state.split_at(problem.position_count());
                self.tangent.renew(problem, Point { time: stage.time, q, v, a: acceleration }, shift, statistics)?;
            }
            correct(problem, stage.time, state, acceleration, &mut self.correction, statistics)?;
            statistics.newton_iterations += 1;
            displace(problem, state, &self.correction, c1, &mut self.displacement);
            let size = norm.measure(&self.displacement, stage.start, state).value;

            acceleration.iter_mut().zip(&self.correction).for_each(|(a, correction)| *a -= c2 * correction);
            place(problem, stage, acceleration, state);

            let done = iteration.converged(size, rounding);
            if let Some(contraction) = iteration.contraction() {
                self.contraction = Some(contraction);
                // Of corrections as small as rounding a quotient says nothing of the tangent.
                if size > rounding {
                    self.tangent.see(contraction);
                }
            }
            if done? {
                return Ok(());
            }
        }
    }
}

/// `state ← (q, v)` of the stage with this acceleration.
pub(crate) fn place<P: ImplicitProblem>(problem: &P, stage: Stage<'_>, acceleration: &[f64], state: &mut [f64]) {
    let position_count = problem.position_count();
    let (known_q, known_v) = stage.known.split_at(position_count);
    let (q, v) = state.split_at_mut(position_count);
    for ((v, known), a) in v.iter_mut().zip(known_v).zip(acceleration) {
        *v = known + stage.step * a;
    }
    problem.implicit_position(known_q, stage.step, v, q);
}

/// `correction ← K⁻¹ r(t, q, v, a)` with the tangent factorized last; the residual is checked to be finite.
pub(crate) fn correct<P: ImplicitProblem>(
    problem: &mut P,
    time: f64,
    state: &[f64],
    acceleration: &[f64],
    correction: &mut [f64],
    statistics: &mut Statistics,
) -> Result<(), Limit> {
    let (q, v) = state.split_at(problem.position_count());
    statistics.residual_evaluations += 1;
    problem.residual(time, q, v, acceleration, correction).map_err(Limit::Failure)?;
    if let Some(index) = correction.iter().position(|r| !r.is_finite()) {
        return Err(Limit::NotFinite(Component::Velocity(index)));
    }
    statistics.solves += 1;
    problem.solve(correction);
    Ok(())
}

/// `displacement ← (N(q) δq, c₁ δq)`: what a correction of the position in velocity coordinates does to the state.
fn displace<P: ImplicitProblem>(problem: &P, state: &[f64], correction: &[f64], c1: f64, displacement: &mut [f64]) {
    let position_count = problem.position_count();
    let (of_position, of_velocity) = displacement.split_at_mut(position_count);
    problem.position_rate(&state[..position_count], correction, of_position);
    of_velocity.iter_mut().zip(correction).for_each(|(velocity, correction)| *velocity = c1 * correction);
}
