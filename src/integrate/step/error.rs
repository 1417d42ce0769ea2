//! Why a run cannot go on, told so that a person can act on it.

use std::fmt;

use crate::integrate::problem::Failure;

/// Why a run could not start or a step could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StepError {
    /// A setting is out of its range.
    #[error("the {name} is {value}, allowed is {allowed}")]
    Option {
        /// The setting.
        name: &'static str,
        /// What was given.
        value: f64,
        /// The range, for people.
        allowed: &'static str,
    },
    /// A method with a fixed step was given none.
    #[error("a fixed step was asked for but not given: set the step")]
    NoStep,
    /// The start has another number of coordinates or velocities than the system.
    #[error("the start has {given} {quantity}, the system has {expected}")]
    Size {
        /// `positions` or `velocities`.
        quantity: &'static str,
        /// How many the start has.
        given: usize,
        /// How many the system has.
        expected: usize,
    },
    /// The system cannot be evaluated at the start.
    #[error("cannot start at t = {} s: {limit}", short(*.time))]
    Start {
        /// Start time in s.
        time: f64,
        /// What is wrong there.
        limit: Limit,
    },
    /// A step that must not shrink failed.
    #[error("the fixed step of {} s from t = {} s fails: {limit}; {advice}", short(*.step), short(*.time))]
    Fixed {
        /// Where the step starts, in s.
        time: f64,
        /// The step in s.
        step: f64,
        /// What is wrong.
        limit: Limit,
        /// What to try.
        advice: &'static str,
    },
    /// The state between the ends of a step that was made cannot be found.
    #[error("no state between t = {} s and t = {} s: {limit}", short(*.from), short(*.to))]
    Between {
        /// Where the step starts, in s.
        from: f64,
        /// Where the step ends, in s.
        to: f64,
        /// What is wrong there.
        limit: Limit,
    },
    /// The step became so small that time stands still.
    #[error("the step from t = {} s shrank to {} s, too small to go on: {limit}", short(*.time), short(*.step))]
    Underflow {
        /// Where the step starts, in s.
        time: f64,
        /// The step in s.
        step: f64,
        /// What made it shrink.
        limit: Limit,
    },
}

impl StepError {
    pub(crate) fn option(name: &'static str, value: f64, allowed: &'static str) -> Self {
        Self::Option { name, value, allowed }
    }

    /// What stopped the run, where it is more than a wrong setting.
    pub fn limit(&self) -> Option<&Limit> {
        match self {
            Self::Start { limit, .. }
            | Self::Fixed { limit, .. }
            | Self::Between { limit, .. }
            | Self::Underflow { limit, .. } => Some(limit),
            Self::Option { .. } | Self::NoStep | Self::Size { .. } => None,
        }
    }
}

/// Six significant digits, with an exponent if there are many zeros.
fn short(x: f64) -> String {
    let rounded = format!("{x:.5e}").parse().unwrap_or(x);
    let shown = format!("{rounded:?}");
    shown.strip_suffix(".0").map_or_else(|| shown.clone(), str::to_owned)
}

/// What stands in the way of a step.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Limit {
    /// The error estimate stays above the tolerance.
    #[error(
        "the error estimate of {0} stays above the tolerance; look for a jump, an impact or a singularity near this \
         time, or loosen the tolerance"
    )]
    ErrorEstimate(Component),
    /// An explicit method is at the edge of its stability region.
    #[error("the step is held by stability, not accuracy (the system is stiff): try sdirk4")]
    Stability,
    /// Newton's iteration for an implicit stage diverges or is too slow.
    #[error(
        "Newton's iteration for the stages does not converge; look for a jump or a singular configuration near this \
         time, or loosen a tolerance that is close to rounding"
    )]
    Newton,
    /// A number is infinite or undefined.
    #[error("{0} or its rate is not a finite number")]
    NotFinite(Component),
    /// The system could not be evaluated.
    #[error("{0}")]
    Failure(Failure),
}

/// One component of the state, counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// A coordinate.
    Position(usize),
    /// A velocity.
    Velocity(usize),
}

impl Component {
    /// The component at `index` of the state `(q, v)`.
    pub(crate) fn of_state(index: usize, position_count: usize) -> Self {
        index.checked_sub(position_count).map_or(Self::Position(index), Self::Velocity)
    }
}

impl fmt::Display for Component {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Position(index) => write!(f, "q[{index}]"),
            Self::Velocity(index) => write!(f, "v[{index}]"),
        }
    }
}
