//! The units of what paths set.

use super::super::Scenario;
use super::super::fields::{ANY_UNIT, Key, Kind, Table};
use super::super::format::{HINGE, SCENARIO};
use super::{Override, element, first_key, full_path, split_component};
use crate::model::Parameter;
use crate::model::address::Target;

impl Scenario {
    /// SI unit of the number that a path sets; empty if it has none, or if it is not the same for all that the path stands for. `set`
    /// are changes with which the scenario has been read.
    pub fn unit(&self, set: &[Override], path: &str) -> &'static str {
        if let Some(unit) = self.unit_of_parameter(path) {
            return unit;
        }
        let found = self.in_document(set, |document| match element(path, document) {
            Some(Target { element: (list, _), rest, .. }) => {
                let written = full_path(list, rest)?;
                declared(list, &written)
            }
            None if first_key(path) == HINGE.name => declared(&HINGE, path.split_once('.')?.1),
            None => declared(&SCENARIO, path),
        });
        found.map_or("", |key| self.chosen(key, path))
    }

    /// Whether a path leads to a key of the format, of an element that the file has.
    pub fn has_key(&self, set: &[Override], path: &str) -> bool {
        let found = self.in_document(set, |document| {
            let Target { element: (list, _), rest, .. } = element(path, document)?;
            let written = full_path(list, rest)?;
            Some(!keys(list, &written).is_empty())
        });
        found.unwrap_or(false)
    }

    fn unit_of_parameter(&self, address: &str) -> Option<&'static str> {
        let found = Parameter::find(&self.description, address).ok()?;
        let unit = found.first()?.quantity.unit();
        Some(if found.iter().all(|one| one.quantity.unit() == unit) { unit } else { "" })
    }

    /// The unit of a key, which may depend on what its hinge moves along, or on the component.
    fn chosen(&self, key: &'static Key, path: &str) -> &'static str {
        let (plain, component) = split_component(path);
        if key.unit == ANY_UNIT {
            return "";
        }
        if let Some((along, about)) = key.unit.split_once(" and ") {
            return component.map_or("", |index| if index < 3 { along } else { about });
        }
        let Some((along, about)) = key.unit.split_once(" or ") else { return key.unit };
        let place = component.map_or(String::new(), |index| format!("[{index}]"));
        let hinge = plain.rsplit_once('.').map_or(plain, |(hinge, _)| hinge);
        let hinge = hinge.strip_suffix(".hinge").unwrap_or(hinge);
        match self.unit_of_parameter(&format!("{hinge}.position{place}")) {
            Some("m") => along,
            Some("rad") => about,
            _ => "",
        }
    }
}

/// The key that a path leads to; `None` of keys of one name with several units.
fn declared(table: &'static Table, path: &str) -> Option<&'static Key> {
    let found = keys(table, path);
    let first = found.first().copied()?;
    found.iter().all(|key| key.unit == first.unit).then_some(first)
}

/// The keys that a path leads to: several where the meaning depends on the type.
fn keys(table: &'static Table, path: &str) -> Vec<&'static Key> {
    let (first, rest) = path.split_once('.').unwrap_or((path, ""));
    let own = table.declarations(first_key(first));
    if rest.is_empty() {
        return own.collect();
    }
    own.filter_map(|key| inner(&key.kind)).flat_map(|table| keys(table, rest)).collect()
}

/// The table that a key can hold.
fn inner(kind: &'static Kind) -> Option<&'static Table> {
    match kind {
        Kind::Table(table) => Some(table),
        Kind::List(kind, _) => inner(kind),
        Kind::Either(kinds) => kinds.iter().find_map(inner),
        _ => None,
    }
}
