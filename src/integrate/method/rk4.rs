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
    step::rates::{combine, rate_by, require_finite, settle, state_rate},
    step::staged::{Evaluate, Staged},
    step::stepper::Stepper,
};

/// The classical Runge–Kutta method, order 4, fixed step. Four evaluations per step and one for the start.
#[derive(Debug)]
pub struct Rk4 {
    progress: Progress,
    control: Controller,
    /// `k₁ … k₄`, and the rate at the end of the step tried; the first is that at the state reached.
    rates: Vec<Vec<f64>>,
    /// State of a stage, then of the end of the step tried.
    next: Vec<f64>,
    under_way: Option<(Trial, usize)>,
}

/// The evaluation at the end of the step.
const LAST: usize = C.len();

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
        let mut rates = vec![vec![0.0; progress.state.len()]; LAST + 1];
        state_rate(problem, progress.time, &progress.state, &mut rates[0], &mut progress.statistics)
            .map_err(|limit| progress.cannot_start(limit))?;
        Ok(Self {
            control: Controller::new(&options, 4, step, &progress, ADVICE),
            next: progress.state.clone(),
            rates,
            progress,
            under_way: None,
        })
    }

    /// Puts the state of a stage, or of the end of the step, into `next`; its time.
    fn stage<P: Problem>(&mut self, problem: &mut P, trial: Trial, stage: usize) -> Result<f64, Limit> {
        let Progress { time, state, position_count, .. } = &mut self.progress;
        if stage < LAST {
            combine(&mut self.next, state, trial.step, A[stage], &self.rates);
            return Ok(*time + C[stage] * trial.step);
        }
        combine(&mut self.next, state, trial.step, &B, &self.rates);
        settle(problem, trial.time, &mut self.next, *position_count)?;
        require_finite(&self.next, *position_count)?;
        Ok(trial.time)
    }

    /// Fills the stages, the state at the end of the step and its rate.
    fn attempt<P: Problem>(&mut self, problem: &mut P, trial: Trial) -> Result<(), Limit> {
        for stage in 1..=LAST {
            let time = self.stage(problem, trial, stage)?;
            state_rate(problem, time, &self.next, &mut self.rates[stage], &mut self.progress.statistics)?;
        }
        Ok(())
    }

    fn accept(&mut self, trial: Trial) {
        let Progress { state, dense, statistics, .. } = &mut self.progress;
        dense.hermite(trial.step, [state, &self.next], [&self.rates[0], &self.rates[LAST]]);
        self.control.accept(trial, 0.0, statistics.steps == 0);
        self.progress.advance(trial.time, &mut self.next);
        self.rates.swap(0, LAST);
    }
}

impl<P: Problem> Stepper<P> for Rk4 {
    fn step(&mut self, problem: &mut P) -> Result<(), StepError> {
        if self.progress.finished() {
            return Ok(());
        }
        let trial = self.control.propose(&self.progress, f64::INFINITY)?;
        if let Err(limit) = self.attempt(problem, trial) {
            return self.control.fail(trial, limit, &self.progress);
        }
        self.accept(trial);
        Ok(())
    }

    fn progress(&self) -> &Progress {
        &self.progress
    }
}

impl<P: Problem> Staged<P> for Rk4 {
    fn ask(&mut self, problem: &mut P) -> Result<f64, StepError> {
        loop {
            let (trial, stage) = match self.under_way.take() {
                Some(under_way) => under_way,
                None => (self.control.propose(&self.progress, f64::INFINITY)?, 1),
            };
            match self.stage(problem, trial, stage) {
                Ok(time) => {
                    self.under_way = Some((trial, stage));
                    return Ok(time);
                }
                Err(limit) => self.control.fail(trial, limit, &self.progress)?,
            }
        }
    }

    fn asked(&self) -> &[f64] {
        &self.next
    }

    fn answer(&mut self, problem: &mut P, evaluate: Evaluate<'_>) -> Result<bool, StepError> {
        let Some((trial, stage)) = self.under_way.take() else { return Ok(false) };
        let statistics = &mut self.progress.statistics;
        if let Err(limit) = rate_by(problem, &self.next, &mut self.rates[stage], statistics, |_, _, _, a| evaluate(a)) {
            return self.control.fail(trial, limit, &self.progress).map(|()| false);
        }
        if stage < LAST {
            self.under_way = Some((trial, stage + 1));
            return Ok(false);
        }
        self.accept(trial);
        Ok(true)
    }
}
