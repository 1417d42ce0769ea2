//! The search in a model without stops.

use super::cascade::{self, Found};
use crate::dynamics::{Fault, System};
use crate::model::Model;
use crate::statics::certify::equilibrium::{Equilibrium, certify};
use crate::statics::certify::unbalanced::unbalanced;
use crate::statics::problem::Landscape;
use crate::statics::problem::place::Place;
use crate::statics::settings::Settings;
use crate::statics::watch::Watch;
use std::sync::Arc;

/// The same for a model without stops.
pub(in crate::statics) fn search_free(
    model: &Arc<Model>,
    settings: &Settings,
    start: &[f64],
    watch: &Watch<'_>,
    searched: &mut dyn FnMut(),
    trail: Option<Vec<Vec<f64>>>,
) -> Result<(Equilibrium, Vec<Vec<f64>>), Fault> {
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, start)?;
    landscape.trail = trail;
    landscape.watch = Some(watch);
    let mut history = Vec::new();
    let first = Place::at(&mut landscape, start.to_vec())?;
    landscape.begin(&first);
    let guess = first.clone();
    let Found { mut place, mut notes, effort } = cascade::search(&mut landscape, settings, first, &mut history)?;
    searched();
    if !place.is_balanced() {
        // Where the search ran away, what is missing shows best where it started.
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
        notes.push(ended.or(fall).unwrap_or_else(|| unbalanced(&mut landscape, &place)));
    }
    let trail = landscape.trail.take().unwrap_or_default();
    Ok((certify(landscape, settings, place, effort, history, notes)?, trail))
}
