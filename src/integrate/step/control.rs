//! The step controller, one for all methods.
//!
//! After a step of length `h` with error norm `e` (see `norm.rs`), of a method whose estimate is `O(h^k)`,
//!
//! ```text
//! h' = h · 0.9 · e^(−α) · e_before^β,   β = 0.2/k,  α = 1/k − ¾ β     after an accepted step
//! h' = h · 0.9 · e^(−1/k)                                            after a rejected one
//! ```
//!
//! within `[0.2 h, 5 h]`: the proportional-integral control of Hairer, Wanner, *Solving ODEs II*, IV.2, after Gustafsson.
//!
//! - After a rejection the step does not grow at once.
//! - The first step may at most double: its estimate alone may be blind (symmetric starts), the second one is a check.
//! - Methods that pay for a change of step (a new factorization) keep it where it would grow by less than 20 %.
//! - The last two steps before the end share the rest, so that none is a sliver.

use crate::integrate::{
    step::error::{Limit, StepError},
    step::options::Options,
    step::progress::Progress,
};

const SAFETY: f64 = 0.9;
const SMALLEST_FACTOR: f64 = 0.2;
const LARGEST_FACTOR: f64 = 5.0;
const LARGEST_FIRST_FACTOR: f64 = 2.0;
/// Factor after a step that could not be finished at all.
const FAILURE_FACTOR: f64 = 0.25;
/// A step this much longer than wished may be taken to land on the end.
const STRETCH: f64 = 1.0 + 1e-6;
/// Errors far below the tolerance say nothing about the trend.
const SMALLEST_REMEMBERED_ERROR: f64 = 1e-4;

/// A step to try.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Trial {
    pub(crate) step: f64,
    /// The time it leads to.
    pub(crate) time: f64,
}

/// Chooses steps.
#[derive(Debug)]
pub(crate) struct Controller {
    /// The error estimate is `O(h^order)`.
    order: f64,
    /// The step is kept where it would grow by less than this factor.
    hold_below: f64,
    /// Next step to try.
    step: f64,
    max_step: f64,
    previous_error: f64,
    rejected: bool,
    /// Why the last attempt was given up.
    limit: Option<Limit>,
    fixed: Option<Grid>,
}

/// The times of a fixed step, by multiplication: a sum of steps would drift from it.
#[derive(Debug)]
struct Grid {
    origin: f64,
    count: u64,
    advice: &'static str,
}

impl Controller {
    /// Starts with `step`, adaptive with an error estimate of `order`; fixed where the options say so.
    ///
    /// `advice` tells what to try where a fixed step fails.
    pub(crate) fn new(options: &Options, order: u8, step: f64, progress: &Progress, advice: &'static str) -> Self {
        let max_step = options.max_step.unwrap_or(f64::INFINITY);
        let (origin, count) = options.grid.unwrap_or((progress.time, 0));
        let shortest = if options.fixed { step } else { shortest_step(progress) };
        Self {
            order: f64::from(order),
            hold_below: 1.0,
            step: step.min(max_step).max(shortest),
            max_step,
            previous_error: SMALLEST_REMEMBERED_ERROR,
            rejected: false,
            limit: None,
            fixed: options.fixed.then_some(Grid { origin, count, advice }),
        }
    }

    /// Keeps the step where it would grow by less than `factor`.
    pub(crate) fn holding_below(self, factor: f64) -> Self {
        Self { hold_below: factor, ..self }
    }

    /// The next step to try (s).
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    pub(crate) fn is_fixed(&self) -> bool {
        self.fixed.is_some()
    }

    /// The next step to try, no longer than `longest` (s) and cut to land on the end.
    ///
    /// # Errors
    /// If the step is lost in the rounding of time.
    pub(crate) fn propose(&self, progress: &Progress, longest: f64) -> Result<Trial, StepError> {
        let (time, end) = (progress.time, progress.end);
        let rest = end - time;
        if self.step < shortest_step(progress).min(rest)
            && let Some(limit) = &self.limit
        {
            return Err(StepError::Underflow { time, step: self.step, limit: limit.clone() });
        }
        let step = if self.fixed.is_some() { self.step } else { self.step.min(longest.max(shortest_step(progress))) };
        let after = match &self.fixed {
            Some(grid) => grid.origin + (grid.count + 1) as f64 * step,
            None if rest < 2.0 * step => time + 0.5 * rest,
            None => time + step,
        };
        if rest <= step * STRETCH || after >= end {
            return Ok(Trial { step: rest, time: end });
        }
        if after <= time {
            return Err(StepError::option("step", step, "long enough to differ from the rounding of time"));
        }
        // The step that time really makes, rounding included: times and states stay together.
        Ok(Trial { step: after - time, time: after })
    }

    /// Chooses the next step after an accepted one with the error norm `error`.
    pub(crate) fn accept(&mut self, trial: Trial, error: f64, first: bool) {
        if let Some(grid) = &mut self.fixed {
            grid.count += 1;
            return;
        }
        let integral = 0.2 / self.order;
        let proportional = 1.0 / self.order - 0.75 * integral;
        let largest = match (self.rejected, first) {
            (true, _) => 1.0,
            (false, true) => LARGEST_FIRST_FACTOR,
            (false, false) => LARGEST_FACTOR,
        };
        let wished = SAFETY * error.powf(-proportional) * self.previous_error.powf(integral);
        let factor = wished.clamp(SMALLEST_FACTOR, largest);
        let held = factor >= 1.0 && factor < self.hold_below;
        self.step = (if held { trial.step } else { factor * trial.step }).min(self.max_step);
        self.previous_error = error.max(SMALLEST_REMEMBERED_ERROR);
        self.rejected = false;
    }

    /// Chooses a shorter step where the error norm `error` is too large.
    pub(crate) fn reject(&mut self, trial: Trial, error: f64, limit: Limit) {
        self.step = trial.step * (SAFETY * error.powf(-1.0 / self.order)).max(SMALLEST_FACTOR);
        self.rejected = true;
        self.limit = Some(limit);
    }

    /// Goes on with the step times `factor` after an accepted one, for a method that chooses its own.
    pub(crate) fn follow(&mut self, trial: Trial, factor: f64) {
        if let Some(grid) = &mut self.fixed {
            grid.count += 1;
            return;
        }
        self.step = (factor * trial.step).min(self.max_step);
    }

    /// Tries again with the step times `factor`, for a method that chooses its own.
    pub(crate) fn retry(&mut self, trial: Trial, factor: f64, limit: Limit) {
        self.step = factor * trial.step;
        self.limit = Some(limit);
    }

    /// Chooses a shorter step where the attempt broke off.
    ///
    /// # Errors
    /// Where the step is fixed.
    pub(crate) fn fail(&mut self, trial: Trial, limit: Limit, progress: &Progress) -> Result<(), StepError> {
        if let Some(grid) = &self.fixed {
            return Err(StepError::Fixed { time: progress.time, step: trial.step, limit, advice: grid.advice });
        }
        self.step = FAILURE_FACTOR * trial.step;
        self.rejected = true;
        self.limit = Some(limit);
        Ok(())
    }
}

/// The shortest step that is still well above the rounding of time, in s.
fn shortest_step(progress: &Progress) -> f64 {
    4.0 * f64::EPSILON * progress.time.abs().max(progress.end.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIAL: Trial = Trial { step: 1.0, time: 1.0 };

    fn controller() -> Controller {
        Controller {
            order: 5.0,
            hold_below: 1.0,
            step: 1.0,
            max_step: 100.0,
            previous_error: SMALLEST_REMEMBERED_ERROR,
            rejected: false,
            limit: None,
            fixed: None,
        }
    }

    #[test]
    fn the_first_step_at_most_doubles_and_later_ones_grow_five_times() {
        let mut control = controller();
        control.accept(TRIAL, 0.0, true);
        assert_eq!(control.step, 2.0);
        control.accept(TRIAL, 0.0, false);
        assert_eq!(control.step, 5.0);
    }

    #[test]
    fn a_rejected_step_shrinks_and_does_not_grow_at_once() {
        let mut control = controller();
        control.reject(TRIAL, 32.0, Limit::Newton);
        // 0.9 · 32^(−1/5)
        assert!((control.step - 0.45).abs() < 1e-15);
        control.accept(TRIAL, 1e-9, false);
        assert_eq!(control.step, 1.0);
        control.accept(TRIAL, 1e-9, false);
        assert!(control.step > 1.0);
    }

    #[test]
    fn a_step_that_would_grow_little_is_held() {
        let mut control = controller().holding_below(1.2);
        control.previous_error = 1.0;
        // 0.9 · e^(−0.17) = 1.1
        control.accept(TRIAL, (0.9_f64 / 1.1).powf(1.0 / 0.17), false);
        assert_eq!(control.step, 1.0);
    }
}
