//! The method of Dormand and Prince: order 5, error estimate of order 4, seven stages, the last one shared.
//!
//! The step itself, the treatment of quaternions and the sign of stiffness are those of `explicit.rs`.
//!
//! **Error**: `O(h⁶)` per step. The step is chosen such that `‖e‖ ≤ 1` in the norm of the options, where `e` is the
//! difference to the embedded rule of order 4; the better value is the one kept.
//!
//! **Work**: six evaluations per step, rejected or not; the seventh stage is the first of the next step.
//!
//! **Stability**: for `ẋ = λ x` bounded by `h |λ| < 3.3` on the negative real axis, about 1 on the imaginary one. Above
//! 3.25 a step counts as held by stability.
//!
//! **Between the ends**: the continuous extension of order 4 that the stages give for free.
//!
//! **Quaternions**: normalising the new state changes the error estimate by `O(h⁷)`.
//!
//! **Reference**: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., II.5 (method), II.4
//! (step), II.6 (dense output); Hairer, Wanner, *II*, IV.2 (stiffness).

use crate::integrate::{
    method::explicit::{Estimate, Explicit, Pair},
    method::tableau::dopri5::{A, C, DENSE, E},
    problem::Problem,
    step::error::StepError,
    step::options::{Options, Start},
    step::progress::Progress,
    step::staged::{Evaluate, Staged},
    step::stepper::Stepper,
};

const PAIR: Pair =
    Pair { nodes: &C, rows: &A, last: C.len() - 1, estimate: Estimate::Single(&E), order: 5, edge: 3.25 };

/// The method of Dormand and Prince, order 5, adaptive.
#[derive(Debug)]
pub struct Dopri5(Explicit);

impl Dopri5 {
    /// Starts a run; the first step is the `step` of the options or chosen from the system.
    ///
    /// # Errors
    /// If an option is out of its range, the start does not fit the system, or the system cannot be evaluated there.
    pub fn new<P: Problem>(problem: &mut P, options: &Options, start: Start<'_>) -> Result<Self, StepError> {
        Explicit::new(&PAIR, 1, problem, options, start).map(Self)
    }

    /// What lies between the ends of the step that has been accepted.
    fn fill_dense(&mut self) {
        let step = self.0.progress.last_step();
        self.0.progress.dense.higher_terms(step, &[&DENSE], &self.0.rates);
    }
}

impl<P: Problem> Stepper<P> for Dopri5 {
    fn step(&mut self, problem: &mut P) -> Result<(), StepError> {
        if self.0.step(problem)? {
            self.fill_dense();
        }
        Ok(())
    }

    fn progress(&self) -> &Progress {
        &self.0.progress
    }

    fn next_step(&mut self) -> Option<f64> {
        Some(self.0.next_step())
    }

    fn stability_limited(&self) -> bool {
        self.0.stability_limited()
    }
}

impl<P: Problem> Staged<P> for Dopri5 {
    fn ask(&mut self, problem: &mut P) -> Result<f64, StepError> {
        self.0.ask(problem)
    }

    fn asked(&self) -> &[f64] {
        &self.0.next
    }

    fn answer(&mut self, problem: &mut P, evaluate: Evaluate<'_>) -> Result<bool, StepError> {
        let accepted = self.0.answer(problem, evaluate)?;
        if accepted {
            self.fill_dense();
        }
        Ok(accepted)
    }
}
