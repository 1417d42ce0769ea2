//! Gauss collocation of three stages: order 6, fixed step, symmetric. For long runs without dissipation.
//!
//! ```text
//! X_i = x + h Σ_j a_ij k_j,   k_i = (N(q_i) v_i, a_i),   x' = x + h Σ_j b_j k_j
//! ```
//!
//! with the coefficients of `implicit/collocation.rs`, the stages solved to rounding as in `stages.rs`.
//!
//! **What it keeps**: the method is symmetric (run backwards from its end it returns to its start, up to rounding) and
//! keeps quadratic invariants of `(q, v)`, among them the norms of quaternions. It is symplectic where the mass matrix is
//! constant; elsewhere momenta are not linear in `(q, v)`, and what bounds the energy error over long times is the
//! symmetry: of a mechanism without dissipation, whose motion run backwards is a motion too, the energy swings within
//! `O(h⁶)` and does not drift as long as the motion is not chaotic. Hairer, Lubich, Wanner, *Geometric Numerical
//! Integration*, IV.2, XI.3. So it is measured: the largest energy error of a double pendulum and of a heavy top is the
//! same after 10⁴ and after 10⁶ steps (`tests/all/integrators/mechanisms.rs`). Where many incommensurable motions meet (three
//! links on balls, even where they swing little) the error grows slowly, ten times from 10⁴ to 10⁵ steps: shorter steps make
//! it small, nothing bounds it. That is the method and not the iteration of its stages: after as many steps of half the
//! length it is some hundred times smaller, where what iterations leave would be as large.
//!
//! **Error**: `O(h⁷)` per step, `O(h⁶)` at a given time. Nothing estimates it: halve the step and compare.
//!
//! **Stability**: A-stable without damping of its own: what the step does not resolve goes on swinging.
//!
//! **Rounding**: the iteration goes on until corrections are rounding, and the sum of all steps is compensated (Kahan),
//! so that rounding does not make the energy drift in one direction. *Geometric Numerical Integration*, VIII.5.
//!
//! **Between the ends**: the polynomial of the step, error `O(h⁴)`: poorer than the ends.

use crate::integrate::{
    implicit::collocation::Collocation,
    implicit::contraction::Accuracy,
    implicit::splitting::GAUSS_3,
    implicit::stages::{Solution, Stages},
    problem::ImplicitProblem,
    step::control::{Controller, Trial},
    step::error::{Limit, StepError},
    step::norm::ErrorNorm,
    step::options::{Options, Start},
    step::progress::Progress,
    step::rates::{require_finite, settle},
    step::stages::StepStages,
    step::start::Begun,
    step::stepper::Stepper,
};

const STAGES: usize = 3;
/// Relative and absolute unit of the iteration's accuracy.
const UNIT: f64 = 1e-13;
/// The iteration aims at rounding, and may stall at what rounding of the residual leaves on stiff systems.
const ACCURACY: Accuracy = Accuracy { left: 1e-2, stalled: 1e2, least_contraction: 0.0 };
/// Steps are equal, so two of them predict the next with rates of twice the order.
const SOLUTION: Solution = Solution { splitting: GAUSS_3, accuracy: ACCURACY, steps: 2, most: 6 };
const ADVICE: &str = "shorten the step";

/// Gauss collocation, order 6, symmetric, fixed step.
#[derive(Debug)]
pub struct Gauss {
    progress: Progress,
    control: Controller,
    norm: ErrorNorm,
    stages: Stages,
    /// State at the end of the step tried.
    next: Vec<f64>,
    /// What rounding took from the sum of all steps, and what it will have taken.
    lost: Vec<f64>,
    next_lost: Vec<f64>,
}

impl Gauss {
    /// Starts a run with the `step` of the options.
    ///
    /// # Errors
    /// Where there is no step, an option is out of its range, the start does not fit the system, or the system cannot be
    /// evaluated there.
    pub fn new<P: ImplicitProblem>(problem: &mut P, options: &Options, start: Start<'_>) -> Result<Self, StepError> {
        let options = Options { fixed: true, ..*options };
        if options.step.is_none() {
            options.validate()?;
            return Err(StepError::NoStep);
        }
        let (order, norm) = (2 * STAGES as u8, ErrorNorm::new(problem, UNIT, UNIT));
        let Begun { mut progress, norm, rate, step } = Begun::new(problem, &options, start, norm, order)?;
        progress.dense.with_terms(STAGES + 1);
        Ok(Self {
            control: Controller::new(&options, order, step, &progress, ADVICE),
            norm,
            stages: Stages::new(problem, Collocation::gauss(STAGES), SOLUTION, &rate),
            next: rate.clone(),
            lost: vec![0.0; rate.len()],
            next_lost: vec![0.0; rate.len()],
            progress,
        })
    }

    /// Solves the stages and sums them up.
    fn attempt<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial) -> Result<(), Limit> {
        let Progress { time, state, position_count, statistics, .. } = &mut self.progress;
        self.stages.solve(problem, &self.norm, (*time, state), trial.step, statistics)?;
        let Stages { method, rates, .. } = &self.stages;
        for i in 0..state.len() {
            let sum: f64 = method.weights.iter().zip(rates).map(|(weight, rate)| weight * rate[i]).sum();
            let change = trial.step * sum + self.lost[i];
            self.next[i] = state[i] + change;
            self.next_lost[i] = (state[i] - self.next[i]) + change;
        }
        require_finite(&self.next, *position_count)?;
        settle(problem, trial.time, &mut self.next, *position_count)?;
        Ok(())
    }
}

impl<P: ImplicitProblem> Stepper<P> for Gauss {
    fn step(&mut self, problem: &mut P) -> Result<(), StepError> {
        if self.progress.finished() {
            return Ok(());
        }
        let trial = self.control.propose(&self.progress, f64::INFINITY)?;
        while let Err(limit) = self.attempt(problem, trial) {
            // Old tangents are to blame first.
            let statistics = &self.progress.statistics;
            if !self.stages.discard_old(statistics) && !self.stages.take_care(statistics) {
                return self.control.fail(trial, limit, &self.progress);
            }
        }
        let Progress { state, position_count, dense, statistics, .. } = &mut self.progress;
        dense.nested(trial.step, [state, &self.next], &self.stages.method.nested, &self.stages.rates);
        dense.follow_velocities(problem, trial.step, [state, &self.next], *position_count);
        self.control.accept(trial, 0.0, statistics.steps == 0);
        self.stages.advance(trial.step, &self.progress.statistics);
        std::mem::swap(&mut self.lost, &mut self.next_lost);
        self.progress.advance(trial.time, &mut self.next);
        Ok(())
    }

    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn stages(&self) -> Option<StepStages<'_>> {
        Some(self.stages.of_step(self.progress.position_count))
    }
}
