//! The inertia that joints feel at their references, for what MuJoCo derives from it.

use super::super::log::Taken;
use super::scene::{Kind, Scene};
use nalgebra::{DMatrix, Isometry3, Vector3};

/// The inertia matrix at the references of all joints, and where each joint begins in it.
pub(super) fn matrix(scene: &Scene<'_>) -> (DMatrix<f64>, Vec<usize>) {
    let mut first = vec![0; scene.joints.len()];
    let mut count = 0;
    for joint in scene.in_order() {
        first[joint] = count;
        count += scene.joints[joint].kind.counts().1;
    }
    let poses = scene.poses(|_| 0.0);
    let mut matrix = DMatrix::zeros(count, count);
    for (index, body) in scene.bodies.iter().enumerate().filter(|(_, body)| body.mass.mass > 0.0) {
        let center = (poses[index] * nalgebra::Point3::from(body.mass.center)).coords;
        let turn = poses[index].rotation.to_rotation_matrix();
        let inertia = turn * body.mass.inertia * turn.transpose();
        let columns = columns(scene, &poses, &first, index, &center);
        for (i, linear, angular) in &columns {
            for (j, other_linear, other_angular) in &columns {
                matrix[(*i, *j)] += body.mass.mass * linear.dot(other_linear) + angular.dot(&(inertia * other_angular));
            }
        }
    }
    for (joint, first) in scene.joints.iter().zip(&first) {
        for at in 0..joint.kind.counts().1 {
            matrix[(first + at, first + at)] += joint.acting.armature;
        }
    }
    (matrix, first)
}

/// What every velocity that moves a body does to its centre of mass and to its turning.
fn columns(
    scene: &Scene<'_>,
    poses: &[Isometry3<f64>],
    first: &[usize],
    body: usize,
    center: &Vector3<f64>,
) -> Vec<(usize, Vector3<f64>, Vector3<f64>)> {
    let mut columns = Vec::new();
    let mut at = body;
    while at != super::scene::WORLD {
        let pose = &poses[at];
        for &index in &scene.bodies[at].joints {
            let joint = &scene.joints[index];
            let anchor = (pose * nalgebra::Point3::from(joint.anchor)).coords;
            let axis = pose.rotation * joint.axis;
            let turned = |axis: Vector3<f64>| (axis.cross(&(center - anchor)), axis);
            match joint.kind {
                Kind::Slide => columns.push((first[index], axis, Vector3::zeros())),
                Kind::Hinge => columns.push((first[index], turned(axis).0, axis)),
                Kind::Ball | Kind::Free => {
                    let mut next = first[index];
                    if joint.kind == Kind::Free {
                        for unit in [Vector3::x(), Vector3::y(), Vector3::z()] {
                            columns.push((next, unit, Vector3::zeros()));
                            next += 1;
                        }
                    }
                    for unit in [Vector3::x(), Vector3::y(), Vector3::z()] {
                        let (linear, angular) = turned(pose.rotation * unit);
                        columns.push((next, linear, angular));
                        next += 1;
                    }
                }
            }
        }
        at = scene.bodies[at].parent;
    }
    columns
}

/// `springdamper`: a stiffness and a damping that give the joint this time constant and damping ratio, with the inertia
/// that it shows at its reference when nothing else is held.
pub(super) fn spring_dampers(scene: &mut Scene<'_>) {
    if scene.joints.iter().all(|joint| joint.spring_damper.is_none()) {
        return;
    }
    let (matrix, first) = matrix(scene);
    let inverse = matrix.cholesky().map(|factors| factors.inverse());
    let (springs, dampers) = (scene.settings.springs, scene.settings.dampers);
    for (joint, first) in scene.joints.iter_mut().zip(first) {
        let Some([time, ratio]) = joint.spring_damper else { continue };
        let Some(inverse) = &inverse else {
            joint.element.note(Taken::Ignored, "`springdamper`: the model has no inertia to reckon it from");
            continue;
        };
        let count = joint.kind.counts().1;
        let inertia = count as f64 / (0..count).map(|at| inverse[(first + at, first + at)]).sum::<f64>();
        let [stiffness, damping] = [inertia / (time * ratio).powi(2), 2.0 * inertia / time];
        let what = format!("`springdamper`: stiffness {stiffness} and damping {damping}, from the inertia {inertia}");
        joint.element.note(Taken::Used, what);
        if springs {
            joint.acting.spring(stiffness, joint.relaxed);
        }
        if dampers {
            joint.acting.damping += damping;
        }
    }
}

/// What inertia a scalar joint shows at its reference when nothing else is held, if that can be told.
pub(super) fn apparent(scene: &Scene<'_>, joint: usize) -> Option<f64> {
    let (matrix, first) = matrix(scene);
    let mut unit = nalgebra::DVector::zeros(matrix.nrows());
    unit[first[joint]] = 1.0;
    let response = matrix.cholesky()?.solve(&unit)[first[joint]];
    (response > 0.0 && response.is_finite()).then(|| 1.0 / response)
}
