//! Everything that pushes: hinge springs, dampers and motors as hinge forces; springs, bushings and loads as wrenches.
//!
//! Each law answers the same questions: its wrenches, their variation, its potential, the power that it takes out
//! (`dissipated`, ≥ 0) and the power it puts in that has no potential (`input`). Gravity belongs to the bodies
//! themselves and is in [`crate::transfer`].

mod bushing;
pub mod hinge;
mod load;
pub mod motor;
mod spring;

use crate::model::{Law, Model};
use crate::motion::Motion;
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;

/// The wrenches of all force elements on the links at their root markers; `wrenches` has one entry per link.
pub fn apply(model: &Model, motion: &Motion, wrenches: &mut [Wrench]) {
    wrenches.fill(Wrench::ZERO);
    for force in &model.forces {
        for (end, wrench) in force.law.ends().iter().zip(of_law(&force.law, motion)) {
            wrenches[end.link] += wrench;
        }
    }
}

/// The variation of the wrenches of [`apply`] with the variation of the motion.
pub fn vary(model: &Model, motion: &Motion, by: &[LinkVariation], wrenches: &mut [Wrench]) {
    wrenches.fill(Wrench::ZERO);
    for force in &model.forces {
        for (end, wrench) in force.law.ends().iter().zip(vary_law(&force.law, motion, by)) {
            wrenches[end.link] += wrench;
        }
    }
}

/// What all force elements attached to one named body do to it, at the root marker of its link.
pub fn on_body(model: &Model, motion: &Motion, body: usize) -> Wrench {
    let mut sum = Wrench::ZERO;
    for force in &model.forces {
        for (end, wrench) in force.law.ends().iter().zip(of_law(&force.law, motion)) {
            if end.body == Some(body) {
                sum += wrench;
            }
        }
    }
    sum
}

/// The first force element whose force is not a finite number.
pub fn not_finite(model: &Model, motion: &Motion) -> Option<usize> {
    model.forces.iter().position(|force| !of_law(&force.law, motion).iter().all(Wrench::is_finite))
}

/// Wrenches at the root markers of the links of both ends; a load has one end.
fn of_law(law: &Law, motion: &Motion) -> [Wrench; 2] {
    match law {
        Law::Spring { ends, stiffness, length, damping } => {
            spring::Spring::at(ends, motion, *stiffness, *length, *damping).wrenches()
        }
        Law::Bushing { .. } => bushing::Bushing::at(law, motion).wrenches(),
        Law::DeadLoad { on, force, torque } => [load::dead(on, force, torque, motion), Wrench::ZERO],
        Law::FollowerLoad { on, force, torque } => [load::follower(on, force, torque, motion), Wrench::ZERO],
    }
}

/// The variation of one element's wrenches, see [`vary`].
pub fn vary_law(law: &Law, motion: &Motion, by: &[LinkVariation]) -> [Wrench; 2] {
    match law {
        Law::Spring { ends, stiffness, length, damping } => {
            spring::Spring::at(ends, motion, *stiffness, *length, *damping).vary(ends, motion, by)
        }
        Law::Bushing { .. } => bushing::Bushing::at(law, motion).vary(motion, by),
        Law::DeadLoad { on, force, .. } => [load::vary_dead(on, force, motion, by), Wrench::ZERO],
        Law::FollowerLoad { on, force, torque } => [load::vary_follower(on, force, torque, motion, by), Wrench::ZERO],
    }
}

/// Potential energy of gravity, force elements and hinge springs and of the loads and motors that have one (J).
pub fn potential(model: &Model, motion: &Motion, q: &[f64]) -> f64 {
    let weight: f64 = model
        .links
        .iter()
        .zip(&motion.links)
        .map(|(link, at)| -link.mass * model.gravity.dot(&(at.position + at.center)))
        .sum();
    let elements: f64 = model
        .forces
        .iter()
        .map(|force| match &force.law {
            Law::Spring { ends, stiffness, length, damping } => {
                spring::Spring::at(ends, motion, *stiffness, *length, *damping).potential()
            }
            Law::Bushing { .. } => bushing::Bushing::at(&force.law, motion).potential(),
            Law::DeadLoad { on, force, .. } => load::potential(on, force, motion),
            Law::FollowerLoad { .. } => 0.0,
        })
        .sum();
    weight + elements + hinge::potential(model, q)
}

/// Power taken out by dampers (W), ≥ 0.
pub fn dissipated(model: &Model, motion: &Motion, v: &[f64]) -> f64 {
    let of_law = |law: &Law| match law {
        Law::Spring { ends, stiffness, length, damping } => {
            spring::Spring::at(ends, motion, *stiffness, *length, *damping).dissipated()
        }
        Law::Bushing { .. } => bushing::Bushing::at(law, motion).dissipated(),
        Law::DeadLoad { .. } | Law::FollowerLoad { .. } => 0.0,
    };
    model.forces.iter().map(|force| of_law(&force.law)).sum::<f64>() + hinge::dissipated(model, v)
}

/// Power put in by loads and motors without a potential (W).
pub fn input(model: &Model, motion: &Motion, time: f64, q: &[f64], v: &[f64]) -> f64 {
    let of_law = |law: &Law| match law {
        Law::DeadLoad { on, torque, .. } => torque.dot(&motion.links[on.link].angular_velocity),
        Law::FollowerLoad { on, force, torque } => load::follower_power(on, force, torque, motion),
        Law::Spring { .. } | Law::Bushing { .. } => 0.0,
    };
    model.forces.iter().map(|force| of_law(&force.law)).sum::<f64>()
        + hinge::input(model, v)
        + motor::input(model, time, q, v)
}

/// How large what one end of an element feels is.
#[derive(Debug, Clone, Copy, Default)]
pub struct Magnitude {
    /// (N)
    pub force: f64,
    /// (N m)
    pub moment: f64,
    /// Stiffness times lengths: the sizes whose difference the force is (N).
    pub noise: f64,
    /// (N/m)
    pub stiffness: f64,
    /// (N m/rad)
    pub turn_stiffness: f64,
}

/// Sizes of an element's forces and stiffnesses at rest, the same at both ends.
pub fn magnitude(law: &Law, motion: &Motion) -> [Magnitude; 2] {
    let size = match law {
        Law::Spring { ends, stiffness, length, damping } => {
            spring::Spring::at(ends, motion, *stiffness, *length, *damping).magnitude()
        }
        Law::Bushing { .. } => bushing::Bushing::at(law, motion).magnitude(),
        Law::DeadLoad { force, torque, .. } | Law::FollowerLoad { force, torque, .. } => {
            Magnitude { force: force.norm(), noise: force.norm(), moment: torque.norm(), ..Magnitude::default() }
        }
    };
    [size, size]
}
