//! Contact and dry friction.
//!
//! `support` answers, for forces that are bounded by cones, whether they can balance loads, by how much, and along which
//! motion they give way: Coulomb's cones of contacts, bounded torques of hinges with dry friction, stops that only press.

pub mod geometry;
pub mod support;
