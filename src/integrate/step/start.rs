//! How a run starts, and the first step of an adaptive method.
//!
//! ```text
//! d₀ = ‖x₀‖, d₁ = ‖ẋ₀‖, h₀ = 0.01 d₀/d₁;  an Euler step of h₀ gives d₂ = ‖ẋ(h₀) − ẋ₀‖ / h₀
//! h  = T (0.01 / max(T d₁, T² d₂))^(1/k),   h ≤ 100 h₀,   h ≤ T/100
//! ```
//!
//! in the error norm of a step of `T/100`, for an estimate of order `k`: Hairer, Nørsett, Wanner, *Solving ODEs I*, II.4, with the system's
//! own time scale `T` in place of the second. A system at rest, or released where derivatives vanish by symmetry,
//! makes `d₁` and `d₂` small or zero and the rule boundless; `T/100` is the bound it lacks. The first step is then
//! judged by its own error estimate as every other.

use crate::integrate::{
    problem::Problem,
    step::error::StepError,
    step::norm::ErrorNorm,
    step::options::{Options, Start},
    step::progress::Progress,
    step::rates::state_rate,
};

/// Largest first step and step for looking ahead, as a fraction of the time scale.
const TIME_FRACTION: f64 = 0.01;
/// Step for looking ahead where the state or its rate is negligible, as a fraction of the time scale.
const BLIND_FRACTION: f64 = 1e-6;
/// Norms below this, in tolerances, are negligible.
const NEGLIGIBLE: f64 = 1e-5;

/// A run before its first step.
pub(crate) struct Begun {
    pub(crate) progress: Progress,
    pub(crate) norm: ErrorNorm,
    /// `(N(q) v, a)` at the start.
    pub(crate) rate: Vec<f64>,
    /// The `step` of the options, or one chosen from the system (s).
    pub(crate) step: f64,
}

impl Begun {
    /// A run whose error estimate has order `order`.
    ///
    /// # Errors
    /// If an option is out of its range, the start does not fit the system, or the system cannot be evaluated there.
    pub(crate) fn new<P: Problem>(
        problem: &mut P,
        options: &Options,
        start: Start<'_>,
        mut norm: ErrorNorm,
        order: u8,
    ) -> Result<Self, StepError> {
        options.validate()?;
        let mut progress = Progress::new(problem, start)?;
        let mut rate = vec![0.0; progress.state.len()];
        state_rate(problem, progress.time, &progress.state, &mut rate, &mut progress.statistics)
            .map_err(|limit| progress.cannot_start(limit))?;
        let step = match options.step {
            Some(step) => step,
            None => first_step(problem, &mut norm, &mut progress, &rate, order),
        };
        Ok(Self { progress, norm, rate, step })
    }
}

/// A first step for an error estimate of order `order`, in s, from the state of `progress` and its `rate`.
fn first_step<P: Problem>(
    problem: &mut P,
    norm: &mut ErrorNorm,
    progress: &mut Progress,
    rate: &[f64],
    order: u8,
) -> f64 {
    let state = &progress.state;
    let scale = norm.time_scale(progress.position_count);
    norm.allow(TIME_FRACTION * scale);
    let size = |x: &[f64]| norm.measure(x, state, state).value;
    let (d0, d1) = (size(state), size(rate));
    let ratio = if d0 < NEGLIGIBLE || d1 < NEGLIGIBLE { BLIND_FRACTION * scale } else { 0.01 * d0 / d1 };
    let ahead = ratio.min(TIME_FRACTION * scale);

    let moved: Vec<f64> = state.iter().zip(rate).map(|(x, rate)| x + ahead * rate).collect();
    let mut change = vec![0.0; state.len()];
    let looked = state_rate(problem, progress.time + ahead, &moved, &mut change, &mut progress.statistics);
    if looked.is_err() {
        return ahead;
    }
    change.iter_mut().zip(rate).for_each(|(after, before)| *after = (*after - before) / ahead);
    let d2 = size(&change);

    let strongest = (scale * d1).max(scale * scale * d2);
    let by_error = scale * (0.01 / strongest.max(f64::MIN_POSITIVE)).powf(1.0 / f64::from(order));
    by_error.min(100.0 * ahead).min(TIME_FRACTION * scale)
}
