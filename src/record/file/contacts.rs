//! `/contacts`: what contacts push with, as JSON with a schema: their number changes from sample to sample. A message stands before the first
//! sample that it belongs to, and holds until the next: what rests is written once.

use super::chunks::{Records, Stop};
use super::{CONTACTS_TOPIC, HINGES_TOPIC};
use crate::record::{ContactInstants, ContactPush};
use mcap::records::Record;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::borrow::Cow;
use std::io::Read;
use std::sync::Arc;

/// The schema's name, and the JSON Schema of a message.
pub(super) const NAME: &str = "stillpoint.Contacts";

/// What a message holds.
pub(super) fn schema() -> String {
    let vector = json!({ "type": "array", "items": { "type": "number" } });
    let contact = json!({
        "type": "object",
        "properties": {
            "between": { "type": "array", "items": { "type": "string" } },
            "point": vector, "normal": vector, "force": vector,
            "mode": { "type": "string", "enum": ["stick", "slip"] },
        },
    });
    let properties = json!({ "time": { "type": "number" }, "contacts": { "type": "array", "items": contact } });
    json!({ "title": NAME, "type": "object", "properties": properties }).to_string()
}

/// A message.
#[derive(Serialize, Deserialize)]
struct Instant<'a> {
    #[serde(borrow)]
    contacts: Vec<Push<'a>>,
    /// (s)
    time: f64,
}

/// One contact of it.
#[derive(Serialize, Deserialize)]
struct Push<'a> {
    #[serde(borrow)]
    between: [Cow<'a, str>; 2],
    force: [f64; 3],
    mode: Mode,
    normal: [f64; 3],
    point: [f64; 3],
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Mode {
    Stick,
    Slip,
}

/// Appends the message of an instant (s).
///
/// # Errors
/// None of numbers and names; what serializers may say.
pub(super) fn message(time: f64, contacts: &[ContactPush], into: &mut Vec<u8>) -> serde_json::Result<()> {
    fn one(contact: &ContactPush) -> Push<'_> {
        let [first, second] = &contact.between;
        Push {
            between: [Cow::Borrowed(first), Cow::Borrowed(second)],
            force: contact.force,
            mode: if contact.slips { Mode::Slip } else { Mode::Stick },
            normal: contact.normal,
            point: contact.point,
        }
    }
    serde_json::to_writer(into, &Instant { contacts: contacts.iter().map(one).collect(), time })
}

fn parsed(data: &[u8]) -> serde_json::Result<(f64, Vec<ContactPush>)> {
    let Instant { contacts, time } = serde_json::from_slice(data)?;
    let one = |push: Push<'_>| ContactPush {
        between: push.between.map(Cow::into_owned),
        point: push.point,
        normal: push.normal,
        force: push.force,
        slips: matches!(push.mode, Mode::Slip),
    };
    Ok((time, contacts.into_iter().map(one).collect()))
}

/// What holds at each sample of a file, with its time (s), to its last whole chunk where it was cut; nothing of a scene without contact.
pub(super) fn read(mut records: Records<impl Read>) -> Result<ContactInstants, String> {
    let (mut channel, mut samples, mut all) = (None, None, Vec::new());
    // Since when the last message holds (s), until a sample has had it.
    let (mut since, mut holds) = (None, Arc::default());
    loop {
        match records.next() {
            Some(Ok(Record::Channel(found))) if found.topic == HINGES_TOPIC => samples = Some(found.id),
            Some(Ok(Record::Channel(found))) if found.topic == CONTACTS_TOPIC => channel = Some(found.id),
            Some(Ok(Record::Message { header, data })) if Some(header.channel_id) == channel => {
                let (time, contacts) = parsed(&data)
                    .map_err(|why| format!("a message of `/contacts` is not what its schema says: {why}"))?;
                (since, holds) = (Some(time), Arc::new(contacts));
            }
            Some(Ok(Record::Message { header, .. })) if samples == Some(header.channel_id) => {
                if channel.is_none() {
                    return Ok(all);
                }
                all.push((since.take().unwrap_or(header.log_time as f64 * 1e-9), Arc::clone(&holds)));
            }
            Some(Ok(_)) => {}
            None | Some(Err(Stop::Truncated)) => return Ok(all),
            Some(Err(Stop::Damaged(what))) => return Err(what),
            Some(Err(Stop::Io(error))) => return Err(error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_are_read_back_bit_for_bit() {
        let mut bits = 0x1234_5678_9abc_def1_u64;
        let mut number = || loop {
            // Marsaglia's xorshift: numbers of all sizes.
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            let number = f64::from_bits(bits);
            if number.is_finite() {
                return number;
            }
        };
        for _ in 0..2000 {
            let mut vector = || [number(), number(), number()];
            let push = ContactPush {
                between: ["a", "b"].map(str::to_owned),
                point: vector(),
                normal: vector(),
                force: vector(),
                slips: true,
            };
            let time = number();
            let mut written = Vec::new();
            message(time, std::slice::from_ref(&push), &mut written).unwrap();
            assert_eq!(parsed(&written).unwrap(), (time, vec![push]));
        }
    }
}
