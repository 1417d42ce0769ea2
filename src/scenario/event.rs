//! `[[event]]`: what a run takes note of.

use super::body::Names;
use super::findings::Finding;
use super::reader::{Reader, Value};
use crate::model::description::{Attachment, Direction, EventDescription, WatchedDescription};
use nalgebra::Vector3;
use toml::de::DeValue;

/// Reads an `[[event]]`; `None` if too little of it is readable.
pub(super) fn event(table: &Reader<'_>, index: usize, bodies: &Names<'_>) -> Option<EventDescription> {
    let name = table.text("name").map_or_else(|| format!("event[{index}]"), str::to_owned);
    if ["hinge", "on", "output"].iter().filter(|key| table.has(key)).count() != 1 {
        let message = format!("event `{name}`: exactly one of `hinge`, `on` and `output` says what is watched");
        table.findings.push(Finding::error(table.span.clone(), message));
        return None;
    }
    let of = match (table.text("hinge"), table.text("output")) {
        (Some(body), _) => {
            WatchedDescription::Hinge { body: body.to_owned(), coordinate: table.count("coordinate").unwrap_or(0) }
        }
        (None, Some(name)) => WatchedDescription::Output { name: name.to_owned() },
        (None, None) => WatchedDescription::Point {
            on: point(table, table.value("on")?, bodies)?,
            axis: table.vector("axis").unwrap_or_else(Vector3::z),
        },
    };
    Some(EventDescription {
        name,
        of,
        value: table.number("value").unwrap_or(0.0),
        direction: match table.text("direction") {
            Some("up") => Direction::Up,
            Some("down") => Direction::Down,
            _ => Direction::Both,
        },
        stops: table.text("action") == Some("stop"),
    })
}

fn point(table: &Reader<'_>, value: Value<'_>, bodies: &Names<'_>) -> Option<Attachment> {
    match value.get_ref() {
        DeValue::String(text) => Some(bodies.attachment(text)),
        DeValue::Table(inner) => bodies.attachment_table(&Reader::new(inner, value.span(), table.findings)),
        _ => None,
    }
}
