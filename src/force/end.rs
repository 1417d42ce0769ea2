//! Where a force acts: on a point as it is described, as it is compiled, at an instant and varied.

use crate::spatial::link::{LinkMotion, LinkVariation};
use nalgebra::{UnitQuaternion, Vector3};

/// The name of the inertial frame where a parent or a body is asked for.
pub const GROUND: &str = "ground";

/// A point of a body or of the ground.
#[derive(Debug, Clone, PartialEq)]
pub enum Point {
    /// Coordinates from the root marker, body axes (m).
    At(Vector3<f64>),
    /// A marker's name.
    Marker(String),
}

/// A point on a named body.
#[derive(Debug, Clone, PartialEq)]
pub struct Attachment {
    /// Body name or [`GROUND`].
    pub body: String,
    /// Where on it.
    pub point: Point,
}

impl From<[f64; 3]> for Point {
    fn from(at: [f64; 3]) -> Self {
        Self::At(at.into())
    }
}

impl From<Vector3<f64>> for Point {
    fn from(at: Vector3<f64>) -> Self {
        Self::At(at)
    }
}

impl From<&str> for Point {
    fn from(marker: &str) -> Self {
        Self::Marker(marker.to_owned())
    }
}

/// A body and a point of it: `("arm", "tip")`, `(GROUND, [0.0, 0.0, 1.0])`.
impl<P: Into<Point>> From<(&str, P)> for Attachment {
    fn from((body, point): (&str, P)) -> Self {
        Self { body: body.to_owned(), point: point.into() }
    }
}

/// A point on a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Index of the link; 0 is the ground.
    pub link: usize,
    /// The named body, `None` for the ground.
    pub body: Option<usize>,
    /// From the link's root marker, link axes (m).
    pub point: Vector3<f64>,
}

/// An attachment, compiled: the point, and how the axes of its body are turned in those of its link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Carrier {
    /// The point.
    pub end: End,
    /// `link_from_body`.
    pub turn: UnitQuaternion<f64>,
}

/// A point that a link carries, at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Anchor {
    /// From the link's root marker, inertial axes (m).
    pub arm: Vector3<f64>,
    /// (m)
    pub position: Vector3<f64>,
    /// (m/s)
    pub velocity: Vector3<f64>,
}

/// Variation of a carried point.
#[derive(Debug, Clone, Copy, Default)]
pub struct AnchorVariation {
    /// Of the arm.
    pub arm: Vector3<f64>,
    /// Of the position.
    pub position: Vector3<f64>,
    /// Of the velocity.
    pub velocity: Vector3<f64>,
}

impl Anchor {
    /// The point that `end` names.
    #[inline]
    pub fn of(end: &End, links: &[LinkMotion]) -> Self {
        let link = &links[end.link];
        let arm = link.turn * end.point;
        Self { arm, position: link.position + arm, velocity: link.velocity + link.angular_velocity.cross(&arm) }
    }

    /// How it varies with its link.
    #[inline]
    pub fn vary(&self, link: &LinkMotion, by: &LinkVariation) -> AnchorVariation {
        let arm = by.turn.cross(&self.arm);
        AnchorVariation {
            arm,
            position: by.position + arm,
            velocity: by.velocity + by.angular_velocity.cross(&self.arm) + link.angular_velocity.cross(&arm),
        }
    }
}
