//! Which coordinates of hinges are distances and which are angles.

use super::super::fields::Table;
use super::super::findings::Findings;
use super::super::format::{DRIVE, EVENT, GEAR, HINGE, HINGE_CURVE, LIMIT, MOTOR};
use super::super::hinge::kind;
use super::super::reader::{Reader, number};
use crate::hinge::HingeKind;
use std::collections::HashMap;
use toml::de::{DeTable, DeValue};

/// What a number of a coordinate measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Motion {
    Slide,
    Turn,
    /// A number of a quaternion.
    Quaternion,
}

/// The hinges of a file by the names of their bodies.
#[derive(Debug)]
pub(super) struct Hinges(HashMap<String, Vec<Motion>>);

impl Hinges {
    pub(super) fn new(document: &DeTable<'_>) -> Self {
        let bodies = document.get("body").and_then(|bodies| bodies.get_ref().as_array());
        let entry = |body: &toml::Spanned<DeValue<'_>>| {
            let body = body.get_ref().as_table()?;
            let name = body.get("name")?.get_ref().as_str()?;
            Some((name.to_owned(), motions(body.get("hinge")?.get_ref().as_table()?)?))
        };
        Self(bodies.into_iter().flat_map(|bodies| bodies.iter()).filter_map(entry).collect())
    }

    /// The coordinates that the numbers of a table belong to, given those of the table around it.
    pub(super) fn of(
        &self,
        declared: &'static Table,
        table: &DeTable<'_>,
        outer: Option<&[Motion]>,
    ) -> Option<Vec<Motion>> {
        let is = |other: &'static Table| declared.name == other.name;
        if is(&HINGE) && table.contains_key("type") {
            return motions(table);
        }
        if is(&LIMIT) {
            return outer?.get(index(table)).map(|motion| vec![*motion]);
        }
        if is(&HINGE_CURVE) {
            return of_velocities(outer?).get(index(table)).map(|motion| vec![*motion]);
        }
        if !(is(&DRIVE) || is(&MOTOR) || is(&EVENT) || is(&GEAR)) {
            return outer.map(<[Motion]>::to_vec);
        }
        if is(&EVENT) && table.contains_key("on") {
            return Some(vec![Motion::Slide]);
        }
        let first = || table.get("between")?.get_ref().as_array()?.first().map(toml::Spanned::get_ref);
        match if is(&GEAR) { first()? } else { return self.coordinate(table) } {
            DeValue::String(body) => self.body(body)?.first().map(|motion| vec![*motion]),
            DeValue::Table(coordinate) => self.coordinate(coordinate),
            _ => None,
        }
    }

    /// The coordinate that `hinge` and `coordinate` of a table name.
    fn coordinate(&self, table: &DeTable<'_>) -> Option<Vec<Motion>> {
        let body = table.get("hinge")?.get_ref().as_str()?;
        self.body(body)?.get(index(table)).map(|motion| vec![*motion])
    }

    /// A body, or a copy of a repeated one.
    fn body(&self, name: &str) -> Option<&Vec<Motion>> {
        let template = || name.strip_suffix(']').and_then(|name| name.rsplit_once('['));
        self.0.get(name).or_else(|| self.0.get(template()?.0))
    }
}

/// `coordinate` of a table.
fn index(table: &DeTable<'_>) -> usize {
    table.get("coordinate").and_then(|index| number(index.get_ref())).unwrap_or(0.0) as usize
}

fn motions(hinge: &DeTable<'_>) -> Option<Vec<Motion>> {
    let findings = Findings::default();
    Some(of_kind(&kind(&Reader::new(hinge, 0..0, &findings))?))
}

/// Of each velocity, given the coordinates: a quaternion moves by three turns.
pub(super) fn of_velocities(coordinates: &[Motion]) -> Vec<Motion> {
    let plain = coordinates.iter().copied().filter(|motion| *motion != Motion::Quaternion);
    let turns = if coordinates.contains(&Motion::Quaternion) { 3 } else { 0 };
    plain.chain([Motion::Turn; 3].into_iter().take(turns)).collect()
}

/// Of each coordinate.
fn of_kind(kind: &HingeKind) -> Vec<Motion> {
    let of = |(_, unit): &(&str, &str)| match *unit {
        "m" => Motion::Slide,
        "rad" => Motion::Turn,
        _ => Motion::Quaternion,
    };
    kind.positions().iter().map(of).collect()
}
