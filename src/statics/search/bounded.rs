//! The minimum of the potential within the limits of a tree: one search with an active set, and its certificate.
//!
//! The search is the trust region's, among rigid limits and with compliant stops in the potential (see
//! [`crate::statics::problem`]). Its answer is certified as that of the scene in which the stops that it rests on bear: the
//! residual of the free coordinates, the sign of every multiplier, the stiffness of the free coordinates, and that of the
//! critical cone (see [`crate::statics::certify::cone`]).

use super::Search;
use super::cascade::{self, Found};
use super::floating::left_in_place;
use super::polish::polish;
use crate::dynamics::{Fault, System};
use crate::model::Model;
use crate::statics::certify::bearing::{self, Set};
use crate::statics::certify::equilibrium::{Equilibrium, certify};
use crate::statics::certify::unbalanced::unbalanced;
use crate::statics::effort::Iteration;
use crate::statics::problem::place::Place;
use crate::statics::problem::{Landscape, within_limits};

/// Where the search ended, and what it worked.
struct Outcome {
    found: Found,
    guess: Place,
    history: Vec<Iteration>,
    /// Balances, stiffnesses, factorizations.
    work: [usize; 3],
}

/// The equilibrium within the limits; `None` when the search ends in no balance before the watch ends it.
///
/// # Errors
/// The element whose numbers are not finite.
pub(super) fn search(mut search: Search<'_>) -> Result<Option<Equilibrium>, Fault> {
    let Search { model, settings, watch, .. } = search;
    let Outcome { found, guess, mut history, work } = descend(search.again())?;
    let Found { mut place, mut notes, effort } = found;
    if !place.is_balanced() && !effort.fell && watch.goes_on() {
        return Ok(None);
    }
    (search.searched)();
    if effort.fell {
        place = guess;
    }
    let set = borne(model, &place.q);
    let Some((bearing, q)) = bearing::with(model, &set, &place.q) else { return Ok(None) };
    let mut system = System::new(&bearing);
    let mut landscape = Landscape::new(&mut system, &q)?;
    let mut certified = Place::at(&mut landscape, q)?;
    if place.is_balanced() && !certified.is_balanced() {
        certified = polish(&mut landscape, certified, &mut history)?;
    }
    if !certified.is_balanced() {
        let ended = watch.note(effort.stage, certified.residual().0);
        notes.push(ended.map_or_else(|| unbalanced(&mut landscape, &certified), Ok)?);
    }
    landscape.residuals += work[0];
    landscape.stiffnesses += work[1];
    landscape.factorizations += work[2];
    let found = certify(landscape, settings, certified, effort, history, notes)?;
    if found.balanced && bearing::pulling(model, &set, &bearing, &found)?.is_some() {
        return Ok(None);
    }
    bearing::finish(model, &set, &bearing, found).map(Some)
}

fn descend(search: Search<'_>) -> Result<Outcome, Fault> {
    let Search { model, start, watch, .. } = search;
    let q = within_limits(model, start);
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, &q)?;
    landscape.watch = Some(watch);
    landscape.trail = search.trail.is_some().then(Vec::new);
    landscape.heed_limits();
    let mut history = Vec::new();
    let guess = match landscape.choose_active(&q)? {
        Some(place) => place,
        None => Place::at(&mut landscape, q)?,
    };
    landscape.begin(&guess);
    let mut found = cascade::within_limits(&mut landscape, guess.clone(), &mut history)?;
    found.place = left_in_place(&mut landscape, start, found.place)?;
    search.record(&mut landscape);
    let work = [landscape.residuals, landscape.stiffnesses, landscape.factorizations];
    Ok(Outcome { found, guess, history, work })
}

/// The stops that a position rests on: rigid ones that it touches, compliant ones that it presses.
pub(super) fn borne(model: &Model, q: &[f64]) -> Set {
    let mut set = bearing::touching(model, q);
    for (side, stop) in set.iter_mut().zip(&model.stops) {
        if !stop.is_rigid() && stop.pressed(q).is_none() {
            *side = None;
        }
    }
    set
}
