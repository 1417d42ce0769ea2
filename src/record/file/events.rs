//! `/events`: what happened, as Foxglove log messages.

use super::chunks::{Records, Stop};
use super::{EVENTS_TOPIC, frames};
use crate::foreign;
use crate::record::Event;
use foxglove::messages::Log;
use foxglove::messages::log::Level;
use mcap::records::Record;
use prost::Message;
use std::io::Read;

/// The message of an event; its time is kept to the nanosecond.
pub(super) fn log(event: &Event, nanoseconds: u64) -> Log {
    Log {
        timestamp: Some(frames::timestamp(nanoseconds)),
        level: Level::Info.into(),
        message: event.text.clone(),
        name: event.name.clone(),
        ..Log::default()
    }
}

/// All events of a file, to its last whole chunk where it was cut.
pub(super) fn read(mut records: Records<impl Read>) -> Result<Vec<Event>, String> {
    let (mut channel, mut events) = (None, Vec::new());
    loop {
        match records.next() {
            Some(Ok(Record::Channel(found))) if found.topic == EVENTS_TOPIC => channel = Some(found.id),
            Some(Ok(Record::Message { header, data })) if Some(header.channel_id) == channel => {
                let log = foreign::parse("the reader of protobuf", || Log::decode(&data[..]))?;
                let log = log.map_err(|error| error.to_string())?;
                events.push(Event { time: header.log_time as f64 * 1e-9, name: log.name, text: log.message });
            }
            Some(Ok(_)) => {}
            None | Some(Err(Stop::Truncated)) => return Ok(events),
            Some(Err(Stop::Damaged(what))) => return Err(what),
            Some(Err(Stop::Io(error))) => return Err(error.to_string()),
        }
    }
}
