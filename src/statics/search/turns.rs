//! Which stops bear, by turns: for scenes whose coordinates are tied together, or whose loads have no potential.
//!
//! A coordinate beyond its limit gets its stop, a stop that would have to pull is taken away, and the search starts from the
//! guess again. It ends where every stop that bears presses and no other is passed: the conditions of Signorini. If a
//! search ends in no balance, stops in the way of the forces left there are tried. If loads have a potential, the set that bears
//! is the active set of a minimum within the limits: in a tree it is looked for at once, see [`super::bounded`], beside loops, drives
//! and gears if no turn ends well, see [`super::active`]. Where that fails, too, or there is no potential, the motion itself finds the stops that bear.
//!
//! **With loops, drives and gears** coordinates depend on each other, and two stops can seldom bear at once: of those
//! that are passed only the first on the way from the guess is added, the loops are brought onto it from there in short
//! steps, and where they cannot be, it takes the place of the others.

use super::free::search_free;
use super::{Search, active, bounded};
use crate::dynamics::{Fault, System};
use crate::model::{Model, Side, StopLaw};
use crate::round_off::ON_A_LIMIT;
use crate::statics::certify::bearing::{PULLS, Set, finish, held, load, touching, unit, with};
use crate::statics::certify::equilibrium::Equilibrium;
use crate::statics::problem::Landscape;
use crate::statics::settings::{Method, Settings, Want};
use std::collections::HashSet;
use std::sync::Arc;

/// The equilibrium with the stops heeded.
pub(super) fn search(mut search: Search<'_>) -> Result<Equilibrium, Fault> {
    let Search { model, settings, watch, .. } = search;
    let descends = settings.method == Method::Auto && model.is_conservative_at_rest();
    let (tied, stable) = (model.is_constrained(), settings.want == Want::Stable);
    if descends
        && stable
        && !tied
        && let Some(found) = bounded::search(search.again())?
    {
        return Ok(found);
    }
    let found = by_turns(search.again())?;
    if found.converged || !watch.goes_on() || settings.method != Method::Auto {
        return Ok(found);
    }
    if !descends {
        return if found.balanced { Ok(found) } else { moved(search, found) };
    }
    // Downhill there is one, wherever it is.
    let lower = match tied {
        true => active::search(search.again())?.map(|lower| after(&found, lower)),
        false if stable || found.balanced => None,
        false => bounded::search(search.again())?,
    };
    match lower.unwrap_or(found) {
        found if found.balanced => Ok(found),
        found => moved(search, found),
    }
}

/// Where the turns end in no balance: those stops are the ones to begin with that press where compliant ones are springs, or else at which
/// the motion itself comes to rest, by dynamic relaxation.
fn moved(mut search: Search<'_>, found: Equilibrium) -> Result<Equilibrium, Fault> {
    if search.model.stops.iter().any(|stop| !stop.is_rigid()) {
        let soft = Arc::new(search.model.with_stops_as_springs());
        let start = search.start;
        let sprung = by_turns(search.of(&soft, start))?;
        if sprung.balanced {
            let again = by_turns(search.of(search.model, &sprung.position))?;
            if again.balanced {
                return Ok(after(&found, after(&sprung, again)));
            }
        }
    }
    let settings = Settings { method: Method::Relaxation, ..*search.settings };
    let rested = by_turns(Search { settings: &settings, ..search.again() })?;
    if !rested.balanced || !search.watch.goes_on() {
        return Ok(found);
    }
    let again = by_turns(search.of(search.model, &rested.position))?;
    Ok(if again.balanced { after(&found, after(&rested, again)) } else { found })
}

/// An answer with what the turns before it have worked.
pub(super) fn after(turns: &Equilibrium, mut found: Equilibrium) -> Equilibrium {
    found.stages.splice(0..0, turns.stages.iter().cloned());
    found.iterations += turns.iterations;
    found.force_evaluations += turns.force_evaluations;
    found
}

fn by_turns(mut search: Search<'_>) -> Result<Equilibrium, Fault> {
    let Search { model, start, watch, .. } = search;
    let mut set = touching(model, start);
    let mut seen = HashSet::new();
    let mut added = None;
    let (mut stages, mut steps, mut evaluations) = (Vec::new(), 0, 0);
    loop {
        seen.insert(set.clone());
        let Some((bearing, guess)) = with(model, &set, start) else {
            // The loops have no position on all of them: the others make way for the one that came last.
            let last = |(index, side): (usize, &Option<Side>)| side.filter(|_| Some(index) == added);
            let alone: Set = set.iter().enumerate().map(last).collect();
            set = if seen.contains(&alone) { vec![None; set.len()] } else { alone };
            if seen.contains(&set) {
                return nowhere(search);
            }
            continue;
        };
        let mut found = search_free(search.of(&bearing, &guess))?;
        stages.append(&mut found.stages);
        steps += found.iterations;
        evaluations += found.force_evaluations;
        let next = match found.balanced {
            true => revised(model, &set, &bearing, &found, start)?,
            false if model.is_constrained() => first_in_the_way(model, &set, &bearing, &guess)?,
            false => in_the_way(model, &set, start)?,
        };
        let again = next.filter(|next| !seen.contains(next) && watch.goes_on());
        if found.balanced && again.is_none() && revised(model, &set, &bearing, &found, start)?.is_some() {
            let ended = watch.note(found.stage, found.relative_residual);
            give_up(&mut found, ended);
        }
        let Some(next) = again else {
            (found.stages, found.iterations, found.force_evaluations) = (stages, steps, evaluations);
            return finish(model, &set, &bearing, found);
        };
        added = (0..set.len()).find(|index| set[*index].is_none() && next[*index].is_some());
        set = next;
    }
}

fn give_up(found: &mut Equilibrium, ended: Option<String>) {
    found.converged = false;
    found.balanced = false;
    found.stability = None;
    let none = || {
        "no combination of stops that bear balances the loads: in each that was tried one would have to pull, or another is passed".to_owned()
    };
    found.notes.push(ended.unwrap_or_else(none));
}

/// If the loops have no position on the stops that were tried: what is found without any, as no equilibrium.
fn nowhere(mut search: Search<'_>) -> Result<Equilibrium, Fault> {
    let Search { start, watch, .. } = search;
    let mut free = Model::clone(search.model);
    free.stops.clear();
    let free = Arc::new(free);
    search.trail = None;
    let mut found = search_free(search.of(&free, start))?;
    let ended = watch.note(found.stage, found.relative_residual);
    give_up(&mut found, ended);
    Ok(found)
}

/// The set after a balance: stops that are passed added, those that pull taken away. `None` if nothing changes.
fn revised(
    model: &Arc<Model>,
    set: &Set,
    bearing: &Arc<Model>,
    found: &Equilibrium,
    start: &[f64],
) -> Result<Option<Set>, Fault> {
    let (held, sizes) = held(bearing, found)?;
    let mut next = set.clone();
    let mut passed: Vec<(f64, usize, Side)> = Vec::new();
    for (index, side) in next.iter_mut().enumerate() {
        let stop = &model.stops[index];
        let value = found.position[stop.position];
        let slack = ON_A_LIMIT.of(unit(model, stop.velocity).max(value.abs()));
        if let Some(bears) = *side {
            let pulls = match stop.law {
                StopLaw::Rigid { .. } => load(stop, bears, &found.position, &held) < -PULLS * sizes[stop.velocity],
                StopLaw::Compliant { .. } => stop.depth(bears, &found.position) < -slack,
            };
            if pulls {
                *side = None;
            }
        } else if let Some(towards) = stop.passed(value, slack) {
            let from = start[stop.position];
            passed.push(((stop.limit(towards) - from) / (value - from), index, towards));
        }
    }
    passed.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Coordinates of loops follow each other: the first stop on the way may keep the others from being passed.
    let count = if model.is_constrained() { 1 } else { passed.len() };
    passed.iter().take(count).for_each(|(_, index, towards)| next[*index] = Some(*towards));
    Ok((next != *set).then_some(next))
}

/// Of the stops towards which the forces at the guess drive loops, gears and drives, the one that is reached first, added.
/// `None` if there is no other.
fn first_in_the_way(model: &Arc<Model>, set: &Set, bearing: &Arc<Model>, guess: &[f64]) -> Result<Option<Set>, Fault> {
    let mut system = System::new(bearing);
    let mut landscape = Landscape::new(&mut system, guess)?;
    let force = landscape.force(guess)?;
    let mut first: Option<(f64, usize, Side)> = None;
    for (index, stop) in model.stops.iter().enumerate().filter(|(index, _)| set[*index].is_none()) {
        let Some(row) = landscape.free.iter().position(|i| *i == stop.velocity) else { continue };
        let speed = force[row] / landscape.metric[row];
        let towards = if speed < 0.0 { Side::Low } else { Side::High };
        let time = (stop.limit(towards) - guess[stop.position]) / speed;
        if time.is_finite() && first.is_none_or(|first| time < first.0) {
            first = Some((time, index, towards));
        }
    }
    Ok(first.map(|(_, index, towards)| {
        let mut next = set.clone();
        next[index] = Some(towards);
        next
    }))
}

/// The stops towards which the forces at the guess push, added. `None` if there is no other.
fn in_the_way(model: &Arc<Model>, set: &Set, start: &[f64]) -> Result<Option<Set>, Fault> {
    let rest = vec![0.0; model.velocity_count()];
    let mut residual = rest.clone();
    System::new(model).at(0.0, start, &rest).residual(&rest, &mut residual)?;
    let mut next = set.clone();
    for (stop, side) in model.stops.iter().zip(next.iter_mut()).filter(|(_, side)| side.is_none()) {
        let towards = if residual[stop.velocity] > 0.0 { Side::Low } else { Side::High };
        if stop.limit(towards).is_finite() && residual[stop.velocity] != 0.0 {
            *side = Some(towards);
        }
    }
    Ok((next != *set).then_some(next))
}
