//! Events that watch a distance for a value that no distance crosses.

use super::{Finding, Scene, exactly};
use crate::model::description::WatchedDescription;
use crate::model::output::QuantityDescription;
use crate::model::problem::number;

pub(super) fn check(scene: &Scene<'_>) {
    let events = &scene.description.events;
    // Of events that could not be read it is said why.
    if scene.tables("event").count() != events.len() {
        return;
    }
    for (table, event) in scene.tables("event").zip(events) {
        let WatchedDescription::Output { name } = &event.of else { continue };
        let is_distance = scene
            .description
            .outputs
            .iter()
            .any(|output| output.name == *name && matches!(output.of, QuantityDescription::Distance { .. }));
        if !(is_distance && event.value <= 0.0) {
            continue;
        }
        let Some(place) = exactly(table, "value").or_else(|| exactly(table, "output")) else { continue };
        let message = format!(
            "event `{}` never comes: the distance `{name}` is never negative, and does not cross {} m",
            event.name,
            number(event.value)
        );
        let help =
            "watch for a small gap above 0, as `value = 0.001`, or for a `position` with an `axis`, which has a sign";
        scene.findings.push(Finding::warning(place.span(), message).help(help));
    }
}
