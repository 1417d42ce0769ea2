//! Numbers that are allowed and hardly meant: slips of the unit, and strains that beams leave out. Each is a warning with its place, the reason and the likely conversion; nothing
//! is changed. A number whose unit is written beside it (`"720 deg"`) is taken at its word.
//!
//! Rather no warning than a wrong one: whatever a scene may have meant is not told.

mod angles;
mod beams;
mod distances;
mod gravity;
mod lengths;
mod sliders;
mod springs;

use super::findings::{Finding, Findings};
use super::hinge::kind;
use super::quantities::Numbers;
use super::reader::Reader;
use crate::hinge::HingeKind;
use crate::model::{Description, Model};
use lengths::Lengths;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

type Place<'a> = &'a Spanned<DeValue<'a>>;

/// A number, and where it is written.
#[derive(Debug, Clone, PartialEq)]
struct Written {
    span: Range<usize>,
    value: f64,
    /// Whether it stands there as a text, with a unit or as a formula: then it is meant.
    is_text: bool,
}

/// A scene whose numbers are judged.
struct Scene<'a> {
    document: &'a DeTable<'a>,
    description: &'a Description,
    numbers: &'a Numbers,
    findings: &'a Findings,
    /// Where something was told: one warning for a number.
    told: RefCell<BTreeSet<(usize, usize)>>,
}

/// Judges the numbers of a scene.
///
/// `model` is that of the description, with its loops closed; `None` if something is wrong besides.
pub(super) fn check(
    document: &DeTable<'_>,
    (description, model): (&Description, Option<&Model>),
    numbers: &Numbers,
    findings: &Findings,
) {
    // What is wrong besides may be why a number looks strange.
    let scene = Scene { document, description, numbers, findings, told: RefCell::default() };
    gravity::check(&scene);
    angles::check(&scene);
    let lengths = Lengths::new(&scene);
    springs::check(&scene, &lengths, model);
    lengths::check(&scene, &lengths);
    beams::check(&scene);
    sliders::check(&scene);
    distances::check(&scene);
    check_stages(&scene);
}

impl<'a> Scene<'a> {
    /// The tables of a list such as `[[body]]`.
    fn tables(&self, list: &str) -> impl Iterator<Item = &'a DeTable<'a>> + use<'a> {
        tables(self.document.get(list))
    }

    /// All numbers of a value.
    fn numbers(&self, place: Place<'_>) -> Vec<Written> {
        let mut found = Vec::new();
        collect(place, &mut |span, value| {
            let is_text = self.numbers.is_text(&span);
            found.push(Written { span, value, is_text });
        });
        found
    }

    /// The number on a path, if there is one and no more.
    fn number(&self, table: &DeTable<'_>, path: &str) -> Option<Written> {
        let mut all = self.numbers(exactly(table, path)?);
        if all.len() == 1 { all.pop() } else { None }
    }

    fn warn(&self, written: &Written, message: String, help: String) {
        if !written.is_text && self.told.borrow_mut().insert((written.span.start, written.span.end)) {
            self.findings.push(Finding::warning(written.span.clone(), message).help(help));
        }
    }
}

/// The tables that a list holds, or the one that stands in its place.
fn tables<'a>(place: Option<Place<'a>>) -> impl Iterator<Item = &'a DeTable<'a>> + use<'a> {
    let value = place.map(Spanned::get_ref);
    let list = value.and_then(|value| value.as_array());
    let one = value.and_then(|value| value.as_table());
    one.into_iter().chain(list.into_iter().flat_map(|list| list.iter().filter_map(|item| item.get_ref().as_table())))
}

/// The value on a path, if all of its keys are there.
fn exactly<'a>(table: &'a DeTable<'a>, path: &str) -> Option<Place<'a>> {
    match path.split_once('.') {
        Some((key, rest)) => exactly(table.get(key)?.get_ref().as_table()?, rest),
        None => table.get(path),
    }
}

/// The text on a path.
fn text<'a>(table: &'a DeTable<'a>, path: &str) -> Option<&'a str> {
    exactly(table, path)?.get_ref().as_str()
}

/// All numbers of lists within lists.
fn collect(place: Place<'_>, found: &mut dyn FnMut(Range<usize>, f64)) {
    let number = |text: &str| text.replace('_', "").parse::<f64>().ok().filter(|x| x.is_finite());
    let value = match place.get_ref() {
        DeValue::Integer(text) => number(text.as_str()),
        DeValue::Float(text) => number(text.as_str()),
        DeValue::Array(items) => {
            items.iter().for_each(|item| collect(item, found));
            None
        }
        _ => None,
    };
    if let Some(value) = value {
        found(place.span(), value);
    }
}

/// What the hinge of a body or beam leaves free, if it has one.
fn hinge_of(body: &DeTable<'_>) -> Option<HingeKind> {
    let findings = Findings::default();
    kind(&Reader::new(body.get("hinge")?.get_ref().as_table()?, 0..0, &findings))
}

/// The units of the coordinates of a hinge.
fn units(kind: &HingeKind) -> Vec<&'static str> {
    kind.positions().iter().map(|(_, unit)| *unit).collect()
}

/// The numbers of a key with a value for each of `count` coordinates, for one body or for each copy, and which coordinate they are of.
fn by_coordinate<'a>(place: Place<'a>, count: usize) -> Vec<(usize, Place<'a>)> {
    let Some(items) = place.get_ref().as_array() else { return vec![(0, place)] };
    let of = |(k, item): (usize, Place<'a>)| match item.get_ref().as_array() {
        Some(of_copy) => of_copy.iter().enumerate().collect::<Vec<_>>(),
        // A list of one number for each copy, or of one for each coordinate.
        None => vec![(if count == 1 { 0 } else { k }, item)],
    };
    items.iter().enumerate().flat_map(of).collect()
}

/// The limits of a hinge, and the coordinates that they are of: pairs or tables, one or a list.
fn limits<'a>(place: Place<'a>) -> Vec<(usize, Place<'a>)> {
    let in_full: Vec<&DeTable<'_>> = tables(Some(place)).collect();
    if !in_full.is_empty() {
        let of = |limit: &'a DeTable<'a>| {
            let mut coordinate = 0;
            if let Some(place) = limit.get("coordinate") {
                collect(place, &mut |_, value| coordinate = value as usize);
            }
            ["low", "high"].into_iter().filter_map(move |key| Some((coordinate, limit.get(key)?)))
        };
        return tables(Some(place)).flat_map(of).collect();
    }
    let Some(items) = place.get_ref().as_array() else { return Vec::new() };
    let of = |(k, item): (usize, Place<'a>)| match item.get_ref().as_array() {
        Some(pair) => pair.iter().map(|one| (k, one)).collect::<Vec<_>>(),
        None => vec![(0, item)],
    };
    items.iter().enumerate().flat_map(of).collect()
}

/// What a length in millimetres is told.
fn in_millimetres(length: f64) -> String {
    format!(
        "lengths are metres: {length} mm are {}; write \"{length} mm\", or \"{length} m\" if it is meant",
        length / 1000.0
    )
}

/// What waits for a time after the end of the run.
fn check_stages(scene: &Scene<'_>) {
    let Some(duration) = scene.number(scene.document, "simulate.duration").map(|written| written.value) else { return };
    for stage in scene.tables("stage") {
        let Some(time) = scene.number(stage, "when.time").filter(|time| time.value > duration) else { continue };
        let message = format!("the stage comes at {} s, after the end of the run at {duration} s", time.value);
        scene.warn(&time, message, "a longer `duration` in `[simulate]` reaches it".to_owned());
    }
}
