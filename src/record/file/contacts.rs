//! `/contacts`: what contacts push with, as JSON with a schema: their number changes from sample to sample.

use super::chunks::{Records, Stop};
use super::{CONTACTS_TOPIC, HINGES_TOPIC};
use crate::record::ContactPush;
use mcap::records::Record;
use serde_json::{Value, json};
use std::io::Read;

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

/// The message of an instant (s).
pub(super) fn message(time: f64, contacts: &[ContactPush]) -> String {
    let one = |contact: &ContactPush| {
        let mode = if contact.slips { "slip" } else { "stick" };
        json!({
            "between": contact.between, "point": contact.point, "normal": contact.normal, "force": contact.force,
            "mode": mode,
        })
    };
    json!({ "time": time, "contacts": contacts.iter().map(one).collect::<Vec<_>>() }).to_string()
}

fn parsed(data: &[u8]) -> Option<(f64, Vec<ContactPush>)> {
    let value: Value = serde_json::from_slice(data).ok()?;
    let vector = |of: &Value| -> Option<[f64; 3]> { Some([of[0].as_f64()?, of[1].as_f64()?, of[2].as_f64()?]) };
    let name = |of: &Value| of.as_str().map(str::to_owned);
    let one = |of: &Value| {
        Some(ContactPush {
            between: [name(&of["between"][0])?, name(&of["between"][1])?],
            point: vector(&of["point"])?,
            normal: vector(&of["normal"])?,
            force: vector(&of["force"])?,
            slips: of["mode"] == "slip",
        })
    };
    let contacts: Option<Vec<ContactPush>> = value["contacts"].as_array()?.iter().map(one).collect();
    Some((value["time"].as_f64()?, contacts?))
}

/// All messages of a file with their times (s), to its last whole chunk where it was cut.
pub(super) fn read(mut records: Records<impl Read>) -> Result<Vec<(f64, Vec<ContactPush>)>, String> {
    let (mut channel, mut samples, mut all) = (None, None, Vec::new());
    loop {
        match records.next() {
            Some(Ok(Record::Channel(found))) if found.topic == HINGES_TOPIC => samples = Some(found.id),
            // Contacts stand before the sample that they belong to.
            Some(Ok(Record::Message { header, .. })) if channel.is_none() && samples == Some(header.channel_id) => {
                return Ok(all);
            }
            Some(Ok(Record::Channel(found))) if found.topic == CONTACTS_TOPIC => channel = Some(found.id),
            Some(Ok(Record::Message { header, data })) if Some(header.channel_id) == channel => {
                all.push(parsed(&data).ok_or("a message of `/contacts` is not what its schema says")?);
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
            let read = parsed(message(time, std::slice::from_ref(&push)).as_bytes());
            assert_eq!(read, Some((time, vec![push])));
        }
    }
}
