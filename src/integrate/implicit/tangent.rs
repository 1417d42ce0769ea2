//! The factorized tangent of an implicit method, kept over stages and steps as long as it serves.
//!
//! ```text
//! K = c₂ ∂r/∂a + c₁ ∂r/∂v + ∂r/∂q,   c₁ and c₂ as the step has them
//! ```
//!
//! **Serving**: it is taken for steps of its own length, up to the rounding of time, until an iteration with it contracts
//! slowly. **Blame**: if a step fails, a tangent of an earlier step is to blame first; one made for the step itself is not.

use crate::integrate::{
    problem::{ImplicitProblem, Point},
    step::error::Limit,
    step::statistics::Statistics,
};

/// A tangent serves steps that differ from its own by this fraction: the rounding of time, no more.
const STEP_BAND: f64 = 1e-3;
/// A tangent with which an iteration contracts worse is renewed before the next step (*Solving ODEs II*, IV.8).
const SLOW: f64 = 0.3;

/// At most one factorized tangent, held by the problem, and what is known of its quality.
#[derive(Debug, Default)]
pub(crate) struct TangentCache {
    held: Option<CachedTangent>,
}

#[derive(Debug, Clone, Copy)]
struct CachedTangent {
    /// What it was made for.
    shift: Shift,
    /// Made for the step now tried.
    fresh: bool,
    slow: bool,
    /// Accepted steps that it served after its own.
    served: u32,
}

/// The length of a step (or `h γ`), and the coefficients of its tangent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shift {
    pub(crate) step: f64,
    pub(crate) c1: f64,
    pub(crate) c2: f64,
}

impl TangentCache {
    /// Whether there is a tangent for steps of this length with which no iteration was slow.
    pub(crate) fn serves(&self, step: f64) -> bool {
        self.held.is_some_and(|held| !held.slow && (step / held.shift.step - 1.0).abs() <= STEP_BAND)
    }

    /// What the tangent was made for: a correction `x` of the position is one of `c₁ x` of the velocity and `c₂ x` of the
    /// acceleration with *these* coefficients, not those of a step that differs a little.
    ///
    /// # Errors
    /// If there is none.
    pub(crate) fn shift(&self) -> Result<Shift, Limit> {
        self.held.map(|held| held.shift).ok_or(Limit::Newton)
    }

    /// Whether the tangent was made for the step now tried.
    pub(crate) fn is_fresh(&self) -> bool {
        self.held.is_some_and(|held| held.fresh)
    }

    /// Whether the tangent has served no step but its own.
    pub(crate) fn served_none(&self) -> bool {
        self.held.is_some_and(|held| held.served == 0)
    }

    /// Factorizes anew at a point.
    ///
    /// # Errors
    /// If the tangent is singular there; none is held then.
    pub(crate) fn renew<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        at: Point<'_>,
        shift: Shift,
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        self.held = None;
        statistics.jacobian_evaluations += 1;
        problem.factorize(at, shift.c1, shift.c2).map_err(Limit::Failure)?;
        self.held = Some(CachedTangent { shift, fresh: true, slow: false, served: 0 });
        Ok(())
    }

    /// The tangent counts as one of an earlier step from now on: the point it was made at is in doubt.
    pub(crate) fn doubt(&mut self) {
        self.held.iter_mut().for_each(|held| held.fresh = false);
    }

    /// Takes note of the contraction of an iteration with it.
    pub(crate) fn see(&mut self, contraction: f64) {
        self.held.iter_mut().for_each(|held| held.slow |= contraction > SLOW);
    }

    /// The step is accepted.
    pub(crate) fn advance(&mut self) {
        if let Some(held) = &mut self.held {
            held.served += u32::from(!held.fresh);
            held.fresh = false;
        }
    }

    /// Gives the tangent up.
    pub(crate) fn clear(&mut self) {
        self.held = None;
    }

    /// Gives the tangent up if it is old; false if it is of the step now tried, or if there is none.
    pub(crate) fn discard_old(&mut self) -> bool {
        let old = self.held.is_some_and(|held| !held.fresh);
        if old {
            self.clear();
        }
        old
    }
}
