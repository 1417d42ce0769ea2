//! The core: the reduced transfer matrix method. Accelerations of a tree of bodies and hinges in O(n), no mass matrix.
//!
//! [`plain`] is the method as printed, in one short function: read it first. The other files compute the same faster.
//!
//! Every vector is in inertial axes and every 6-vector is taken at its marker. A body's *root marker* carries its
//! inboard hinge; its other hinge points are its *tip markers*.
//!
//! | code | paper | meaning | shape | unit |
//! |---|---|---|---|---|
//! | `a` = [`LinkAcceleration`] | r̈, ω̇ | acceleration of a root marker | 6 | m/s², rad/s² |
//! | `f` = [`Wrench`] | q, m | internal force and moment at a root marker | 6 | N, N m |
//! | `S`, `e` | S, e | reduced matrix and vector: `f = S a + e` | 6×6 sym., 6 | |
//! | `H` | H | motion subspace of a hinge, at the marker: `[0; n]` of a turn, `[n; 0]` of a slide, `[p n; n]` of a screw, `[0; 1]` of a ball | 6×k | |
//! | `D`, `u` | | hinge pivot `Hᵀ S H + A` and load `τ − Hᵀ e` | k×k, k | |
//! | `γ` | γ | what velocities add to the acceleration across a hinge | 6 | |
//! | `d` | | from the parent's root marker to this one | 3 | m |
//!
//! ```text
//! (1) body     f_R = M a_R + b + Σ_T X(d)ᵀ f_T − f_applied         paper (59), (60)
//! (2) hinge    a_R = X(d) a_P + H q̈ + γ                            paper (55), (56), (61), (62)
//! (3)          Hᵀ f_R = τ − A q̈                                    decoupled hinge equation
//! (4)          f_R = S a_R + e                                     assumption of the reduction
//! (5)          D = Hᵀ S H + A,   S' = S − S H D⁻¹ Hᵀ S
//! (6)          u = τ − Hᵀ e,     e' = e + S' γ + S H D⁻¹ u
//! (7)          S_P += X(d)ᵀ S' X(d),   e_P += X(d)ᵀ e'
//! (8)          q̈ = D⁻¹ (u − Hᵀ S a_in),  a_in = X(d) a_P + γ
//! ```
//!
//! (5) and (7) for `S` are a factorization; (6) to (8) solve with it for any number of right sides. The first, with
//! weight and velocities, is solved in the sweep that factorizes ([`Reduction::accelerations`]), others follow
//! ([`Reduction::solve`]). The same relations read the other way are inverse dynamics ([`balance`]), and their
//! differentiation in one direction is the action of the tangent ([`variation`]); in all directions at once it gives the
//! Jacobians of the accelerations ([`jacobian`]).

#![allow(non_snake_case)]

pub mod balance;
pub mod element;
pub mod embedded;
pub mod flexible;
pub mod jacobian;
pub mod lanes;
pub mod mass;
pub mod plain;
mod plan;
pub mod reduce;
pub mod tangent;
pub mod variation;

pub use crate::motion::variation::LinkAcceleration;
pub use reduce::{Reduction, Singular};

use crate::model::{Joint, Link};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Wrench;
use crate::spatial::fused::{cross_add, dot, fma, scale_add, times_add};
use nalgebra::Vector3;

/// `Hᵀ w` for a hinge of one coordinate.
#[inline(always)]
fn along(joint: &Joint, axis: &Vector3<f64>, w: &Wrench) -> f64 {
    match joint {
        Joint::Slide { .. } => dot(axis, &w.force),
        Joint::Screw { pitch } => fma(*pitch, dot(axis, &w.force), dot(axis, &w.moment)),
        _ => dot(axis, &w.moment),
    }
}

/// `X(d) a_P + γ`: the acceleration of a root marker while its own hinge does not accelerate.
#[inline(always)]
fn inboard(link: &LinkMotion, parent: &LinkAcceleration, with_bias: bool) -> LinkAcceleration {
    let linear = cross_add(&parent.angular, &link.arm, &parent.linear);
    if with_bias {
        LinkAcceleration { linear: linear + link.bias, angular: parent.angular + link.angular_bias }
    } else {
        LinkAcceleration { linear, angular: parent.angular }
    }
}

/// `d × f`, exactly across `d`: a light link that a heavy body hangs on passes a force of that weight nearly along its arm,
/// and the round-off of the product would turn the link about it.
fn lever(d: &Vector3<f64>, f: &Vector3<f64>) -> Vector3<f64> {
    let (moment, square) = (d.cross(f), d.norm_squared());
    if square == 0.0 { moment } else { moment - d * (d.dot(&moment) / square) }
}

/// Adds `H q̈`.
#[inline(always)]
fn accelerate(link: &Link, at: &LinkMotion, motion: &Motion, hinge: &[f64], a: &mut LinkAcceleration) {
    let first = link.velocity;
    match link.joint {
        Joint::None | Joint::Modal { .. } => {}
        Joint::Interface { modal, tip } => motion.modals[modal].tips[tip].accelerate(&hinge[first..], a),
        Joint::Turn => a.angular = scale_add(hinge[first], &at.axis, &a.angular),
        Joint::Slide { .. } => a.linear = scale_add(hinge[first], &at.axis, &a.linear),
        Joint::Screw { pitch } => {
            a.angular = scale_add(hinge[first], &at.axis, &a.angular);
            a.linear = scale_add(pitch * hinge[first], &at.axis, &a.linear);
        }
        Joint::Ball { .. } => {
            let relative = Vector3::new(hinge[first], hinge[first + 1], hinge[first + 2]);
            a.angular = times_add(&at.turn, &relative, &a.angular);
        }
        Joint::Along { rod } => flexible::accelerate(&motion.rods[rod], &hinge[first..=first], a),
        Joint::Flex { rod, count } => flexible::accelerate(&motion.rods[rod], &hinge[first..first + count], a),
    }
}
