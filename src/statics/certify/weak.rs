//! What is one-sided at an equilibrium: stops that are touched and bear nothing, and kinks of forces. What happens on either side?

use super::bearing::{self, PULLS, Set, unit};
use super::equilibrium::{Equilibrium, ONLY_UNSTABLE};
use super::kinks;
use super::sided::look;
use super::sides::{Beyond, Leaving, Sided, Sides};
use super::stability::StabilityVerdict;
use crate::dynamics::Fault;
use crate::model::{Model, Side, Stop, StopLaw};
use crate::round_off::ON_A_LIMIT;
use crate::statics::settings::{Settings, Want};
use std::sync::Arc;

/// The stops that press at a balance on a set of stops, and the sides of all others that are touched. `load` is what each
/// stop of the set bears, and the size of the forces there.
fn idle(model: &Model, set: &Set, q: &[f64], load: &dyn Fn(usize, Side) -> [f64; 2]) -> (Set, Vec<Sided>) {
    let (mut pressed, mut sided) = (vec![None; set.len()], Vec::new());
    for (index, stop) in model.stops.iter().enumerate() {
        let slack = ON_A_LIMIT.of(unit(model, stop.velocity).max(q[stop.position].abs()));
        let bears = set[index].filter(|side| match stop.law {
            StopLaw::Rigid { .. } => {
                let [load, size] = load(index, *side);
                // A range of no width holds whatever it bears.
                load.abs() > PULLS * size || stop.range[0] == stop.range[1]
            }
            StopLaw::Compliant { .. } => stop.depth(*side, q) > slack,
        });
        pressed[index] = bears;
        if bears.is_none() && !model.coordinates[stop.velocity].lock {
            let touched = stop.sides().filter(|side| stop.depth(*side, q).abs() <= slack);
            sided.extend(touched.map(|side| off(model, stop, side)));
        }
    }
    (pressed, sided)
}

/// The row of a stop, into it.
fn off(model: &Model, stop: &Stop, side: Side) -> Sided {
    let beyond = match stop.law {
        StopLaw::Rigid { .. } => Beyond::Nothing,
        StopLaw::Compliant { stiffness, .. } => Beyond::Stiffness([0.0, stiffness]),
    };
    let row = vec![(stop.velocity, side.sign())];
    Sided { row, beyond, is_kink: false, name: model.label(stop.velocity) }
}

/// What happens on all sides of a balance on a set of stops.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Around {
    /// The stops that press.
    pub pressed: Set,
    pub sides: Sides,
    /// Whose stiffness is another one on the other side.
    pub kinks: Vec<String>,
}

/// Looks to all sides of a balance on the stops of a set; `load` is what each of them bears, and the size of the forces there. `None`
/// if nothing is one-sided.
///
/// # Errors
/// The element whose numbers are not finite.
pub(in crate::statics) fn around(
    model: &Arc<Model>,
    set: &Set,
    q: &[f64],
    load: &dyn Fn(usize, Side) -> [f64; 2],
) -> Result<Option<Around>, Fault> {
    let (pressed, mut sided) = idle(model, set, q, load);
    sided.extend(kinks::at(model, q)?);
    if sided.is_empty() {
        return Ok(None);
    }
    let Some((freed, q)) = bearing::with(model, &pressed, q) else { return Ok(None) };
    let mut kinks: Vec<String> = Vec::new();
    for one in &sided {
        if matches!(one.beyond, Beyond::Stiffness(_)) && !kinks.contains(&one.name) {
            kinks.push(one.name.clone());
        }
    }
    let sides = look(&freed, &q, &sided)?;
    Ok(Some(Around { pressed, sides, kinks }))
}

/// Looks to all sides of an equilibrium that does not run away on the one that its stiffness is of: if something runs away on
/// another it is unstable, and if nothing brings it back there it is neutral. Gives what leaves it.
///
/// # Errors
/// The element whose numbers are not finite.
pub(in crate::statics) fn examine(
    model: &Arc<Model>,
    settings: &Settings,
    found: &mut Equilibrium,
) -> Result<Option<(Leaving, Set)>, Fault> {
    let holds = found.stability.as_ref().is_some_and(|one| one.verdict != StabilityVerdict::Unstable);
    if !(found.balanced && holds) {
        return Ok(None);
    }
    let set = bearing::borne(model, found);
    let Some((bearing, _)) = bearing::with(model, &set, &found.position) else { return Ok(None) };
    let (held, sizes) = bearing::held(&bearing, found)?;
    let load = |index: usize, side: Side| {
        let stop = &model.stops[index];
        [bearing::load(stop, side, &found.position, &held), sizes[stop.velocity]]
    };
    let Some(Around { pressed, sides, kinks }) = around(model, &set, &found.position, &load)? else { return Ok(None) };
    let Some(stability) = &mut found.stability else { return Ok(None) };
    match sides {
        Sides::Leave(leaving) if leaving.falls => {
            stability.verdict = StabilityVerdict::Unstable;
            stability.unstable_directions += 1;
            found.notes.push(leaving.note(model));
            if settings.want == Want::Stable && found.converged {
                found.converged = false;
                found.notes.push(ONLY_UNSTABLE.to_owned());
            }
            return Ok(Some((leaving, pressed)));
        }
        Sides::Leave(_) => {
            stability.verdict = StabilityVerdict::Neutral;
            stability.neutral_directions += 1;
        }
        Sides::Hold => {}
        Sides::Swing => {
            stability.supposes = Some("impacts end what swings and grows off stops that bear nothing");
            found.notes.push(
                "off stops that bear nothing the motion swings and grows until it strikes them: what impacts leave of it is not \
                 judged; a run shows it"
                    .to_owned(),
            );
        }
        Sides::Unknown => {
            stability.supposes = Some("nothing leaves stops that bear nothing, or crosses kinks of forces");
        }
    }
    if !kinks.is_empty() && !stability.modes.is_empty() {
        found.notes.push(format!(
            "the stiffness of {} is another one on the other side of this place: frequencies are those of one side",
            kinks.join(", ")
        ));
    }
    Ok(None)
}

impl Leaving {
    fn note(&self, model: &Model) -> String {
        let names = self.names.join(", ");
        let how = match model.is_conservative_at_rest() {
            true => "the potential falls there",
            false => "the motion grows there",
        };
        match self.kinks_alone {
            true => format!("unstable on one side of the kink of {names}: {how}"),
            false => format!("unstable off the stop of {names}, which bears nothing: {how}"),
        }
    }
}
