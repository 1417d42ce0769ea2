//! How much room a motion takes.

use crate::record::Scene;
use crate::record::solids::{Form, Solid};
use crate::spatial::Pose;
use nalgebra::{Point3, Vector3};

/// A box along the inertial axes; empty at first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub(super) min: Vector3<f64>,
    pub(super) max: Vector3<f64>,
}

impl Default for Bounds {
    fn default() -> Self {
        Self { min: Vector3::repeat(f64::INFINITY), max: Vector3::repeat(f64::NEG_INFINITY) }
    }
}

impl Bounds {
    /// Grows to hold a ball; balls at no finite place are passed over.
    pub(super) fn include(&mut self, center: &Vector3<f64>, radius: f64) {
        if center.iter().all(|x| x.is_finite()) && radius.is_finite() {
            self.min = self.min.inf(&center.add_scalar(-radius));
            self.max = self.max.sup(&center.add_scalar(radius));
        }
    }

    /// Grows to hold the bodies' solids at one instant.
    pub(super) fn include_bodies(&mut self, outlines: &[Outline], poses: &[Pose]) {
        for (outline, pose) in outlines.iter().zip(poses) {
            for (point, radius) in &outline.points {
                self.include(&(pose * point).coords, *radius);
            }
        }
    }

    /// Middle; the origin when empty.
    pub(super) fn center(&self) -> Vector3<f64> {
        if self.is_empty() { Vector3::zeros() } else { 0.5 * (self.min + self.max) }
    }

    /// Edge lengths; a metre each when empty.
    pub(super) fn size(&self) -> Vector3<f64> {
        if self.is_empty() { Vector3::repeat(1.0) } else { self.max - self.min }
    }

    pub(super) fn corners(&self) -> [Vector3<f64>; 8] {
        let (center, half) = (self.center(), 0.5 * self.size());
        std::array::from_fn(|k| {
            let side = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
            center + half.component_mul(&Vector3::new(side(0), side(1), side(2)))
        })
    }

    fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }
}

/// A body's outermost points, body axes, each with the radius of a ball about it.
#[derive(Debug, Clone, Default)]
pub(super) struct Outline {
    points: Vec<(Point3<f64>, f64)>,
}

impl Outline {
    /// Of a body's solids.
    pub(super) fn new(solids: &[Solid]) -> Self {
        let mut points = Vec::new();
        for solid in solids {
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
                // What a mesh file holds is the viewer's knowledge.
                Form::Mesh { .. } => add(0.0, 0.0, 0.0, 0.0),
            }
        }
        Self { points }
    }

    /// Farthest point from the root marker (m).
    pub(super) fn reach(&self) -> f64 {
        self.points.iter().map(|(point, radius)| point.coords.norm() + radius).fold(0.0, f64::max)
    }
}

/// A guess at the room of a motion of which only the start is known: the start, and about every hinge point on the
/// ground a ball as wide as its tree can stretch. Trees that can leave (`free` and sliding hinges) get room to do so.
pub(super) fn expected(scene: &Scene, outlines: &[Outline], poses: &[Pose]) -> Bounds {
    let mut bounds = Bounds::default();
    bounds.include_bodies(outlines, poses);
    let reach = tree_reaches(scene, outlines);
    for (index, body) in scene.bodies.iter().enumerate().filter(|(_, body)| body.parent.is_none()) {
        match body.hinge.as_str() {
            "revolute" | "universal" | "spherical" => bounds.include(&body.hinge_at.into(), reach[index]),
            "fixed" => {}
            _ => bounds.include(&poses[index].translation.vector, 1.5 * reach[index]),
        }
    }
    bounds
}

/// How far from its root marker each body's subtree can stretch.
fn tree_reaches(scene: &Scene, outlines: &[Outline]) -> Vec<f64> {
    let mut children = vec![Vec::new(); scene.bodies.len()];
    let mut order = Vec::new();
    for (index, body) in scene.bodies.iter().enumerate() {
        match body.parent {
            Some(parent) => children[parent].push(index),
            None => order.push(index),
        }
    }
    let mut next = 0;
    while next < order.len() {
        order.extend(&children[order[next]]);
        next += 1;
    }
    let mut reach: Vec<f64> = outlines.iter().map(Outline::reach).collect();
    for &index in order.iter().rev() {
        if let Some(parent) = scene.bodies[index].parent {
            let through = Vector3::from(scene.bodies[index].hinge_at).norm() + reach[index];
            reach[parent] = reach[parent].max(through);
        }
    }
    reach
}
