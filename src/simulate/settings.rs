//! What a user asks of a run.

use crate::integrate::{Method, Options};
use crate::simulate::mode::Mode;
use std::sync::Arc;

/// The least and the largest relative tolerance that may be asked for.
pub const TOLERANCES: [f64; 2] = [1e-14, 1.0];

/// The `[simulate]` table.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Where the run starts.
    pub start: Start,
    /// Simulated time (s), > 0.
    pub duration: f64,
    /// The time stepping method.
    pub integrator: Integrator,
    /// Relative tolerance of adaptive methods, for the error at the end of the run.
    pub tolerance: f64,
    /// Absolute tolerance beside it, in units of the scene's own length, angle 1 rad and time.
    pub absolute_tolerance: f64,
    /// Step of fixed-step methods, first step of adaptive ones (s).
    pub step: Option<f64>,
    /// For `generalized-alpha`: the part of motions far faster than the step that a step leaves, in [0, 1].
    pub rho_infinity: f64,
    /// Contacts whose gap is at most this part of the smaller of both shapes are closed: `[statics] gap`.
    pub gap: f64,
    /// Where an earlier run ended that this one goes on from; `None` for a run from t = 0.
    pub resume: Option<Resume>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            start: Start::Equilibrium,
            duration: 10.0,
            integrator: Integrator::Auto,
            tolerance: 1e-8,
            absolute_tolerance: 1e-8,
            step: None,
            rho_infinity: Options::default().rho_infinity,
            gap: crate::statics::Settings::GAP,
            resume: None,
        }
    }
}

impl Settings {
    /// The time at which the run begins (s).
    pub fn begin(&self) -> f64 {
        self.resume.as_ref().map_or(0.0, |resume| resume.time)
    }
}

/// Where a run ended, beside its state: what another run needs to go on as the first one would have.
///
/// A method that takes its steps from a fixed grid and remembers nothing of the last one (`rk4`) goes on bit for bit, if the
/// run did not end within a step, nor within something short that a formula does. An adaptive one begins with the step that it would have taken; what it remembers of
/// earlier steps (their error, past accelerations, factorizations, and for implicit methods the guess of the next stages)
/// is made anew. What holds, slides and touches goes on as it did.
#[derive(Debug, Clone, PartialEq)]
pub struct Resume {
    /// The time reached (s).
    pub time: f64,
    /// The method that was at work.
    pub method: Method,
    /// The next step (s).
    pub step: Option<f64>,
    /// The fixed grid that the steps belong to; `None` for an adaptive method, and if the last step was cut.
    pub grid: Option<Grid>,
    /// What stops, dry friction and contacts did; `None` if there are none, or if it is decided anew.
    pub mode: Option<Arc<Mode>>,
}

/// Times of fixed steps: `origin + k step`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Origin (s).
    pub origin: f64,
    /// Steps made since then.
    pub steps: u64,
}

/// Where a run starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// At the equilibrium that statics finds.
    Equilibrium,
    /// At the hinge positions and velocities as they stand.
    Given,
}

/// Who chooses the time stepping method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrator {
    /// The program: an explicit method where the run starts at a given state, an implicit one where it starts at rest, and
    /// from one to the other where stability of the explicit one asks for it.
    Auto,
    /// The user.
    Method(Method),
}

impl Integrator {
    /// By its name in scenario files.
    pub fn named(name: &str) -> Option<Self> {
        let method = |method: &Method| method.name() == name;
        match name {
            "auto" => Some(Self::Auto),
            _ => Method::ALL.into_iter().find(method).map(Self::Method),
        }
    }
}
