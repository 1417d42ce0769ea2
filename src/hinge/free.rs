//! Moves freely.

use super::axes::frame;
use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names};
use nalgebra::UnitQuaternion;

/// Moves freely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Free;

impl Freedom for Free {
    const NAME: &'static str = "free";
    const DOC: &'static str = "Moves freely. Coordinates: x, y, z in the hinge frame, quaternion w, x, y, z; \
        velocities: rates of x, y, z, then relative angular velocity, body axes.";
    const CLOSES: Option<&'static str> = None;
    const POSITIONS: Names = &[("x", "m"), ("y", "m"), ("z", "m"), ("qw", "1"), ("qx", "1"), ("qy", "1"), ("qz", "1")];
    const VELOCITIES: Names =
        &[("vx", "m/s"), ("vy", "m/s"), ("vz", "m/s"), ("wx", "rad/s"), ("wy", "rad/s"), ("wz", "rad/s")];
    const ORDER: Option<[&'static str; 2]> = Some([
        "x, y, z, then quaternion w, x, y, z",
        "along x, y, z of the hinge frame, then about the body's x, y, z",
    ]);

    fn read(_: &dyn Keys) -> Self {
        Self
    }

    fn elementary(&self, rest: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        let slides = frame().map(|axis| Joint::slide(&axis));
        slides.into_iter().chain([Joint::ball(rest.get(3..).unwrap_or(&[]))]).collect()
    }

    fn conditions(&self) -> Vec<Condition> {
        Vec::new()
    }
}
