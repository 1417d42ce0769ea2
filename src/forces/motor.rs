//! Motors with laws, in hinge coordinates (the laws themselves: [`crate::model::motor`]).

use crate::model::Model;
use crate::model::motor::Push;

/// What every motor pushes with at a state, in the order of the model.
pub fn pushes(model: &Model, time: f64, q: &[f64], v: &[f64], out: &mut [Push]) {
    for (push, motor) in out.iter_mut().zip(&model.motors) {
        let at = motor.coordinate;
        *push = motor.at(time, q[at.position], v[at.velocity]);
    }
}

/// Adds their forces to the hinge forces.
pub fn apply(model: &Model, pushes: &[Push], tau: &mut [f64]) {
    for (push, motor) in pushes.iter().zip(&model.motors) {
        tau[motor.coordinate.velocity] += push.force;
    }
}

/// Adds the variation of the hinge forces with `dq` and `dv`; an empty list is zero.
pub fn vary(model: &Model, pushes: &[Push], dq: &[f64], dv: &[f64], out: &mut [f64]) {
    let of = |list: &[f64], at: usize| list.get(at).copied().unwrap_or(0.0);
    for (push, motor) in pushes.iter().zip(&model.motors) {
        let at = motor.coordinate.velocity;
        out[at] += push.by_position * of(dq, at) + push.by_velocity * of(dv, at);
    }
}

/// Power put in (W).
pub(super) fn input(model: &Model, time: f64, q: &[f64], v: &[f64]) -> f64 {
    let power = |motor: &crate::model::motor::Motor| {
        let (q, v) = (q[motor.coordinate.position], v[motor.coordinate.velocity]);
        motor.at(time, q, v).force * v
    };
    model.motors.iter().map(power).sum()
}

/// The potential of what they push with at rest at t = 0 (J): of those that have one.
pub fn potential_at_rest(model: &Model, q: &[f64]) -> f64 {
    let with = model.motors.iter().filter(|motor| motor.has_potential());
    with.map(|motor| motor.potential(q[motor.coordinate.position])).sum()
}
