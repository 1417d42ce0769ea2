//! The methods of Adams with order and step chosen as the run goes: one evaluation per step, orders 1 to 12.
//!
//! With `f_n` the rate found at the time `t_n`, `h = t_{n+1} − t_n` and the scaled differences of the rates
//!
//! ```text
//! Φ_0(n) = f_n,   Φ_{j+1}(n) = Φ_j(n) − β_j(n − 1) Φ_j(n − 1),   β_j(n) = Π_{i<j} (t_{n+1} − t_{n−i}) / (t_n − t_{n−i−1})
//! ```
//!
//! a step of order `k` predicts with the polynomial through the last `k` rates, evaluates there, and corrects with the
//! polynomial that has this rate too:
//!
//! ```text
//! (1)  p  = x + h Σ_{j<k} g_j β_j Φ_j(n)
//! (2)  f' = f(t + h, p),   x' = p + h g_k Φ_k(n + 1)
//! ```
//!
//! The weights `g_j` are integrals of the polynomials (`differences.rs`). The rate is not taken again at `x'`: it would
//! double the work, and what it gains on smooth motions is a fraction of that. Only where a projection moves the state is
//! it taken there.
//!
//! **Error**: (2) less the same rule of one order less, `h (g_k − g_{k−1}) Φ_k(n + 1)`.
//!
//! **Order**: what the orders `k − 2` to `k + 1` would have left, `h γ*_j Φ_j(n + 1)` with the weights `γ*` of equal
//! steps, is compared after each step. The order falls where a lower one would not have been worse, and rises where a
//! higher one would have been better and the last `k + 1` steps were equal. A run starts with order 1 and a short step,
//! and raises the one and doubles the other in each step until that no longer helps.
//!
//! **Work**: one evaluation per step, rejected or not, and per component of the state some four times the order in
//! multiplications. Every event starts the run anew with some twenty short steps.
//!
//! **Stability**: poor at high orders, so a system that turns stiff drives the order down. Low orders for many steps on
//! end count as held by stability. A step that could be much longer by its error is held by nothing: a body that falls freely
//! needs no order above the second, however long its steps.
//!
//! **Between the ends**: the polynomial of (2), as exact as the ends.
//!
//! **Quaternions** are stepped as numbers in R⁴ and normalised after the step.
//!
//! **Reference**: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., III.5 (variable steps),
//! III.7 (order and step); L.F. Shampine, M.K. Gordon, *Computer Solution of Ordinary Differential Equations* (1975).

use crate::integrate::{
    method::differences::{Differences, MOST_TERMS, Weights},
    method::explicit::ADVICE,
    problem::Problem,
    step::control::{Controller, Trial},
    step::error::{Component, Limit, StepError},
    step::norm::ErrorNorm,
    step::options::{Options, Start},
    step::progress::Progress,
    step::rates::{require_finite, state_rate},
    step::start::Begun,
    step::stepper::Stepper,
};

/// Highest order: above it rounding of the differences and poor stability cost more than is gained.
const MOST: usize = MOST_TERMS - 2;
/// Smallest share of the tolerance that a step is asked for (see `step/norm.rs`): its steps are many and short, and their
/// errors of one sign.
const SMALLEST_SHARE: f64 = 1e-3;
/// Steps aim at this part of what they may leave.
const AIM: f64 = 0.2;
/// A step that would grow by less is kept: equal steps are what orders rise on.
const HOLD_BELOW: f64 = 1.1;
/// What a step may grow and shrink by. Differences of steps that grow fast say little.
const LARGEST_FACTOR: f64 = 1.2;
const FACTORS: [f64; 2] = [0.5, 0.9];
const REJECTED_FACTORS: [f64; 2] = [0.2, 0.7];
/// From this many attempts in a row that fail the history is not trusted: order 1.
const FAILURES: u32 = 3;
/// Orders up to the first for so many steps on end mean stability, not accuracy; where a step may leave less than [`TIGHT`],
/// accuracy asks for higher ones than the second.
const LOW: [usize; 2] = [3, 6];
const LOW_STEPS: u32 = 40;
const TIGHT: f64 = 1e-9;
/// A step that its error would let grow by this is not held: what stability holds is at its limit, and after a rejection, which halves
/// it, next to it again.
const UNHELD: f64 = 4.0;

/// Adams methods of variable order and step.
#[derive(Debug)]
pub struct Adams {
    progress: Progress,
    control: Controller,
    norm: ErrorNorm,
    /// Of the rates up to the state reached, and with the one of the step tried.
    past: Differences,
    tried: Differences,
    /// `γ*_j`.
    equal: [f64; MOST_TERMS],
    /// Order of the next step, and of the one made last.
    order: usize,
    last_order: usize,
    /// Orders and steps still grow from nothing.
    starting: bool,
    /// Steps of one length so far.
    constant: usize,
    failures: u32,
    /// Steps of low order on end.
    low: u32,
    /// `p`, `f'`, and the state at the end of the step tried.
    predicted: Vec<f64>,
    rate: Vec<f64>,
    next: Vec<f64>,
    /// The state at the start of the last step, and how far the polynomial misses it once that is known.
    previous: Vec<f64>,
    miss: Vec<f64>,
    miss_is_known: bool,
    /// A state inside the last step.
    between: Vec<f64>,
    /// Of the norm, inverse, for the step tried.
    weights: Vec<f64>,
}

/// Norms of what the step tried left, in what it may leave.
#[derive(Debug, Clone, Copy)]
struct Left {
    /// By the difference of two correctors.
    error: f64,
    /// By the weights of equal steps, of the orders `k − 2 … k + 1`; infinite where that cannot be told.
    orders: [f64; 4],
}

impl Adams {
    /// Starts a run; the first step is the `step` of the options or chosen from the system.
    ///
    /// # Errors
    /// If an option is out of its range, the start does not fit the system, or the system cannot be evaluated there.
    pub fn new<P: Problem>(problem: &mut P, options: &Options, start: Start<'_>) -> Result<Self, StepError> {
        let norm = ErrorNorm::shared(problem, options, &start, SMALLEST_SHARE);
        let Begun { progress, norm, rate, step } = Begun::new(problem, options, start, norm, 2)?;
        let past = Differences::new(progress.time, &rate);
        Ok(Self {
            control: Controller::new(options, 2, step, &progress, ADVICE),
            tried: past.clone(),
            past,
            equal: equal_steps(),
            order: 1,
            last_order: 1,
            starting: true,
            constant: 0,
            failures: 0,
            low: 0,
            predicted: progress.state.clone(),
            next: progress.state.clone(),
            previous: progress.state.clone(),
            miss: rate.clone(),
            miss_is_known: false,
            between: rate.clone(),
            weights: rate.clone(),
            rate,
            norm,
            progress,
        })
    }

    /// (1) and (2).
    fn attempt<P: Problem>(&mut self, problem: &mut P, trial: Trial) -> Result<Left, Limit> {
        let Progress { state, position_count, statistics, .. } = &mut self.progress;
        let (k, h) = (self.order, trial.step);
        let Weights { integrals, ratios } = self.past.weights(h, k + 1);
        self.past.sum(state, h, &integrals[..k], &mut self.predicted);
        state_rate(problem, trial.time, &self.predicted, &mut self.rate, statistics)?;
        self.tried.advance(&self.past, trial.time, &self.rate, &ratios[..=k]);
        let [last, before] = [k, k - 1].map(|j| h * integrals[j] / ratios[j]);
        self.tried.add(&self.predicted, last, k, &mut self.next);
        problem.normalize(&mut self.next[..*position_count]);
        require_finite(&self.next, *position_count)?;
        Ok(self.left(h, last - before))
    }

    /// What the step tried left.
    fn left(&mut self, h: f64, difference: f64) -> Left {
        let k = self.order;
        self.norm.inverse_weights(&self.progress.state, &self.next, &mut self.weights);
        let largest = |j: usize| h * self.tried.largest(j, &self.weights);
        let of_order = |j: usize, size: f64| self.equal[j] * size;
        let of = |j: usize| of_order(j, largest(j));
        let same = largest(k);
        let lowest = if k > 2 { of(k - 2) } else { f64::INFINITY };
        let lower = if k > 1 { of(k - 1) } else { f64::INFINITY };
        let higher = if k < MOST && self.constant >= k { of(k + 1) } else { f64::INFINITY };
        Left { error: difference.abs() / h * same, orders: [lowest, lower, of_order(k, same), higher] }
    }

    /// The component that decides the error of a step of that order.
    fn worst(&self, differences: &Differences, order: usize) -> Component {
        let size = |i: &usize| (differences.of(*i, order) * self.weights[*i]).abs();
        let worst = (0..self.weights.len()).max_by(|i, j| size(i).total_cmp(&size(j)));
        self.progress.component(worst.unwrap_or(0))
    }

    /// Projects the end of the step; where that moves it, its rate is taken there.
    fn project<P: Problem>(&mut self, problem: &mut P, trial: Trial) -> Result<(), Limit> {
        let Progress { position_count, statistics, .. } = &mut self.progress;
        let (q, v) = self.next.split_at_mut(*position_count);
        if problem.project(trial.time, q, v).map_err(Limit::Failure)? {
            state_rate(problem, trial.time, &self.next, &mut self.rate, statistics)?;
            let ratios = self.past.weights(trial.step, self.order + 1).ratios;
            self.tried.advance(&self.past, trial.time, &self.rate, &ratios[..=self.order]);
        }
        Ok(())
    }

    fn accept(&mut self, trial: Trial, left: Left) {
        let same = (trial.step / self.progress.last_step() - 1.0).abs() < 1e-9;
        self.constant = if same { self.constant + 1 } else { 1 };
        self.last_order = self.order;
        self.progress.statistics.error_sum += left.error * self.norm.tolerance();
        std::mem::swap(&mut self.past, &mut self.tried);
        let wanted = self.choose(left);
        self.control.follow(trial, if self.starting { 2.0 } else { bounded(wanted) });
        let low = LOW[usize::from(self.norm.tolerance() < TIGHT)];
        self.low = match self.order <= low && !self.starting {
            true => self.low + u32::from(wanted < UNHELD),
            false => 0,
        };
        self.failures = 0;
        self.miss_is_known = false;
        self.previous.copy_from_slice(&self.progress.state);
        self.progress.advance(trial.time, &mut self.next);
    }

    /// Chooses the order of the next step; gives the factor for its length that its error would allow.
    fn choose(&mut self, left: Left) -> f64 {
        let (k, [_, lower, same, higher]) = (self.order, left.orders);
        let falls = falls(k, left.orders);
        self.starting &= !falls && k < MOST;
        if self.starting {
            self.order = k + 1;
            return f64::INFINITY;
        }
        let expected = if falls || (higher.is_finite() && k > 1 && lower <= same.min(higher)) {
            self.order = k - 1;
            lower
        } else if higher < if k > 1 { same } else { 0.5 * same } {
            self.order = k + 1;
            higher
        } else {
            same
        };
        (AIM / expected.max(f64::MIN_POSITIVE)).powf(1.0 / (self.order + 1) as f64)
    }

    /// A step that left too much: a shorter one, and a lower order where that is no worse.
    fn reject(&mut self, trial: Trial, left: Left) {
        let [shortest, longest] = REJECTED_FACTORS;
        let factor = (AIM / left.error).powf(1.0 / (self.order + 1) as f64).clamp(shortest, longest);
        if falls(self.order, left.orders) {
            self.order -= 1;
        }
        let limit = match self.stability_is_poor() {
            true => Limit::Stability,
            false => Limit::ErrorEstimate(self.worst(&self.tried, self.order)),
        };
        self.control.retry(trial, factor, limit);
    }

    /// Lowers trust in the order after a rejected step.
    fn distrust(&mut self) {
        self.progress.statistics.rejected_steps += 1;
        self.starting = false;
        self.failures += 1;
        if self.failures >= FAILURES {
            self.order = 1;
        }
    }

    fn stability_is_poor(&self) -> bool {
        self.low >= LOW_STEPS
    }

    /// The polynomial of the last step at `time`, from the end of the step.
    fn back(&self, time: f64, state: &mut [f64]) {
        let h = time - self.progress.time;
        let count = self.last_order + 1;
        let weights = self.past.weights(h, count).integrals;
        self.past.sum(&self.progress.state, h, &weights[..count], state);
    }
}

/// The factor for the length of the next step, from the one that its error would allow.
fn bounded(wanted: f64) -> f64 {
    if wanted >= HOLD_BELOW {
        (FACTORS[1] * wanted).clamp(1.0, LARGEST_FACTOR)
    } else if wanted < 1.0 {
        wanted.clamp(FACTORS[0], FACTORS[1])
    } else {
        1.0
    }
}

/// Whether a lower order than `k` would have left no more.
fn falls(k: usize, [lowest, lower, same, _]: [f64; 4]) -> bool {
    match k {
        1 => false,
        2 => lower <= 0.5 * same,
        _ => lower.max(lowest) <= same,
    }
}

/// `γ*_j`: `Σ_{m≤j} γ*_m / (j + 1 − m) = 0` for `j ≥ 1`, `γ*_0 = 1`.
fn equal_steps() -> [f64; MOST_TERMS] {
    let mut weights = [1.0; MOST_TERMS];
    for j in 1..MOST_TERMS {
        weights[j] = -(0..j).map(|m| weights[m] / (j + 1 - m) as f64).sum::<f64>();
    }
    weights.map(f64::abs)
}

impl<P: Problem> Stepper<P> for Adams {
    fn step(&mut self, problem: &mut P) -> Result<(), StepError> {
        while !self.progress.finished() {
            let trial = self
                .control
                .propose(&self.progress, problem.longest_step(self.progress.position(), self.progress.velocity()))?;
            self.norm.allow(trial.step);
            match self.attempt(problem, trial) {
                Ok(left) if left.error <= 1.0 || self.control.is_fixed() => match self.project(problem, trial) {
                    Ok(()) => {
                        self.accept(trial, left);
                        return Ok(());
                    }
                    Err(limit) => self.control.fail(trial, limit, &self.progress)?,
                },
                Ok(left) => self.reject(trial, left),
                Err(limit) => self.control.fail(trial, limit, &self.progress)?,
            }
            self.distrust();
        }
        Ok(())
    }

    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn limiting(&self) -> Component {
        self.worst(&self.past, self.last_order)
    }

    fn interpolate(&mut self, problem: &mut P, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<(), StepError> {
        let Progress { time: end, previous_time: start, position_count, .. } = self.progress;
        if time >= end || end <= start {
            self.progress.interpolate(problem, time, q, v);
            return Ok(());
        }
        if time <= start {
            q.copy_from_slice(&self.previous[..position_count]);
            v.copy_from_slice(&self.previous[position_count..]);
            return Ok(());
        }
        if !std::mem::replace(&mut self.miss_is_known, true) {
            // What normalising and projecting moved the end by; it is spread over the step.
            let mut miss = std::mem::take(&mut self.miss);
            self.back(start, &mut miss);
            miss.iter_mut().zip(&self.previous).for_each(|(miss, at)| *miss = at - *miss);
            self.miss = miss;
        }
        let mut state = std::mem::take(&mut self.between);
        self.back(time, &mut state);
        let part = (end - time) / (end - start);
        state.iter_mut().zip(&self.miss).for_each(|(value, miss)| *value += part * miss);
        q.copy_from_slice(&state[..position_count]);
        v.copy_from_slice(&state[position_count..]);
        self.between = state;
        problem.normalize(q);
        Ok(())
    }

    fn stability_limited(&self) -> bool {
        self.stability_is_poor()
    }
}
