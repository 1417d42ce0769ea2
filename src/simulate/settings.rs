//! What a user asks of a run.

use crate::integrate::{Method, Options};

/// The `[simulate]` table.
#[derive(Debug, Clone, Copy, PartialEq)]
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
        }
    }
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
