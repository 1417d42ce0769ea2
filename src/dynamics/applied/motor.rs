//! What pushes single hinge coordinates: motors with laws (the laws themselves: [`crate::model::motor`]), then springs and
//! dampers by tables.

use super::Laws;
use crate::model::Model;
use crate::model::motor::{Motor, Push};

/// What everything that pushes a single coordinate does at a state, in the order of [`Model::pushed`].
pub fn pushes(model: &Model, laws: &Laws, time: f64, q: &[f64], v: &[f64], out: &mut [Push]) {
    let (motors, curves) = out.split_at_mut(model.motors.len());
    for ((index, push), motor) in motors.iter_mut().enumerate().zip(&model.motors) {
        let at = motor.coordinate;
        *push = motor.within(laws.pieces(index), time, q[at.position], v[at.velocity]);
    }
    for (index, force) in model.inputs.iter().zip(&laws.inputs) {
        motors[*index] = model.motors[*index].saturated(*force);
    }
    for (push, curve) in curves.iter_mut().zip(laws.curves.iter()) {
        *push = super::curve::push(curve, q, v);
    }
}

/// Adds their forces to the hinge forces.
pub fn apply(model: &Model, pushes: &[Push], tau: &mut [f64]) {
    for (push, coordinate) in pushes.iter().zip(model.pushed()) {
        tau[coordinate.velocity] += push.force;
    }
}

/// Adds the variation of the hinge forces with `dq` and `dv`; an empty list is zero.
pub fn vary(model: &Model, pushes: &[Push], dq: &[f64], dv: &[f64], out: &mut [f64]) {
    let of = |list: &[f64], at: usize| list.get(at).copied().unwrap_or(0.0);
    for (push, coordinate) in pushes.iter().zip(model.pushed()) {
        let at = coordinate.velocity;
        out[at] += push.by_position * of(dq, at) + push.by_velocity * of(dv, at);
    }
}

/// Power put in (W).
pub(super) fn input(model: &Model, laws: &Laws, time: f64, q: &[f64], v: &[f64]) -> f64 {
    let own = |index: usize, motor: &Motor| match motor.given() {
        Some(_) => 0.0,
        None => {
            let at = motor.coordinate;
            motor.within(laws.pieces(index), time, q[at.position], v[at.velocity]).force
        }
    };
    let power = |motor: &Motor, force: f64| force * v[motor.coordinate.velocity];
    let inputs = model.inputs.iter().map(|index| &model.motors[*index]).zip(&laws.inputs);
    model.motors.iter().enumerate().map(|(index, motor)| power(motor, own(index, motor))).sum::<f64>()
        + inputs.map(|(motor, force)| power(motor, motor.saturated(*force).force)).sum::<f64>()
}

/// The potential of what they push with at rest at t = 0 (J): of those that have one.
pub fn potential_at_rest(model: &Model, q: &[f64]) -> f64 {
    let with = model.motors.iter().filter(|motor| motor.has_potential());
    with.map(|motor| motor.potential(q[motor.coordinate.position])).sum()
}
