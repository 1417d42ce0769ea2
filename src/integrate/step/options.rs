//! What the user chooses: tolerances, steps, the start and the end.

use crate::integrate::step::error::StepError;

/// Tolerances and steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Error allowed at the end of the run, relative to a component's size, in `[0, 0.1]`. What the motion itself makes of
    /// an error on the way is not counted.
    pub relative: f64,
    /// Error allowed at the end of the run as a fraction of a component's scale
    /// ([`scales`](crate::integrate::Problem::scales)), above 0.
    pub absolute: f64,
    /// The run's duration in s, above 0, where the stepper makes only a part of it: a step is allowed the part of the error
    /// that it is of the duration (with a smallest share, see the guide). `None`: from the start to the end of the stepper.
    pub duration: Option<f64>,
    /// The fixed step, or the first one an adaptive method tries, in s, above 0.
    pub step: Option<f64>,
    /// No step is longer than this, in s, above 0.
    pub max_step: Option<f64>,
    /// Keeps an adaptive method at `step`, without looking at its error estimate.
    pub fixed: bool,
    /// For a fixed step: the time from which steps are counted (s), and how many there have been; `None`: from the start on.
    pub grid: Option<(f64, u64)>,
    /// Part of motions far faster than the step that a step of [`GeneralizedAlpha`](crate::integrate::GeneralizedAlpha)
    /// leaves, in `[0, 1]`.
    pub rho_infinity: f64,
}

impl Default for Options {
    /// Relative 1e-6, absolute 1e-9, steps chosen by the method, `ρ∞` 0.8.
    fn default() -> Self {
        Self {
            relative: 1e-6,
            absolute: 1e-9,
            duration: None,
            step: None,
            max_step: None,
            fixed: false,
            grid: None,
            rho_infinity: 0.8,
        }
    }
}

impl Options {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`StepError::Option`] for the first value out of its range; also where a fixed step is asked for but not given.
    pub fn validate(&self) -> Result<(), StepError> {
        if !(0.0..=0.1).contains(&self.relative) {
            return Err(StepError::option("relative tolerance", self.relative, "0 to 0.1"));
        }
        if !(self.absolute > 0.0 && self.absolute.is_finite()) {
            return Err(StepError::option("absolute tolerance", self.absolute, "above 0"));
        }
        for (name, value) in [("step", self.step), ("longest step", self.max_step), ("duration", self.duration)] {
            if let Some(value) = value
                && !(value > 0.0 && value.is_finite())
            {
                return Err(StepError::option(name, value, "above 0 s"));
            }
        }
        if !(0.0..=1.0).contains(&self.rho_infinity) {
            return Err(StepError::option("spectral radius at infinity", self.rho_infinity, "0 to 1"));
        }
        if self.fixed && self.step.is_none() {
            return Err(StepError::NoStep);
        }
        Ok(())
    }
}

/// Where a run starts and when it ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start<'a> {
    /// Start time in s.
    pub time: f64,
    /// Coordinates at the start, `position_count` of them; quaternions need not be normalised.
    pub position: &'a [f64],
    /// Velocities at the start, `velocity_count` of them.
    pub velocity: &'a [f64],
    /// End time in s, not before `time`. The last step lands on it exactly.
    pub end: f64,
}
