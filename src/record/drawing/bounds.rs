//! How much room bodies and lines take.

use crate::record::scene::CurvePicture;
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

    /// Grows to hold a disc with this unit axis.
    fn include_disc(&mut self, center: &Vector3<f64>, axis: &Vector3<f64>, radius: f64) {
        let reach = axis.map(|cosine| radius * (1.0 - cosine * cosine).max(0.0).sqrt());
        self.include(&(center - reach), 0.0);
        self.include(&(center + reach), 0.0);
    }

    /// Grows to hold the bodies' solids at one instant.
    pub(in crate::record) fn include_bodies(&mut self, outlines: &[Outline], poses: &[Pose]) {
        outlines.iter().zip(poses).for_each(|(outline, pose)| self.include_body(outline, pose));
    }

    /// Grows to hold a body at one instant.
    pub(in crate::record) fn include_body(&mut self, outline: &Outline, pose: &Pose) {
        for (point, radius) in &outline.points {
            self.include(&(pose * point).coords, *radius);
        }
        for (center, axis, radius) in &outline.discs {
            self.include_disc(&(pose * center).coords, &(pose * axis), *radius);
        }
    }

    /// Grows to hold points of bodies (`None`: the ground) at one instant.
    pub(in crate::record) fn include_ends<'e>(
        &mut self,
        ends: impl IntoIterator<Item = &'e (Option<usize>, [f64; 3])>,
        poses: &[Pose],
    ) {
        for (body, point) in ends {
            let pose = body.and_then(|body| poses.get(body)).copied().unwrap_or_default();
            self.include(&(pose * Point3::from(*point)).coords, 0.0);
        }
    }

    /// Grows to hold a curve at one instant.
    pub(in crate::record) fn include_curve(&mut self, curve: &CurvePicture, poses: &[Pose]) {
        let pose = curve.body.and_then(|body| poses.get(body)).copied().unwrap_or_default();
        curve.points.iter().for_each(|at| self.include(&(pose * Point3::from(*at)).coords, 0.0));
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

/// A body's outermost parts, body axes.
#[derive(Debug, Clone, Default)]
pub(in crate::record) struct Outline {
    /// Points, each with the radius of a ball about it (m).
    points: Vec<(Point3<f64>, f64)>,
    /// Centres, unit axes and radii (m) of the ends of cylinders.
    discs: Vec<(Point3<f64>, Vector3<f64>, f64)>,
}

impl Outline {
    /// Of a body's solids.
    pub(in crate::record) fn new(solids: &[Solid]) -> Self {
        let (mut points, mut discs) = (Vec::new(), Vec::new());
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
                Form::Cylinder { radius, length } => {
                    let end = |side: f64| solid.pose * Point3::new(0.0, 0.0, 0.5 * side * length);
                    discs.extend([-1.0, 1.0].map(|side| (end(side), solid.pose * Vector3::z(), *radius)));
                }
                Form::Capsule { radius, length } => {
                    add(0.0, 0.0, -0.5 * length, *radius);
                    add(0.0, 0.0, 0.5 * length, *radius);
                }
                // What a mesh file holds is known to those who read it.
                Form::Mesh { .. } => add(0.0, 0.0, 0.0, 0.0),
            }
        }
        Self { points, discs }
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
    pub(in crate::record) fn reach(&self) -> f64 {
        let discs = self.discs.iter().map(|(center, _, radius)| (center, radius));
        let points = self.points.iter().map(|(point, radius)| (point, radius));
        points.chain(discs).map(|(point, radius)| point.coords.norm() + radius).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::solids::Solid;
    use nalgebra::{Isometry3, Translation3, UnitQuaternion};

    /// Against points of both rims, a tenth of a degree apart.
    #[test]
    fn a_cylinder_takes_the_room_of_its_rims() {
        for k in 0..50 {
            let t = f64::from(k);
            let turn = UnitQuaternion::from_euler_angles(1.7 * t, 0.9 * t, 2.3 * t);
            let pose = Isometry3::from_parts(
                Translation3::new(0.1 * t, -0.2, 0.3),
                if k == 0 { UnitQuaternion::identity() } else { turn },
            );
            let (radius, length) = (0.08 + 0.01 * t, 0.4);
            let form = Form::Cylinder { radius, length };
            let solid =
                Solid { form, pose: Isometry3::identity(), color: [1.0; 4], own_color: false, unbounded: false };
            let mut bounds = Bounds::default();
            bounds.include_bodies(&[Outline::new(&[solid])], &[pose]);
            let mut rims = Bounds::default();
            for step in 0..3600 {
                let (sin, cos) = (f64::from(step) * 0.1f64.to_radians()).sin_cos();
                for side in [-0.5, 0.5] {
                    rims.include(&(pose * Point3::new(radius * cos, radius * sin, side * length)).coords, 0.0);
                }
            }
            let apart = (bounds.min - rims.min).amax().max((bounds.max - rims.max).amax());
            assert!(apart < 1e-6 * radius.max(length), "{k}: {bounds:?} {rims:?}");
        }
    }
}
