//! The outputs of an equilibrium.

use super::certify::equilibrium::Equilibrium;
use crate::dynamics::{Fault, Powers, System};
use crate::model::Model;
use crate::output::{Given, Outputs};
use std::sync::Arc;

/// The numbers of all outputs at a pose that statics found, in the order of the model; empty for a model without.
///
/// # Errors
/// The output that is not a finite number, or a pose that cannot be evaluated.
pub fn outputs(model: &Arc<Model>, found: &Equilibrium) -> Result<Vec<f64>, Fault> {
    let Some(mut outputs) = Outputs::new(model) else { return Ok(Vec::new()) };
    let (q, v) = (&found.position[..], &found.velocity[..]);
    let rest = vec![0.0; v.len()];
    let mut system = System::new(model);
    let mut powers = Powers::default();
    if Outputs::asks_power(model) {
        powers = system.at(0.0, q, v).powers();
    }
    if model.is_constrained() {
        // Places the rows; what they push is known from the search.
        system.at(0.0, q, v).accelerations(&mut rest.clone())?;
        system.set_multipliers(&found.multipliers);
    }
    let mut stops = rest.clone();
    for bearing in &found.stops {
        let stop = model.stops.iter().find(|stop| model.label(stop.velocity) == bearing.hinge);
        if let Some(stop) = stop {
            stops[stop.velocity] += if bearing.low { bearing.load } else { -bearing.load };
        }
    }
    let mut at = system.at(0.0, q, v);
    at.share_multipliers()?;
    let mut energies = at.energies();
    energies.potential += found.stops.iter().map(|bearing| 0.5 * bearing.load * bearing.depth).sum::<f64>();
    let mut residual = rest.clone();
    let balanced = at.residual(&rest, &mut residual)?;
    let given =
        Given { accelerations: &rest, reactions: &found.reactions, stops: &stops, energies, account: [0.0; 2], powers };
    Ok(outputs.evaluate(&balanced, &given)?.to_vec())
}
