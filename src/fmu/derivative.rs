//! How outputs answer to inputs at one place.
//!
//! Positions, velocities and the time stay; accelerations are affine in what inputs push with, `u`:
//!
//! ```text
//! (1)  q̈(u + h e) = q̈(u) + h ∂q̈/∂u e       exactly, whatever h: two accelerations give ∂q̈/∂u but for rounding
//! (2)  ∂y/∂u = ∂y/∂q̈ ∂q̈/∂u                  by the chain rule of the outputs
//! ```

use super::FmuError;
use crate::dynamics::{Fault, Powers, System};
use crate::linear::Input;
use crate::model::Model;
use crate::output::{Given, Outputs, Varied};
use crate::simulator::Simulator;
use std::sync::Arc;

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
    let answer = accelerations(&mut system, [q, v], now.time, &a, seed)?;
    let Some(mut outputs) = Outputs::new(&model) else { return Ok(Vec::new()) };
    let mut at = system.at(now.time, q, v);
    at.share_multipliers()?;
    let energies = at.energies();
    let mut residual = vec![0.0; v.len()];
    let balanced = at.residual(&a, &mut residual)?;
    let mut reactions = Vec::new();
    balanced.reactions(&mut reactions);
    let (stops, account, powers) = (&vec![0.0; v.len()][..], [0.0; 2], Powers::default());
    let given = Given { accelerations: &a, reactions: &reactions, stops, contacts: &[], energies, account, powers };
    outputs.evaluate(&balanced, &given)?;
    let zero = vec![0.0; v.len()];
    let by = Varied { time: 0.0, position: &zero, velocity: &zero, acceleration: &answer };
    let mut varied = outputs.vary(&balanced, &given, &by).to_vec();
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

/// `∂q̈/∂u · seed` by (1), from `q̈(u)`.
fn accelerations(
    system: &mut System,
    [q, v]: [&[f64]; 2],
    time: f64,
    here: &[f64],
    seed: &[f64],
) -> Result<Vec<f64>, Fault> {
    let (mut answer, mut there) = (vec![0.0; v.len()], vec![0.0; v.len()]);
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
        system.at(time, q, v).accelerations(&mut there)?;
        system.inputs()[place] = before;
        let rate = seed[place] / (other - before);
        for ((sum, there), here) in answer.iter_mut().zip(&there).zip(here) {
            *sum += rate * (there - here);
        }
    }
    Ok(answer)
}
