//! Everything that pushes in a scene: force elements as wrenches, hinge springs, dampers and motors as hinge forces.
//!
//! The kinds of force elements are in [`crate::force`]; here is what they do together. Gravity belongs to the bodies
//! themselves and is in [`crate::transfer`].

mod curve;
pub mod hinge;
mod laws;
pub mod motor;
mod phase;

pub use laws::{Boundary, Laws};
pub use phase::{Phase, Rubbing, rate_of};

use crate::element::{Rod, RodMotion, Slice, Station};
use crate::force::{Act, Force};
use crate::model::Model;
use crate::motion::Motion;
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use nalgebra::Vector3;

/// The wrenches of all force elements on the links at their root markers; `wrenches` has one entry per link.
pub fn apply(laws: &Laws, motion: &Motion, wrenches: &mut [Wrench]) {
    wrenches.fill(Wrench::ZERO);
    for force in laws.forces.iter() {
        let ends = force.law.ends();
        force.law.wrenches(&motion.links, &mut |end, wrench| wrenches[ends[end].link] += wrench);
    }
}

/// The variation of the wrenches of [`apply`] with the variation of the motion.
pub fn vary(laws: &Laws, motion: &Motion, by: &[LinkVariation], wrenches: &mut [Wrench]) {
    wrenches.fill(Wrench::ZERO);
    for force in laws.forces.iter() {
        let ends = force.law.ends();
        force.law.vary(&motion.links, by, &mut |end, wrench| wrenches[ends[end].link] += wrench);
    }
}

/// What all force elements attached to one named body do to it, at the root marker of its link.
pub fn on_body(laws: &Laws, motion: &Motion, body: usize) -> Wrench {
    let mut sum = Wrench::ZERO;
    for force in laws.forces.iter() {
        let ends = force.law.ends();
        force.law.wrenches(&motion.links, &mut |end, wrench| {
            if ends[end].body == Some(body) {
                sum += wrench;
            }
        });
    }
    sum
}

/// The first force element whose direction is not determined.
pub fn in_one_place<'a>(laws: &'a Laws, motion: &Motion) -> Option<&'a Force> {
    laws.forces.iter().find(|force| force.law.in_one_place(&motion.links, 0.0))
}

/// The first force element of which something is not a finite number, and what.
pub fn not_finite<'a>(laws: &'a Laws, motion: &Motion) -> Option<(&'a Force, &'static str)> {
    laws.forces.iter().find_map(|force| Some((force, force.law.not_finite(&motion.links)?)))
}

/// Potential energy of gravity, force elements and hinge springs and of the loads and motors that have one (J).
pub fn potential(model: &Model, laws: &Laws, motion: &Motion, q: &[f64]) -> f64 {
    let weight: f64 = model
        .links
        .iter()
        .zip(&motion.links)
        .map(|(link, at)| -link.mass * model.gravity.dot(&(at.position + at.center)))
        .sum();
    let elements: f64 = laws.forces.iter().map(|force| force.law.potential(&motion.links)).sum();
    let rods: f64 = model.rods.iter().zip(&motion.rods).map(|(rod, at)| of_rod(rod, at, &model.gravity)).sum();
    let modals = model.modals.iter().zip(&motion.modals).map(|(body, at)| {
        let frame = &motion.links[body.link];
        -model.gravity.dot(&(body.modal.mass * frame.position + at.first))
    });
    let rods = rods + modals.sum::<f64>();
    weight + rods + elements + hinge::potential(model, q) + curve::potential(&laws.curves, q)
}

/// Of the weight and of dead loads on the slices inside a flexible element (J).
fn of_rod(rod: &Rod, at: &RodMotion, gravity: &Vector3<f64>) -> f64 {
    let slices = rod.slices.iter().zip(&at.stations).enumerate().skip(1).take(rod.steps() - 1);
    let of = |(k, (slice, station)): (usize, (&Slice, &Station))| {
        let load = if rod.follows { Vector3::zeros() } else { rod.load_at(k, &station.link.turn) };
        -(slice.mass * gravity + load).dot(&station.link.position)
    };
    slices.map(of).sum()
}

/// Power put in by loads that follow the sections of flexible elements (W).
fn input_to_rods(model: &Model, motion: &Motion) -> f64 {
    let following = model.rods.iter().zip(&motion.rods).filter(|(rod, _)| rod.follows);
    let of = |(rod, at): (&Rod, &RodMotion)| {
        let load = |k: usize| rod.load_at(k, &at.stations[k].link.turn).dot(&at.stations[k].link.velocity);
        (1..rod.steps()).map(load).sum::<f64>()
    };
    following.map(of).sum()
}

/// Power taken out by dampers (W), ≥ 0.
pub fn dissipated(model: &Model, laws: &Laws, motion: &Motion, v: &[f64]) -> f64 {
    laws.forces.iter().map(|force| force.law.dissipated(&motion.links)).sum::<f64>()
        + hinge::dissipated(model, v)
        + curve::powers(&laws.curves, v)[0]
}

/// Power put in by loads and motors without a potential (W).
pub fn input(model: &Model, laws: &Laws, motion: &Motion, time: f64, q: &[f64], v: &[f64]) -> f64 {
    laws.forces.iter().map(|force| force.law.input(&motion.links)).sum::<f64>()
        + hinge::input(model, v)
        + input_to_rods(model, motion)
        + curve::powers(&laws.curves, v)[1]
        + motor::input(model, laws, time, q, v)
}
