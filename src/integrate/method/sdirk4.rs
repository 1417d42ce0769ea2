//! The singly diagonally implicit method of Hairer and Wanner: order 4, error estimate of order 3, five stages.
//!
//! ```text
//! X_i = x + h Σ_{j<i} a_ij k_j + h γ k_i,   k_i = (N(q_i) v_i, a_i),   γ = 1/4,   x' = X_5
//! ```
//!
//! Each stage is solved for its acceleration `a_i` alone (see `implicit/stage.rs`); all stages share one iteration matrix.
//!
//! **Stability**: L-stable (`R(∞) = 0`) and stiffly accurate (the last stage is the result), so motions much faster than
//! the step die out as they do in the system, and the step follows the slow ones. A fast motion that is *not* damped in
//! the system is damped by the method where the step does not resolve it.
//!
//! **Error**: `O(h⁵)` per step where the step resolves the system. The stages alone are only of order 1, which shows on
//! stiff parts driven by time-dependent loads: a strong damper of rate `λ` leaves an error of the size `h/λ` in its
//! velocity (small for the stiffest), a stiff spring whose rest position moves an error `O(h)` in the velocity along it.
//! The estimate sees this and shortens the step, so tight tolerances are expensive there.
//!
//! **Error estimate**: the plain difference `e = h Σ_i e_i k_i` to the embedded rule does not vanish for stiff parts and
//! would force them to be resolved. It is filtered by `(I − h γ J)⁻¹` (see `implicit/filter.rs`).
//!
//! **Between the ends**: a cubic in the stage rates, error `O(h⁴)` like that of the steps (no weights of order 4 exist).
//! Unlike a Hermite cubic it does not use the rate at the start, which is huge where a fast transient begins. Positions,
//! whose rates are velocities, have a Hermite cubic.
//!
//! **Quaternions** are stepped as numbers in R⁴ and normalised after the step. Within a step the stages are off unit
//! length by `O(h²)`.
//!
//! **Reference**: Hairer, Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., IV.6 (method), IV.8 (practice).

use crate::integrate::{
    implicit::filter::{End, filter},
    implicit::stage::{Newton, Stage},
    implicit::{ADVICE, HOLD_BELOW, Implicit},
    method::predict::Predictor,
    method::tableau::sdirk4::{A, B, C, CUBES, E, GAMMA, SQUARES},
    problem::{ImplicitProblem, Point},
    step::control::{Controller, Trial},
    step::error::{Limit, StepError},
    step::norm::{ErrorNorm, Measured},
    step::options::{Options, Start},
    step::progress::Progress,
    step::rates::{combine, require_finite, settle, weighted_sum},
    step::stages::StepStages,
    step::start::Begun,
};

/// Smallest share of the tolerance that a step is asked for (see `step/norm.rs`): its steps are better than their estimate, by an
/// order, and damp the fast ones.
const SMALLEST_SHARE: f64 = 0.1;
/// The error estimate is `O(h⁴)`.
const ESTIMATE_ORDER: u8 = 4;

/// The SDIRK method of Hairer and Wanner, order 4, L-stable, adaptive.
#[derive(Debug)]
pub struct Sdirk4 {
    progress: Progress,
    control: Controller,
    norm: ErrorNorm,
    newton: Newton,
    predictor: Predictor,
    /// `k₁ … k₅`, each `(N(q) v, a)`.
    rates: Vec<Vec<f64>>,
    /// `X₁ … X₅`.
    states: Vec<Vec<f64>>,
    /// The weights of the cubic beyond the line, as `StepStages` has them.
    nested: [Vec<f64>; 2],
    /// The known part of a stage.
    known: Vec<f64>,
    /// State of a stage, then of the end of the step tried.
    next: Vec<f64>,
    /// Acceleration of a stage, then of the end of the step tried.
    acceleration: Vec<f64>,
    error: Vec<f64>,
    /// Right side and solution of the filter, in velocity coordinates.
    filter: Vec<f64>,
}

impl Sdirk4 {
    /// Starts a run; the first step is the `step` of the options or chosen from the system.
    ///
    /// # Errors
    /// If an option is out of its range, the start does not fit the system, or the system cannot be evaluated there.
    pub fn new<P: ImplicitProblem>(problem: &mut P, options: &Options, start: Start<'_>) -> Result<Self, StepError> {
        let norm = ErrorNorm::shared(problem, options, &start, SMALLEST_SHARE);
        let Begun { progress, norm, rate, step } = Begun::new(problem, options, start, norm, ESTIMATE_ORDER)?;
        problem.reserve();
        let acceleration = rate[progress.position_count..].to_vec();
        Ok(Self {
            control: Controller::new(options, ESTIMATE_ORDER, step, &progress, ADVICE).holding_below(HOLD_BELOW),
            newton: Newton::new(problem, options.fixed, &rate),
            predictor: Predictor::new(&acceleration),
            known: rate.clone(),
            next: rate.clone(),
            error: rate.clone(),
            filter: acceleration.clone(),
            states: vec![rate.clone(); C.len()],
            nested: nested(),
            rates: vec![rate; C.len()],
            acceleration,
            norm,
            progress,
        })
    }

    /// The norm of the filtered error estimate of the step just tried.
    fn estimate<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial) -> Result<Measured, Limit> {
        let Progress { state, statistics, .. } = &mut self.progress;
        let gamma_step = GAMMA * trial.step;
        weighted_sum(&mut self.error, trial.step, &E, &self.rates);
        let end = End { time: trial.time, step: gamma_step, state: &self.next };
        // The known part and the last acceleration are free now.
        let scratch = (&mut self.known[..], &mut self.acceleration[..]);
        filter(problem, end, &mut self.error, scratch, &mut self.filter, statistics)?;
        Ok(self.norm.measure(&self.error, state, &self.next))
    }
}

impl Implicit for Sdirk4 {
    fn reached(&self) -> &Progress {
        &self.progress
    }

    fn parts(&mut self) -> (&mut Progress, &mut Controller) {
        (&mut self.progress, &mut self.control)
    }

    fn attempt<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial) -> Result<Measured, Limit> {
        self.norm.allow(trial.step);
        let Progress { time, state, position_count, statistics, .. } = &mut self.progress;
        let (q, v) = state.split_at(*position_count);
        let point = Point { time: *time, q, v, a: self.predictor.start() };
        let gamma_step = GAMMA * trial.step;
        self.newton.prepare(problem, point, gamma_step, statistics)?;
        for stage in 0..C.len() {
            combine(&mut self.known, state, trial.step, A[stage], &self.rates);
            self.predictor.predict(stage, trial.step, &mut self.acceleration);
            let at = Stage { time: *time + C[stage] * trial.step, step: gamma_step, known: &self.known, start: state };
            self.newton.solve(problem, &self.norm, at, &mut self.next, &mut self.acceleration, statistics)?;
            self.predictor.record(stage, &self.acceleration);
            self.states[stage].copy_from_slice(&self.next);
            let (q, v) = self.next.split_at(*position_count);
            let (position_rate, acceleration) = self.rates[stage].split_at_mut(*position_count);
            problem.position_rate(q, v, position_rate);
            acceleration.copy_from_slice(&self.acceleration);
        }
        require_finite(&self.next, *position_count)?;
        if self.control.is_fixed() {
            return Ok(Measured { value: 0.0, worst: 0 });
        }
        self.estimate(problem, trial)
    }

    fn accept<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial, error: f64) -> Result<(), Limit> {
        let Progress { state, position_count, dense, statistics, .. } = &mut self.progress;
        settle(problem, trial.time, &mut self.next, *position_count)?;
        dense.cubic(trial.step, [state, &self.next], &SQUARES, &CUBES, &self.rates);
        dense.follow_velocities(problem, trial.step, [state, &self.next], *position_count);
        self.control.accept(trial, error, statistics.steps == 0);
        statistics.error_sum += error * self.norm.tolerance();
        self.predictor.advance(trial.step);
        self.newton.advance(trial.step, statistics);
        self.progress.advance(trial.time, &mut self.next);
        Ok(())
    }

    fn discard_old(&mut self) -> bool {
        self.newton.discard_old(&self.progress.statistics)
    }

    fn step_stages(&self) -> Option<StepStages<'_>> {
        let (states, nested, position_count) = (&self.states[..], &self.nested[..], self.progress.position_count);
        Some(StepStages { nodes: &C, states, weights: &B, nested, position_count })
    }
}

/// `r₂` and `r₃` of the cubic, whose `θ²` and `θ³` come of `θ (1 − θ) (r₂ + θ r₃)`.
fn nested() -> [Vec<f64>; 2] {
    [(0..C.len()).map(|i| -SQUARES[i] - CUBES[i]).collect(), CUBES.iter().map(|cube| -cube).collect()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_step_is_integrated_with_the_weights_of_the_cubic() {
        let nested = nested();
        let stages = StepStages { nodes: &C, states: &[], weights: &B, nested: &nested, position_count: 0 };
        for theta in [0.0_f64, 0.3, 0.8, 1.0] {
            for degree in 0..3 {
                let sum: f64 = (0..C.len()).map(|i| stages.weight(i, theta) * C[i].powi(degree)).sum();
                let exact = theta.powi(degree + 1) / f64::from(degree + 1);
                // Sums of five terms up to 20.
                assert!((sum - exact).abs() < 1e-13, "degree {degree} up to {theta}: {sum} for {exact}");
            }
            let cubic = |i: usize| theta * theta * (SQUARES[i] + theta * CUBES[i]);
            let linear = |i: usize| theta * (B[i] - SQUARES[i] - CUBES[i]);
            assert!((0..C.len()).all(|i| (stages.weight(i, theta) - linear(i) - cubic(i)).abs() < 1e-13));
        }
        let at_end: f64 = (0..C.len()).map(|i| stages.weight(i, 1.0) * C[i].powi(3)).sum();
        assert!((at_end - 0.25).abs() < 1e-14, "order 4 at the end: {at_end}");
    }
}
