//! A minimum of the potential within the limits of a scene with loops, drives or gears, by a primal active-set method
//! (Nocedal & Wright 2006, 16.5).
//!
//! ```text
//! minimize V(q)  on the closed positions, within low ≤ q ≤ high
//! 1. down V with the stops of the set bearing, up to the first limit on the way: its stop joins the set                (1)
//! 2. at a minimum with this set: of the stops that would have to pull the one that does most leaves it, back to 1      (2)
//! ```
//!
//! It ends where none pulls. The potential falls along every way of (1), and (2) is at minima alone, so that no set comes again
//! before the search has moved; if one does, in a corner of more limits than motions, the search gives up. A compliant stop adds its
//! spring to the potential while it is in the set: it joins and leaves where the way passes its limit.

use super::Search;
use super::bounded::borne;
use super::cascade::{self, Found};
use crate::dynamics::{Fault, System};
use crate::model::{Model, Side, Stop};
use crate::round_off::ON_A_LIMIT;
use crate::statics::certify::bearing::{self, Set, unit};
use crate::statics::certify::equilibrium::{Equilibrium, certify};
use crate::statics::effort::Stage;
use crate::statics::problem::place::Place;
use crate::statics::problem::{Gate, Landscape};
use std::collections::HashSet;

/// Its name among the stages of a search.
const STAGE: &str = "active set";

/// Where the way down with one set ends.
enum End {
    /// At the limit of this stop.
    Halted { stop: usize, q: Vec<f64> },
    /// At a minimum.
    Rests(Box<Equilibrium>),
    /// Nowhere.
    Fails,
}

/// What the ways so far have worked, and what they had to say.
#[derive(Default)]
struct Work {
    notes: Vec<String>,
    steps: usize,
    evaluations: usize,
    factorizations: usize,
}

impl Work {
    /// Gives an answer the work of all ways to it.
    fn told(self, found: &mut Equilibrium) {
        found.stage = STAGE;
        found.stages = vec![Stage {
            name: STAGE,
            iterations: self.steps,
            force_evaluations: self.evaluations,
            factorizations: self.factorizations,
            relative_residual: found.relative_residual,
            balanced: found.balanced,
        }];
        found.iterations = self.steps;
        found.force_evaluations = self.evaluations;
        found.notes.splice(0..0, self.notes);
    }
}

/// The equilibrium within the limits; `None` when the search ends in no balance.
///
/// # Errors
/// The element whose numbers are not finite.
pub(super) fn search(mut search: Search<'_>) -> Result<Option<Equilibrium>, Fault> {
    let Search { model, start, watch, .. } = search;
    let (mut q, mut set) = (start.to_vec(), borne(model, start));
    let (mut met, mut work) = (HashSet::new(), Work::default());
    while watch.goes_on() && met.insert(set.clone()) {
        let Some((bearing, at)) = bearing::with(model, &set, &q) else { return Ok(None) };
        if let Some((stop, side)) = crossed(model, &set, &at) {
            set[stop] = side;
            continue;
        }
        let end = descend(search.of(&bearing, &at), gates(model, &set), &mut work)?;
        let now = match &end {
            End::Halted { q, .. } => q,
            End::Rests(found) => &found.position,
            End::Fails => return Ok(None),
        };
        if now.iter().zip(&q).any(|(now, q)| (now - q).abs() > ON_A_LIMIT.of(now.abs().max(1.0))) {
            met.clear();
            met.insert(set.clone());
        }
        q.clone_from(now);
        match end {
            End::Halted { stop, .. } => {
                set[stop] = if set[stop].is_some() { None } else { nearer(&model.stops[stop], &q) }
            }
            End::Rests(mut found) => match bearing::pulling(model, &set, &bearing, &found)? {
                Some(stop) => set[stop] = None,
                None => {
                    work.told(&mut found);
                    return bearing::finish(model, &set, &bearing, *found).map(Some);
                }
            },
            End::Fails => return Ok(None),
        }
    }
    Ok(None)
}

fn slack(model: &Model, stop: &Stop, q: &[f64]) -> f64 {
    ON_A_LIMIT.of(unit(model, stop.velocity).max(q[stop.position].abs()))
}

/// A stop that bears although it is not in the set, or is in it and pulls, by where the coordinates are: as those of loops that
/// were brought onto the others.
fn crossed(model: &Model, set: &Set, q: &[f64]) -> Option<(usize, Option<Side>)> {
    let of = |(index, side): (usize, &Option<Side>)| {
        let stop = &model.stops[index];
        let slack = slack(model, stop, q);
        match *side {
            None => stop.passed(q[stop.position], slack).map(|side| (index, Some(side))),
            Some(side) => (!stop.is_rigid() && stop.depth(side, q) < -slack).then_some((index, None)),
        }
    };
    set.iter().enumerate().find_map(of)
}

/// The side of a stop that a position is nearer to.
fn nearer(stop: &Stop, q: &[f64]) -> Option<Side> {
    Side::ALL.into_iter().min_by(|a, b| stop.depth(*a, q).abs().total_cmp(&stop.depth(*b, q).abs()))
}

/// What the coordinates must not leave while this set bears.
pub(super) fn gates(model: &Model, set: &Set) -> Vec<Gate> {
    let gate = |(index, side): (usize, &Option<Side>)| {
        let stop = &model.stops[index];
        let range = match *side {
            None => stop.range,
            Some(_) if stop.is_rigid() => return None,
            Some(Side::Low) => [f64::NEG_INFINITY, stop.range[0]],
            Some(Side::High) => [stop.range[1], f64::INFINITY],
        };
        let farthest =
            range.iter().filter(|limit| limit.is_finite()).fold(0.0_f64, |most, limit| most.max(limit.abs()));
        let slack = ON_A_LIMIT.of(unit(model, stop.velocity).max(farthest));
        Some(Gate { stop: index, position: stop.position, range, slack })
    };
    set.iter().enumerate().filter_map(gate).collect()
}

/// Down the potential of a scene whose stops bear, up to a gate.
fn descend(search: Search<'_>, gates: Vec<Gate>, work: &mut Work) -> Result<End, Fault> {
    let Search { model, settings, start, watch, .. } = search;
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, start)?;
    landscape.watch = Some(watch);
    landscape.trail = search.trail.is_some().then(Vec::new);
    landscape.fence(gates);
    let mut history = Vec::new();
    let first = Place::at(&mut landscape, start.to_vec())?;
    landscape.begin(&first);
    let Found { place, notes, effort } = cascade::within_limits(&mut landscape, first, &mut history)?;
    work.steps += history.len();
    work.evaluations += landscape.residuals;
    work.factorizations += landscape.factorizations;
    search.record(&mut landscape);
    if let Some(stop) = landscape.halted_at() {
        work.notes.extend(notes);
        return Ok(End::Halted { stop, q: place.q });
    }
    if !place.is_balanced() {
        return Ok(End::Fails);
    }
    landscape.unfence();
    work.notes.extend(notes);
    certify(landscape, settings, place, effort, history, Vec::new()).map(|found| End::Rests(Box::new(found)))
}
