//! What elements and values are called in messages.

use super::fields::{Key, Table};
use std::fmt;
use toml::de::DeValue;

/// The element a finding is about, named only when there is one: `hinge of body `upper``.
#[derive(Clone, Copy)]
pub(super) struct Element<'e> {
    pub(super) table: &'static Table,
    pub(super) name: Option<&'e str>,
    pub(super) index: Option<usize>,
    pub(super) within: Option<&'e Element<'e>>,
}

impl fmt::Display for Element<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.name, self.index, self.within) {
            (_, _, None) => return Ok(()),
            (Some(name), ..) => write!(f, "{} `{name}`", self.table.name)?,
            (None, Some(index), Some(Element { within: None, .. })) => write!(f, "{}[{index}]", self.table.name)?,
            (None, None, Some(Element { within: None, .. })) => write!(f, "[{}]", self.table.name)?,
            _ => f.write_str(self.table.name)?,
        }
        match self.within {
            Some(outer) if outer.within.is_some() => write!(f, " of {outer}"),
            _ => Ok(()),
        }
    }
}

impl Element<'_> {
    /// What a message starts with.
    pub(super) fn prefix(&self) -> String {
        let name = self.to_string();
        if name.is_empty() { name } else { format!("{name}: ") }
    }
}

/// A value on its way down: the key it belongs to and the element around it.
pub(super) struct Item<'i> {
    pub(super) element: &'i Element<'i>,
    pub(super) key: &'static Key,
    /// As written in a message: `at`, `markers.tip`.
    pub(super) path: String,
}

impl Item<'_> {
    pub(super) fn subject(&self) -> String {
        format!("{}`{}`", self.element.prefix(), self.path)
    }

    pub(super) fn example(&self) -> Option<String> {
        (!self.key.example.is_empty()).then(|| format!("for example `{} = {}`", self.key.name, self.key.example))
    }
}

/// What a value is, for people.
pub(super) fn found(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(_) => format!("the text {}", written(value)),
        DeValue::Integer(_) | DeValue::Float(_) => format!("the number {}", written(value)),
        DeValue::Boolean(flag) => format!("`{flag}`"),
        DeValue::Datetime(_) => "a date or time".to_owned(),
        DeValue::Array(items) if items.is_empty() => "an empty list".to_owned(),
        DeValue::Array(items) => format!("a list of {}", items.len()),
        DeValue::Table(_) => "a table".to_owned(),
    }
}

/// A value as it is written, cut where it is long.
pub(super) fn written(value: &DeValue<'_>) -> String {
    const LONGEST: usize = 40;
    let text = match value {
        DeValue::String(text) => format!("\"{text}\""),
        DeValue::Integer(integer) => integer.to_string(),
        DeValue::Float(float) => float.as_str().to_owned(),
        other => other.type_str().to_owned(),
    };
    match text.char_indices().nth(LONGEST) {
        Some((cut, _)) => format!("{}…", &text[..cut]),
        None => text,
    }
}
