//! The variation of an element's stations in one direction: the outward sweep, differentiated.
//!
//! With `Φ = Z δq` the relative turn and shift of a step and (v, w) = W, all in axes of the station:
//!
//! ```text
//! (8) δW = Φ̇ + [W, Φ],   δẆ = Φ̈ + [Ẇ, Φ] + [W, Φ̇]
//!     Φ̇ = Ż δq + Z δq̇,   Φ̈ = Z̈ δq + 2 Ż δq̇ + Z δq̈
//! ```

use super::exponential::{bracket, halves, joined};
use super::motion::{RodMotion, Station};
use super::rod::{Local, Rod};
use crate::spatial::link::{LinkAcceleration, LinkMotion, LinkVariation};
use nalgebra::{Matrix3, Vector6};

/// A direction in which an element's coordinates, their rates and second rates vary; an empty list is zero.
#[derive(Debug, Clone, Copy)]
pub struct RodDirection<'a> {
    /// δq
    pub position: &'a [f64],
    /// δq̇
    pub velocity: &'a [f64],
    /// δq̈
    pub acceleration: &'a [f64],
}

/// What the motion varies about: accelerations of the frame that carries the element and of its coordinates.
#[derive(Debug, Clone, Copy)]
pub struct RodPoint<'a> {
    /// Of the parent link.
    pub parent: &'a LinkMotion,
    /// Of the parent link's root marker.
    pub acceleration: &'a LinkAcceleration,
    /// q̈
    pub second: &'a [f64],
}

/// The part of a step's variation that comes from the element's own coordinates, inertial axes.
struct Own {
    phi: Vector6<f64>,
    twist: Vector6<f64>,
    rate: Vector6<f64>,
}

/// A twist of the station's axes in inertial ones.
fn turned(turn: &Matrix3<f64>, x: &Vector6<f64>) -> Vector6<f64> {
    let (linear, angular) = halves(x);
    joined(&(turn * linear), &(turn * angular))
}

impl RodMotion {
    /// The step that ends at a station, with what depends on rates and second rates if there are any.
    pub fn local<'a>(&self, rod: &'a Rod, station: usize, second: &[f64]) -> Local<'a> {
        match self.moves || second.iter().any(|x| *x != 0.0) {
            true => rod.moving(station - 1, &self.q, &self.v, second),
            false => rod.still(station - 1, &self.q),
        }
    }

    /// Columns of `Z`, `Ż` and `Z̈` of a step, inertial axes.
    pub fn columns(&self, local: &Local<'_>, station: usize, i: usize) -> [Vector6<f64>; 3] {
        let turn = &self.stations[station].link.turn;
        local.subspaces(i).map(|x| turned(turn, &x))
    }

    /// `Ẇ` at a station: the rate of its twist in axes that turn with it.
    pub fn twist_rate(&self, station: usize, second: &[f64]) -> Vector6<f64> {
        let columns = self.subspace(station).iter().zip(second);
        columns.fold(self.stations[station].twist_bias, |sum, (z, x)| sum + *x * z)
    }

    /// Root → tip: gives every station's variation, station 0 (the root frame) first.
    pub fn vary(
        &self,
        rod: &Rod,
        at: &RodPoint<'_>,
        by: &RodDirection<'_>,
        parent: &LinkVariation,
        mut each: impl FnMut(usize, &LinkVariation),
    ) {
        let none = Own { phi: Vector6::zeros(), twist: Vector6::zeros(), rate: Vector6::zeros() };
        let root = &self.stations[0];
        let mut varied = across(at.parent, root, &Vector6::zeros(), at.acceleration, parent, &none);
        let mut acceleration = root.link.carry(at.acceleration);
        each(0, &varied);
        for k in 1..self.stations.len() {
            let (last, next) = (&self.stations[k - 1].link, &self.stations[k]);
            let rate = self.twist_rate(k, at.second);
            let own = self.own(rod, k, at.second, &rate, by);
            varied = across(last, next, &rate, &acceleration, &varied, &own);
            let mut following = next.link.carry(&acceleration);
            for (z, x) in self.subspace(k).iter().zip(at.second) {
                let (linear, angular) = halves(z);
                following.linear += *x * linear;
                following.angular += *x * angular;
            }
            acceleration = following;
            each(k, &varied);
        }
    }

    fn own(&self, rod: &Rod, k: usize, second: &[f64], rate: &Vector6<f64>, by: &RodDirection<'_>) -> Own {
        let [mut phi, mut first, mut twice] = [Vector6::zeros(); 3];
        if !self.moves && second.iter().all(|x| *x == 0.0) {
            // At rest Ż and Z̈ vanish, and so do the twist and its rate: Z is known.
            let sum = |by: &[f64]| self.subspace(k).iter().zip(by).map(|(z, x)| *x * z).sum();
            return Own { phi: sum(by.position), twist: sum(by.velocity), rate: sum(by.acceleration) };
        }
        let twist = &self.stations[k].twist;
        if [by.position, by.velocity, by.acceleration].iter().all(|by| by.iter().all(|x| *x == 0.0)) {
            return Own { phi, twist: first, rate: twice };
        }
        let local = self.local(rod, k, second);
        for i in 0..rod.count() {
            let [z, zd, zdd] = self.columns(&local, k, i);
            if let Some(x) = by.position.get(i) {
                (phi, first, twice) = (phi + *x * z, first + *x * zd, twice + *x * zdd);
            }
            if let Some(x) = by.velocity.get(i) {
                (first, twice) = (first + *x * z, twice + 2.0 * *x * zd);
            }
            if let Some(x) = by.acceleration.get(i) {
                twice += *x * z;
            }
        }
        Own { phi, twist: first + bracket(twist, &phi), rate: twice + bracket(rate, &phi) + bracket(twist, &first) }
    }
}

/// Across a step: eq. (8) in inertial axes, and the relations of `relative_motion` varied term by term.
fn across(
    last: &LinkMotion,
    next: &Station,
    twist_rate: &Vector6<f64>,
    a: &LinkAcceleration,
    p: &LinkVariation,
    own: &Own,
) -> LinkVariation {
    let (d, w) = (next.link.arm, last.angular_velocity);
    let ((shift, spin), (slip, roll)) = (halves(&own.phi), halves(&next.twist));
    let turn = p.turn + spin;
    let varied = |x: &Vector6<f64>, own: &Vector6<f64>| {
        let ((v, w), (dv, dw)) = (halves(x), halves(own));
        (turn.cross(&v) + dv, turn.cross(&w) + dw)
    };
    let (delta_slip, delta_roll) = varied(&next.twist, &own.twist);
    let (delta_slip_rate, delta_roll_rate) = varied(twist_rate, &own.rate);
    let delta_arm = p.turn.cross(&d) + shift;
    let delta_swing = p.angular_velocity.cross(&d) + w.cross(&delta_arm);
    LinkVariation {
        turn,
        position: p.position + delta_arm,
        angular_velocity: p.angular_velocity + delta_roll,
        velocity: p.velocity + delta_swing + delta_slip,
        angular_acceleration: p.angular_acceleration
            + p.angular_velocity.cross(&roll)
            + w.cross(&delta_roll)
            + delta_roll_rate,
        acceleration: p.acceleration
            + p.angular_acceleration.cross(&d)
            + a.angular.cross(&delta_arm)
            + p.angular_velocity.cross(&(w.cross(&d) + 2.0 * slip))
            + w.cross(&(delta_swing + 2.0 * delta_slip))
            + delta_roll.cross(&slip)
            + roll.cross(&delta_slip)
            + delta_slip_rate,
    }
}
