//! Positions and orientations as MJCF writes them.

use super::defaults::Settled;
use super::settings::Settings;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

/// Shorter vectors have no direction.
const SHORTEST: f64 = 1e-14;

/// `pos` and any of the orientations.
pub(super) fn pose(element: &Settled<'_>, settings: &Settings) -> Isometry3<f64> {
    let at = element.vector("pos").map_or_else(Vector3::zeros, Vector3::from);
    Isometry3::from_parts(Translation3::from(at), orientation(element, settings).unwrap_or_default())
}

/// `quat`, `axisangle`, `euler`, `xyaxes` or `zaxis`.
pub(super) fn orientation(element: &Settled<'_>, settings: &Settings) -> Option<UnitQuaternion<f64>> {
    let keys = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];
    let own = |key: &&&str| element.element.attribute(key).is_some();
    let written: Vec<&&str> = keys.iter().filter(own).collect();
    if let [_, second, ..] = written[..] {
        let attribute = element.element.attribute(second)?;
        let problem = attribute.wrong(&format!("is written beside `{}`", written[0]));
        element.element.refuse(problem.help("one orientation is enough: keep one of the two"));
        return None;
    }
    let key = written.first().copied().or_else(|| keys.iter().find(|key| element.attribute(key).is_some()))?;
    match *key {
        "quat" => {
            let [w, x, y, z] = element.vector("quat")?;
            let quaternion = nalgebra::Quaternion::new(w, x, y, z);
            nonzero(element, key, quaternion.norm())?;
            Some(UnitQuaternion::from_quaternion(quaternion))
        }
        "axisangle" => {
            let [x, y, z, angle] = element.vector("axisangle")?;
            let axis = Vector3::new(x, y, z);
            nonzero(element, key, axis.norm())?;
            Some(UnitQuaternion::from_axis_angle(&Unit::new_normalize(axis), angle * settings.angle))
        }
        "euler" => Some(euler(Vector3::from(element.vector("euler")?), settings)),
        "xyaxes" => {
            let [a, b, c, d, e, f] = element.vector("xyaxes")?;
            let (x, y) = (Vector3::new(a, b, c), Vector3::new(d, e, f));
            nonzero(element, key, x.norm())?;
            let x = x.normalize();
            let y = y - x * x.dot(&y);
            nonzero(element, key, y.norm())?;
            let y = y.normalize();
            let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
            Some(UnitQuaternion::from_rotation_matrix(&turn))
        }
        _ => {
            let axis = Vector3::from(element.vector("zaxis")?);
            nonzero(element, key, axis.norm())?;
            Some(from_z_to(&axis))
        }
    }
}

fn nonzero(element: &Settled<'_>, key: &str, norm: f64) -> Option<()> {
    if norm > SHORTEST && norm.is_finite() {
        return Some(());
    }
    let attribute = element.attribute(key)?;
    attribute.element.refuse(attribute.wrong(&format!("is \"{}\", which has no direction", attribute.value)));
    None
}

/// Turns about axes that go along (lower case letters) or stay (upper case), one after the other.
pub(super) fn euler(angles: Vector3<f64>, settings: &Settings) -> UnitQuaternion<f64> {
    let mut turn = UnitQuaternion::identity();
    for (angle, letter) in angles.iter().zip(settings.euler) {
        let axis = match letter.to_ascii_lowercase() {
            'x' => Vector3::x_axis(),
            'y' => Vector3::y_axis(),
            _ => Vector3::z_axis(),
        };
        let next = UnitQuaternion::from_axis_angle(&axis, angle * settings.angle);
        turn = if letter.is_ascii_lowercase() { turn * next } else { next * turn };
    }
    turn
}

/// The shortest turn that takes z there.
pub(super) fn from_z_to(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    let across = Vector3::z().cross(axis);
    let sine = across.norm();
    let about = if sine < 1e-10 * axis.norm() { Vector3::x() } else { across };
    UnitQuaternion::from_axis_angle(&Unit::new_normalize(about), sine.atan2(axis.z))
}

/// Roll, pitch, yaw, exact also where pitch is ±90°: after the yaw is taken off, whatever it is, two angles are left.
pub(super) fn roll_pitch_yaw(turn: &UnitQuaternion<f64>) -> Vector3<f64> {
    let r = turn.to_rotation_matrix();
    let yaw = r[(1, 0)].atan2(r[(0, 0)]);
    let rest = Rotation3::from_axis_angle(&Vector3::z_axis(), -yaw) * r;
    let pitch = (-rest[(2, 0)]).atan2(rest[(0, 0)]);
    let roll = (-rest[(1, 2)]).atan2(rest[(1, 1)]);
    Vector3::new(roll, pitch, yaw)
}

/// A vector without the round-off of turning it.
pub(super) fn clean(vector: Vector3<f64>) -> [f64; 3] {
    let noise = 1e-15 * vector.amax();
    // Also −0 becomes 0.
    [vector.x, vector.y, vector.z].map(|part| if part.abs() <= noise { 0.0 } else { part })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roll_pitch_yaw_come_back_also_near_the_pole() {
        let half = std::f64::consts::FRAC_PI_2;
        for pitch in [0.3, -1.2, half, -half, half - 1e-9, half + 1e-12, -half + 1e-15] {
            for (roll, yaw) in [(0.1, 0.7), (-2.0, 3.0), (0.0, 0.0), (1.0, -1.0)] {
                let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
                let rpy = roll_pitch_yaw(&turn);
                let back = UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z);
                // Round-off of a few products of sines.
                assert!(back.angle_to(&turn) < 1e-14 || (back.coords.dot(&turn.coords).abs() - 1.0).abs() < 1e-15);
                let off = (back.to_rotation_matrix().matrix() - turn.to_rotation_matrix().matrix()).norm();
                assert!(off < 2e-15, "{roll} {pitch} {yaw}: {off}");
            }
        }
    }
}
