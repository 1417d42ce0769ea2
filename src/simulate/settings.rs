//! What a user asks of a run.

/// The `(simulate)` table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Where the run starts.
    pub start: Start,
    /// Simulated time (s), > 0.
    pub duration: f64,
    /// The time stepping method.
    pub integrator: Integrator,
    /// Relative tolerance of adaptive methods.
    pub tolerance: f64,
    /// Absolute tolerance beside it, in units of the scene's own length, angle 1 rad and time.
    pub absolute_tolerance: f64,
    /// Step of fixed-step methods, first step of adaptive ones (s).
    pub step: Option<f64>,
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

/// The time stepping methods, by their names in scenario files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrator {
    /// From an equilibrium `sdirk4`, from a given state `dopri5` until it is held by stability, `sdirk4` from there.
    Auto,
    /// Classical Runge–Kutta, fixed step.
    Rk4,
    /// Dormand–Prince 5(4), adaptive.
    Dopri5,
    /// Dormand–Prince 8(5,3), adaptive.
    Dop853,
    /// L-stable, stiffly accurate, order 4, adaptive.
    Sdirk4,
}
