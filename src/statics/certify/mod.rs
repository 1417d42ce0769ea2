//! The certificate of a pose: whether its residual proves an equilibrium, what kind that is, and what holds it.

pub(super) mod bearing;
pub(super) mod closed;
pub(super) mod cone;
mod copositive;
pub(super) mod damped;
pub(super) mod equilibrium;
pub(super) mod falling;
pub(super) mod known;
pub(super) mod modes;
pub(super) mod stability;
mod subspace;
pub(super) mod unbalanced;
pub(super) mod weak;
