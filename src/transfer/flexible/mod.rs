//! Flexible elements in the sweeps: what a hinge of one coordinate is to [`super`], an element of m coordinates and K steps
//! is here. Its stations are links without a hinge of their own, at which slices of mass sit; `Z` of the element
//! ([`crate::element`]) takes the part of `H`.
//!
//! ```text
//! (1) at a station   S += M_k,   e += b_k − load
//! (2) through a step e += S γ,   ρ += Nᵀ γ,   ρ += Zᵀ e,   P += Zᵀ N + Nᵀ Z + Zᵀ S Z,   N += S Z;   S, N, e shifted
//!     start, tip     N = 0,  P = 0,  ρ = −τ
//! (3) at the root    D = P,   S' = S − N D⁻¹ Nᵀ,   e' = e − N D⁻¹ ρ,   q̈ = −D⁻¹ (ρ + Nᵀ a)
//! ```
//!
//! With K = 1 and a constant `Z` these are eqs. (5) to (8) of the parent module. One triangle of `S` and of `P` is computed:
//! in chains of thin elements the skew part of rounding would grow until no digit is right.

mod balance;
mod eliminate;
mod modal;

pub use balance::RodBalance;
pub(super) use eliminate::RodPivot;
pub(super) use modal::ModalPivot;

use super::LinkAcceleration;
use super::element::Reduced;
use crate::element::pivot::Pivot;
use crate::element::{Rod, RodMotion, halves};
use crate::spatial::{Sym3, Wrench};
use nalgebra::Vector3;

/// Adds `H q̈` of an element as one hinge.
#[inline(never)]
pub(super) fn accelerate(at: &RodMotion, second: &[f64], a: &mut LinkAcceleration) {
    for (tip, x) in at.tip.iter().zip(second) {
        let (linear, angular) = halves(tip);
        a.linear += *x * linear;
        a.angular += *x * angular;
    }
}

/// Accelerations of all stations from that of the parent link; without velocity terms for a change alone.
pub(super) fn follow(
    at: &RodMotion,
    parent: &LinkAcceleration,
    second: &[f64],
    with_bias: bool,
    out: &mut [LinkAcceleration],
) {
    let mut before = *parent;
    for (k, (station, out)) in at.stations.iter().zip(out).enumerate() {
        let link = &station.link;
        let mut a = match with_bias {
            true => link.carry(&before),
            false => {
                LinkAcceleration { linear: before.linear + before.angular.cross(&link.arm), angular: before.angular }
            }
        };
        if k > 0 {
            for (z, x) in at.subspace(k).iter().zip(second) {
                let (linear, angular) = halves(z);
                a.linear += *x * linear;
                a.angular += *x * angular;
            }
        }
        *out = a;
        before = a;
    }
}

/// Eliminates an element's own coordinates from what it passes on: with `D = L Lᵀ`, `G = N L⁻ᵀ` and `y = L⁻¹ u` in place of `N` and `u`,
/// `S ← S − G Gᵀ` and `e ← e + G y`.
///
/// # Errors
/// The pivot that is not positive.
#[inline]
fn eliminate_own(
    pivot: &mut Pivot,
    load: &mut [f64],
    columns: &mut [Wrench],
    (S, e): (&mut Reduced, &mut Wrench),
) -> Result<(), f64> {
    pivot.factorize_definite()?;
    pivot.forward(load, |y, factor, other| *y += factor * other, |y, factor| *y *= factor);
    let add = |n: &mut Wrench, factor: f64, other: &Wrench| n.add_times(factor, other);
    pivot.forward(columns, add, |n, factor| *n = n.times(factor));
    for (g, y) in columns.iter().zip(load) {
        S.downdate(g, 1.0);
        e.add_times(*y, g);
    }
    Ok(())
}

/// `b` of a slice: its velocity terms with its weight, less the load on it.
fn velocity_terms(rod: &Rod, at: &RodMotion, station: usize, gravity: &Vector3<f64>) -> Wrench {
    let (slice, link) = (&rod.slices[station], &at.stations[station].link);
    let w = link.angular_velocity;
    let moment = if slice.inertia == Sym3::ZERO { Vector3::zeros() } else { w.cross(&(link.inertia * w)) };
    Wrench { force: -slice.mass * gravity - rod.load_at(station, &link.turn), moment }
}
