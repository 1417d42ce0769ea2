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
//! before; otherwise it is renewed before the next step.
//!
//! **Stopping**: with the contraction `θ` of the last two corrections the error left is about `θ/(1−θ) ‖Δ‖`. It must be below the
//! fraction `κ = min(1/200, √tolerance)` of the step's share of the tolerance, in the norm of the error estimate. Two reasons: the
//! table's coefficients carry a stage's error into the result up to 50-fold (`a₅₃/γ`, `a₅₄/γ`); and these errors all have
//! the same sign, so they add up over the steps, of which a tight tolerance makes many. The first correction of a stage
//! is judged by the contraction of the stages before it in the same step. A correction as small as rounding ends the
//! iteration too.
//! Hairer, Wanner, *Solving ODEs II*, IV.8.

use crate::integrate::{
    error::{Component, Limit},
    norm::ErrorNorm,
    problem::{ImplicitProblem, Point},
    statistics::Statistics,
};

/// Largest κ.
const LARGEST_FRACTION: f64 = 0.005;
const MAX_ITERATIONS: u32 = 12;
/// A factorization that contracts worse is renewed.
const SLOW: f64 = 0.3;
/// A factorization serves steps that differ from its own by this fraction: the rounding of time, no more.
const STEP_BAND: f64 = 1e-3;
/// Corrections below this many roundings of the state are none.
pub(crate) const ROUNDINGS: f64 = 8.0;
/// Corrections that stall below this many times that are what the rounding of the residual leaves.
const STALLED: f64 = 32.0;
/// Where the residual rounds worse than the state (trees whose forces cancel), corrections may stall below this part of
/// the tolerance; of a fixed step, which has no error to hide, below all of it.
const STALLED_PARTS: [f64; 2] = [1e-3, 1.0];

/// The iteration matrix, what is known of its quality, and buffers.
#[derive(Debug)]
pub(crate) struct Newton {
    /// Corrections that stall below this are rounding, in tolerances.
    stalled: f64,
    factorization: Option<Factorization>,
    /// Residual, then correction; in velocity coordinates.
    correction: Vec<f64>,
    /// The correction as a change of the state `(q, v)`.
    displacement: Vec<f64>,
}

#[derive(Debug)]
struct Factorization {
    /// `h γ` it was made for.
    step: f64,
    /// Made at the start of the step now tried.
    fresh: bool,
    /// Contraction last seen in this step, over two corrections where there are three.
    contraction: Option<f64>,
    slow: bool,
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
    /// For steps that are `fixed` or not.
    pub(crate) fn new(fixed: bool, velocity_count: usize, state_count: usize) -> Self {
        Self {
            stalled: STALLED_PARTS[usize::from(fixed)],
            factorization: None,
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
        let serves = |last: &Factorization| !last.slow && (step / last.step - 1.0).abs() <= STEP_BAND;
        if self.factorization.as_ref().is_some_and(serves) {
            return Ok(());
        }
        self.factorization = None;
        let c1 = 1.0 / step;
        statistics.jacobian_evaluations += 1;
        problem.factorize(point, c1, c1 * c1).map_err(Limit::Failure)?;
        self.factorization = Some(Factorization { step, fresh: true, contraction: None, slow: false });
        Ok(())
    }

    /// The step is accepted: the factorization is no longer of the start of the next one.
    pub(crate) fn advance(&mut self) {
        if let Some(last) = &mut self.factorization {
            last.fresh = false;
            last.contraction = None;
        }
    }

    /// Gives up the factorization where it is old; false where it is of this very step, so that a new one would not help.
    pub(crate) fn discard_old(&mut self) -> bool {
        let old = self.factorization.as_ref().is_some_and(|last| !last.fresh);
        if old {
            self.factorization = None;
        }
        old
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
        let factorization = self.factorization.as_mut().ok_or(Limit::Newton)?;
        let fraction = norm.tolerance().sqrt().min(LARGEST_FRACTION);
        let mut before = [None; 2];
        place(problem, stage, acceleration, state);
        for iteration in 1..=MAX_ITERATIONS {
            evaluate(problem, stage.time, state, acceleration, &mut self.correction, statistics)?;
            statistics.newton_iterations += 1;
            statistics.solves += 1;
            problem.solve(&mut self.correction);
            displace(problem, state, &self.correction, factorization.step, &mut self.displacement);
            let size = norm.measure(&self.displacement, stage.start, state).value;

            let c2 = 1.0 / (factorization.step * factorization.step);
            acceleration.iter_mut().zip(&self.correction).for_each(|(a, correction)| *a -= c2 * correction);
            place(problem, stage, acceleration, state);

            let rounding = ROUNDINGS * norm.rounding(state);
            let stalled = self.stalled.max(STALLED * rounding);
            let correction = Correction { size, before, rounding, stalled, target: fraction.max(rounding) };
            if factorization.converged(correction, MAX_ITERATIONS - iteration)? {
                return Ok(());
            }
            before = [Some(size), before[0]];
        }
        Err(Limit::Newton)
    }
}

/// The size of a correction, of the two before in the same stage (the last first), of corrections that are rounding, of
/// those that are rounding where they stall, and of the error that may be left.
#[derive(Debug, Clone, Copy)]
struct Correction {
    size: f64,
    before: [Option<f64>; 2],
    rounding: f64,
    stalled: f64,
    target: f64,
}

impl Factorization {
    /// Whether the iteration may stop after this correction, `left` being the iterations that remain.
    fn converged(&mut self, correction: Correction, left: u32) -> Result<bool, Limit> {
        let Correction { size, before: [before, second], rounding, stalled, target } = correction;
        if !size.is_finite() {
            return Err(Limit::Newton);
        }
        if let Some(before) = before {
            // A single quotient of a hinge tree swings between large and small.
            self.contraction = Some(second.map_or(size / before, |second| (size / second).sqrt()));
        }
        if size <= rounding {
            return Ok(true);
        }
        // It no longer shrinks, and is about as small as the rounding of the residual makes it.
        let stalls =
            before.is_some_and(|before| size > 0.5 * before) || second.is_some_and(|second| size > 0.25 * second);
        if size <= stalled && stalls {
            return Ok(true);
        }
        self.slow |= before.is_some() && self.contraction.is_some_and(|contraction| contraction > SLOW);
        // That of another stage is trusted a little less.
        let trust = if before.is_some() { 1.0 } else { 0.8 };
        let Some(contraction) = self.contraction.map(|seen| seen.max(f64::EPSILON).powf(trust)) else {
            return Ok(false);
        };
        if contraction < 1.0 {
            let remaining = contraction / (1.0 - contraction) * size;
            let reachable = remaining * contraction.powi(left as i32) <= target;
            // One quotient is too poor a witness to give up on.
            return if reachable || second.is_none() { Ok(remaining <= target) } else { Err(Limit::Newton) };
        }
        // No progress: rounding of the residual, harmless where the correction is already below the target.
        match before {
            Some(_) if size > target => Err(Limit::Newton),
            Some(_) => Ok(true),
            None => Ok(false),
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

/// `residual ← r(t, q, v, a)`, checked to be finite.
pub(crate) fn evaluate<P: ImplicitProblem>(
    problem: &mut P,
    time: f64,
    state: &[f64],
    acceleration: &[f64],
    residual: &mut [f64],
    statistics: &mut Statistics,
) -> Result<(), Limit> {
    let (q, v) = state.split_at(problem.position_count());
    statistics.residual_evaluations += 1;
    problem.residual(time, q, v, acceleration, residual).map_err(Limit::Failure)?;
    match residual.iter().position(|r| !r.is_finite()) {
        Some(index) => Err(Limit::NotFinite(Component::Velocity(index))),
        None => Ok(()),
    }
}

/// `displacement ← (N(q) δq, δq / step)`: what a correction of the position in velocity coordinates does to the state.
fn displace<P: ImplicitProblem>(problem: &P, state: &[f64], correction: &[f64], step: f64, displacement: &mut [f64]) {
    let position_count = problem.position_count();
    let (of_position, of_velocity) = displacement.split_at_mut(position_count);
    problem.position_rate(&state[..position_count], correction, of_position);
    of_velocity.iter_mut().zip(correction).for_each(|(velocity, correction)| *velocity = correction / step);
}
