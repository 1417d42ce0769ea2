//! Two methods to compare with: explicit motion with kinetic damping, and maximal coordinates with multipliers. Neither uses the
//! tangent of the tree, nor the steps that the search ends with.

pub(super) mod lagrange;
pub(super) mod relaxation;
