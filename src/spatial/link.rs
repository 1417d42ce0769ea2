//! One link at one instant: its motion, and how that varies.

use super::{Pose, Sym3};
use nalgebra::{Matrix3, Translation3, UnitQuaternion, Vector3};

/// Position and velocity of one link at its root marker, and its mass properties turned to inertial axes. What the sweep to
/// the root reads comes last, and of that what the sweep back reads: large trees wait for memory.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct LinkMotion {
    /// `world_from_link`.
    pub turn: Matrix3<f64>,
    /// Root marker (m).
    pub position: Vector3<f64>,
    /// Of the root marker (m/s).
    pub velocity: Vector3<f64>,
    /// Velocity relative to the parent: along the axis for a slide, else angular (a screw's is `pitch` times that beside it).
    pub relative: Vector3<f64>,
    /// Angular velocity (rad/s).
    pub angular_velocity: Vector3<f64>,
    /// From the root marker to the centre of mass (m).
    pub center: Vector3<f64>,
    /// About the root marker (kg m²).
    pub inertia: Sym3,
    /// Axis of a turn, slide or screw.
    pub axis: Vector3<f64>,
    /// From the parent's root marker to this one (m).
    pub arm: Vector3<f64>,
    /// What the velocities add to the linear acceleration of the root marker (m/s²).
    pub bias: Vector3<f64>,
    /// What the velocities add to the angular acceleration (rad/s²).
    pub angular_bias: Vector3<f64>,
}

impl LinkMotion {
    /// The ground.
    pub const GROUND: Self = Self {
        turn: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        position: Vector3::new(0.0, 0.0, 0.0),
        velocity: Vector3::new(0.0, 0.0, 0.0),
        angular_velocity: Vector3::new(0.0, 0.0, 0.0),
        arm: Vector3::new(0.0, 0.0, 0.0),
        axis: Vector3::new(0.0, 0.0, 0.0),
        relative: Vector3::new(0.0, 0.0, 0.0),
        bias: Vector3::new(0.0, 0.0, 0.0),
        angular_bias: Vector3::new(0.0, 0.0, 0.0),
        center: Vector3::new(0.0, 0.0, 0.0),
        inertia: Sym3::ZERO,
    };

    /// `γ`: what the velocities add to the acceleration across the hinge.
    #[inline(always)]
    pub fn velocity_terms(&self) -> LinkAcceleration {
        LinkAcceleration { linear: self.bias, angular: self.angular_bias }
    }

    /// `X(d) a_P + γ`: the acceleration of the root marker from that of the one before it, its own hinge at rest.
    pub fn carry(&self, parent: &LinkAcceleration) -> LinkAcceleration {
        LinkAcceleration {
            linear: parent.linear + parent.angular.cross(&self.arm) + self.bias,
            angular: parent.angular + self.angular_bias,
        }
    }

    /// `world_from_link` as a pose.
    pub fn pose(&self) -> Pose {
        let turn = nalgebra::Rotation3::from_matrix_unchecked(self.turn);
        Pose::from_parts(Translation3::from(self.position), UnitQuaternion::from_rotation_matrix(&turn))
    }
}

/// Acceleration of one link's root marker.
#[derive(Debug, Clone, Copy, Default)]
pub struct LinkAcceleration {
    /// r̈ (m/s²).
    pub linear: Vector3<f64>,
    /// ω̇ (rad/s²).
    pub angular: Vector3<f64>,
}

/// Variation of one link's motion and acceleration.
#[derive(Debug, Clone, Copy, Default)]
pub struct LinkVariation {
    /// δθ: the small turn.
    pub turn: Vector3<f64>,
    /// δr of the root marker.
    pub position: Vector3<f64>,
    /// δω.
    pub angular_velocity: Vector3<f64>,
    /// δv.
    pub velocity: Vector3<f64>,
    /// δω̇.
    pub angular_acceleration: Vector3<f64>,
    /// δr̈.
    pub acceleration: Vector3<f64>,
}
