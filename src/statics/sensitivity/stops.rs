//! Stops that touch and bear next to nothing: on their other side an equilibrium answers otherwise.

use crate::model::Model;
use crate::statics::certify::bearing::{self, Set};
use crate::statics::certify::equilibrium::Equilibrium;

/// What bears with less than this part of the largest force is about to lift off.
const LIFTS: f64 = 1e-9;

/// Stops of an equilibrium that touch and bear next to nothing: how it answers to a push is another one on their other side.
pub fn idle_stops(model: &Model, found: &Equilibrium) -> Vec<String> {
    let largest = found.reactions.iter().map(|wrench| wrench.force.norm()).fold(0.0, f64::max);
    let touched = bearing::touching(model, &found.position);
    let idle = |(index, stop): (usize, &crate::model::Stop)| {
        let load = bearing::told(model, found, stop).map_or(0.0, |one| one.load);
        let lever = model.length_scale() / bearing::unit(model, stop.velocity);
        let bears = load > LIFTS * largest * lever;
        (touched[index].is_some() && !bears).then(|| model.label(stop.velocity))
    };
    model.stops.iter().enumerate().filter_map(idle).collect()
}

/// Stops that touch without a push: on their other side derivatives are others.
pub(super) fn one_sided(model: &Model, found: &Equilibrium, set: &Set, largest: f64) -> Vec<String> {
    let touched = bearing::touching(model, &found.position);
    let idle = |index: usize| {
        let stop = &model.stops[index];
        let hinge = model.label(stop.velocity);
        let load = bearing::told(model, found, stop).map_or(0.0, |one| one.load);
        let lever = bearing::unit(model, stop.velocity);
        match set[index] {
            None => touched[index]
                .is_some()
                .then(|| format!("the stop of {hinge} touches and bears nothing: sensitivities are those without it")),
            _ if load * lever <= LIFTS * largest => {
                Some(format!("the stop of {hinge} bears next to nothing: sensitivities hold as long as it bears"))
            }
            _ => None,
        }
    };
    let mut notes: Vec<String> = (0..set.len()).filter_map(idle).collect();
    let bears: Vec<String> = found.stops.iter().map(|stop| stop.hinge.clone()).collect();
    if !bears.is_empty() {
        notes.push(format!("sensitivities hold as long as the stops of {} bear", bears.join(", ")));
    }
    notes
}
