//! What a time loop sees of a method.

use crate::integrate::{
    problem::Problem,
    step::{error::Component, error::StepError, progress::Progress, stages::StepStages, statistics::Statistics},
};

/// A method at work on one run.
///
/// ```text
/// while !stepper.finished() { stepper.step(problem)?; … }
/// ```
pub trait Stepper<P: Problem> {
    /// Makes one accepted step that does not pass the end time; does nothing at the end.
    ///
    /// # Errors
    /// [`StepError::Underflow`] where no step is small enough, [`StepError::Fixed`] where a fixed step fails. The state
    /// is then that of the last accepted step.
    fn step(&mut self, problem: &mut P) -> Result<(), StepError>;

    /// Where the run stands.
    fn progress(&self) -> &Progress;

    /// The step that would be tried next (s), if the method says so.
    fn next_step(&mut self) -> Option<f64> {
        None
    }

    /// Whether the last steps were held by stability instead of accuracy: the system is stiff and an implicit method
    /// would be faster. Always false for implicit methods.
    fn stability_limited(&self) -> bool {
        false
    }

    /// The component whose estimated error decided the length of the last step.
    fn limiting(&self) -> Component {
        self.progress().component(self.progress().worst)
    }

    /// Whether the end is reached.
    fn finished(&self) -> bool {
        self.progress().finished()
    }

    /// The time reached, in s.
    fn time(&self) -> f64 {
        self.progress().time()
    }

    /// Where the last step started, in s.
    fn previous_time(&self) -> f64 {
        self.progress().previous_time()
    }

    /// The coordinates reached.
    fn position(&self) -> &[f64] {
        self.progress().position()
    }

    /// The velocities reached.
    fn velocity(&self) -> &[f64] {
        self.progress().velocity()
    }

    /// The state at `time` inside the last step; a time outside is taken as the nearer end.
    ///
    /// Quaternions come normalised. At both ends the result is the state itself.
    ///
    /// # Errors
    /// [`StepError::Between`] where the method has to evaluate the system between the ends and cannot.
    fn interpolate(&mut self, problem: &mut P, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<(), StepError> {
        self.progress().interpolate(problem, time, q, v);
        Ok(())
    }

    /// The stages of the last step, where the method is of the kind that integrates better with them than with
    /// [`interpolate`](Self::interpolate): one of implicit stages.
    fn stages(&self) -> Option<StepStages<'_>> {
        None
    }

    /// What the run has cost so far.
    fn statistics(&self) -> &Statistics {
        self.progress().statistics()
    }
}
