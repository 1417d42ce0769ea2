//! What is one-sided at an equilibrium: stops that are touched and bear nothing, and kinks of forces. What happens on either side?

use super::bearing::{self, PULLS, Set, unit};
use super::equilibrium::{Equilibrium, ONLY_UNSTABLE};
use super::kinks;
use super::sided::{along_all, look};
use super::sides::{Beyond, Leaving, Sided, Sides};
use super::stability::{Stability, StabilityVerdict};
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

/// What is one-sided at a balance, in the scene in which the stops that press bear.
struct OneSided {
    pressed: Set,
    sided: Vec<Sided>,
    freed: Arc<Model>,
    q: Vec<f64>,
}

impl OneSided {
    /// `None` if nothing is.
    fn of(
        model: &Arc<Model>,
        set: &Set,
        q: &[f64],
        load: &dyn Fn(usize, Side) -> [f64; 2],
    ) -> Result<Option<Self>, Fault> {
        let (pressed, mut sided) = idle(model, set, q, load);
        sided.extend(kinks::at(model, q)?);
        if sided.is_empty() {
            return Ok(None);
        }
        let freed = bearing::with(model, &pressed, q);
        Ok(freed.map(|(freed, q)| Self { pressed, sided, freed, q }))
    }

    fn around(self) -> Result<Around, Fault> {
        let mut kinks: Vec<String> = Vec::new();
        for one in &self.sided {
            if matches!(one.beyond, Beyond::Stiffness(_)) && !kinks.contains(&one.name) {
                kinks.push(one.name.clone());
            }
        }
        let sides = look(&self.freed, &self.q, &self.sided)?;
        Ok(Around { pressed: self.pressed, sides, kinks })
    }

    /// Of a balance that runs away with the stiffness of one side of everything: how many motions have no stiffness that stay on no
    /// side, if none of these runs away and no motion needs to be on that side. Of one kink every motion or its opposite is on it.
    fn side_of_no_motion(&self) -> Result<Option<usize>, Fault> {
        let kinks = self.sided.iter().filter(|one| matches!(one.beyond, Beyond::Stiffness(_))).count();
        if kinks < 2 {
            return Ok(None);
        }
        let along = along_all(&self.freed, &self.q, &self.sided)?;
        Ok(along.filter(|(unstable, _)| *unstable == 0).map(|(_, neutral)| neutral))
    }
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
    OneSided::of(model, set, q, load)?.map(OneSided::around).transpose()
}

/// Looks to all sides of an equilibrium that does not run away on the one that its stiffness is of: if something runs away on
/// another it is unstable, and if nothing brings it back there it is neutral. Of one that does run away it is asked whether some motion
/// is on that side: at several kinks it may be none. Gives what leaves it.
///
/// # Errors
/// The element whose numbers are not finite.
pub(in crate::statics) fn examine(
    model: &Arc<Model>,
    settings: &Settings,
    found: &mut Equilibrium,
) -> Result<Option<(Leaving, Set)>, Fault> {
    let Some(verdict) = found.stability.as_ref().map(|one| one.verdict).filter(|_| found.balanced) else {
        return Ok(None);
    };
    let set = bearing::borne(model, found);
    let Some((bearing, _)) = bearing::with(model, &set, &found.position) else { return Ok(None) };
    let (held, sizes) = bearing::held(&bearing, found)?;
    let load = |index: usize, side: Side| {
        let stop = &model.stops[index];
        [bearing::load(stop, side, &found.position, &held), sizes[stop.velocity]]
    };
    let Some(one_sided) = OneSided::of(model, &set, &found.position, &load)? else { return Ok(None) };
    let falls = verdict == StabilityVerdict::Unstable;
    let (Around { pressed, sides, kinks }, neutral) = match falls {
        false => (one_sided.around()?, None),
        true => {
            let Some(neutral) = one_sided.side_of_no_motion()? else { return Ok(None) };
            (one_sided.around()?, Some(neutral))
        }
    };
    if let Some(neutral) = neutral {
        if matches!(sides, Sides::Unknown | Sides::Swing) {
            return Ok(None);
        }
        held_by_others(found, settings, neutral);
    }
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
            // Where all is neutral on one side, what is neutral on another is among it.
            let all = model.degrees_of_freedom() - stability.unstable_directions;
            stability.neutral_directions = (stability.neutral_directions + 1).min(all);
        }
        Sides::Hold => {}
        Sides::Swing => {
            stability.supposes = Some("impacts end what swings and grows off stops that bear nothing");
            found.notes.push(SWINGS.to_owned());
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

/// What is said of motions that swing and grow until they strike.
const SWINGS: &str = "off stops that bear nothing the motion swings and grows until it strikes them: what impacts leave of it is not \
                      judged; a run shows it";

/// The verdict on an equilibrium whose stiffness is that of a side on which no motion is: what all sides say comes next.
fn held_by_others(found: &mut Equilibrium, settings: &Settings, neutral: usize) {
    let Some(stability) = &mut found.stability else { return };
    let supposes = stability.supposes;
    *stability = Stability { supposes, ..Stability::of(0, neutral, Vec::new(), Vec::new()) };
    if settings.want == Want::Stable {
        found.notes.retain(|note| note != ONLY_UNSTABLE);
        found.converged = true;
    }
    found.notes.push(
        "kinks of forces meet here, and their sides depend on each other: no frequencies are told of a side on which no motion is"
            .to_owned(),
    );
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
