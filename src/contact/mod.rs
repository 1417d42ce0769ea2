//! Contact and dry friction.
//!
//! `support` answers, for forces that are bounded by cones, whether they can balance loads, by how much, and along which
//! motion they give way: Coulomb's cones of contacts, bounded torques of hinges with dry friction, stops that only press.

mod bounded;
pub(crate) mod cone;
pub(crate) mod frame;
pub mod geometry;
pub(crate) mod hinges;
pub(crate) mod pairs;
pub mod support;
