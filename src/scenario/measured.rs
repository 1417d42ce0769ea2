//! Numbers that are measured as what they are compared with: values of events, and setpoints of controllers.

use super::findings::Finding;
use super::quantities::Numbers;
use super::reader::Reader;
use crate::model::controller::ControlLawDescription;
use crate::model::description::WatchedDescription;
use crate::model::structure::Structure;
use crate::model::{Description, Model};
use crate::quantity::Dimension;
use crate::quantity::measure::Measure;
use std::ops::Range;

/// Refuses quantities in another unit than that of the coordinate or output that they are compared with.
pub(super) fn check(scenario: &Reader<'_>, description: &Description, texts: &Numbers) {
    let (events, controllers) = (scenario.tables("event"), scenario.tables("controller"));
    let mut spans: Vec<Range<usize>> = events.iter().flat_map(|table| written(table, "value")).collect();
    spans.extend(controllers.iter().flat_map(|table| written(table, "setpoint")));
    // What is wrong with the elements themselves is said elsewhere.
    let whole = (events.len(), controllers.len()) == (description.events.len(), description.controllers.len());
    if !whole || spans.iter().all(|span| texts.measure(span).is_none()) {
        return;
    }
    let Ok(model) = Model::build(&Structure::first(description).describe(description)) else { return };
    let labels = || model.outputs.iter().flat_map(|output| output.labels().zip(&output.units));
    let units_of = |name: &str| -> Vec<String> {
        let own = |label: &str| label == name || label.strip_prefix(name).is_some_and(|rest| rest.starts_with('['));
        labels().filter(|(label, _)| own(label)).map(|(_, unit)| unit.clone()).collect()
    };
    let hinge = |name: &String| {
        let of_body = description.bodies.iter().find(|body| body.name == *name).map(|body| &body.hinge.kind);
        of_body.or_else(|| description.beams.iter().find(|beam| beam.name == *name).map(|beam| &beam.hinge.kind))
    };
    let refuse = |span: Range<usize>, what: &str, unit: &str| {
        let fits = |measure: Measure| Dimension::of(unit).is_ok_and(|dimension| measure.fits(dimension));
        if texts.measure(&span).is_some_and(|measure| !fits(measure)) {
            let unit = if unit.is_empty() || unit == "1" { "a pure number" } else { &format!("measured in {unit}") };
            scenario.findings.push_value(Finding::error(span, format!("`{what}` is {unit}, not in this unit")));
        }
    };
    for (table, event) in events.iter().zip(&description.events) {
        let (what, unit) = match &event.of {
            WatchedDescription::Point { .. } => (event.name.clone(), Some("m".to_owned())),
            WatchedDescription::Output { name } => (name.clone(), units_of(name).into_iter().next()),
            WatchedDescription::Hinge { body, coordinate } => {
                let unit = hinge(body).and_then(|kind| Some(kind.positions().get(*coordinate)?.1.to_owned()));
                (body.clone(), unit)
            }
        };
        for (span, unit) in written(table, "value").into_iter().zip(unit) {
            refuse(span, &what, &unit);
        }
    }
    for (table, controller) in controllers.iter().zip(&description.controllers) {
        if let ControlLawDescription::Expression { .. } = controller.law {
            continue;
        }
        let sensed: Vec<(&String, String)> = controller
            .senses
            .iter()
            .flat_map(|name| units_of(name).into_iter().map(move |unit| (name, unit)))
            .collect();
        for (span, (name, unit)) in written(table, "setpoint").into_iter().zip(sensed) {
            refuse(span, name, &unit);
        }
    }
}

/// Where the numbers of a key are written.
fn written(table: &Reader<'_>, key: &str) -> Vec<Range<usize>> {
    let Some(value) = table.value(key) else { return Vec::new() };
    match value.get_ref().as_array() {
        Some(items) => items.iter().map(|item| item.span()).collect(),
        None => vec![value.span()],
    }
}
