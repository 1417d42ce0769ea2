//! Turns freely.

use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names};
use nalgebra::UnitQuaternion;

/// Turns freely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spherical;

impl Freedom for Spherical {
    const NAME: &'static str = "spherical";
    const DOC: &'static str = "Turns freely. Coordinates: quaternion w, x, y, z; \
        velocities: angular velocity relative to the parent, body axes.";
    const CLOSES: Option<&'static str> = Some("Turns freely: the two points stay together.");
    const POSITIONS: Names = &[("qw", "1"), ("qx", "1"), ("qy", "1"), ("qz", "1")];
    const VELOCITIES: Names = &[("wx", "rad/s"), ("wy", "rad/s"), ("wz", "rad/s")];
    const ORDER: Option<[&'static str; 2]> = Some(["quaternion w, x, y, z", "about the body's x, y, z"]);

    fn read(_: &dyn Keys) -> Self {
        Self
    }

    fn elementary(&self, rest: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        vec![Joint::ball(rest)]
    }

    fn conditions(&self) -> Vec<Condition> {
        Condition::together().to_vec()
    }
}
