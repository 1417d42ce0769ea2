//! Typed access to a table that has been checked against its declaration.
//!
//! Every accessor answers `None` if the key is absent and where something was found wrong with its value: that has
//! been said already, and reading goes on.

use super::findings::{Finding, Findings};
use nalgebra::{UnitQuaternion, Vector3};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value and its span.
pub(super) type Value<'a> = &'a Spanned<DeValue<'a>>;

/// A table, read.
#[derive(Debug, Clone)]
pub(super) struct Reader<'a> {
    pub(super) table: &'a DeTable<'a>,
    /// The header or the braces.
    pub(super) span: Range<usize>,
    pub(super) findings: &'a Findings,
}

impl<'a> Reader<'a> {
    pub(super) fn new(table: &'a DeTable<'a>, span: Range<usize>, findings: &'a Findings) -> Self {
        Self { table, span, findings }
    }

    /// Whether the key is there, readable or not.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// Where the value of a key is written; if it is absent, that of the table.
    pub(super) fn span_of(&self, key: &str) -> Range<usize> {
        self.table.get(key).map_or_else(|| self.span.clone(), Spanned::span)
    }

    /// Where a key is written; if it is absent, that of the table.
    pub(super) fn key_span(&self, key: &str) -> Range<usize> {
        self.table.get_key_value(key).map_or_else(|| self.span.clone(), |(key, _)| key.span())
    }

    /// A value with nothing wrong in it.
    pub(super) fn value(&self, key: &str) -> Option<Value<'a>> {
        self.table.get(key).filter(|value| !self.findings.touch(&value.span()))
    }

    pub(super) fn text(&self, key: &str) -> Option<&'a str> {
        self.value(key)?.get_ref().as_str()
    }

    pub(super) fn flag(&self, key: &str) -> Option<bool> {
        self.value(key)?.get_ref().as_bool()
    }

    pub(super) fn number(&self, key: &str) -> Option<f64> {
        number(self.value(key)?.get_ref())
    }

    pub(super) fn count(&self, key: &str) -> Option<usize> {
        self.number(key).map(|count| count as usize)
    }

    pub(super) fn numbers(&self, key: &str) -> Option<Vec<f64>> {
        numbers(self.value(key)?.get_ref())
    }

    pub(super) fn vector(&self, key: &str) -> Option<Vector3<f64>> {
        vector(self.value(key)?.get_ref())
    }

    /// Roll, pitch, yaw as in URDF.
    pub(super) fn turn(&self, key: &str) -> UnitQuaternion<f64> {
        self.vector(key)
            .map_or_else(UnitQuaternion::identity, |rpy| UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z))
    }

    /// A table, even where something is wrong in it.
    pub(super) fn table(&self, key: &str) -> Option<Reader<'a>> {
        self.open(self.table.get(key)?)
    }

    /// The tables of a list, or the only one.
    pub(super) fn tables(&self, key: &str) -> Vec<Reader<'a>> {
        match self.table.get(key).map(Spanned::get_ref) {
            Some(DeValue::Array(items)) => items.iter().filter_map(|item| self.open(item)).collect(),
            _ => self.table(key).into_iter().collect(),
        }
    }

    /// A table of names in the order of the file.
    pub(super) fn names(&self, key: &str) -> Vec<(&'a str, Reader<'a>)> {
        let Some(inner) = self.table(key) else { return Vec::new() };
        let mut keys: Vec<_> = inner.table.iter().map(|(key, _)| (key.span().start, key.get_ref().as_ref())).collect();
        keys.sort_unstable();
        keys.into_iter().map(|(_, name)| (name, inner.clone())).collect()
    }

    pub(super) fn open(&self, value: Value<'a>) -> Option<Reader<'a>> {
        Some(Reader::new(value.get_ref().as_table()?, value.span(), self.findings))
    }
}

/// The number a value holds, be it finite or not.
pub(super) fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        DeValue::Integer(integer) => u64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|n| n as f64),
        _ => None,
    }
}

/// The numbers of a list.
pub(super) fn numbers(value: &DeValue<'_>) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(|item| number(item.get_ref())).collect()
}

/// The numbers of a list of lists.
pub(super) fn rows(value: &DeValue<'_>) -> Option<Vec<Vec<f64>>> {
    value.as_array()?.iter().map(|item| numbers(item.get_ref())).collect()
}

/// A list of three numbers.
pub(super) fn vector(value: &DeValue<'_>) -> Option<Vector3<f64>> {
    match numbers(value)?[..] {
        [x, y, z] => Some(Vector3::new(x, y, z)),
        _ => None,
    }
}

/// Exactly one of these keys; otherwise that is said, and there is none.
pub(super) fn only<'k>(table: &Reader<'_>, what: &str, keys: &[&'k str]) -> Option<&'k str> {
    let mut given = keys.iter().filter(|key| table.has(key));
    match (given.next(), given.next()) {
        (Some(one), None) => Some(one),
        (first, _) => {
            let list = keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
            let (place, message) = match first {
                Some(first) => (table.key_span(first), format!("{what}: more than one of {list}")),
                None => (table.span.clone(), format!("{what}: one of {list} is needed")),
            };
            table.findings.push(Finding::error(place, message).help("keep exactly one of them"));
            None
        }
    }
}
