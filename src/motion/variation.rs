//! The variation of the motion in one direction: the outward sweep, differentiated.
//!
//! Every line is the variation of one of the outward sweep of the parent module: an axis turns with the parent (`δn = δθ_P × n`), a link's
//! vectors with the link (`δc = δθ × c`).

use super::{LinkMotion, Motion};
use crate::element::{RodDirection, RodPoint};
use crate::model::{Joint, Link, Model};
pub use crate::spatial::link::{LinkAcceleration, LinkVariation};
use nalgebra::Vector3;

/// A direction in which hinge coordinates, velocities and accelerations vary. Turns of balls are given as small turns
/// in link axes, so all three have one number per velocity. An empty list is zero.
#[derive(Debug, Clone, Copy, Default)]
pub struct Direction<'a> {
    /// δq
    pub position: &'a [f64],
    /// δq̇
    pub velocity: &'a [f64],
    /// δq̈
    pub acceleration: &'a [f64],
}

#[inline]
fn one(list: &[f64], at: usize) -> f64 {
    if list.is_empty() { 0.0 } else { list[at] }
}

#[inline]
fn three(list: &[f64], at: usize) -> Vector3<f64> {
    if list.is_empty() { Vector3::zeros() } else { Vector3::new(list[at], list[at + 1], list[at + 2]) }
}

/// Root → tips over `range` of links: `out[i]` from the parents' variations. `v̇` are the hinge accelerations and
/// `accelerations` the links' ones at the point of differentiation.
pub fn outward(
    model: &Model,
    motion: &Motion,
    accelerations: &[LinkAcceleration],
    hinge_accelerations: &[f64],
    by: &Direction<'_>,
    range: std::ops::Range<usize>,
    out: &mut [LinkVariation],
) {
    for index in range {
        let link = &model.links[index];
        if let Some(rod) = link.joint.rod() {
            let point = rod_point(motion, link, &accelerations[link.parent], hinge_accelerations);
            let (at, mut tip) = (&motion.rods[rod], LinkVariation::default());
            let by = rod_direction(link, by);
            at.vary(&model.rods[rod], &point, &by, &out[link.parent], |_, varied| tip = *varied);
            out[index] = tip;
            continue;
        }
        if let Some((modal, tip)) = link.joint.interface() {
            let (at, frame) = (&motion.modals[modal], &model.links[link.parent]);
            let carried = (&motion.links[link.parent], &accelerations[link.parent]);
            let second = &hinge_accelerations[frame.velocity..frame.velocity + frame.joint.counts().1];
            let by = modal_direction(frame, by);
            let given = &model.modals[modal].modal.tips[tip];
            out[index] = at.tips[tip].vary(given, carried, [&at.q, &at.v, second], &out[link.parent], by);
            continue;
        }
        let parent = (&motion.links[link.parent], &accelerations[link.parent], out[link.parent]);
        out[index] = outboard(link, &motion.links[index], parent, hinge_accelerations, by);
    }
}

/// The part of a direction in an element's own coordinates.
pub(crate) fn rod_direction<'a>(link: &Link, by: &Direction<'a>) -> RodDirection<'a> {
    let own = link.velocity..link.velocity + link.joint.counts().1;
    let part = |list: &'a [f64]| list.get(own.clone()).unwrap_or(&[]);
    RodDirection { position: part(by.position), velocity: part(by.velocity), acceleration: part(by.acceleration) }
}

/// The part of a direction in the coordinates of a modal body, by the link of its frame.
pub(crate) fn modal_direction<'a>(frame: &Link, by: &Direction<'a>) -> [&'a [f64]; 3] {
    let own = frame.velocity..frame.velocity + frame.joint.counts().1;
    let part = |list: &'a [f64]| list.get(own.clone()).unwrap_or(&[]);
    [by.position, by.velocity, by.acceleration].map(part)
}

/// What an element's motion varies about.
pub(crate) fn rod_point<'a>(
    motion: &'a Motion,
    link: &Link,
    acceleration: &'a LinkAcceleration,
    hinge_accelerations: &'a [f64],
) -> RodPoint<'a> {
    let own = link.velocity..link.velocity + link.joint.counts().1;
    RodPoint { parent: &motion.links[link.parent], acceleration, second: &hinge_accelerations[own] }
}

fn outboard(
    link: &Link,
    own: &LinkMotion,
    parent: (&LinkMotion, &LinkAcceleration, LinkVariation),
    hinge_accelerations: &[f64],
    by: &Direction<'_>,
) -> LinkVariation {
    let (carrier, acceleration, p) = parent;
    let (w, dw, d) = (carrier.angular_velocity, p.angular_velocity, own.arm);
    let at = link.velocity;
    let mut delta_arm = p.turn.cross(&d);
    let mut turn = p.turn;
    // Relative motion: along the axis (slip) and about it (spin); and their rates.
    let (mut slip, mut spin) = (Vector3::zeros(), Vector3::zeros());
    let (mut delta_slip, mut delta_spin) = (Vector3::zeros(), Vector3::zeros());
    let (mut delta_slip_rate, mut delta_spin_rate) = (Vector3::zeros(), Vector3::zeros());
    match link.joint {
        // Of elements and interfaces see `outward`; the frame of a modal body does not move with its coordinates.
        Joint::None | Joint::Flex { .. } | Joint::Along { .. } | Joint::Modal { .. } | Joint::Interface { .. } => {}
        Joint::Turn | Joint::Screw { .. } => {
            let (n, dn) = (own.axis, p.turn.cross(&own.axis));
            turn += n * one(by.position, at);
            spin = own.relative;
            delta_spin = p.turn.cross(&spin) + n * one(by.velocity, at);
            delta_spin_rate = dn * hinge_accelerations[at] + n * one(by.acceleration, at);
            if let Joint::Screw { pitch } = link.joint {
                delta_arm += pitch * n * one(by.position, at);
                (slip, delta_slip) = (pitch * spin, pitch * delta_spin);
                delta_slip_rate = pitch * delta_spin_rate;
            }
        }
        Joint::Slide { .. } => {
            let (n, dn) = (own.axis, p.turn.cross(&own.axis));
            delta_arm += n * one(by.position, at);
            slip = own.relative;
            delta_slip = p.turn.cross(&slip) + n * one(by.velocity, at);
            delta_slip_rate = dn * hinge_accelerations[at] + n * one(by.acceleration, at);
        }
        Joint::Ball { .. } => {
            turn += own.turn * three(by.position, at);
            spin = own.relative;
            let spin_rate = own.turn * three(hinge_accelerations, at);
            delta_spin = turn.cross(&spin) + own.turn * three(by.velocity, at);
            delta_spin_rate = turn.cross(&spin_rate) + own.turn * three(by.acceleration, at);
        }
    }
    let swing = w.cross(&d);
    let delta_swing = dw.cross(&d) + w.cross(&delta_arm);
    LinkVariation {
        turn,
        position: p.position + delta_arm,
        angular_velocity: dw + delta_spin,
        velocity: p.velocity + delta_swing + delta_slip,
        angular_acceleration: p.angular_acceleration + delta_spin_rate + dw.cross(&spin) + w.cross(&delta_spin),
        acceleration: p.acceleration
            + p.angular_acceleration.cross(&d)
            + acceleration.angular.cross(&delta_arm)
            + dw.cross(&(swing + 2.0 * slip))
            + w.cross(&(delta_swing + 2.0 * delta_slip))
            + delta_slip_rate,
    }
}
