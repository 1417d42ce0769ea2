//! Where to look from.

use super::bounds::Bounds;
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
    // 25° beside that direction, 15° above the horizon.
    let turn = if size.x < size.y { -25f64 } else { -65f64 }.to_radians();
    let rise = 15f64.to_radians();
    let back = Vector3::new(rise.cos() * turn.cos(), rise.cos() * turn.sin(), rise.sin());
    let right = Vector3::z().cross(&back).normalize();
    let up = back.cross(&right);
    let slope = (0.5 * FIELD).tan();
    let far = |corner: &Vector3<f64>| {
        let offset = corner - target;
        offset.dot(&back) + MARGIN * offset.dot(&right).abs().max(offset.dot(&up).abs()) / slope
    };
    let distance = bounds.corners().iter().map(far).fold(0.1 * largest, f64::max);
    let below = bounds.min.z < -0.01 * largest || bounds.min.z > largest;
    Camera {
        eye: target + distance * back,
        target,
        floor: if below && bounds.min.z.is_finite() { bounds.min.z } else { 0.0 },
        spacing: round_down(largest / 8.0),
    }
}

/// 1, 2 or 5 times a power of ten.
fn round_down(length: f64) -> f64 {
    let decade = 10f64.powf(length.log10().floor());
    [5.0, 2.0].into_iter().map(|step| step * decade).find(|step| *step <= length).unwrap_or(decade)
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

    #[test]
    fn grid_lines_stand_at_round_distances() {
        let round = [0.13, 0.2, 0.49, 7.0, 1000.0].map(round_down);
        assert_eq!(round, [0.1, 0.2, 0.2, 5.0, 1000.0]);
    }
}
