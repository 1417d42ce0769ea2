//! How much room bodies and lines take.

use crate::record::scene::LinePicture;
use crate::record::solids::{Form, Solid};
use crate::spatial::Pose;
use nalgebra::{Point3, Vector3};

/// A box along the inertial axes; empty at first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::record) struct Bounds {
    pub(in crate::record) min: Vector3<f64>,
    pub(in crate::record) max: Vector3<f64>,
}

impl Default for Bounds {
    fn default() -> Self {
        Self { min: Vector3::repeat(f64::INFINITY), max: Vector3::repeat(f64::NEG_INFINITY) }
    }
}

impl Bounds {
    /// Grows to hold a ball; balls at no finite place are passed over.
    pub(in crate::record) fn include(&mut self, center: &Vector3<f64>, radius: f64) {
        if center.iter().all(|x| x.is_finite()) && radius.is_finite() {
            self.min = self.min.inf(&center.add_scalar(-radius));
            self.max = self.max.sup(&center.add_scalar(radius));
        }
    }

    /// Grows to hold the bodies' solids at one instant.
    pub(in crate::record) fn include_bodies(&mut self, outlines: &[Outline], poses: &[Pose]) {
        for (outline, pose) in outlines.iter().zip(poses) {
            for (point, radius) in &outline.points {
                self.include(&(pose * point).coords, *radius);
            }
        }
    }

    /// Grows to hold the ends of springs at one instant.
    pub(in crate::record) fn include_lines(&mut self, lines: &[LinePicture], poses: &[Pose]) {
        for (body, point) in lines.iter().flat_map(|line| &line.ends) {
            let pose = body.and_then(|body| poses.get(body)).copied().unwrap_or_default();
            self.include(&(pose * Point3::from(*point)).coords, 0.0);
        }
    }

    /// Middle; the origin when empty.
    pub(in crate::record) fn center(&self) -> Vector3<f64> {
        if self.is_empty() { Vector3::zeros() } else { 0.5 * (self.min + self.max) }
    }

    /// Edge lengths; a metre each when empty.
    pub(in crate::record) fn size(&self) -> Vector3<f64> {
        if self.is_empty() { Vector3::repeat(1.0) } else { self.max - self.min }
    }

    pub(in crate::record) fn corners(&self) -> [Vector3<f64>; 8] {
        let (center, half) = (self.center(), 0.5 * self.size());
        std::array::from_fn(|k| {
            let side = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
            center + half.component_mul(&Vector3::new(side(0), side(1), side(2)))
        })
    }

    pub(in crate::record) fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }
}

/// A body's outermost points, body axes, each with the radius of a ball about it.
#[derive(Debug, Clone, Default)]
pub(in crate::record) struct Outline {
    points: Vec<(Point3<f64>, f64)>,
}

impl Outline {
    /// Of a body's solids.
    pub(in crate::record) fn new(solids: &[Solid]) -> Self {
        let mut points = Vec::new();
        for solid in solids.iter().filter(|solid| !solid.unbounded) {
            let mut add =
                |x: f64, y: f64, z: f64, radius: f64| points.push((solid.pose * Point3::new(x, y, z), radius));
            match &solid.form {
                Form::Box([a, b, c]) => {
                    for k in 0..8 {
                        let half = |edge: f64, bit: usize| if k >> bit & 1 == 0 { -0.5 * edge } else { 0.5 * edge };
                        add(half(*a, 0), half(*b, 1), half(*c, 2), 0.0);
                    }
                }
                Form::Ball(radius) => add(0.0, 0.0, 0.0, *radius),
                Form::Cylinder { radius, length } | Form::Capsule { radius, length } => {
                    add(0.0, 0.0, -0.5 * length, *radius);
                    add(0.0, 0.0, 0.5 * length, *radius);
                }
                // What a mesh file holds is known to those who read it.
                Form::Mesh { .. } => add(0.0, 0.0, 0.0, 0.0),
            }
        }
        Self { points }
    }

    /// Grows to hold points.
    pub(super) fn include(&mut self, points: impl Iterator<Item = Point3<f64>>) {
        let mut bounds = Bounds::default();
        points.for_each(|point| bounds.include(&point.coords, 0.0));
        if !bounds.is_empty() {
            self.points.extend(bounds.corners().map(|corner| (corner.into(), 0.0)));
        }
    }

    /// Farthest point from the root marker (m).
    #[cfg(feature = "view")]
    pub(in crate::record) fn reach(&self) -> f64 {
        self.points.iter().map(|(point, radius)| point.coords.norm() + radius).fold(0.0, f64::max)
    }
}
