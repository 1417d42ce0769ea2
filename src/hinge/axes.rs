//! Axes that hinges are given: their checks, and unit vectors across them.

use nalgebra::{Matrix3, Vector3};

/// Takes a key, what is wrong with it, and what is allowed.
pub type Say<'s> = &'s mut dyn FnMut(&'static str, String, &'static str);

/// Says so if the one axis of a hinge has no direction.
pub(super) fn check_axis(axis: &Vector3<f64>, owner: &str, say: Say<'_>) {
    if has_no_direction(axis) {
        let message = format!("the axis of the {owner} is [{}, {}, {}]", axis.x, axis.y, axis.z);
        say("axis", message, "allowed: a finite vector that is not zero");
    }
}

/// Whether an axis is zero or not finite.
pub(super) fn has_no_direction(axis: &Vector3<f64>) -> bool {
    !axis.iter().all(|x| x.is_finite()) || axis.norm() == 0.0
}

/// Two unit vectors across an axis, and its own; coordinate axes if they are perpendicular to it.
pub(super) fn around(axis: &Vector3<f64>) -> [Vector3<f64>; 3] {
    let n = axis.normalize();
    let t = Vector3::ith(n.iamin(), 1.0);
    let t = (t - n * n.dot(&t)).normalize();
    let all = Matrix3::from_columns(&[t, n.cross(&t), n]);
    [all.column(0).into(), all.column(1).into(), all.column(2).into()]
}

/// The three axes of the hinge frame.
pub(super) fn frame() -> [Vector3<f64>; 3] {
    [Vector3::x(), Vector3::y(), Vector3::z()]
}
