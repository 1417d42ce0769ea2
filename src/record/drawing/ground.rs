//! Where to look from, and the ground under what is seen.

use super::bounds::Bounds;
use nalgebra::Vector3;

/// The ground under a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::record) struct Ground {
    /// Its height (m).
    pub(in crate::record) floor: f64,
    /// Distance of the lines of its grid (m).
    pub(in crate::record) spacing: f64,
}

impl Ground {
    /// At height zero, unless the scene reaches below it or is far above.
    pub(in crate::record) fn under(bounds: &Bounds) -> Self {
        let largest = bounds.size().max().max(1e-6);
        let apart = bounds.min.z < -0.01 * largest || bounds.min.z > largest;
        let floor = if apart && bounds.min.z.is_finite() { bounds.min.z } else { 0.0 };
        Self { floor, spacing: round_down(largest / 8.0) }
    }
}

/// From the scene to the eye, a unit vector: a little from above, and across the direction in which the bounds are thinnest, so that a
/// plane motion is seen from its side.
pub(in crate::record) fn back(bounds: &Bounds) -> Vector3<f64> {
    // 25° beside that direction, 15° above the horizon.
    let size = bounds.size();
    let turn = if size.x < size.y { -25f64 } else { -65f64 }.to_radians();
    let rise = 15f64.to_radians();
    Vector3::new(rise.cos() * turn.cos(), rise.cos() * turn.sin(), rise.sin())
}

/// 1, 2 or 5 times a power of ten.
pub(in crate::record) fn round_down(length: f64) -> f64 {
    let decade = 10f64.powf(length.log10().floor());
    [5.0, 2.0].into_iter().map(|step| step * decade).find(|step| *step <= length).unwrap_or(decade)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_lines_stand_at_round_distances() {
        let round = [0.13, 0.2, 0.49, 7.0, 1000.0].map(round_down);
        assert_eq!(round, [0.1, 0.2, 0.2, 5.0, 1000.0]);
    }
}
