//! Stops of an equilibrium that bear nothing: what happens off them.

use super::cone;
use super::equilibrium::Equilibrium;
use super::stability::StabilityVerdict;
use crate::dynamics::{Fault, System};
use crate::model::Model;
use crate::statics::problem::{Landscape, within_limits};
use crate::statics::settings::{Settings, Want};
use std::sync::Arc;

/// Looks to the open side of the stops of an equilibrium that bear nothing: if the potential falls there it is unstable,
/// however stiff it is along its stops, and if nothing brings it back it is neutral. Trees whose loads have a potential.
///
/// # Errors
/// The element whose numbers are not finite.
pub(in crate::statics) fn examine_weak(
    model: &Arc<Model>,
    settings: &Settings,
    found: &mut Equilibrium,
) -> Result<(), Fault> {
    let touches = found.stops.iter().any(|stop| stop.depth == 0.0);
    if !(found.balanced && touches) || model.is_constrained() || !model.is_conservative_at_rest() {
        return Ok(());
    }
    let Some(stability) = found.stability.as_mut().filter(|one| one.verdict != StabilityVerdict::Unstable) else {
        return Ok(());
    };
    let mut system = System::new(model);
    let q = within_limits(model, &found.position);
    let mut landscape = Landscape::new(&mut system, &q)?;
    landscape.heed_limits();
    let Some(place) = landscape.choose_active(&q)? else { return Ok(()) };
    let Some(descent) = cone::weakest(&mut landscape, &place)? else { return Ok(()) };
    if !descent.falls {
        stability.verdict = StabilityVerdict::Neutral;
        stability.neutral_directions += 1;
        return Ok(());
    }
    stability.verdict = StabilityVerdict::Unstable;
    stability.unstable_directions += 1;
    let names: Vec<String> = descent.leaving.iter().map(|i| model.label(*i)).collect();
    found
        .notes
        .push(format!("unstable off the stop of {}, which bears nothing: the potential falls there", names.join(", ")));
    if settings.want == Want::Stable && found.converged {
        found.converged = false;
        found.notes.push("only an unstable equilibrium was found; `want = \"any\"` would accept it".to_owned());
    }
    Ok(())
}
