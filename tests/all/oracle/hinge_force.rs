//! Hinge forces: motor, damper and spring in every velocity of a hinge.

use super::force::torsion;
use super::place::{position_of, quaternion, rest_of, velocity_of};
use nalgebra::Vector3;
use stillpoint::model::description::{HingeDescription, HingeKind};

/// One force per velocity.
pub(crate) fn of(hinge: &HingeDescription) -> Vec<f64> {
    let (q, rest, v) = (position_of(hinge), rest_of(hinge), velocity_of(hinge));
    let value = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(0.0);
    let mut forces: Vec<f64> =
        v.iter().enumerate().map(|(i, v)| value(&hinge.force, i) - value(&hinge.damping, i) * v).collect();
    let plain = match hinge.kind {
        HingeKind::Spherical => 0,
        HingeKind::Free => 3,
        _ => v.len(),
    };
    for (i, force) in forces.iter_mut().enumerate().take(plain) {
        *force -= value(&hinge.stiffness, i) * (q[i] - rest[i]);
    }
    if plain < v.len() {
        let stiffness = Vector3::from_fn(|i, _| value(&hinge.stiffness, plain + i));
        let turn = quaternion(&rest[plain..]).inverse() * quaternion(&q[plain..]);
        let torque = torsion(&turn, &stiffness);
        (0..3).for_each(|i| forces[plain + i] += torque[i]);
    }
    forces
}
