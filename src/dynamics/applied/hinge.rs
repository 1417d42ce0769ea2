//! Hinge forces: springs, dampers and constant motors in the hinge coordinates.
//!
//! ```text
//! turns and slides:  τ = −k (q − q_rest) − c q̇ + τ₀
//! balls:             τ = −G(φ)ᵀ K φ − c ω + τ₀,   φ = log(rest⁻¹ ∘ p), link axes   (crate::spatial::rotation)
//! ```

use crate::element::Rod;
use crate::element::modal::Modal;
use crate::model::{Coordinate, Link, Model};
use crate::motion::unit_quaternion;
use crate::spatial::rotation::{rotation_vector, torsion_spring};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// `tau` ← hinge forces at coordinates `q` and velocities `v`, one per velocity.
pub fn apply(model: &Model, q: &[f64], v: &[f64], tau: &mut [f64]) {
    let mut springs = false;
    for ((tau, coordinate), v) in tau.iter_mut().zip(&model.coordinates).zip(v) {
        *tau = coordinate.force - coordinate.damping * v;
        springs |= coordinate.stiffness != 0.0;
    }
    rods(model, |link, rod| {
        let (position, velocity) = (&q[link.position..], &v[link.velocity..]);
        for i in 0..rod.count() {
            let damped = if rod.damping == 0.0 { 0.0 } else { rod.damping * rod.elastic(i, velocity) };
            tau[link.velocity + i] -= rod.elastic(i, position) + damped;
        }
    });
    modals(model, |first, modal| {
        for i in 0..modal.count() {
            let to = first.velocity + i;
            tau[to] -= modal.elastic(i, &q[first.position..]) + modal.damped(i, &v[first.velocity..]);
        }
    });
    if !springs {
        return;
    }
    for_springs(model, |link, coordinates| match link.joint.rest() {
        Some(rest) => {
            let torque = torsion_spring(&from_rest(rest, q, link), stiffness(coordinates), Vector3::zeros()).0;
            for (i, t) in torque.iter().enumerate() {
                tau[link.velocity + i] += t;
            }
        }
        None => tau[link.velocity] -= coordinates[0].stiffness * (q[link.position] - coordinates[0].rest),
    });
}

/// `out` ← variation of the hinge forces with `dq` (small turns for balls) and `dv`; an empty list is zero.
pub fn vary(model: &Model, q: &[f64], dq: &[f64], dv: &[f64], out: &mut [f64]) {
    for (at, coordinate) in model.coordinates.iter().enumerate() {
        out[at] = if dv.is_empty() { 0.0 } else { -coordinate.damping * dv[at] };
    }
    rods(model, |link, rod| {
        let part = |list: &[f64], i: usize| list.get(link.velocity..).map_or(0.0, |own| rod.elastic(i, own));
        for i in 0..rod.count() {
            let damped = if rod.damping == 0.0 || dv.is_empty() { 0.0 } else { rod.damping * part(dv, i) };
            out[link.velocity + i] -= damped + if dq.is_empty() { 0.0 } else { part(dq, i) };
        }
    });
    modals(model, |first, modal| {
        for i in 0..modal.count() {
            let to = first.velocity + i;
            out[to] -= dv.get(first.velocity..).map_or(0.0, |own| modal.damped(i, own));
            out[to] -= dq.get(first.velocity..).map_or(0.0, |own| modal.elastic(i, own));
        }
    });
    if dq.is_empty() {
        return;
    }
    for_springs(model, |link, coordinates| {
        let at = link.velocity;
        match link.joint.rest() {
            Some(rest) => {
                let (_, tangent) = torsion_spring(&from_rest(rest, q, link), stiffness(coordinates), Vector3::zeros());
                let change = tangent * Vector3::new(dq[at], dq[at + 1], dq[at + 2]);
                for (i, t) in change.iter().enumerate() {
                    out[at + i] += t;
                }
            }
            None => out[at] -= coordinates[0].stiffness * dq[at],
        }
    });
}

/// What the spring of a ball pushes it with (N m), link axes; zero without a spring.
pub fn ball_torque(model: &Model, link: &Link, q: &[f64]) -> Vector3<f64> {
    let stiffness = stiffness(&model.coordinates[link.velocity..link.velocity + 3]);
    match link.joint.rest() {
        Some(rest) if stiffness != Vector3::zeros() => {
            torsion_spring(&from_rest(rest, q, link), stiffness, Vector3::zeros()).0
        }
        _ => Vector3::zeros(),
    }
}

/// `∂τ/∂(turn)` of a ball's spring, link axes; `None` without a spring.
pub fn ball_tangent(model: &Model, link: &Link, q: &[f64]) -> Option<Matrix3<f64>> {
    let rest = link.joint.rest()?;
    let stiffness = stiffness(&model.coordinates[link.velocity..link.velocity + 3]);
    (stiffness != Vector3::zeros()).then(|| torsion_spring(&from_rest(rest, q, link), stiffness, Vector3::zeros()).1)
}

pub(super) fn potential(model: &Model, q: &[f64]) -> f64 {
    let mut sum = 0.0;
    for_springs(model, |link, coordinates| {
        sum += match link.joint.rest() {
            Some(rest) => {
                let phi = rotation_vector(&from_rest(rest, q, link));
                0.5 * phi.component_mul(&phi).dot(&stiffness(coordinates))
            }
            None => 0.5 * coordinates[0].stiffness * (q[link.position] - coordinates[0].rest).powi(2),
        };
    });
    rods(model, |link, rod| {
        let own = &q[link.position..link.position + rod.count()];
        sum += own.iter().enumerate().map(|(i, x)| 0.5 * x * rod.elastic(i, own)).sum::<f64>();
    });
    modals(model, |first, modal| sum += modal.elastic_energy(&q[first.position..first.position + modal.count()]));
    for link in &model.links {
        if link.joint.is_scalar() {
            sum -= model.coordinates[link.velocity].force * q[link.position];
        }
    }
    sum
}

pub(super) fn dissipated(model: &Model, v: &[f64]) -> f64 {
    let mut sum = model.coordinates.iter().zip(v).map(|(coordinate, v)| coordinate.damping * v * v).sum::<f64>();
    rods(model, |link, rod| {
        let own = &v[link.velocity..link.velocity + rod.count()];
        sum += rod.damping * own.iter().enumerate().map(|(i, x)| x * rod.elastic(i, own)).sum::<f64>();
    });
    modals(model, |first, modal| sum += modal.dissipated(&v[first.velocity..first.velocity + modal.count()]));
    sum
}

/// Motors about balls have no potential.
pub(super) fn input(model: &Model, v: &[f64]) -> f64 {
    let ball = |link: &&Link| link.joint.is_ball();
    let of_ball =
        |link: &Link| (0..3).map(|i| link.velocity + i).map(|i| model.coordinates[i].force * v[i]).sum::<f64>();
    model.links.iter().filter(ball).map(of_ball).sum()
}

/// The flexible elements with their links, if there are any.
fn rods(model: &Model, mut each: impl FnMut(&Link, &Rod)) {
    if model.rods.is_empty() {
        return;
    }
    for link in &model.links {
        if let Some(rod) = link.joint.rod() {
            each(link, &model.rods[rod]);
        }
    }
}

/// The modal bodies with the links of their coordinates.
fn modals(model: &Model, mut each: impl FnMut(&Link, &Modal)) {
    model.modals.iter().for_each(|body| each(&model.links[body.link], &body.modal));
}

fn for_springs(model: &Model, mut each: impl FnMut(&Link, &[Coordinate])) {
    for link in &model.links {
        let (_, count) = link.joint.counts();
        let coordinates = &model.coordinates[link.velocity..link.velocity + count];
        if coordinates.iter().any(|coordinate| coordinate.stiffness != 0.0) {
            each(link, coordinates);
        }
    }
}

fn stiffness(coordinates: &[Coordinate]) -> Vector3<f64> {
    Vector3::new(coordinates[0].stiffness, coordinates[1].stiffness, coordinates[2].stiffness)
}

fn from_rest(rest: &UnitQuaternion<f64>, q: &[f64], link: &Link) -> UnitQuaternion<f64> {
    rest.inverse() * unit_quaternion(&q[link.position..link.position + 4])
}
