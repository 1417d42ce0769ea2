//! The factorized Newton matrices of implicit steps; which of them a system has, and how it is made, is in `newton`.

use super::bordered::Bordered;
use super::differenced::Differenced;
use crate::dynamics::TangentSolver;

/// The factorized tangent of an implicit step.
pub(in crate::simulate) enum Tangent {
    /// Not asked for yet.
    None,
    /// Of a tree.
    Tree(Box<TangentSolver>),
    /// With loops, drives or gears: bordered by their rows.
    Bordered(Box<Bordered>),
    /// Beside contacts that move: by differences of the accelerations.
    Differenced(Box<Differenced>),
}
