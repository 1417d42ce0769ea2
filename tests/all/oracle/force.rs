//! Springs, bushings and loads as forces at points, written from their laws.

use super::place::{Placed, attached};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use stillpoint::model::description::{Bushing, Curve, Description, ForceKind, Load, LoadAxes, Rope, Spring};

/// A force at a point and a torque on one body, inertial axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Push {
    /// `None` for the ground.
    pub(crate) body: Option<usize>,
    pub(crate) at: Vector3<f64>,
    pub(crate) force: Vector3<f64>,
    pub(crate) torque: Vector3<f64>,
}

/// What all force elements do, to the ground too.
pub(crate) fn pushes(description: &Description, placed: &[Placed]) -> Vec<Push> {
    description.forces.iter().flat_map(|force| of_kind(description, placed, &force.kind)).collect()
}

fn of_kind(description: &Description, placed: &[Placed], kind: &ForceKind) -> Vec<Push> {
    match kind {
        ForceKind::Spring(Spring { between, stiffness, length, damping }) => {
            let [(first, a, xa), (second, b, xb)] = [0, 1].map(|i| attached(description, placed, &between[i]));
            let distance = (xb - xa).norm();
            let direction = (xb - xa) / distance;
            let rate = direction.dot(&(b.velocity_at(&xb) - a.velocity_at(&xa)));
            let tension = (stiffness * (distance - length) + damping * rate) * direction;
            vec![
                Push { body: first, at: xa, force: tension, torque: Vector3::zeros() },
                Push { body: second, at: xb, force: -tension, torque: Vector3::zeros() },
            ]
        }
        ForceKind::Bushing(Bushing { between, frame, stiffness, damping, preload }) => {
            let [(first, a, xa), (second, b, xb)] = [0, 1].map(|i| attached(description, placed, &between[i]));
            let (mut force, mut torque) = bushing_on_second(&a, &b, &xa, &xb, frame, stiffness, damping);
            let axes = [a.turn, b.turn].map(|turn| turn * frame.to_rotation_matrix().into_inner());
            force += axes[0] * Vector3::new(preload[0], preload[1], preload[2]);
            let turn = UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(
                axes[0].transpose() * axes[1],
            ));
            torque += axes[1] * pulled(&turn, &-Vector3::new(preload[3], preload[4], preload[5]));
            vec![
                Push { body: first, at: xb, force: -force, torque: -torque },
                Push { body: second, at: xb, force, torque },
            ]
        }
        ForceKind::Rope(rope) => rope_pushes(description, placed, rope),
        ForceKind::Curve(Curve { between, extension, rate: by_rate, length, .. }) => {
            let [(first, a, xa), (second, b, xb)] = [0, 1].map(|i| attached(description, placed, &between[i]));
            let distance = (xb - xa).norm();
            let direction = (xb - xa) / distance;
            let rate = direction.dot(&(b.velocity_at(&xb) - a.velocity_at(&xa)));
            let pull = (straight(extension, distance - length) + straight(by_rate, rate)) * direction;
            vec![
                Push { body: first, at: xa, force: pull, torque: Vector3::zeros() },
                Push { body: second, at: xb, force: -pull, torque: Vector3::zeros() },
            ]
        }
        ForceKind::Load(Load { on, force, torque, axes, .. }) => {
            let (body, at, point) = attached(description, placed, on);
            let turn = if *axes == LoadAxes::Body { at.turn } else { Matrix3::identity() };
            vec![Push { body, at: point, force: turn * force, torque: turn * torque }]
        }
        ForceKind::Slider(_) => unreachable!("its beam is none of rigid bodies"),
    }
}

/// Every point is pulled towards those before and after it.
fn rope_pushes(description: &Description, placed: &[Placed], rope: &Rope) -> Vec<Push> {
    let points: Vec<_> = rope.through.iter().map(|at| attached(description, placed, at)).collect();
    let to = |i: usize, j: usize| (points[j].2 - points[i].2).normalize();
    let velocity = |i: usize| points[i].1.velocity_at(&points[i].2);
    let (mut path, mut rate) = (0.0, 0.0);
    for i in 1..points.len() {
        path += (points[i].2 - points[i - 1].2).norm();
        rate += to(i - 1, i).dot(&(velocity(i) - velocity(i - 1)));
    }
    let tension = (rope.stiffness * (path - rope.length) + rope.damping * rate).max(0.0);
    let pull = |i: usize| {
        let before = if i > 0 { to(i, i - 1) } else { Vector3::zeros() };
        let after = if i + 1 < points.len() { to(i, i + 1) } else { Vector3::zeros() };
        tension * (before + after)
    };
    (0..points.len())
        .map(|i| Push { body: points[i].0, at: points[i].2, force: pull(i), torque: Vector3::zeros() })
        .collect()
}

/// Straight from point to point, and on beyond the ends; zero without points.
fn straight(points: &[[f64; 2]], x: f64) -> f64 {
    let pair = points.windows(2).find(|pair| x <= pair[1][0]).or(points.windows(2).last());
    pair.map_or(0.0, |pair| pair[0][1] + (x - pair[0][0]) * (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]))
}

/// Force at the second point and torque on the second body.
fn bushing_on_second(
    a: &Placed,
    b: &Placed,
    xa: &Vector3<f64>,
    xb: &Vector3<f64>,
    frame: &UnitQuaternion<f64>,
    stiffness: &[f64; 6],
    damping: &[f64; 6],
) -> (Vector3<f64>, Vector3<f64>) {
    let frame = frame.to_rotation_matrix().into_inner();
    let (on_a, on_b) = (a.turn * frame, b.turn * frame);
    let mut force = Vector3::zeros();
    let mut torque = Vector3::zeros();
    for i in 0..3 {
        // Elongation along an axis that A carries, and its rate: d/dt (e·x) = ė·x + e·ẋ.
        let e = on_a.column(i).into_owned();
        let elongation = e.dot(&(xb - xa));
        let rate = a.spin.cross(&e).dot(&(xb - xa)) + e.dot(&(b.velocity_at(xb) - a.velocity_at(xa)));
        force -= (stiffness[i] * elongation + damping[i] * rate) * e;
        torque -= damping[i + 3] * e.dot(&(b.spin - a.spin)) * e;
    }
    let relative = nalgebra::Rotation3::from_matrix_unchecked(on_a.transpose() * on_b);
    let turn = UnitQuaternion::from_rotation_matrix(&relative);
    torque += on_b * torsion(&turn, &Vector3::new(stiffness[3], stiffness[4], stiffness[5]));
    (force, torque)
}

/// The torque of the potential `½ φᵀKφ`, φ the rotation vector of `turn`, in the axes that `turn` leads from.
///
/// The work done in a small turn δ is `torque·δ = −(Kφ)·δφ` with `δ = J(φ) δφ`, hence `Jᵀ torque = −Kφ`. J is summed
/// from its definition, the differential of the exponential map: `J = Σ (−1)ᵏ [φ]×ᵏ / (k+1)!`.
pub(crate) fn torsion(turn: &UnitQuaternion<f64>, stiffness: &Vector3<f64>) -> Vector3<f64> {
    pulled(turn, &stiffness.component_mul(&turn.scaled_axis()))
}

/// The torque of a potential whose derivative by φ is `y`: `Jᵀ torque = −y`.
fn pulled(turn: &UnitQuaternion<f64>, y: &Vector3<f64>) -> Vector3<f64> {
    let phi = turn.scaled_axis();
    let (mut term, mut sum) = (Matrix3::identity(), Matrix3::identity());
    // |φ| ≤ π: the forty-first term is below 1e-28.
    for k in 1..40 {
        term *= -phi.cross_matrix() / (k + 1) as f64;
        sum += term;
    }
    -sum.transpose().lu().solve(y).expect("regular below 2π")
}
