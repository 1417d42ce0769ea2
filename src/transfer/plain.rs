//! The reduced transfer matrix method as it is printed. Read this first: two sweeps over a tree of rigid bodies and
//! hinges give all accelerations and all reactions in O(n), with full 6×6 matrices and nothing else in the way.
//!
//! Symbols and equation numbers are those of [`super`]. A 6-vector has its linear part above its angular part
//! (acceleration `a = [r̈; ω̇]`, wrench `f = [force; moment]`), is in inertial axes and is taken at its own marker.
//!
//! The program itself uses [`Reduction`](super::Reduction), which gives the same numbers: it stores one triangle of `S`,
//! writes the zeros of `S' H` instead of computing them, keeps chains in registers, computes halves of large trees at
//! once, and refines the result if a pivot has lost digits. A test compares the two on random trees.

use super::Singular;
use crate::model::{Joint, Link, Model};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Wrench;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Matrix6xX, Vector3, Vector6};

/// The motion and the internal forces that the transfer equations give.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// `q̈`, one number per velocity coordinate (m/s², rad/s²; about a ball in link axes).
    pub hinge: DVector<f64>,
    /// `a_R` of every link: acceleration of its root marker (m/s², rad/s²). Link 0, the ground, has zero.
    pub accelerations: Vec<Vector6<f64>>,
    /// `f_R` of every link: what its inboard hinge passes to it at its root marker (N, N m). Entry 0 is what the
    /// hinges and the force elements on the ground ask of it.
    pub reactions: Vec<Vector6<f64>>,
}

/// A hinge between the two sweeps.
struct Hinge {
    H: Matrix6xX<f64>,
    D_inverse: DMatrix<f64>,
    u: DVector<f64>,
}

/// Accelerations and reactions of a tree whose positions and velocities are in `motion`. `applied` has one wrench per
/// link, at its root marker (N, N m; without weight, which comes from [`Model::gravity`]); `tau` has one hinge force per
/// velocity coordinate (N, N m). Loops, drives and gears are not looked at: the tree alone moves.
///
/// # Errors
/// A hinge whose pivot `D` is not positive definite, with the smallest diagonal entry of `D`.
///
/// # Panics
/// If `applied` has fewer entries than the model has links, or `tau` fewer than it has velocity coordinates.
pub fn accelerations(model: &Model, motion: &Motion, applied: &[Wrench], tau: &[f64]) -> Result<Solution, Singular> {
    let links = model.links.len();
    let bodies = || model.links.iter().zip(&motion.links);
    // Eqs. (1) and (4) for every body on its own: S = M, e = b − f_applied.
    let mut S: Vec<_> = bodies().map(|(link, at)| mass_matrix(link, at)).collect();
    let mut e: Vec<_> = bodies().zip(applied).map(|((link, at), f)| velocity_terms(model, link, at) - six(f)).collect();

    // The ground stands still whatever is welded to it.
    (S[0], e[0]) = (Matrix6::zeros(), -six(&applied[0]));

    // Tips → root: eqs. (5) to (7).
    let mut hinges = Vec::with_capacity(links - 1);
    for index in (1..links).rev() {
        let (link, at) = (&model.links[index], &motion.links[index]);
        let H = motion_subspace(link, at);
        let (first, count) = (link.velocity, H.ncols());
        let SH = S[index] * &H;
        let D = H.tr_mul(&SH) + armature(model, first, count);
        let Some(factors) = D.clone().cholesky() else {
            return Err(Singular { link: index, pivot: D.diagonal().min() });
        };
        let D_inverse = factors.inverse();
        let u = DVector::from_column_slice(&tau[first..first + count]) - H.tr_mul(&e[index]);
        let S_inboard = S[index] - &SH * &D_inverse * SH.transpose();
        let e_inboard = e[index] + S_inboard * gamma(at) + &SH * (&D_inverse * &u);
        let X = shift(&at.arm);
        S[link.parent] += X.tr_mul(&(S_inboard * X));
        e[link.parent] += X.tr_mul(&e_inboard);
        hinges.push(Hinge { H, D_inverse, u });
    }

    // Root → tips: eqs. (8), (2) and (4). The ground does not accelerate.
    let mut hinge = DVector::zeros(model.velocity_count());
    let mut a = vec![Vector6::zeros(); links];
    for (index, Hinge { H, D_inverse, u }) in (1..links).zip(hinges.into_iter().rev()) {
        let (link, at) = (&model.links[index], &motion.links[index]);
        let a_in = shift(&at.arm) * a[link.parent] + gamma(at);
        let own = D_inverse * (u - H.tr_mul(&(S[index] * a_in)));
        a[index] = a_in + H * &own;
        hinge.rows_mut(link.velocity, own.len()).copy_from(&own);
    }
    let reactions = (0..links).map(|index| S[index] * a[index] + e[index]).collect();
    Ok(Solution { hinge, accelerations: a, reactions })
}

/// `M = [m 1, −m[c]×; m[c]×, J]` of eq. (1).
fn mass_matrix(link: &Link, at: &LinkMotion) -> Matrix6<f64> {
    let mc = (link.mass * at.center).cross_matrix();
    blocks(&(link.mass * Matrix3::identity()), &-mc, &mc, &at.inertia.matrix())
}

/// `b = [m ω×(ω×c); ω×(J ω)]` of eq. (1), less the weight `[m g; c × m g]`.
fn velocity_terms(model: &Model, link: &Link, at: &LinkMotion) -> Vector6<f64> {
    let (w, c, weight) = (at.angular_velocity, at.center, link.mass * model.gravity);
    let force = link.mass * w.cross(&w.cross(&c)) - weight;
    let moment = w.cross(&(at.inertia * w)) - c.cross(&weight);
    stacked(&force, &moment)
}

/// `H` of eq. (2): the relative acceleration of the root marker for a unit of each `q̈` of its hinge.
fn motion_subspace(link: &Link, at: &LinkMotion) -> Matrix6xX<f64> {
    let zero = Vector3::zeros();
    match link.joint {
        // Elements are beyond the printed method: `flexible` has its equations.
        Joint::None | Joint::Flex { .. } | Joint::Along { .. } | Joint::Modal { .. } | Joint::Interface { .. } => {
            Matrix6xX::zeros(0)
        }
        Joint::Turn => Matrix6xX::from_columns(&[stacked(&zero, &at.axis)]),
        Joint::Slide { .. } => Matrix6xX::from_columns(&[stacked(&at.axis, &zero)]),
        Joint::Screw { pitch } => Matrix6xX::from_columns(&[stacked(&(pitch * at.axis), &at.axis)]),
        Joint::Ball { .. } => {
            let axis = |i: usize| stacked(&zero, &at.turn.column(i).into_owned());
            Matrix6xX::from_columns(&[axis(0), axis(1), axis(2)])
        }
    }
}

/// `γ` of eq. (2): what the velocities add to the acceleration across the hinge.
fn gamma(at: &LinkMotion) -> Vector6<f64> {
    stacked(&at.bias, &at.angular_bias)
}

/// `X(d) = [1, −[d]×; 0, 1]`: from the acceleration of the parent's root marker to that of a point `d` away.
fn shift(d: &Vector3<f64>) -> Matrix6<f64> {
    blocks(&Matrix3::identity(), &-d.cross_matrix(), &Matrix3::zeros(), &Matrix3::identity())
}

/// `A` of eq. (3): the inertia of the hinge's own drive train, one number per coordinate.
fn armature(model: &Model, first: usize, count: usize) -> DMatrix<f64> {
    DMatrix::from_diagonal(&DVector::from_fn(count, |i, _| model.coordinates[first + i].armature))
}

fn six(wrench: &Wrench) -> Vector6<f64> {
    stacked(&wrench.force, &wrench.moment)
}

fn stacked(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

fn blocks(ff: &Matrix3<f64>, fm: &Matrix3<f64>, mf: &Matrix3<f64>, mm: &Matrix3<f64>) -> Matrix6<f64> {
    let mut all = Matrix6::zeros();
    for (row, column, block) in [(0, 0, ff), (0, 3, fm), (3, 0, mf), (3, 3, mm)] {
        all.fixed_view_mut::<3, 3>(row, column).copy_from(block);
    }
    all
}
