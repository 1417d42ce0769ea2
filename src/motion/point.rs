//! A point carried by a link: what forces act on.

use super::variation::LinkVariation;
use super::{LinkMotion, Motion};
use crate::model::End;
use nalgebra::Vector3;

/// A carried point at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// From the link's root marker, inertial axes (m).
    pub arm: Vector3<f64>,
    /// (m)
    pub position: Vector3<f64>,
    /// (m/s)
    pub velocity: Vector3<f64>,
}

/// Variation of a carried point.
#[derive(Debug, Clone, Copy)]
pub struct PointVariation {
    /// Of the arm.
    pub arm: Vector3<f64>,
    /// Of the position.
    pub position: Vector3<f64>,
    /// Of the velocity.
    pub velocity: Vector3<f64>,
}

impl Point {
    /// The point that `end` names.
    #[inline]
    pub fn of(end: &End, motion: &Motion) -> Self {
        let link = &motion.links[end.link];
        let arm = link.turn * end.point;
        Self { arm, position: link.position + arm, velocity: link.velocity + link.angular_velocity.cross(&arm) }
    }

    /// How it varies with its link.
    #[inline]
    pub fn vary(&self, link: &LinkMotion, by: &LinkVariation) -> PointVariation {
        let arm = by.turn.cross(&self.arm);
        PointVariation {
            arm,
            position: by.position + arm,
            velocity: by.velocity + by.angular_velocity.cross(&self.arm) + link.angular_velocity.cross(&arm),
        }
    }
}
