//! The classical Runge–Kutta method: order 4, four stages, fixed step.
//!
//! ```text
//! k₁ = f(t, x)              k₂ = f(t + h/2, x + h/2 k₁)
//! k₃ = f(t + h/2, x + h/2 k₂)    k₄ = f(t + h, x + h k₃)
//! x' = x + h/6 (k₁ + 2 k₂ + 2 k₃ + k₄)
//! ```
//!
//! **Error**: `O(h⁵)` per step, `O(h⁴)` at a given time. Nothing estimates it: halve the step and compare.
//!
//! **Stability**: for `ẋ = λ x` the step must satisfy `h |λ| < 2.78` on the negative real axis and `h |λ| < 2.83` on the
//! imaginary one, so `h` is at most about 0.45 of the shortest period of the system, and far less for accuracy.
//!
//! **Between the ends**: the Hermite cubic with the rates at both ends, which are known anyway; its error is `O(h⁴)`
//! like that of the steps.
//!
//! **Quaternions** are stepped as numbers in R⁴; the new state is normalised before its rate is taken, so this rate is
//! also the first stage of the next step. The correction is `O(h⁵)` and costs no order.
//!
//! **Reference**: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., II.1.

use crate::integrate::{
    method::explicit::ADVICE,
    method::tableau::rk4::{A, B, C},
    problem::Problem,
    step::control::{Controller, Trial},
    step::error::{Limit, StepError},
    step::options::{Options, Start},
    step::progress::Progress,
    step::rates::{combine, require_finite, settle, state_rate},
    step::stepper::Stepper,
};

/// The classical Runge–Kutta method, order 4, fixed step. Four evaluations per step and one for the start.
#[derive(Debug)]
pub struct Rk4 {
    progress: Progress,
    control: Controller,
    /// `k₁ … k₄`; the first is the rate at the state reached.
    rates: Vec<Vec<f64>>,
    /// The rate at the end of the step tried.
    end_rate: Vec<f64>,
    /// State of a stage, then of the end of the step tried.
    next: Vec<f64>,
}

impl Rk4 {
    /// Starts a run with the fixed `step` of the options; the last step is cut to land on the end.
    ///
    /// # Errors
    /// If no step is given, an option is out of its range, the start does not fit the system, or the system cannot
    /// be evaluated there.
    pub fn new<P: Problem>(problem: &mut P, options: &Options, start: Start<'_>) -> Result<Self, StepError> {
        let options = Options { fixed: true, ..*options };
        options.validate()?;
        let step = options.step.ok_or(StepError::NoStep)?;
        let mut progress = Progress::new(problem, start)?;
        let mut rates = vec![vec![0.0; progress.state.len()]; C.len()];
        state_rate(problem, progress.time, &progress.state, &mut rates[0], &mut progress.statistics)
            .map_err(|limit| progress.cannot_start(limit))?;
        Ok(Self {
            control: Controller::new(&options, 4, step, &progress, ADVICE),
            end_rate: rates[0].clone(),
            next: progress.state.clone(),
            rates,
            progress,
        })
    }

    /// Fills the stages, the state at the end of the step and its rate.
    fn attempt<P: Problem>(&mut self, problem: &mut P, trial: Trial) -> Result<(), Limit> {
        let Progress { time, state, position_count, statistics, .. } = &mut self.progress;
        for stage in 1..C.len() {
            combine(&mut self.next, state, trial.step, A[stage], &self.rates);
            state_rate(problem, *time + C[stage] * trial.step, &self.next, &mut self.rates[stage], statistics)?;
        }
        combine(&mut self.next, state, trial.step, &B, &self.rates);
        settle(problem, trial.time, &mut self.next, *position_count)?;
        require_finite(&self.next, *position_count)?;
        state_rate(problem, trial.time, &self.next, &mut self.end_rate, statistics)
    }
}

impl<P: Problem> Stepper<P> for Rk4 {
    fn step(&mut self, problem: &mut P) -> Result<(), StepError> {
        if self.progress.finished() {
            return Ok(());
        }
        let trial = self.control.propose(&self.progress)?;
        if let Err(limit) = self.attempt(problem, trial) {
            return self.control.fail(trial, limit, &self.progress);
        }
        let Progress { state, dense, statistics, .. } = &mut self.progress;
        dense.hermite(trial.step, [state, &self.next], [&self.rates[0], &self.end_rate]);
        self.control.accept(trial, 0.0, statistics.steps == 0);
        self.progress.advance(trial.time, &mut self.next);
        std::mem::swap(&mut self.rates[0], &mut self.end_rate);
        Ok(())
    }

    fn progress(&self) -> &Progress {
        &self.progress
    }
}
