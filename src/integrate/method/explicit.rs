//! What explicit pairs whose last stage is the first of the next step have in common: the step, its error, its limits.
//!
//! ```text
//! X_i = x + h Σ_{j<i} a_ij k_j,   k_i = f(t + c_i h, X_i),   x' = X_last,   the next k_0 = k_last
//! ```
//!
//! **Quaternions** are stepped as numbers in R⁴. The new state is normalised before the last stage is taken: the new
//! state does not depend on this stage, so sharing it stays exact, and the change in the error estimate is of higher
//! order than the estimate.
//!
//! **Stability**: on a stiff system the error estimate holds the step at the edge of the stability region. The quotient
//!
//! ```text
//! h |λ| ≈ h ‖k_last − k_before‖ / ‖X_last − X_before‖
//! ```
//!
//! (both stages are at the end of the step) tells: at the edge in fifteen steps with no six quiet ones in a row between,
//! [`Explicit::stability_limited`] is raised; six quiet steps lower it. Hairer, Wanner, *Solving ODEs II*, IV.2.

use crate::integrate::{
    problem::Problem,
    step::control::{Controller, Trial},
    step::error::{Limit, StepError},
    step::norm::{ErrorNorm, Measured},
    step::options::{Options, Start},
    step::progress::Progress,
    step::rates::{combine, rate_by, require_finite, state_rate, weighted_sum},
    step::reach::Reach,
    step::staged::Evaluate,
    step::start::Begun,
};

/// Smallest share of the tolerance that a step is asked for: see `step/norm.rs`.
const SMALLEST_SHARE: f64 = 1.0 / 300.0;
/// Steps at the edge that make a system stiff, and quiet ones that clear it.
const STIFF_STEPS: u32 = 15;
const QUIET_STEPS: u32 = 6;
/// What is told of the error of a step is the part `10 h|λ|` of its estimate: that is the error of a rule of one order less, and
/// ten leaves room for its constant.
const ROOM: f64 = 10.0;
pub(crate) const ADVICE: &str =
    "beyond the stability limit of an explicit method numbers grow without bound: shorten the step, or try sdirk4";

/// A pair.
#[derive(Debug)]
pub(crate) struct Pair {
    /// `c_i`; those after the last stage of the step serve dense output alone.
    pub(crate) nodes: &'static [f64],
    /// `a_ij`; row `last` is the step.
    pub(crate) rows: &'static [&'static [f64]],
    /// The stage shared with the next step.
    pub(crate) last: usize,
    pub(crate) estimate: Estimate,
    /// The estimate is `O(h^order)`.
    pub(crate) order: u8,
    /// The step is at the edge of stability where `h |λ|` is above this.
    pub(crate) edge: f64,
}

/// How the error is estimated from the stages.
#[derive(Debug)]
pub(crate) enum Estimate {
    /// The difference to one embedded rule.
    Single(&'static [f64]),
    /// The differences to a better and a poorer rule: `‖e‖² / √(‖e‖² + 0.01 ‖poorer‖²)`. The poorer one keeps the better
    /// one from vanishing by chance.
    Double([&'static [f64]; 2]),
}

/// A pair at work.
#[derive(Debug)]
pub(crate) struct Explicit {
    pub(crate) progress: Progress,
    pub(crate) pair: &'static Pair,
    /// `k_0, k_1, …` of the last step tried.
    pub(crate) rates: Vec<Vec<f64>>,
    /// State of a stage, then of the end of the step tried; the start of the step once that is accepted.
    pub(crate) next: Vec<f64>,
    /// State of the stage before the last, for the edge of stability; then the error estimate.
    pub(crate) spare: Vec<f64>,
    /// The last step was accepted, and its last rate is still to become the first of the next one.
    pub(crate) accepted: bool,
    control: Controller,
    norm: ErrorNorm,
    edge: Edge,
    reach: Reach,
    /// The step that is tried evaluation by evaluation, and the stage that comes next.
    under_way: Option<(Trial, usize)>,
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
    fn accept(&mut self, limit: f64) {
        if self.reach > limit {
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

impl Explicit {
    /// Starts a run with room for `dense_terms` terms of dense output above the cubic.
    pub(crate) fn new<P: Problem>(
        pair: &'static Pair,
        dense_terms: usize,
        problem: &mut P,
        options: &Options,
        start: Start<'_>,
    ) -> Result<Self, StepError> {
        let norm = ErrorNorm::shared(problem, options, &start, SMALLEST_SHARE);
        let Begun { mut progress, norm, rate, step } = Begun::new(problem, options, start, norm, pair.order)?;
        progress.dense.with_higher_terms(dense_terms);
        let mut rates = vec![vec![0.0; rate.len()]; pair.nodes.len()];
        rates[0] = rate;
        Ok(Self {
            control: Controller::new(options, pair.order, step, &progress, ADVICE),
            next: progress.state.clone(),
            spare: progress.state.clone(),
            accepted: false,
            edge: Edge::default(),
            reach: Reach::default(),
            under_way: None,
            pair,
            norm,
            rates,
            progress,
        })
    }

    /// The step that would be tried next (s).
    pub(crate) fn next_step(&self) -> f64 {
        self.control.step()
    }

    /// Makes one accepted step, with the Hermite cubic of its ends between them; false if the end was reached before.
    pub(crate) fn step<P: Problem>(&mut self, problem: &mut P) -> Result<bool, StepError> {
        if self.progress.finished() {
            return Ok(false);
        }
        loop {
            let trial = self.propose(problem)?;
            let error = self.attempt(problem, trial);
            if self.judge(problem, trial, error)? {
                return Ok(true);
            }
        }
    }

    /// The next step to try.
    fn propose<P: Problem>(&mut self, problem: &P) -> Result<Trial, StepError> {
        if std::mem::take(&mut self.accepted) {
            self.rates.swap(0, self.pair.last);
        }
        let trial = self
            .control
            .propose(&self.progress, problem.longest_step(self.progress.position(), self.progress.velocity()))?;
        self.norm.allow(trial.step);
        Ok(trial)
    }

    /// Accepts or rejects a step by its error; whether it is accepted.
    fn judge<P: Problem>(
        &mut self,
        problem: &mut P,
        trial: Trial,
        error: Result<Measured, Limit>,
    ) -> Result<bool, StepError> {
        match error {
            Ok(error) if error.value <= 1.0 || self.control.is_fixed() => match self.project(problem, trial) {
                Ok(()) => {
                    self.progress.worst = error.worst;
                    self.accept(trial, error.value);
                    return Ok(true);
                }
                Err(limit) => self.control.fail(trial, limit, &self.progress)?,
            },
            Ok(error) => self.control.reject(trial, error.value, self.limit(error)),
            Err(limit) => self.control.fail(trial, limit, &self.progress)?,
        }
        self.progress.statistics.rejected_steps += 1;
        Ok(false)
    }

    /// As [`crate::integrate::Staged::ask`].
    pub(crate) fn ask<P: Problem>(&mut self, problem: &mut P) -> Result<f64, StepError> {
        loop {
            let (trial, stage) = match self.under_way.take() {
                Some(under_way) => under_way,
                None => (self.propose(problem)?, 1),
            };
            match self.stage(problem, trial, stage) {
                Ok(time) => {
                    self.under_way = Some((trial, stage));
                    return Ok(time);
                }
                Err(limit) => drop(self.judge(problem, trial, Err(limit))?),
            }
        }
    }

    /// As [`crate::integrate::Staged::answer`].
    pub(crate) fn answer<P: Problem>(&mut self, problem: &mut P, evaluate: Evaluate<'_>) -> Result<bool, StepError> {
        let Some((trial, stage)) = self.under_way.take() else { return Ok(false) };
        let statistics = &mut self.progress.statistics;
        let taken = rate_by(problem, &self.next, &mut self.rates[stage], statistics, |_, _, _, a| evaluate(a));
        match taken {
            Ok(()) if stage < self.pair.last => {
                self.under_way = Some((trial, stage + 1));
                Ok(false)
            }
            taken => {
                let error = taken.map(|()| self.measured(trial));
                self.judge(problem, trial, error)
            }
        }
    }

    pub(crate) fn stability_limited(&self) -> bool {
        self.edge.at_edge >= STIFF_STEPS
    }

    /// Fills the stages and the state at the end of the step; gives the norm of its error estimate.
    fn attempt<P: Problem>(&mut self, problem: &mut P, trial: Trial) -> Result<Measured, Limit> {
        for stage in 1..=self.pair.last {
            let time = self.stage(problem, trial, stage)?;
            state_rate(problem, time, &self.next, &mut self.rates[stage], &mut self.progress.statistics)?;
        }
        Ok(self.measured(trial))
    }

    /// Puts the state of a stage into `next`; its time.
    fn stage<P: Problem>(&mut self, problem: &mut P, trial: Trial, stage: usize) -> Result<f64, Limit> {
        let Progress { time, state, position_count, .. } = &mut self.progress;
        let Pair { nodes, rows, last, .. } = *self.pair;
        if stage == last {
            self.spare.copy_from_slice(&self.next);
        }
        combine(&mut self.next, state, trial.step, rows[stage], &self.rates);
        if stage == last {
            problem.normalize(&mut self.next[..*position_count]);
            require_finite(&self.next, *position_count)?;
        }
        Ok(*time + nodes[stage] * trial.step)
    }

    /// The norm of the error estimate once all stages are there.
    fn measured(&mut self, trial: Trial) -> Measured {
        let last = self.pair.last;
        let apart = self.norm.distance(&self.next, &self.spare);
        let rates_apart = self.norm.distance(&self.rates[last], &self.rates[last - 1]);
        self.edge.reach = if apart > 0.0 { trial.step * rates_apart / apart } else { 0.0 };
        self.estimate(trial.step)
    }

    fn estimate(&mut self, step: f64) -> Measured {
        let mut measure = |weights: &[f64]| {
            weighted_sum(&mut self.spare, step, weights, &self.rates);
            self.norm.measure(&self.spare, &self.progress.state, &self.next)
        };
        match self.pair.estimate {
            Estimate::Single(weights) => measure(weights),
            Estimate::Double([better, poorer]) => {
                let (error, other) = (measure(better), measure(poorer).value);
                if !(error.value.is_finite() && other.is_finite()) {
                    return Measured { value: f64::INFINITY, ..error };
                }
                let length = error.value.hypot(0.1 * other);
                let share = if length > 0.0 { error.value / length } else { 0.0 };
                Measured { value: error.value * share, ..error }
            }
        }
    }

    /// Projects the end of the step; where that moves it, its rate is taken again.
    fn project<P: Problem>(&mut self, problem: &mut P, trial: Trial) -> Result<(), Limit> {
        let Progress { position_count, statistics, .. } = &mut self.progress;
        let (q, v) = self.next.split_at_mut(*position_count);
        if problem.project(trial.time, q, v).map_err(Limit::Failure)? {
            state_rate(problem, trial.time, &self.next, &mut self.rates[self.pair.last], statistics)?;
        }
        Ok(())
    }

    fn accept(&mut self, trial: Trial, error: f64) {
        let Progress { state, dense, statistics, .. } = &mut self.progress;
        dense.hermite(trial.step, [state, &self.next], [&self.rates[0], &self.rates[self.pair.last]]);
        self.control.accept(trial, error, statistics.steps == 0);
        self.reach.see(&self.norm, [state, &self.next], [&self.rates[0], &self.rates[self.pair.last]]);
        statistics.error_sum += error * self.norm.tolerance() * (ROOM * self.reach.of(trial.step)).min(1.0);
        self.edge.accept(self.pair.edge);
        self.progress.advance(trial.time, &mut self.next);
        self.accepted = true;
    }

    /// What made the error estimate too large.
    fn limit(&self, error: Measured) -> Limit {
        if self.edge.reach > self.pair.edge {
            return Limit::Stability;
        }
        Limit::ErrorEstimate(self.progress.component(error.worst))
    }
}
