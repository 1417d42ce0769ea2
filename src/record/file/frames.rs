//! `/tf`: body poses as Foxglove frame transforms.

use crate::record::Scene;
use crate::spatial::Pose;
use foxglove::messages::{FrameTransform, FrameTransforms, Quaternion, Timestamp, Vector3};
use nalgebra::{Quaternion as Rotation, Translation3, UnitQuaternion};

/// Name of the inertial frame.
pub(super) fn inertial_frame(scene: &Scene) -> &'static str {
    if scene.bodies.iter().any(|body| body.name == "world") { "ground" } else { "world" }
}

/// The message for the scene's bodies, to be filled anew for every sample.
pub(super) fn transforms(scene: &Scene) -> FrameTransforms {
    // Looked up once: it goes through all bodies.
    let inertial = inertial_frame(scene);
    let transform = |name: &String| FrameTransform {
        timestamp: None,
        parent_frame_id: inertial.into(),
        child_frame_id: name.clone(),
        translation: Some(Vector3::default()),
        rotation: Some(Quaternion::default()),
    };
    FrameTransforms { transforms: scene.bodies.iter().map(|body| transform(&body.name)).collect() }
}

/// Fills in the poses.
pub(super) fn fill(message: &mut FrameTransforms, nanoseconds: u64, poses: &[Pose]) {
    let time = timestamp(nanoseconds);
    for (transform, pose) in message.transforms.iter_mut().zip(poses) {
        let (at, turn) = (&pose.translation.vector, pose.rotation.quaternion());
        transform.timestamp = Some(time);
        transform.translation = Some(Vector3 { x: at.x, y: at.y, z: at.z });
        transform.rotation = Some(Quaternion { x: turn.i, y: turn.j, z: turn.k, w: turn.w });
    }
}

/// Reads the poses back.
pub(super) fn poses(message: &FrameTransforms) -> impl Iterator<Item = Pose> {
    message.transforms.iter().map(|transform| {
        let at = transform.translation.unwrap_or_default();
        let turn = transform.rotation.unwrap_or_default();
        // Not normalised: the recording gives back what was written.
        let turn = UnitQuaternion::new_unchecked(Rotation::new(turn.w, turn.x, turn.y, turn.z));
        Pose::from_parts(Translation3::new(at.x, at.y, at.z), turn)
    })
}

/// A message's own time; Foxglove's clock ends after 136 years.
pub(super) fn timestamp(nanoseconds: u64) -> Timestamp {
    let seconds = u32::try_from(nanoseconds / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, (nanoseconds % 1_000_000_000) as u32)
}
