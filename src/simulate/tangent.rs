//! The factorized Newton matrices of implicit steps; which of them a system has, and how it is made, is in `newton`.

use super::bordered::Bordered;
use super::differenced::Differenced;
use crate::dynamics::{DenseTangent, TangentSolver};

/// The factorized tangent of an implicit step.
pub(super) enum Tangent {
    /// Not asked for yet.
    None,
    /// In O(n), by sweeps.
    Sweep(Box<TangentSolver>),
    /// Dense: where more forces reach across the tree than it has coordinates.
    Dense(Box<DenseTangent>),
    /// With loops, drives or gears: bordered by their rows.
    Bordered(Box<Bordered>),
    /// Beside contacts that move: by differences of the accelerations.
    Differenced(Box<Differenced>),
}
