//! A method whose evaluations someone else makes, one after the other: of several systems at once, each of which takes the steps
//! that it would take alone.
//!
//! ```text
//! while !stepper.finished() {
//!     let time = stepper.ask(problem)?;                        // the state is stepper.asked()
//!     stepper.answer(problem, &mut |a| …)?;                    // true where a step has been accepted with it
//! }
//! ```

use crate::integrate::{
    problem::{Failure, Problem},
    step::{error::StepError, stepper::Stepper},
};

/// Writes the accelerations that were asked for.
pub type Evaluate<'e> = &'e mut dyn FnMut(&mut [f64]) -> Result<(), Failure>;

/// A [`Stepper`] that can be stepped evaluation by evaluation, with the same states, errors and dense output as step by step.
pub trait Staged<P: Problem>: Stepper<P> {
    /// Goes to the next evaluation of a run that is not [finished](Stepper::finished); gives its time (s).
    ///
    /// # Errors
    /// As [`Stepper::step`].
    fn ask(&mut self, problem: &mut P) -> Result<f64, StepError>;

    /// The state `(q, v)` at which accelerations are asked for.
    fn asked(&self) -> &[f64];

    /// Takes the accelerations there; whether a step has been accepted with them.
    ///
    /// # Errors
    /// As [`Stepper::step`].
    fn answer(&mut self, problem: &mut P, evaluate: Evaluate<'_>) -> Result<bool, StepError>;
}
