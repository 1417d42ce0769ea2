//! Mechanics of one rigid body: poses and wrenches. Knows nothing of systems.
//!
//! Vectors are resolved in inertial axes unless a name says otherwise; a rotation `world_from_body` turns body axes
//! into inertial ones.

use nalgebra::{Isometry3, Vector3};

/// Position and orientation of a frame: `world_from_body`.
pub type Pose = Isometry3<f64>;

/// A force and a moment at a point that the context names, inertial axes [N, N m].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wrench {
    /// [N]
    pub force: Vector3<f64>,
    /// [N m]
    pub moment: Vector3<f64>,
}
