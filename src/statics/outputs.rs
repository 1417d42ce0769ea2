//! The outputs of an equilibrium, and what its beams bear.

use super::certify::equilibrium::Equilibrium;
use super::standing::{by_rule, with_contacts};
use crate::dynamics::{Balanced, BeamState, DiagramPoint, Fault, Powers, System};
use crate::model::Model;
use crate::output::{Given, Outputs};
use std::sync::Arc;

/// The numbers of all outputs at a pose that statics found, in the order of the model; empty for a model without.
///
/// # Errors
/// The output that is not a finite number, or a pose that cannot be evaluated.
pub fn outputs(model: &Arc<Model>, found: &Equilibrium) -> Result<Vec<f64>, Fault> {
    let model = &pushed(model, found);
    let Some(mut outputs) = Outputs::new(model) else { return Ok(Vec::new()) };
    let (q, v) = (&found.position[..], &found.velocity[..]);
    let rest = vec![0.0; v.len()];
    let mut system = System::new(model);
    let mut powers = Powers::default();
    if Outputs::asks_power(model) {
        powers = system.at(0.0, q, v).powers();
    }
    push_as_found(&mut system, found)?;
    let mut stops = rest.clone();
    for bearing in &found.stops {
        let stop = model.stops.iter().find(|stop| model.label(stop.velocity) == bearing.hinge);
        if let Some(stop) = stop {
            stops[stop.velocity] += -bearing.side.sign() * bearing.load;
        }
    }
    let mut at = system.at(0.0, q, v);
    at.share_multipliers()?;
    let mut energies = at.energies();
    energies.potential += found.stops.iter().map(|bearing| 0.5 * bearing.load * bearing.depth).sum::<f64>();
    let mut residual = rest.clone();
    let balanced = at.residual(&rest, &mut residual)?;
    let contacts = found.standing.as_ref().map_or_else(Vec::new, |standing| by_rule(model, &standing.contacts));
    let given = Given {
        accelerations: &rest,
        reactions: &found.reactions,
        stops: &stops,
        contacts: &contacts,
        energies,
        account: [0.0; 2],
        powers,
    };
    Ok(outputs.evaluate(&balanced, &given)?.to_vec())
}

/// What flexible beams bear at a pose that statics found, in the order of the model; empty for a model without.
///
/// # Errors
/// A pose that cannot be evaluated.
pub fn beams(model: &Arc<Model>, found: &Equilibrium) -> Result<Vec<BeamState>, Fault> {
    if model.beams.is_empty() { Ok(Vec::new()) } else { at_rest(model, found, |balanced| balanced.beams()) }
}

/// What some of the beams bear at a pose that statics found, at `stretches` + 1 points of each of their elements; the beams by their
/// indices.
///
/// # Errors
/// A pose that cannot be evaluated.
pub fn diagrams(
    model: &Arc<Model>,
    found: &Equilibrium,
    beams: &[usize],
    stretches: usize,
) -> Result<Vec<Vec<DiagramPoint>>, Fault> {
    at_rest(model, found, |balanced| {
        beams.iter().map(|beam| balanced.diagram(&model.beams[*beam], stretches)).collect()
    })
}

/// Asks the force balance at a pose that statics found.
fn at_rest<T>(model: &Arc<Model>, found: &Equilibrium, ask: impl FnOnce(&Balanced<'_>) -> T) -> Result<T, Fault> {
    let mut system = System::new(&pushed(model, found));
    push_as_found(&mut system, found)?;
    let mut at = system.at(0.0, &found.position, &found.velocity);
    at.share_multipliers()?;
    let rest = vec![0.0; found.velocity.len()];
    Ok(ask(&at.residual(&rest, &mut rest.clone())?))
}

/// The model, with what its contacts bear as loads.
fn pushed(model: &Arc<Model>, found: &Equilibrium) -> Arc<Model> {
    match &found.standing {
        Some(standing) if !standing.contacts.is_empty() => with_contacts(model, &found.position, &standing.contacts),
        _ => Arc::clone(model),
    }
}

/// Places the rows of loops, drives and gears, which push as the search found: what locks and stops hold is not in the system.
fn push_as_found(system: &mut System, found: &Equilibrium) -> Result<(), Fault> {
    if system.model().is_constrained() {
        system.set_multipliers(&found.multipliers);
    }
    Ok(())
}
