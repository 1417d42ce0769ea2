//! Constant loads: dead (fixed in inertial axes) and follower (fixed in the link's axes).

use crate::model::End;
use crate::motion::Motion;
use crate::motion::point::Point;
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use nalgebra::Vector3;

pub(super) fn dead(on: &End, force: &Vector3<f64>, torque: &Vector3<f64>, motion: &Motion) -> Wrench {
    let wrench = Wrench::at_arm(*force, Point::of(on, motion).arm);
    Wrench { force: wrench.force, moment: wrench.moment + torque }
}

pub(super) fn vary_dead(on: &End, force: &Vector3<f64>, motion: &Motion, by: &[LinkVariation]) -> Wrench {
    let arm = by[on.link].turn.cross(&Point::of(on, motion).arm);
    Wrench { force: Vector3::zeros(), moment: arm.cross(force) }
}

/// A constant force has the potential `−F·x`.
pub(super) fn potential(on: &End, force: &Vector3<f64>, motion: &Motion) -> f64 {
    -force.dot(&Point::of(on, motion).position)
}

/// A follower load at the root marker: it turns with the link as a whole.
pub(super) fn follower(on: &End, force: &Vector3<f64>, torque: &Vector3<f64>, motion: &Motion) -> Wrench {
    let turn = &motion.links[on.link].turn;
    let wrench = Wrench::at_arm(turn * force, turn * on.point);
    Wrench { force: wrench.force, moment: wrench.moment + turn * torque }
}

pub(super) fn vary_follower(
    on: &End,
    force: &Vector3<f64>,
    torque: &Vector3<f64>,
    motion: &Motion,
    by: &[LinkVariation],
) -> Wrench {
    let wrench = follower(on, force, torque, motion);
    let turn = by[on.link].turn;
    Wrench { force: turn.cross(&wrench.force), moment: turn.cross(&wrench.moment) }
}

pub(super) fn follower_power(on: &End, force: &Vector3<f64>, torque: &Vector3<f64>, motion: &Motion) -> f64 {
    let wrench = follower(on, force, torque, motion);
    let link = &motion.links[on.link];
    wrench.force.dot(&link.velocity) + wrench.moment.dot(&link.angular_velocity)
}
