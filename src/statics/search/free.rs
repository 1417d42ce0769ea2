//! The search in a model without stops.

use super::Search;
use super::cascade::{self, Found};
use super::floating::left_in_place;
use crate::dynamics::{Fault, System};
use crate::statics::certify::equilibrium::{Equilibrium, certify};
use crate::statics::certify::unbalanced::unbalanced;
use crate::statics::problem::Landscape;
use crate::statics::problem::place::Place;
use crate::statics::settings::Method;

/// Finds the equilibrium of a model without stops.
pub(super) fn search_free(search: Search<'_>) -> Result<Equilibrium, Fault> {
    let Search { model, settings, start, watch, .. } = search;
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, start)?;
    landscape.trail = search.trail.is_some().then(Vec::new);
    landscape.watch = Some(watch);
    let mut history = Vec::new();
    let first = Place::at(&mut landscape, start.to_vec())?;
    landscape.begin(&first);
    let guess = first.clone();
    let Found { mut place, mut notes, effort } = cascade::search(&mut landscape, settings, first, &mut history)?;
    (search.searched)();
    if !place.is_balanced() {
        // If the search ran away, what is missing shows best where it started.
        if landscape.is_far(&place.q) && !effort.fell {
            notes.push(
                "the search ran away, beyond all lengths of the scene: balance there would be round-off".to_owned(),
            );
        }
        let fall = landscape.falling(&place.q).map(|fall| fall.note());
        if effort.fell || landscape.is_far(&place.q) {
            place = guess;
        }
        let ended = watch.note(effort.stage, place.residual().0);
        notes.retain(|note| Some(note) != fall.as_ref());
        notes.push(ended.or(fall).map_or_else(|| unbalanced(&mut landscape, &place), Ok)?);
    }
    if matches!(settings.method, Method::Auto | Method::Newton) {
        place = left_in_place(&mut landscape, start, place)?;
    }
    search.record(&mut landscape);
    certify(landscape, settings, place, effort, history, notes)
}
