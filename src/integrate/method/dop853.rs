//! The method of Dormand and Prince of order 8, with error estimates of orders 5 and 3: thirteen stages, the last one
//! shared. For tight tolerances.
//!
//! The step itself, the treatment of quaternions and the sign of stiffness are those of `explicit.rs`.
//!
//! **Error**: `O(h⁹)` per step. With the differences `e₅`, `e₃` to embedded rules of orders 5 and 3 the step is chosen
//! such that
//!
//! ```text
//! ‖e₅‖² / √(‖e₅‖² + 0.01 ‖e₃‖²) ≤ 1,
//! ```
//!
//! which is `O(h⁸)` where the step resolves the system, and falls back on `‖e₅‖` where it does not.
//!
//! **Work**: twelve evaluations per step, rejected or not; three more for a step inside which a state is asked for.
//!
//! **Stability**: for `ẋ = λ x` bounded by `h |λ| < 6.1` on the negative real axis. Above that a step counts as held by
//! stability.
//!
//! **Between the ends**: the continuous extension of order 7, made when it is asked for. A step that fails takes what is
//! needed for it; inside the step before there is then only the cubic through its ends.
//!
//! **Quaternions**: normalising the new state changes the error estimate by `O(h¹⁰)`.
//!
//! **Reference**: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., II.5 (method), II.6
//! (dense output), II.10 (practice); Hairer, Wanner, *II*, IV.2 (stiffness).

use crate::integrate::{
    method::explicit::{Estimate, Explicit, Pair},
    method::tableau::dop853::{A, C, DENSE, E3, E5},
    problem::Problem,
    step::error::StepError,
    step::options::{Options, Start},
    step::progress::Progress,
    step::rates::{combine, state_rate},
    step::staged::{Evaluate, Staged},
    step::stepper::Stepper,
};

const LAST: usize = 12;
const PAIR: Pair =
    Pair { nodes: &C, rows: &A, last: LAST, estimate: Estimate::Double([&E5, &E3]), order: 8, edge: 6.1 };

/// The method of Dormand and Prince, order 8, adaptive.
#[derive(Debug)]
pub struct Dop853 {
    core: Explicit,
    /// The highest terms of the dense output of the last step are made.
    dense: bool,
}

impl Dop853 {
    /// Starts a run; the first step is the `step` of the options or chosen from the system.
    ///
    /// # Errors
    /// If an option is out of its range, the start does not fit the system, or the system cannot be evaluated there.
    pub fn new<P: Problem>(problem: &mut P, options: &Options, start: Start<'_>) -> Result<Self, StepError> {
        let core = Explicit::new(&PAIR, DENSE.len(), problem, options, start)?;
        Ok(Self { core, dense: false })
    }

    /// The stages and terms that only dense output needs, from the stages of the last step.
    fn make_dense<P: Problem>(&mut self, problem: &mut P) -> Result<(), StepError> {
        let Explicit { progress, rates, next: start, spare: place, .. } = &mut self.core;
        let (from, step) = (progress.previous_time, progress.last_step());
        for stage in LAST + 1..C.len() {
            combine(place, start, step, A[stage], rates);
            state_rate(problem, from + C[stage] * step, place, &mut rates[stage], &mut progress.statistics)
                .map_err(|limit| StepError::Between { from, to: progress.time, limit })?;
        }
        progress.dense.higher_terms(step, &DENSE, rates);
        self.dense = true;
        Ok(())
    }
}

impl<P: Problem> Stepper<P> for Dop853 {
    fn step(&mut self, problem: &mut P) -> Result<(), StepError> {
        if self.core.step(problem)? {
            self.dense = false;
        }
        Ok(())
    }

    fn progress(&self) -> &Progress {
        &self.core.progress
    }

    fn interpolate(&mut self, problem: &mut P, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<(), StepError> {
        if time < self.core.progress.time && self.core.accepted && !self.dense {
            self.make_dense(problem)?;
        }
        self.core.progress.interpolate(problem, time, q, v);
        Ok(())
    }

    fn next_step(&mut self) -> Option<f64> {
        Some(self.core.next_step())
    }

    fn stability_limited(&self) -> bool {
        self.core.stability_limited()
    }
}

impl<P: Problem> Staged<P> for Dop853 {
    fn ask(&mut self, problem: &mut P) -> Result<f64, StepError> {
        self.core.ask(problem)
    }

    fn asked(&self) -> &[f64] {
        &self.core.next
    }

    fn answer(&mut self, problem: &mut P, evaluate: Evaluate<'_>) -> Result<bool, StepError> {
        let accepted = self.core.answer(problem, evaluate)?;
        self.dense &= !accepted;
        Ok(accepted)
    }
}
