//! Numbers that are measured as what they are compared with, or as what they make of it: values of events, setpoints and gains of controllers.

use super::findings::Finding;
use super::quantities::Numbers;
use super::reader::Reader;
use crate::model::controller::{ControlLawDescription, ControllerDescription};
use crate::model::description::{EventDescription, WatchedDescription};
use crate::model::structure::Structure;
use crate::model::{Description, Model};
use crate::quantity::Dimension;
use crate::quantity::measure::Measure;
use std::ops::Range;
use toml::Spanned;
use toml::de::DeValue;

/// Refuses quantities in another unit than that of the coordinate or output that they are compared with, and makes them numbers of that unit: an output
/// may count in degrees.
pub(super) fn settle(scenario: &Reader<'_>, description: &mut Description, texts: &Numbers) {
    let (events, controllers) = (scenario.tables("event"), scenario.tables("controller"));
    let mut spans: Vec<Range<usize>> = events.iter().flat_map(|table| written(table, "value")).collect();
    spans.extend(controllers.iter().flat_map(|table| CONTROLLER_KEYS.map(|key| written(table, key))).flatten());
    // What is wrong with the elements themselves is said elsewhere.
    let whole = (events.len(), controllers.len()) == (description.events.len(), description.controllers.len());
    if !whole || spans.iter().all(|span| texts.measure(span).is_none()) {
        return;
    }
    let Ok(model) = Model::build(&Structure::first(description).describe(description)) else { return };
    let measuring = Measuring { scenario, texts, model: &model };
    for (index, table) in events.iter().enumerate() {
        if let Some((what, unit)) = measuring.watched(description, &description.events[index]) {
            let sizes = written(table, "value").into_iter().map(|span| measuring.size(span, &what, &unit));
            description.events[index].value /= sizes.product::<f64>();
        }
    }
    for (table, controller) in controllers.iter().zip(&mut description.controllers) {
        measuring.controller(table, controller);
    }
}

/// What 1 of the unit is, if a quantity is written here; else 1. A quantity in a unit that does not fit is refused.
pub(super) fn size(scenario: &Reader<'_>, texts: &Numbers, span: Range<usize>, what: &str, unit: &str) -> f64 {
    let Some(measure) = texts.measure(&span).filter(|measure| *measure != Measure::Plain) else { return 1.0 };
    if !Dimension::of(unit).is_ok_and(|dimension| measure.fits(dimension)) {
        let unit = if unit.is_empty() || unit == "1" { "a pure number" } else { &format!("measured in {unit}") };
        scenario.findings.push_value(Finding::error(span, format!("`{what}` is {unit}, not in this unit")));
    }
    Dimension::size_of(unit)
}

/// Keys of controllers whose unit is that of what they sense and drive.
const CONTROLLER_KEYS: [&str; 7] = ["setpoint", "bias", "limit", "matrix", "proportional", "integral", "derivative"];

/// A number that a controller senses or drives, and its unit.
struct Measured<'a> {
    name: &'a str,
    unit: String,
}

struct Measuring<'s> {
    scenario: &'s Reader<'s>,
    texts: &'s Numbers,
    model: &'s Model,
}

impl Measuring<'_> {
    /// Units of the numbers of an output, or of the one that a label names.
    fn units_of(&self, name: &str) -> Vec<String> {
        let labels = self.model.outputs.iter().flat_map(|output| output.labels().zip(&output.units));
        let own = |label: &str| label == name || label.strip_prefix(name).is_some_and(|rest| rest.starts_with('['));
        labels.filter(|(label, _)| own(label)).map(|(_, unit)| unit.clone()).collect()
    }

    /// What an event watches, and its unit.
    fn watched(&self, description: &Description, event: &EventDescription) -> Option<(String, String)> {
        let hinge = |name: &String| {
            let of_body = description.bodies.iter().find(|body| body.name == *name).map(|body| &body.hinge.kind);
            of_body.or_else(|| description.beams.iter().find(|beam| beam.name == *name).map(|beam| &beam.hinge.kind))
        };
        match &event.of {
            WatchedDescription::Point { .. } => Some((event.name.clone(), "m".to_owned())),
            WatchedDescription::Output { name } => Some((name.clone(), self.units_of(name).into_iter().next()?)),
            WatchedDescription::Hinge { body, coordinate } => {
                Some((body.clone(), hinge(body)?.positions().get(*coordinate)?.1.to_owned()))
            }
        }
    }

    fn size(&self, span: Range<usize>, what: &str, unit: &str) -> f64 {
        size(self.scenario, self.texts, span, what, unit)
    }

    /// What a gain is multiplied with that is a quantity, so that it is one on numbers of this unit; the times a second as often as `time` says.
    fn gain(&self, span: Range<usize>, over: &Measured<'_>, under: &Measured<'_>, time: f64) -> f64 {
        let Some(measure) = self.texts.measure(&span).filter(|measure| *measure != Measure::Plain) else { return 1.0 };
        let Some(wanted) = gain(&over.unit, &under.unit, time) else { return 1.0 };
        if measure.together(wanted).is_none() {
            let per = match time {
                0.0 => "",
                -1.0 => " and second",
                _ => ", times a second",
            };
            let (over, under) = (&over.unit, if under.unit.is_empty() { "1" } else { &under.unit });
            let message = format!("this gain is measured in {over} per {under}{per}, not in this unit");
            self.scenario.findings.push_value(Finding::error(span, message));
        }
        Dimension::size_of(&under.unit)
    }

    fn controller(&self, table: &Reader<'_>, controller: &mut ControllerDescription) {
        let of_sensed = |name| self.units_of(name).into_iter().map(move |unit| Measured { name, unit });
        let sensed: Vec<Measured> = controller.senses.iter().map(String::as_str).flat_map(of_sensed).collect();
        let driven: Vec<Measured> = controller.drives.iter().filter_map(|name| driven(self.model, name)).collect();
        if sensed.is_empty() || driven.is_empty() || driven.len() != controller.drives.len() {
            return;
        }
        let sizes = |key: &str, of: &[Measured<'_>]| -> Vec<f64> {
            let all = written(table, key).into_iter().zip(of);
            all.map(|(span, one)| self.size(span, one.name, &one.unit)).collect()
        };
        let wanted = sizes("setpoint", &sensed);
        sizes("bias", &driven);
        sizes("limit", &driven);
        match &mut controller.law {
            ControlLawDescription::Gain { matrix, setpoint, .. } => {
                setpoint.iter_mut().zip(wanted).for_each(|(number, size)| *number /= size);
                let spans = written(table, "matrix");
                // Rows of a wrong length are said to be so elsewhere.
                if matrix.len() != driven.len() || matrix.iter().any(|row| row.len() != sensed.len()) {
                    return;
                }
                let entries = matrix.iter_mut().zip(&driven);
                let entries =
                    entries.flat_map(|(row, over)| row.iter_mut().zip(&sensed).map(move |(k, y)| (k, over, y)));
                for ((k, over, under), span) in entries.zip(spans) {
                    *k *= self.gain(span, over, under, 0.0);
                }
            }
            ControlLawDescription::Pid { proportional, integral, derivative, setpoint, .. } => {
                *setpoint /= wanted.iter().product::<f64>();
                let gains = [
                    ("proportional", proportional, 0.0),
                    ("integral", integral, -1.0),
                    ("derivative", derivative, 1.0),
                ];
                for (key, gain, time) in gains {
                    for span in written(table, key) {
                        *gain *= self.gain(span, &driven[0], &sensed[0], time);
                    }
                }
            }
            ControlLawDescription::Expression { .. } => {}
        }
    }
}

/// What a motor pushes with.
fn driven<'a>(model: &Model, name: &'a str) -> Option<Measured<'a>> {
    let motor = model.motors.iter().find(|motor| motor.name == name)?;
    let unit = if motor.coordinate.slides { "N" } else { "N m" };
    Some(Measured { name, unit: unit.to_owned() })
}

/// What a gain measures: one unit over another, times a power of time.
fn gain(over: &str, under: &str, time: f64) -> Option<Measure> {
    let of = |unit: &str| {
        Some(Measure::from(if matches!(unit, "" | "1") { Dimension::default() } else { Dimension::of(unit).ok()? }))
    };
    Some(of(over)?.times(of(under)?, -1.0).times(of("s")?, time))
}

/// Where the numbers of a key are written, row by row.
fn written(table: &Reader<'_>, key: &str) -> Vec<Range<usize>> {
    fn each(value: &Spanned<DeValue<'_>>, spans: &mut Vec<Range<usize>>) {
        match value.get_ref().as_array() {
            Some(items) => items.iter().for_each(|item| each(item, spans)),
            None => spans.push(value.span()),
        }
    }
    let mut spans = Vec::new();
    table.value(key).into_iter().for_each(|value| each(value, &mut spans));
    spans
}
