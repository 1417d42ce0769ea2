//! Where to look from.

use crate::record::drawing::bounds::Bounds;
use crate::record::drawing::ground::{Ground, back};
use nalgebra::Vector3;

/// Vertical field of view of the viewer's eye (rad).
const FIELD: f64 = 55.0 / 180.0 * std::f64::consts::PI;
/// Room left around the motion.
const MARGIN: f64 = 1.12;

/// An eye and the ground under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Camera {
    pub(super) eye: Vector3<f64>,
    pub(super) target: Vector3<f64>,
    /// Height of the ground grid (m).
    pub(super) floor: f64,
    /// Distance of its lines (m).
    pub(super) spacing: f64,
}

/// Sees the whole of the bounds, a little from above, and across the direction in which they are thinnest, so that a
/// plane motion is seen from its side.
pub(super) fn camera(bounds: &Bounds) -> Camera {
    let (size, target) = (bounds.size(), bounds.center());
    let largest = size.max().max(1e-6);
    let back = back(bounds);
    let right = Vector3::z().cross(&back).normalize();
    let up = back.cross(&right);
    let slope = (0.5 * FIELD).tan();
    let far = |corner: &Vector3<f64>| {
        let offset = corner - target;
        offset.dot(&back) + MARGIN * offset.dot(&right).abs().max(offset.dot(&up).abs()) / slope
    };
    let distance = bounds.corners().iter().map(far).fold(0.1 * largest, f64::max);
    let Ground { floor, spacing } = Ground::under(bounds);
    Camera { eye: target + distance * back, target, floor, spacing }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eye_sees_every_corner() {
        let boxes =
            [([0.0; 3], [1.0; 3]), ([-5.0, 2.0, -3.0], [-4.9, 9.0, 3.0]), ([0.0, 0.0, 10.0], [100.0, 0.0, 10.0])];
        for (min, max) in boxes {
            let mut bounds = Bounds::default();
            bounds.include(&min.into(), 0.0);
            bounds.include(&max.into(), 0.0);
            let camera = camera(&bounds);
            let ahead = (camera.target - camera.eye).normalize();
            for corner in bounds.corners() {
                let depth = (corner - camera.eye).dot(&ahead);
                let aside = (corner - camera.eye - depth * ahead).norm();
                // The frame is a square about the circle of the field of view.
                assert!(aside <= 2f64.sqrt() * depth * (0.5 * FIELD).tan() / MARGIN * (1.0 + 1e-12), "{corner}");
            }
        }
    }
}
