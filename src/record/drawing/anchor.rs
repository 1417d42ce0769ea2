//! Points of bodies that something drawn hangs on, and the poses that carry them.

use crate::spatial::Pose;
use nalgebra::{Point3, UnitQuaternion, Vector3};

/// A point of a body (`None`: the ground), in its axes.
pub(super) type Anchor = (Option<usize>, [f64; 3]);

/// The turn that takes z along a direction; none for a direction without length.
pub(super) fn toward(direction: &Vector3<f64>) -> UnitQuaternion<f64> {
    let down = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    match direction.try_normalize(0.0) {
        Some(along) => UnitQuaternion::rotation_between(&Vector3::z(), &along).unwrap_or_else(down),
        None => UnitQuaternion::identity(),
    }
}

/// The pose of a body (`None`: the ground).
pub(super) fn carried(body: Option<usize>, poses: &[Pose]) -> Pose {
    body.and_then(|body| poses.get(body)).copied().unwrap_or_default()
}

/// Where it is (m).
pub(super) fn point((body, at): &Anchor, poses: &[Pose]) -> Vector3<f64> {
    (carried(*body, poses) * Point3::from(*at)).coords
}
