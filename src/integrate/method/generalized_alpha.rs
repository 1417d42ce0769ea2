//! The generalized-α method on the hinges' manifold: order 2, adaptive, with numerical damping chosen by the user.
//!
//! ```text
//! (1)  q' = q ⊞ (h v + h² ((½ − β) a + β a')),   v' = v + h ((1 − γ) a + γ a'),   r(t', q', v', v̇') = 0
//! (2)  (1 − α_m) a' + α_m a = (1 − α_f) v̇' + α_f v̇
//!
//!      α_m = (2ρ − 1)/(ρ + 1),   α_f = ρ/(ρ + 1),   γ = ½ + α_f − α_m,   β = ¼ (½ + γ)²
//! ```
//!
//! `⊞` adds plain coordinates and turns quaternions by a rotation vector in body axes, so they stay of unit length by
//! themselves. `a` follows the acceleration `v̇` with a delay and is part of the state.
//!
//! **Damping**: of motions far faster than the step a step leaves the part `ρ∞` (1: all, as the trapezoidal rule; 0:
//! none), of motions that the step resolves nearly all. Order 2 whatever `ρ∞`.
//!
//! **Newton**: the unknown is `v̇'`. With `x` the correction of the position in velocity coordinates,
//! `δv̇' = c₂ x`, `δv' = c₁ x` with `c₁ = γ/(β h)`, `c₂ = (1 − α_m)/((1 − α_f) β h²)`: one sweep of the tangent. Newton stops by the
//! rule of `implicit/contraction.rs`, at a fixed part of the tolerance.
//!
//! **Change of step**: `a − v̇` is a delay proportional to the step and is scaled with it, else a change of step would cost
//! the order.
//!
//! **Error estimate**: the differences to one and two integrals of the parabola through the last three accelerations,
//!
//! ```text
//! (3)  e_v = v' − v − ∫p,   e_q = h² ((½ − β) a + β a') − ∬p         O(h³)
//! ```
//!
//! with what the method would not resolve filtered out, `K w = c₂ M e`: the tangent of the step again, one solve each.
//! A step is asked for its share `h/T` of the tolerance (`step/norm.rs`): the many steps of a method of low order add up, and with a smallest
//! share that is always the same a run at a tenth of the tolerance would only be a fifth as wrong. The smallest share is
//!
//! ```text
//! (4)  0.003 √tolerance
//! ```
//!
//! and no more, so that ordinary motion does not meet it: it has steps of `h/T = O(√tolerance)`. A pulse of width `w` does, whose share `w/T`
//! asked for steps that are the shorter a part of it the shorter it is, `h/w = O(√(tolerance w/T))`. With (4) they are `O(√tolerance)` of
//! it, as many for any width, and errors add up to a part of the tolerance that is the same whatever this is. Equal errors per step, not per
//! time, are the least work.
//!
//! **Between the ends**: the Hermite cubic.
//!
//! **Reference**: J. Chung, G.M. Hulbert, J. Appl. Mech. 60 (1993); O. Brüls, M. Arnold, *The generalized-α scheme as a
//! linear multistep integrator*, J. Comput. Nonlinear Dyn. 3 (2008) for steps that change; O. Brüls, A. Cardona,
//! M. Arnold, Mech. Mach. Theory 48 (2012) for the manifold.

use crate::integrate::{
    implicit::care::Care,
    implicit::contraction::{Accuracy, Iteration},
    implicit::stage::correct,
    implicit::tangent::{Shift, TangentCache},
    implicit::{ADVICE, HOLD_BELOW, Implicit},
    problem::{ImplicitProblem, Point},
    step::control::{Controller, Trial},
    step::error::{Limit, StepError},
    step::norm::{ErrorNorm, Measured},
    step::options::{Options, Start},
    step::progress::Progress,
    step::rates::{require_finite, settle, state_rate},
    step::start::Begun,
};

/// The error estimate is `O(h³)`, in shares of the tolerance it is `O(h²)`.
const ESTIMATE_ORDER: u8 = 2;
/// Newton may leave this part of the tolerance; at tolerances close to rounding it may stall earlier.
const ACCURACY: Accuracy = Accuracy { left: 0.01, stalled: 0.1, least_contraction: 0.0 };
/// The factor of (4).
const SMALLEST_SHARE: f64 = 0.003;
const MAX_ITERATIONS: u32 = 10;

/// Generalized-α on the manifold, order 2, adaptive.
#[derive(Debug)]
pub struct GeneralizedAlpha {
    progress: Progress,
    control: Controller,
    norm: ErrorNorm,
    weights: Weights,
    /// `(N(q) v, v̇)` at the start of the step and at its end.
    rate: Vec<f64>,
    next_rate: Vec<f64>,
    /// `a` and `a'`.
    delayed: Vec<f64>,
    next_delayed: Vec<f64>,
    /// `v̇` one step before the start.
    before: Vec<f64>,
    /// The step that led to the start; `None` at the first.
    last_step: Option<f64>,
    next: Vec<f64>,
    /// The change of the position in this step, in velocity coordinates.
    change: Vec<f64>,
    /// Residual, then correction, in velocity coordinates; and as a change of the state.
    correction: Vec<f64>,
    displacement: Vec<f64>,
    /// Accelerations with an error added, for the filter.
    displaced: Vec<f64>,
    tangent: TangentCache,
    care: Care,
}

/// α_m, α_f, β, γ.
#[derive(Debug, Clone, Copy)]
struct Weights {
    mean: f64,
    force: f64,
    beta: f64,
    gamma: f64,
}

impl Weights {
    fn new(rho: f64) -> Self {
        let (mean, force) = ((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0));
        let gamma = 0.5 + force - mean;
        Self { mean, force, beta: 0.25 * (0.5 + gamma).powi(2), gamma }
    }

    /// `(c₁, c₂)`.
    fn shifts(&self, step: f64) -> (f64, f64) {
        let c2 = (1.0 - self.mean) / ((1.0 - self.force) * self.beta * step * step);
        (self.gamma / (self.beta * step), c2)
    }
}

impl GeneralizedAlpha {
    /// Starts a run; the first step is the `step` of the options or chosen from the system.
    ///
    /// # Errors
    /// If an option is out of its range, the start does not fit the system, or the system cannot be evaluated there.
    pub fn new<P: ImplicitProblem>(problem: &mut P, options: &Options, start: Start<'_>) -> Result<Self, StepError> {
        let smallest = SMALLEST_SHARE * options.relative.max(options.absolute).sqrt();
        let norm = ErrorNorm::shared(problem, options, &start, smallest).without_floor();
        let Begun { progress, norm, rate, step } = Begun::new(problem, options, start, norm, ESTIMATE_ORDER)?;
        problem.reserve();
        let acceleration = rate[progress.position_count..].to_vec();
        Ok(Self {
            control: Controller::new(options, ESTIMATE_ORDER, step, &progress, ADVICE).holding_below(HOLD_BELOW),
            weights: Weights::new(options.rho_infinity),
            next_rate: rate.clone(),
            delayed: acceleration.clone(),
            next_delayed: acceleration.clone(),
            before: acceleration.clone(),
            last_step: None,
            next: rate.clone(),
            change: acceleration.clone(),
            correction: acceleration.clone(),
            displacement: rate.clone(),
            displaced: acceleration,
            tangent: TangentCache::default(),
            care: Care::of(problem),
            rate,
            norm,
            progress,
        })
    }

    fn iterate<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial) -> Result<(), Limit> {
        let position_count = self.progress.position_count;
        let shift = self.tangent.shift()?;
        let Shift { c1, c2, .. } = shift;
        let mut iteration = Iteration::new(ACCURACY, MAX_ITERATIONS);
        loop {
            let Progress { state, statistics, .. } = &mut self.progress;
            if self.care.is_taken() {
                let (q, v) = self.next.split_at(position_count);
                let at = Point { time: trial.time, q, v, a: &self.next_rate[position_count..] };
                self.tangent.renew(problem, at, shift, statistics)?;
            }
            let acceleration = &mut self.next_rate[position_count..];
            correct(problem, trial.time, &self.next, acceleration, &mut self.correction, statistics)?;
            statistics.newton_iterations += 1;
            let (of_position, of_velocity) = self.displacement.split_at_mut(position_count);
            problem.position_rate(&self.next[..position_count], &self.correction, of_position);
            of_velocity.iter_mut().zip(&self.correction).for_each(|(by, x)| *by = c1 * x);
            acceleration.iter_mut().zip(&self.correction).for_each(|(a, x)| *a -= c2 * x);
            let size = self.norm.measure(&self.displacement, state, &self.next).value;
            let rounding = self.norm.rounding(&self.next);
            self.place(problem, trial.step);
            let done = iteration.converged(size, rounding);
            if let Some(contraction) = iteration.contraction().filter(|_| size > rounding) {
                self.tangent.see(contraction);
            }
            if done? {
                return Ok(());
            }
        }
    }

    /// `a'` by (2) from the present `v̇'`, then `(q', v')` by (1).
    fn place<P: ImplicitProblem>(&mut self, problem: &P, step: f64) {
        let Weights { mean, force, beta, gamma } = self.weights;
        let Progress { state, position_count, .. } = &self.progress;
        // The delay of `a` is that of the step before.
        let delay = self.last_step.map_or(1.0, |last| step / last);
        let (q, v) = state.split_at(*position_count);
        let (next_q, next_v) = self.next.split_at_mut(*position_count);
        for i in 0..v.len() {
            let (now, then) = (self.rate[position_count + i], self.next_rate[position_count + i]);
            let delayed = now + delay * (self.delayed[i] - now);
            let next = ((1.0 - force) * then + force * now - mean * delayed) / (1.0 - mean);
            self.next_delayed[i] = next;
            self.change[i] = step * v[i] + step * step * ((0.5 - beta) * delayed + beta * next);
            next_v[i] = v[i] + step * ((1.0 - gamma) * delayed + gamma * next);
        }
        problem.displace(q, &self.change, next_q);
    }

    /// The norm of (3), filtered.
    fn estimate<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial) -> Result<Measured, Limit> {
        let Progress { state, position_count, statistics, .. } = &mut self.progress;
        let (_, c2) = self.weights.shifts(trial.step);
        let Weights { beta, gamma, .. } = self.weights;
        let h = trial.step;
        let delay = self.last_step.map_or(1.0, |last| h / last);
        let (of_position, of_velocity) = self.displacement.split_at_mut(*position_count);
        for pass in [Pass::Velocity, Pass::Position] {
            let acceleration = &self.next_rate[*position_count..];
            for i in 0..self.displaced.len() {
                let (now, then) = (self.rate[*position_count + i], acceleration[i]);
                let (delayed, next) = (now + delay * (self.delayed[i] - now), self.next_delayed[i]);
                // p = now + s (then − now) + curve s (s − 1), s = 0…1 over the step; the part of the curve is 1/6 for
                // one integral and 1/12 for two.
                let curve = match self.last_step {
                    Some(last) => (then - now - (now - self.before[i]) * h / last) / (1.0 + last / h),
                    None => then - now,
                };
                let error = match pass {
                    Pass::Velocity => h * ((1.0 - gamma) * delayed + gamma * next - 0.5 * (now + then) + curve / 6.0),
                    Pass::Position => {
                        h * h * ((0.5 - beta) * delayed + beta * next - now / 3.0 - then / 6.0 + curve / 12.0)
                    }
                };
                self.displaced[i] = then + c2 * error;
            }
            correct(problem, trial.time, &self.next, &self.displaced, &mut self.correction, statistics)?;
            match pass {
                Pass::Velocity => of_velocity.copy_from_slice(&self.correction),
                Pass::Position => problem.position_rate(&self.next[..*position_count], &self.correction, of_position),
            }
        }
        Ok(self.norm.measure(&self.displacement, state, &self.next))
    }
}

/// Which of the two errors is filtered.
#[derive(Debug, Clone, Copy)]
enum Pass {
    Velocity,
    Position,
}

impl Implicit for GeneralizedAlpha {
    fn reached(&self) -> &Progress {
        &self.progress
    }

    fn parts(&mut self) -> (&mut Progress, &mut Controller) {
        (&mut self.progress, &mut self.control)
    }

    fn attempt<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial) -> Result<Measured, Limit> {
        self.norm.allow(trial.step);
        let position_count = self.progress.position_count;
        let (c1, c2) = self.weights.shifts(trial.step);
        // First guess: the acceleration stays.
        self.next_rate[position_count..].copy_from_slice(&self.rate[position_count..]);
        self.place(problem, trial.step);
        if !self.tangent.serves(trial.step) {
            let (q, v) = self.next.split_at(position_count);
            let at = Point { time: trial.time, q, v, a: &self.next_rate[position_count..] };
            let shift = Shift { step: trial.step, c1, c2 };
            self.tangent.renew(problem, at, shift, &mut self.progress.statistics)?;
        }
        self.iterate(problem, trial)?;
        let (q, v) = self.next.split_at(position_count);
        problem.position_rate(q, v, &mut self.next_rate[..position_count]);
        require_finite(&self.next, position_count)?;
        if self.control.is_fixed() {
            return Ok(Measured { value: 0.0, worst: 0 });
        }
        self.estimate(problem, trial)
    }

    fn accept<P: ImplicitProblem>(&mut self, problem: &mut P, trial: Trial, error: f64) -> Result<(), Limit> {
        let Progress { state, position_count, dense, statistics, .. } = &mut self.progress;
        if settle(problem, trial.time, &mut self.next, *position_count)? {
            state_rate(problem, trial.time, &self.next, &mut self.next_rate, statistics)?;
        }
        dense.hermite(trial.step, [state, &self.next], [&self.rate, &self.next_rate]);
        self.control.accept(trial, error, statistics.steps == 0);
        statistics.error_sum += error * self.norm.tolerance();
        self.before.copy_from_slice(&self.rate[*position_count..]);
        self.last_step = Some(trial.step);
        std::mem::swap(&mut self.rate, &mut self.next_rate);
        std::mem::swap(&mut self.delayed, &mut self.next_delayed);
        self.tangent.advance();
        self.care.advance(trial.step, &self.progress.statistics);
        self.progress.advance(trial.time, &mut self.next);
        Ok(())
    }

    fn discard_old(&mut self) -> bool {
        self.tangent.discard_old() || self.care.take_if_asked(&self.progress.statistics)
    }
}
