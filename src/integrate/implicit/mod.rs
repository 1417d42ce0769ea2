//! The step of an adaptive implicit method: tries, and what follows from each.

pub(crate) mod care;
pub(crate) mod collocation;
pub(crate) mod contraction;
pub(crate) mod filter;
pub(crate) mod history;
pub(crate) mod splitting;
pub(crate) mod stage;
pub(crate) mod stages;
pub(crate) mod tangent;

use crate::integrate::{
    problem::ImplicitProblem,
    step::control::{Controller, Trial},
    step::error::{Limit, StepError},
    step::norm::Measured,
    step::progress::Progress,
    step::stages::StepStages,
    step::stepper::Stepper,
};

/// A step that would grow by less is kept, and with it the factorization.
pub(crate) const HOLD_BELOW: f64 = 1.2;
/// What to do if a fixed step cannot be solved.
pub(crate) const ADVICE: &str = "shorten the step, or let the method choose it";

/// What such a method does in a step.
pub(crate) trait Implicit {
    /// Where the run stands.
    fn reached(&self) -> &Progress;

    /// Where the run stands, and what chooses its steps.
    fn parts(&mut self) -> (&mut Progress, &mut Controller);

    /// Solves for the end of a step; gives the norm of its error estimate, 0 where the step is fixed.
    fn attempt<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial) -> Result<Measured, Limit>;

    /// Makes the end of the step tried the state reached.
    ///
    /// # Errors
    /// If it cannot be projected.
    fn accept<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial, error: f64) -> Result<(), Limit>;

    /// Gives up tangents of an earlier step, or takes more of them where the step cannot be shortened; false if that would
    /// not help any more.
    fn discard_old(&mut self) -> bool;

    /// The stages of the last step, as [`Stepper::stages`] has them.
    fn step_stages(&self) -> Option<StepStages<'_>> {
        None
    }
}

impl<P: ImplicitProblem, M: Implicit> Stepper<P> for M {
    fn step(&mut self, problem: &mut P) -> Result<(), StepError> {
        step(self, problem)
    }

    fn progress(&self) -> &Progress {
        self.reached()
    }

    fn next_step(&mut self) -> Option<f64> {
        Some(self.parts().1.step())
    }

    fn stages(&self) -> Option<StepStages<'_>> {
        self.step_stages()
    }
}

/// Makes one accepted step.
fn step<P: ImplicitProblem>(method: &mut impl Implicit, problem: &mut P) -> Result<(), StepError> {
    loop {
        let (progress, control) = method.parts();
        if progress.finished() {
            return Ok(());
        }
        let trial = control.propose(progress, problem.longest_step(progress.position(), progress.velocity()))?;
        let attempt = match method.attempt(problem, trial) {
            Ok(error) if error.value <= 1.0 => {
                method.parts().0.worst = error.worst;
                method.accept(problem, trial, error.value).map(|()| None)
            }
            other => other.map(Some),
        };
        let outcome = match attempt {
            Ok(None) => return Ok(()),
            // Old tangents are to blame first.
            Err(_) if method.discard_old() => continue,
            other => other,
        };
        let (progress, control) = method.parts();
        match outcome {
            Ok(Some(error)) => {
                control.reject(trial, error.value, Limit::ErrorEstimate(progress.component(error.worst)));
            }
            Err(limit) => control.fail(trial, limit, progress)?,
            Ok(None) => {}
        }
        progress.statistics.rejected_steps += 1;
    }
}
