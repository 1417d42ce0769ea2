//! Joints that carry nothing with mass or inertia, fixed where they start.

use super::super::log::Taken;
use super::scene::{Kind, Scene, WORLD};
use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion};

/// Fixes them, if that is asked for, and says so. A joint with an armature has a motion of its own, and keeps it.
pub(super) fn massless(scene: &mut Scene<'_>) {
    let weighs = |body: &super::scene::Body<'_>| body.mass.mass > 0.0 || body.mass.inertia != Matrix3::zeros();
    let mut heavy: Vec<bool> = scene.bodies.iter().map(weighs).collect();
    for body in (WORLD + 1..scene.bodies.len()).rev() {
        if heavy[body] {
            heavy[scene.bodies[body].parent] = true;
        } else if scene.bodies[body].joints.iter().any(|joint| scene.joints[*joint].acting.armature == 0.0) {
            fix(scene, body);
        }
    }
}

fn fix(scene: &mut Scene<'_>, body: usize) {
    let mut pose = scene.bodies[body].pose;
    for index in std::mem::take(&mut scene.bodies[body].joints) {
        let joint = &scene.joints[index];
        let anchor = Translation3::from(joint.anchor);
        let turned = |turn: UnitQuaternion<f64>| anchor * turn * anchor.inverse();
        let quaternion = |at: &[f64]| UnitQuaternion::from_quaternion(Quaternion::new(at[0], at[1], at[2], at[3]));
        let start = &joint.start[..];
        pose = match joint.kind {
            Kind::Slide => pose * Translation3::from(joint.axis * start[0]),
            Kind::Hinge => pose * turned(UnitQuaternion::from_scaled_axis(joint.axis * start[0])),
            Kind::Ball => pose * turned(quaternion(start)),
            Kind::Free => {
                Isometry3::from_parts(Translation3::new(start[0], start[1], start[2]), quaternion(&start[3..]))
            }
        };
        joint.element.note(Taken::Approximated, "it carries nothing with mass: it is fixed, as asked for");
        scene.names.joints.retain(|_, place| *place != index);
        scene.names.welded.push(joint.name.clone());
    }
    scene.bodies[body].pose = pose;
}
