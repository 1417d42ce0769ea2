//! `[[contact]]`, and `friction` wherever it stands.

use super::reader::{Reader, Value, number};
use crate::model::StopLaw;
use crate::model::description::{ContactDescription, DryFriction};

/// Reads a `[[contact]]`; `None` where too little of it is readable.
pub(super) fn contact(table: &Reader<'_>, index: usize) -> Option<ContactDescription> {
    let name = table.text("name").map_or_else(|| format!("contact[{index}]"), str::to_owned);
    let sides = table.value("between")?.get_ref().as_array()?;
    let mut sides = sides.iter().map(|side| side.get_ref().as_str().map(str::to_owned));
    let friction = table.value("friction").and_then(|value| friction(table, value));
    Some(ContactDescription {
        name,
        between: [sides.next()??, sides.next()??],
        friction: friction.unwrap_or(DryFriction::new(0.0)),
        law: StopLaw::Rigid { restitution: table.number("restitution").unwrap_or(0.0) },
    })
}

/// One number, or one at rest and one in motion.
pub(super) fn friction(table: &Reader<'_>, value: Value<'_>) -> Option<DryFriction> {
    if let Some(inner) = table.open(value) {
        return Some(DryFriction { stick: inner.number("stick")?, slide: inner.number("slide")? });
    }
    number(value.get_ref()).map(DryFriction::new)
}
