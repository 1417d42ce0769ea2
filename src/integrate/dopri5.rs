//! The method of Dormand and Prince: order 5, error estimate of order 4, seven stages, the last one shared.
//!
//! ```text
//! X_i = x + h Σ_j a_ij k_j,   k_i = f(t + c_i h, X_i),   x' = X_7,   e = h Σ_i e_i k_i
//! ```
//!
//! **Error**: `O(h⁶)` per step. The step is chosen such that `‖e‖ ≤ 1` in the norm of the options, where `e` is the
//! difference to the embedded rule of order 4; the better value is the one kept.
//!
//! **Work**: six evaluations per step, rejected or not; the seventh stage is the first of the next step.
//!
//! **Stability**: for `ẋ = λ x` bounded by `h |λ| < 3.3` on the negative real axis, about 1 on the imaginary one. On a
//! stiff system the estimate then holds the step at this edge. The quotient
//!
//! ```text
//! h |λ| ≈ h ‖k_7 − k_6‖ / ‖X_7 − X_6‖
//! ```
//!
//! (both stages are at the end of the step) tells: above 3.25 in fifteen steps with no six quiet ones in a row between,
//! [`stability_limited`](Stepper::stability_limited) is raised; six quiet steps lower it.
//!
//! **Between the ends**: the continuous extension of order 4 that the stages give for free.
//!
//! **Quaternions** are stepped as numbers in R⁴. The new state is normalised before the seventh stage is taken: the new
//! state does not depend on this stage, so sharing it stays exact, and the change in the error estimate is `O(h⁷)`.
//!
//! **Reference**: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., II.5 (method), II.4
//! (step), II.6 (dense output); Hairer, Wanner, *II*, IV.2 (stiffness).

use crate::integrate::{
    control::{Controller, Trial},
    error::{Limit, StepError},
    norm::{ErrorNorm, Measured},
    options::{Options, Start},
    problem::Problem,
    progress::Progress,
    rates::{combine, require_finite, state_rate, weighted_sum},
    start::first_step,
    stepper::Stepper,
    tableau::dopri5::{A, C, DENSE, E},
};

/// The error estimate is `O(h⁵)`.
const ESTIMATE_ORDER: u8 = 5;
const LAST: usize = C.len() - 1;
/// The step is at the edge of stability where `h |λ|` is above this.
const EDGE: f64 = 3.25;
/// Steps at the edge that make a system stiff, and quiet ones that clear it.
const STIFF_STEPS: u32 = 15;
const QUIET_STEPS: u32 = 6;
const ADVICE: &str =
    "beyond the stability limit of an explicit method numbers grow without bound: shorten the step, or try sdirk4";

/// The method of Dormand and Prince, order 5, adaptive.
#[derive(Debug)]
pub struct Dopri5 {
    progress: Progress,
    control: Controller,
    norm: ErrorNorm,
    /// `k₁ … k₇`; the first is the rate at the state reached.
    rates: Vec<Vec<f64>>,
    /// State of a stage, then of the end of the step tried.
    next: Vec<f64>,
    /// State of the sixth stage, for the stiffness test; then the error estimate.
    spare: Vec<f64>,
    edge: Edge,
}

/// How often the step was at the edge of stability.
#[derive(Debug, Default)]
struct Edge {
    /// `h |λ|` of the last attempt.
    reach: f64,
    at_edge: u32,
    quiet: u32,
}

impl Edge {
    fn accept(&mut self) {
        if self.reach > EDGE {
            self.quiet = 0;
            self.at_edge = (self.at_edge + 1).min(STIFF_STEPS);
        } else {
            self.quiet += 1;
            if self.quiet >= QUIET_STEPS {
                self.at_edge = 0;
            }
        }
    }
}

impl Dopri5 {
    /// Starts a run; the first step is the `step` of the options or chosen from the system.
    ///
    /// # Errors
    /// Where an option is out of its range, the start does not fit the system, or the system cannot be evaluated there.
    pub fn new<P: Problem>(problem: &mut P, options: &Options, start: Start<'_>) -> Result<Self, StepError> {
        options.validate()?;
        let mut progress = Progress::new(problem, start)?;
        let norm = ErrorNorm::new(problem, options.relative, options.absolute);
        let mut rates = vec![vec![0.0; progress.state.len()]; C.len()];
        state_rate(problem, progress.time, &progress.state, &mut rates[0], &mut progress.statistics)
            .map_err(|limit| progress.cannot_start(limit))?;
        let step = match options.step {
            Some(step) => step,
            None => first_step(problem, &norm, &mut progress, &rates[0], ESTIMATE_ORDER),
        };
        Ok(Self {
            control: Controller::new(options, ESTIMATE_ORDER, step, &progress, ADVICE),
            next: progress.state.clone(),
            spare: progress.state.clone(),
            edge: Edge::default(),
            norm,
            rates,
            progress,
        })
    }

    /// Fills the stages and the state at the end of the step; gives the norm of its error estimate.
    fn attempt<P: Problem>(&mut self, problem: &mut P, trial: Trial) -> Result<Measured, Limit> {
        let Progress { time, state, position_count, statistics, .. } = &mut self.progress;
        for stage in 1..=LAST {
            if stage == LAST {
                self.spare.copy_from_slice(&self.next);
            }
            combine(&mut self.next, state, trial.step, A[stage], &self.rates);
            if stage == LAST {
                problem.normalize(&mut self.next[..*position_count]);
                require_finite(&self.next, *position_count)?;
            }
            state_rate(problem, *time + C[stage] * trial.step, &self.next, &mut self.rates[stage], statistics)?;
        }
        let apart = self.norm.distance(&self.next, &self.spare);
        let rates_apart = self.norm.distance(&self.rates[LAST], &self.rates[LAST - 1]);
        self.edge.reach = if apart > 0.0 { trial.step * rates_apart / apart } else { 0.0 };

        weighted_sum(&mut self.spare, trial.step, &E, &self.rates);
        Ok(self.norm.measure(&self.spare, state, &self.next))
    }

    fn accept(&mut self, trial: Trial, error: f64) {
        let Progress { state, dense, statistics, .. } = &mut self.progress;
        dense.hermite(trial.step, [state, &self.next], [&self.rates[0], &self.rates[LAST]]);
        dense.quartic_term(trial.step, &DENSE, &self.rates);
        self.control.accept(trial, error, statistics.steps == 0);
        self.edge.accept();
        self.progress.advance(trial.time, &mut self.next);
        self.rates.swap(0, LAST);
    }

    /// What made the error estimate too large.
    fn limit(&self, error: Measured) -> Limit {
        if self.edge.reach > EDGE {
            return Limit::Stability;
        }
        Limit::ErrorEstimate(self.progress.component(error.worst))
    }
}

impl<P: Problem> Stepper<P> for Dopri5 {
    fn step(&mut self, problem: &mut P) -> Result<(), StepError> {
        while !self.progress.finished() {
            let trial = self.control.propose(&self.progress)?;
            match self.attempt(problem, trial) {
                Ok(error) if error.value <= 1.0 || self.control.is_fixed() => {
                    self.accept(trial, error.value);
                    break;
                }
                Ok(error) => self.control.reject(trial, error.value, self.limit(error)),
                Err(limit) => self.control.fail(trial, limit, &self.progress)?,
            }
            self.progress.statistics.rejected_steps += 1;
        }
        Ok(())
    }

    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn stability_limited(&self) -> bool {
        self.edge.at_edge >= STIFF_STEPS
    }
}
