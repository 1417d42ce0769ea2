//! How outputs answer to inputs at one place.
//!
//! Positions, velocities and the time stay; accelerations are affine in what inputs push with, `u`:
//!
//! ```text
//! (1)  q̈(u + h e) = q̈(u) + h ∂q̈/∂u e       exactly, whatever h: two accelerations give ∂q̈/∂u but for rounding
//! (2)  ∂y/∂u = ∂y/∂q̈ ∂q̈/∂u                  by the chain rule of the outputs
//! ```

use super::FmuError;
use crate::dynamics::{Fault, System};
use crate::linear::Input;
use crate::model::output::{EnergyKind, SectionQuantity, Source};
use crate::model::{Model, Quantity};
use crate::output::{AtStops, Outputs, Varied};
use crate::simulator::Simulator;
use std::sync::Arc;

/// A time (s), positions and velocities.
type At<'a> = (f64, [&'a [f64]; 2]);

/// `∂y/∂u · seed` of every number of the outputs; not a number for one whose variation is not known. A limit of a motor that is
/// reached holds its force.
pub(super) fn of_outputs(simulator: &Simulator, seed: &[f64]) -> Result<Vec<f64>, FmuError> {
    let now = simulator.snapshot();
    let model = Arc::new(simulator.model().continued(&now.inputs, &now.memories));
    smooth(&model, &now.state.position)?;
    let mut system = System::new(&model);
    let (q, v) = (&now.state.position[..], &now.state.velocity[..]);
    let mut a = vec![0.0; v.len()];
    system.at(now.time, q, v).accelerations(&mut a)?;
    let place = (now.time, [q, v]);
    let answer = along(&mut system, place, seed, a.len(), |_, a| Ok(a.to_vec()))?;
    let Some(mut outputs) = Outputs::new(&model) else { return Ok(Vec::new()) };
    let zero = vec![0.0; v.len()];
    let mut by = Varied { time: 0.0, position: &zero, velocity: &zero, acceleration: &answer, others: &[] };
    let mut look = |system: &mut System, a: &[f64], directions: &[Varied<'_>]| {
        outputs.look(system.at(now.time, q, v), a, &AtStops::default(), directions)
    };
    let mut varied = look(&mut system, &a, &[by])?.variations.concat();
    if varied.iter().any(|x| x.is_nan()) {
        // Beside the chain rule: these are affine in inputs, too, as far as they are known.
        let values = |system: &mut System, a: &[f64]| Ok(look(system, a, &[])?.values);
        let mut others = along(&mut system, place, seed, varied.len(), values)?;
        for output in model.outputs.iter().filter(|output| !is_affine(&output.quantity)) {
            others[output.range()].fill(f64::NAN);
        }
        by.others = &others;
        varied = look(&mut system, &a, &[by])?.variations.concat();
    }
    // What an input pushes with is no acceleration: the chain (2) does not have it.
    let moving = (0..seed.len()).filter(|place| seed[*place] != 0.0).map(|place| input(&model, place));
    for input in moving {
        for output in model.outputs.iter().filter(|output| input.is_told_by(&model, output)) {
            varied[output.range()].fill(f64::NAN);
        }
    }
    Ok(varied)
}

fn input(model: &Model, place: usize) -> Input {
    let index = model.inputs[place];
    let motor = &model.motors[index];
    Input::Coordinate { name: motor.name.clone(), velocity: motor.coordinate.velocity, motor: Some(index) }
}

/// Where accelerations are affine in forces: no dry friction, no contact, and no stop that may bear.
fn smooth(model: &Model, q: &[f64]) -> Result<(), FmuError> {
    if !(model.hinge_friction.is_empty() && model.contacts.is_empty()) {
        let message = "the scene has dry friction or contact: its derivatives are not known";
        return Err(FmuError::Derivative(message.to_owned()));
    }
    let touched = |stop: &&crate::model::Stop| {
        let at = q[stop.position];
        !(at > stop.range[0] && at < stop.range[1])
    };
    match model.stops.iter().find(touched) {
        Some(stop) => {
            let name = model.label(stop.velocity);
            Err(FmuError::Derivative(format!("the hinge of {name} is at a stop: derivatives are not known there")))
        }
        None => Ok(()),
    }
}

/// Whether what an output is by itself is affine in what inputs push with: what it is by positions and velocities alone does not change.
/// Ledgers and what contacts bear are not known here.
fn is_affine(quantity: &Quantity) -> bool {
    match quantity {
        Quantity::Force(force) => !matches!(force.source, Source::Contact(_) | Source::Stops(_)),
        Quantity::Energy(kind) => matches!(kind, EnergyKind::Kinetic | EnergyKind::Potential),
        Quantity::Section(section) => section.component != Some(SectionQuantity::STRESS),
        Quantity::Reaction(_) | Quantity::Length(_) | Quantity::Power(_) => true,
        _ => false,
    }
}

/// `∂y/∂u · seed` by (1) of the `count` numbers that `of` makes of the accelerations `q̈(u)`.
fn along(
    system: &mut System,
    (time, [q, v]): At<'_>,
    seed: &[f64],
    count: usize,
    mut of: impl FnMut(&mut System, &[f64]) -> Result<Vec<f64>, Fault>,
) -> Result<Vec<f64>, Fault> {
    let (mut answer, mut a) = (vec![0.0; count], vec![0.0; v.len()]);
    let mut told = |system: &mut System| {
        system.at(time, q, v).accelerations(&mut a)?;
        of(system, &a)
    };
    let here = told(system)?;
    for place in (0..seed.len()).filter(|place| seed[*place] != 0.0) {
        let model = Arc::clone(system.model());
        let limit = model.motors[model.inputs[place]].limit();
        let before = system.inputs()[place];
        if before.abs() > limit {
            continue;
        }
        // A large step, away from the limit if there is one.
        let other = match limit.is_finite() {
            true if before.abs() > 0.5 * limit => 0.0,
            true => limit,
            false => before + before.abs().max(1.0),
        };
        system.inputs()[place] = other;
        let there = told(system)?;
        system.inputs()[place] = before;
        let rate = seed[place] / (other - before);
        for ((sum, there), here) in answer.iter_mut().zip(&there).zip(&here) {
            *sum += rate * (there - here);
        }
    }
    told(system)?;
    Ok(answer)
}
