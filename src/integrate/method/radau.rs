//! Radau IIA with its stages solved together: orders 5 and 9, for stiff systems, the latter at tight tolerances.
//!
//! ```text
//! (1)  X_i = x + h Σ_j a_ij k_j,   k_i = (N(q_i) v_i, a_i),   r(t + c_i h, q_i, v_i, a_i) = 0,   x' = X_s
//! ```
//!
//! with the coefficients of `implicit/collocation.rs`. The stages are coupled; `stages.rs` solves them with one tangent of a real
//! shift, an O(n) sweep.
//!
//! **Stability**: L-stable and stiffly accurate, as `sdirk4`. Unlike there every stage is itself of order `s`, so a
//! strong damper or a stiff spring that moves leaves an error `O(h^s)` and not `O(h)`: tight tolerances stay cheap.
//!
//! **Error**: `O(h^{2s})` per step where the step resolves the system.
//!
//! **Error estimate**: how far the polynomial of the step misses the rate `k_0` at its start,
//!
//! ```text
//! (2)  e = κ h (k_0 − Σ_i ℓ_i(0) k_i) = O(h^{s+1}),
//! ```
//!
//! filtered with the tangent's shift (see `implicit/filter.rs`). It is the difference to an embedded rule of order `s` (*Solving
//! ODEs II*, IV.8, with `κ` in place of the real eigenvalue), and also of the order of the error between the ends, so a sample is as good as the
//! tolerance while the ends of steps are better: so much better that the errors of all steps add up to less than the
//! tolerance, and every step is allowed the whole of it, not a share (`step/norm.rs`). The last stage of a step is the first rate of the next.
//!
//! The error of the end itself, where the solution behaves like `exp(λt)`, is the part
//!
//! ```text
//! (3)  s! / ((2s)! κ) · (h|λ|)^{s−1}
//! ```
//!
//! of (2), with `|λ|` of `step/reach.rs`. Its sum over all steps is told, not asked for, together with what the iteration of each step has
//! left of the stages: at tight tolerances that is more than (3).
//!
//! **Between the ends**: the polynomial itself, error `O(h^{s+1})`; that of positions with the velocities at both ends as slopes.
//!
//! **Why this method and not another** (`stillpoint precision` on a stiff chain, at an error of 10⁻⁹): singly diagonal
//! methods have stage order 1 or 2 and need ten times the steps; the classical solution of (1) by one real and pairs of
//! complex tangents needs complex sweeps.
//!
//! **Quaternions** are stepped as numbers in R⁴ and normalised after the step.
//!
//! **Reference**: Hairer, Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., IV.5, IV.8.

use crate::integrate::{
    implicit::collocation::Collocation,
    implicit::contraction::Accuracy,
    implicit::filter::{End, filter},
    implicit::splitting::{RADAU_3, RADAU_5, Splitting},
    implicit::stages::{Solution, Stages},
    implicit::{ADVICE, HOLD_BELOW, Implicit},
    problem::ImplicitProblem,
    step::control::{Controller, Trial},
    step::error::{Limit, StepError},
    step::norm::{ErrorNorm, Measured},
    step::options::{Options, Start},
    step::progress::Progress,
    step::rates::{settle, state_rate},
    step::reach::Reach,
    step::stages::StepStages,
    step::start::Begun,
};

/// Room for what equation (3) leaves out: the motion has more than one rate.
const ROOM: f64 = 10.0;
/// At a tolerance of 10⁻¹⁰. A larger part left spoils the prediction of the next stages, and three times as much leaves
/// 2·10⁻⁸ of Kapitza's pendulum (`docs/hard_cases.md`). At tolerances close to rounding the iteration may stall earlier.
const ACCURACY: Accuracy = Accuracy { left: 0.001, stalled: 0.1, least_contraction: 0.1 };
const TIGHT: f64 = 1e-10;
/// What the iterations of all steps leave adds up. Looser tolerances make fewer steps, each of which may leave more, but no
/// more than so many times that.
const MOST_LEFT: f64 = 7.0;
/// `κ`. Larger ones only make steps shorter whose ends are more exact than the tolerance anyway.
const ESTIMATE_3: f64 = 1.0 / 5.0;
const ESTIMATE_5: f64 = 1.0 / 13.0;

/// Radau IIA of 3 or 5 stages: order 5 or 9, L-stable, adaptive.
#[derive(Debug)]
pub struct Radau {
    progress: Progress,
    control: Controller,
    norm: ErrorNorm,
    stages: Stages,
    /// `κ ℓ_i(0)`, and `κ`.
    at_start: Vec<f64>,
    estimate: f64,
    reach: Reach,
    /// `k_0`: `(N(q) v, a)` at the start of the step.
    rate: Vec<f64>,
    /// State at the end of the step tried.
    next: Vec<f64>,
    error: Vec<f64>,
    /// A state, an acceleration and a right side for the filter.
    displaced: Vec<f64>,
    acceleration: Vec<f64>,
    filtered: Vec<f64>,
}

impl Radau {
    /// Starts a run of order 5; the first step is the `step` of the options or chosen from the system.
    ///
    /// # Errors
    /// If an option is out of its range, the start does not fit the system, or the system cannot be evaluated there.
    pub fn order_5<P: ImplicitProblem>(
        problem: &mut P,
        options: &Options,
        start: Start<'_>,
    ) -> Result<Self, StepError> {
        Self::new(problem, (3, RADAU_3, ESTIMATE_3), options, start)
    }

    /// Starts a run of order 9.
    ///
    /// # Errors
    /// As [`Radau::order_5`].
    pub fn order_9<P: ImplicitProblem>(
        problem: &mut P,
        options: &Options,
        start: Start<'_>,
    ) -> Result<Self, StepError> {
        Self::new(problem, (5, RADAU_5, ESTIMATE_5), options, start)
    }

    fn new<P: ImplicitProblem>(
        problem: &mut P,
        (stages, splitting, estimate): (usize, Splitting, f64),
        options: &Options,
        start: Start<'_>,
    ) -> Result<Self, StepError> {
        let (estimate_order, norm) = (stages as u8 + 1, ErrorNorm::new(problem, options.relative, options.absolute));
        let Begun { mut progress, norm, rate, step } = Begun::new(problem, options, start, norm, estimate_order)?;
        progress.dense.with_terms(stages + 1);
        let method = Collocation::radau(stages);
        let steps_fewer = (norm.tolerance() / TIGHT).powf(1.0 / f64::from(estimate_order)).clamp(1.0, MOST_LEFT);
        let accuracy = Accuracy { left: steps_fewer * ACCURACY.left, ..ACCURACY };
        let solution = Solution { splitting, accuracy, steps: 2, most: stages + 1 };
        let acceleration = rate[progress.position_count..].to_vec();
        Ok(Self {
            control: Controller::new(options, estimate_order, step, &progress, ADVICE).holding_below(HOLD_BELOW),
            at_start: (0..stages).map(|j| estimate * method.lagrange(j, 0.0)).collect(),
            estimate,
            reach: Reach::default(),
            stages: Stages::new(problem, method, solution, &rate),
            next: rate.clone(),
            error: rate.clone(),
            displaced: rate.clone(),
            filtered: acceleration.clone(),
            acceleration,
            rate,
            norm,
            progress,
        })
    }

    /// The part of the estimate that the error of the end is, eq. (3), with room; at most all of it.
    fn end(&self, step: f64) -> f64 {
        let s = self.at_start.len();
        let factorials: f64 = (s + 1..=2 * s).map(|k| k as f64).product();
        let reach = self.reach.of(step).powi(s as i32 - 1);
        (ROOM * reach / (factorials * self.estimate)).min(1.0)
    }

    /// The norm of (2), filtered.
    fn estimate<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial) -> Result<Measured, Limit> {
        let Progress { state, position_count, statistics, .. } = &mut self.progress;
        let last = self.at_start.len() - 1;
        self.error.iter_mut().zip(&self.rate).for_each(|(error, rate)| *error = self.estimate * rate);
        for (weight, rate) in self.at_start.iter().zip(&self.stages.rates) {
            self.error.iter_mut().zip(rate).for_each(|(error, rate)| *error -= weight * rate);
        }
        self.error.iter_mut().for_each(|error| *error *= trial.step);
        self.acceleration.copy_from_slice(&self.stages.rates[last][*position_count..]);
        let step = trial.step * self.stages.diagonal;
        let end = End { time: trial.time, step, state: &self.next };
        let scratch = (&mut self.displaced[..], &mut self.acceleration[..]);
        filter(problem, end, &mut self.error, scratch, &mut self.filtered, statistics)?;
        Ok(self.norm.measure(&self.error, state, &self.next))
    }
}

impl Implicit for Radau {
    fn reached(&self) -> &Progress {
        &self.progress
    }

    fn parts(&mut self) -> (&mut Progress, &mut Controller) {
        (&mut self.progress, &mut self.control)
    }

    fn attempt<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial) -> Result<Measured, Limit> {
        let Progress { time, state, statistics, .. } = &mut self.progress;
        self.stages.solve(problem, &self.norm, (*time, state), trial.step, statistics)?;
        self.next.copy_from_slice(&self.stages.states[self.at_start.len() - 1]);
        if self.control.is_fixed() {
            return Ok(Measured { value: 0.0, worst: 0 });
        }
        self.estimate(problem, trial)
    }

    fn accept<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial, error: f64) -> Result<(), Limit> {
        let rates = [&self.rate[..], &self.stages.rates[self.at_start.len() - 1]];
        self.reach.see(&self.norm, [&self.progress.state, &self.next], rates);
        // A fixed step is solved to the same tolerance, but nothing estimates its error.
        if !self.control.is_fixed() {
            let left = error * self.end(trial.step) + self.stages.left;
            self.progress.statistics.error_sum += left * self.norm.tolerance();
        }
        let Progress { state, position_count, dense, statistics, .. } = &mut self.progress;
        if settle(problem, trial.time, &mut self.next, *position_count)? {
            state_rate(problem, trial.time, &self.next, &mut self.rate, statistics)?;
        } else {
            self.rate.copy_from_slice(&self.stages.rates[self.at_start.len() - 1]);
        }
        dense.nested(trial.step, [state, &self.next], &self.stages.method.nested, &self.stages.rates);
        dense.follow_velocities(problem, trial.step, [state, &self.next], *position_count);
        self.control.accept(trial, error, statistics.steps == 0);
        self.stages.advance(trial.step, &self.progress.statistics);
        self.progress.advance(trial.time, &mut self.next);
        Ok(())
    }

    fn discard_old(&mut self) -> bool {
        let statistics = &self.progress.statistics;
        self.stages.discard_old(statistics) || (self.control.is_fixed() && self.stages.take_care(statistics))
    }

    fn step_stages(&self) -> Option<StepStages<'_>> {
        Some(self.stages.of_step(self.progress.position_count))
    }
}
