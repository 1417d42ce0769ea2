//! Where a run begins, and where it is.

/// Hinge coordinates and velocities.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct State {
    /// Hinge coordinates.
    pub position: Vec<f64>,
    /// Hinge velocities.
    pub velocity: Vec<f64>,
}
