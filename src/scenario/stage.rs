//! `[[stage]]`: what opens, closes, locks and is released in a run, and when.

use super::couplings::name;
use super::findings::Finding;
use super::reader::Reader;
use crate::model::description::{StageDescription, When};

/// Reads a `[[stage]]`; `None` if too little of it is readable.
pub(super) fn stage(table: &Reader<'_>, index: usize) -> Option<StageDescription> {
    let name = name(table, "stage", index);
    let inner = table.table("when")?;
    let when = match (inner.has("time"), inner.has("event")) {
        (true, false) => When::Time(inner.number("time")?),
        (false, true) => When::Event(inner.text("event")?.to_owned()),
        _ => {
            let message = format!("stage `{name}`: exactly one of `time` and `event` says when it comes");
            table.findings.push(Finding::error(inner.span.clone(), message));
            return None;
        }
    };
    let names = |key: &str| -> Option<Vec<String>> {
        if !table.has(key) {
            return Some(Vec::new());
        }
        let items = table.value(key)?.get_ref().as_array()?;
        items.iter().map(|item| item.get_ref().as_str().map(str::to_owned)).collect()
    };
    let (open, close, lock, release) = (names("open")?, names("close")?, names("lock")?, names("release")?);
    let outputs = names("outputs")?;
    Some(StageDescription { name, when, open, close, lock, release, outputs })
}
