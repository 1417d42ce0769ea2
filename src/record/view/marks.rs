//! What happened, as lines of a log: those of one name under one path.

use super::entity::{TIMELINE, path};
use super::sdk::{TextLog, TextLogLevel, TimeColumn};
use super::sent::Sent;
use super::stream::Stream;
use crate::record::Event;
use std::collections::BTreeMap;

/// The folder of all of them.
pub(super) const EVENTS: &str = "events";
/// Says of itself which method goes on from here: of use to whom the steps matter.
const INTEGRATOR: &str = "integrator";

/// Sends events at their times.
pub(super) fn send(stream: &Stream, events: &[Event]) -> Sent {
    let mut by_name: BTreeMap<&str, Vec<&Event>> = BTreeMap::new();
    for event in events {
        by_name.entry(event.name.as_str()).or_default().push(event);
    }
    for (name, events) in by_name {
        let level = if name == INTEGRATOR { TextLogLevel::DEBUG } else { TextLogLevel::INFO };
        let times = TimeColumn::new_duration_secs(TIMELINE, events.iter().map(|event| event.time));
        let lines = TextLog::update_fields()
            .with_many_text(events.iter().map(|event| event.text.as_str()))
            .with_many_level(std::iter::repeat_n(level, events.len()));
        stream.send_columns(path(&[EVENTS, name]), times, lines.columns_of_unit_batches()?)?;
    }
    Ok(())
}
