//! `--set path=value`: changes to a scenario from the command line.
//!
//! | path | sets |
//! |---|---|
//! | `title`, `gravity` | a key of the file |
//! | `simulate.duration` | a key of `[simulate]`, `[statics]` or `[record]` |
//! | `model.base` | how a model is taken; its bodies and hinges are set by name like all others |
//! | `upper.mass`, `upper.markers.tip` | a key of the body `upper`; of a repeated body for all its copies |
//! | `upper.hinge.position`, `upper.position` | a key of its hinge |
//! | `boom.material.young`, `boom.young` | a key of the material of a beam or a cable |
//! | `stay.stiffness`, `force[0].stiffness` | a key of a force, by its name or its place, and so of whatever else is a list in the file: loops, drives, gears, motors, events |
//! | `link[3].stiffness` | of one copy of a repeated body, if copies may differ in it |
//! | `gravity[2]`, `push.force[0]`, `slider.position[1]` | one component of a list |
//! | `tyre.force.extension[3][1]`, `stay.between[1].at[2]` | a component of a list within a list, or of a table within one |
//! | `hinge.damping` | a key of every hinge whose type has it, unless something is called `hinge` |
//!
//! The value is written as in a file; what is no TOML value is taken as text, so `statics.want=any` needs no quotes.

mod component;
mod overlap;
mod unit;
mod within;

use super::check::article;
use super::fields::{Kind, Table, listed};
use super::findings::{Finding, Findings};
use super::format::{BODY, HINGE, MATERIAL, SCENARIO};
use super::quantities::PARAMETERS;
use super::reader::number;
use super::sources::Sources;
use crate::model::address::{Entry, Target, resolve, split_component};
use crate::suggest::closest;
use component::Part;
use std::borrow::Cow;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// One change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// As on a command line: `--set upper.mass=2.0`.
    shown: String,
    path: Range<usize>,
    value: Range<usize>,
}

/// Why a text is no override.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum OverrideError {
    /// There is no `=`: option and text.
    #[error("`{0} {1}` sets nothing: write a path and a value, for example `{0} upper.mass=2.0`")]
    NoValue(&'static str, String),
    /// There is nothing before the `=`: option and text.
    #[error("`{0} {1}` names nothing to set: write a path and a value, for example `{0} upper.mass=2.0`")]
    NoPath(&'static str, String),
}

impl Override {
    /// Reads `path=value`.
    ///
    /// # Errors
    /// If the path or the `=` is missing. Whether the path exists and the value fits is checked by
    /// [`parse`](super::parse) and [`load_with`](super::load_with).
    pub fn parse(text: &str) -> Result<Self, OverrideError> {
        Self::of_option("--set", text)
    }

    /// As [`parse`](Self::parse), of another option of the command line, which is named in messages.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn of_option(option: &'static str, text: &str) -> Result<Self, OverrideError> {
        let (path, value) = text.split_once('=').ok_or_else(|| OverrideError::NoValue(option, text.to_owned()))?;
        let part = |from: usize, text: &str| {
            let start = option.len() + 1 + from + (text.len() - text.trim_start().len());
            start..start + text.trim().len()
        };
        if path.trim().is_empty() {
            return Err(OverrideError::NoPath(option, text.to_owned()));
        }
        if value.trim().is_empty() {
            return Err(OverrideError::NoValue(option, text.to_owned()));
        }
        Ok(Self { shown: format!("{option} {text}"), path: part(0, path), value: part(path.len() + 1, value) })
    }

    /// Gives a number of `[parameters]` another value; a name may hold anything.
    pub(super) fn of_parameter(name: &str, value: f64) -> Self {
        let (path, value) = (format!("{PARAMETERS}.{name}"), format!("{value:?}"));
        let ends = (path.len(), path.len() + 1 + value.len());
        Self { shown: format!("{path}={value}"), path: 0..ends.0, value: ends.0 + 1..ends.1 }
    }

    /// As on a command line: `--set upper.mass=2.0`.
    pub fn shown(&self) -> &str {
        &self.shown
    }

    /// What it sets.
    pub fn path(&self) -> &str {
        &self.shown[self.path.clone()]
    }

    /// Whether it changes how a model is taken, or a parameter that this may follow from: that has to be known before there are any
    /// bodies.
    pub(super) fn is_of_model(&self) -> bool {
        let first = self.path().split_once('.').map_or(self.path(), |(first, _)| first);
        first == "model" || first == PARAMETERS
    }
}

/// Puts all overrides into a parsed file, so that they are checked as if they were written there.
pub(super) fn apply<'a>(
    overrides: Vec<&'a Override>,
    document: &mut DeTable<'a>,
    sources: &mut Sources<'a>,
    findings: &Findings,
) {
    for change in overrides {
        let start = sources.add("command line", &change.shown);
        let text = &change.shown[change.value.clone()];
        let value = moved(parse_value(text), start + change.value.start);
        let change = Change { path: change.path(), span: start + change.path.start..start + change.path.end, value };
        if let Err(finding) = change.apply(document) {
            findings.push(finding);
        }
    }
}

fn parse_value(text: &str) -> Spanned<DeValue<'_>> {
    DeValue::parse(text).unwrap_or_else(|_| Spanned::new(0..text.len(), DeValue::String(Cow::Borrowed(text))))
}

/// A value with all spans moved.
pub(super) fn moved(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let span = value.span().start + by..value.span().end + by;
    let inner = match value.into_inner() {
        DeValue::Array(items) => DeValue::Array(items.into_iter().map(|item| moved(item, by)).collect()),
        DeValue::Table(table) => DeValue::Table(
            table
                .into_iter()
                .map(|(key, value)| {
                    let span = key.span().start + by..key.span().end + by;
                    (Spanned::new(span, key.into_inner()), moved(value, by))
                })
                .collect(),
        ),
        other => other,
    };
    Spanned::new(span, inner)
}

struct Change<'a> {
    path: &'a str,
    span: Range<usize>,
    value: Spanned<DeValue<'a>>,
}

impl<'a> Change<'a> {
    fn apply(self, document: &mut DeTable<'a>) -> Result<(), Finding> {
        let first = self.path.split(['.', '[']).next().unwrap_or_default();
        let of_file = |name: &str| SCENARIO.declarations(name).next().map(|key| &key.kind);
        let is_setting = match of_file(first) {
            Some(kind) if holds_table(kind) => true,
            Some(kind) => split_component(self.path).0 == first && kind.elements().is_none(),
            None => false,
        };
        if is_setting {
            let path = self.path;
            self.check_parameter(document)?;
            return self.set(document, &SCENARIO, path);
        }
        if let Some(Target { element: (list, index), copy, rest }) = element(self.path, document)
            && let Some(table) = element_mut(document, list.name, index)
        {
            let path = self.element_path(list, rest)?;
            return match copy {
                Some(copy) => self.set_copy(table, copy, &path),
                None => self.set(table, list, &path),
            };
        }
        match self.path.split_once('.') {
            Some(("hinge", key)) => self.every_hinge(document, key),
            _ => Err(self.unknown_target(document)),
        }
    }

    /// A parameter that is set must be there: a slip of the finger would set one that nothing uses.
    fn check_parameter(&self, document: &DeTable<'_>) -> Result<(), Finding> {
        let Some(name) = self.path.strip_prefix(PARAMETERS).and_then(|rest| rest.strip_prefix('.')) else {
            return Ok(());
        };
        let table = document.get(PARAMETERS).and_then(|table| table.get_ref().as_table());
        let known: Vec<&str> =
            table.into_iter().flat_map(|table| table.keys().map(|key| key.get_ref().as_ref())).collect();
        if known.contains(&name) {
            return Ok(());
        }
        let help = closest(name, known.iter().copied()).map(|near| format!("did you mean `parameters.{near}`?"));
        let message = format!("there is no parameter `{name}`");
        Err(Finding::error(self.span.clone(), message).maybe_help(help))
    }

    /// The path as it stands in the file.
    fn element_path(&self, table: &'static Table, path: &'a str) -> Result<Cow<'a, str>, Finding> {
        if let Some(full) = full_path(table, path) {
            return Ok(full);
        }
        let of_part = part(table).map(|(_, part)| part.names(None));
        let names = table.names(None).chain(of_part.into_iter().flatten()).collect();
        let who = match table.name == BODY.name {
            true => "a body and its hinge have".to_owned(),
            false => format!("{} {} has", article(table.name), table.name),
        };
        Err(self.unknown_key(&who, first_key(path), names))
    }

    fn unknown_key(&self, who: &str, key: &str, mut names: Vec<&'static str>) -> Finding {
        names.sort_unstable();
        names.dedup();
        let help = match closest(key, names.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("{who} {}", listed(names.into_iter())),
        };
        Finding::error(self.span.clone(), format!("`{}`: unknown key `{key}`", self.path)).help(help)
    }

    fn unknown_target(&self, document: &DeTable<'_>) -> Finding {
        let target = self.path.rsplit_once('.').map_or(split_component(self.path).0, |(target, _)| target);
        let finding = Finding::error(self.span.clone(), format!("nothing is called `{target}`"));
        if let Some((name, rest)) = target.split_once('[')
            && rest.contains(']')
            && let Some(count) = copies_of(document, name)
        {
            return finding.help(format!("`{name}` has {count} copies, `{name}[0]` to `{name}[{}]`", count.max(1) - 1));
        }
        let names: Vec<Cow<'_, str>> = named(document).collect();
        let settings = SCENARIO.keys.iter().filter(|key| key.kind.elements().is_none()).map(|key| key.name);
        let fixed: Vec<&str> = settings.chain(["hinge"]).collect();
        let help = match closest(target, names.iter().map(Cow::as_ref).chain(fixed.iter().copied())) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!(
                "a path starts with the name of a body, a force or the like, or with {}",
                listed(fixed.into_iter())
            ),
        };
        finding.help(help)
    }

    fn every_hinge(self, document: &mut DeTable<'a>, key: &'a str) -> Result<(), Finding> {
        let first = first_key(key);
        if HINGE.declarations(first).next().is_none() {
            return Err(self.unknown_key("a hinge has", first, HINGE.names(None).collect()));
        }
        let mut found = false;
        let bodies = document.get_mut("body").and_then(|bodies| match bodies.get_mut() {
            DeValue::Array(items) => Some(items),
            _ => None,
        });
        for body in bodies.into_iter().flat_map(|items| items.iter_mut()) {
            let DeValue::Table(body) = body.get_mut() else { continue };
            let has_component = match split_component(key) {
                (plain, Some(index)) => component::count(body, plain).is_some_and(|count| index < count),
                (_, None) => true,
            };
            let Some(DeValue::Table(hinge)) = body.get_mut("hinge").map(Spanned::get_mut) else { continue };
            let of_type = hinge.get("type").and_then(|of_type| of_type.get_ref().as_str()).unwrap_or_default();
            if has_component && HINGE.declarations(first).any(|key| key.belongs_to(of_type)) {
                found = true;
                let each = Change { path: self.path, span: self.span.clone(), value: self.value.clone() };
                each.set(body, &BODY, &format!("hinge.{key}"))?;
            }
        }
        let message = || format!("no hinge of this scenario has `{key}`");
        if found { Ok(()) } else { Err(Finding::error(self.span.clone(), message())) }
    }

    /// Sets what `path` leads to from `table`, making the tables on the way.
    fn set(self, table: &mut DeTable<'a>, declared: &'static Table, path: &str) -> Result<(), Finding> {
        if within::is_within_a_list(table, path) {
            return within::put(&self, table, path);
        }
        let (plain, component) = split_component(path);
        if let Some(index) = component.filter(|_| walk(table, path, true).is_none()) {
            let part = Part { copy: None, component: Some(index) };
            let whole = component::with(&self, table, declared, plain, part)?;
            return self.put(table, plain, whole);
        }
        let value = self.value.clone();
        self.put(table, path, value)
    }

    /// Sets a value of one copy of a repeated body.
    fn set_copy(self, table: &mut DeTable<'a>, copy: usize, path: &str) -> Result<(), Finding> {
        let (plain, component) = split_component(path);
        let whole = component::with(&self, table, &BODY, plain, Part { copy: Some(copy), component })?;
        self.put(table, plain, whole)
    }

    /// Puts a value where `path` leads, making the tables on the way.
    fn put(&self, table: &mut DeTable<'a>, path: &str, value: Spanned<DeValue<'a>>) -> Result<(), Finding> {
        let key = |name: &str| Spanned::new(self.span.clone(), Cow::Owned(name.to_owned()));
        // Names of markers may hold dots.
        let (first, rest) = match path.split_once('.') {
            Some(("markers", rest)) if !rest.is_empty() => ("markers", rest),
            Some((first, rest)) => (first, rest),
            None => {
                table.remove(path);
                table.insert(key(path), value);
                return Ok(());
            }
        };
        if !table.contains_key(first) {
            table.insert(key(first), Spanned::new(self.span.clone(), DeValue::Table(DeTable::new())));
        }
        match table.get_mut(first).map(Spanned::get_mut) {
            Some(DeValue::Table(inner)) if first == "markers" => {
                inner.remove(rest);
                inner.insert(key(rest), value);
                Ok(())
            }
            Some(DeValue::Table(inner)) => self.put(inner, rest, value),
            _ => {
                let message = format!("`{}`: `{first}` is not a table, there is no `{rest}` in it", self.path);
                Err(Finding::error(self.span.clone(), message).help(format!("set `{first}` as a whole")))
            }
        }
    }
}

/// The table within an element whose keys may be written without its name: the hinge of a body, the material of a beam or a cable.
fn part(table: &Table) -> Option<(&'static str, &'static Table)> {
    let has_material = table.declarations(MATERIAL.name).next().is_some();
    match table.name == BODY.name {
        true => Some(("hinge", &HINGE)),
        false => has_material.then_some((MATERIAL.name, &MATERIAL)),
    }
}

/// A path from an element as it stands in the file; `None` if its first key is not known.
fn full_path<'p>(table: &Table, path: &'p str) -> Option<Cow<'p, str>> {
    let has =
        |table: &Table, key: &str| table.declarations(key).next().is_some() || key == "type" && !table.types.is_empty();
    let key = first_key(path);
    if has(table, key) {
        return Some(Cow::Borrowed(path));
    }
    let (name, _) = part(table).filter(|(_, part)| has(part, key))?;
    Some(Cow::Owned(format!("{name}.{path}")))
}

/// The first key of a path, without its component.
fn first_key(path: &str) -> &str {
    path.split(['.', '[']).next().unwrap_or_default()
}

/// The value where a path leads; of markers with or without its component.
fn walk<'t, 'a>(table: &'t DeTable<'a>, path: &str, with_component: bool) -> Option<&'t Spanned<DeValue<'a>>> {
    let path = if with_component { path } else { split_component(path).0 };
    match path.split_once('.') {
        Some(("markers", rest)) => table.get("markers")?.get_ref().as_table()?.get(rest),
        Some((first, rest)) => walk(table.get(first)?.get_ref().as_table()?, rest, true),
        None => table.get(path),
    }
}

/// The element that a path begins with: list, index and copy.
fn element<'p>(path: &'p str, document: &DeTable<'_>) -> Option<Target<'p, (&'static Table, usize)>> {
    let has = |(table, _): (&'static Table, usize), path: &str| full_path(table, path).is_some();
    resolve(path, entries(document), has)
}

/// How many copies a body of this name has, if it is repeated.
fn copies_of(document: &DeTable<'_>, name: &str) -> Option<usize> {
    entries(document).find(|entry| entry.name == name)?.copies
}

/// Whether a key of the file can be a table with keys of its own.
fn holds_table(kind: &Kind) -> bool {
    match kind {
        Kind::Table(_) | Kind::Map(_) => true,
        Kind::Either(kinds) => kinds.iter().any(holds_table),
        _ => false,
    }
}

/// All elements: what they are and where, their names and places, how often they are repeated.
fn entries<'d>(document: &'d DeTable<'_>) -> impl Iterator<Item = Entry<'d, (&'static Table, usize)>> + Clone {
    SCENARIO.keys.iter().filter_map(|key| key.kind.elements()).flat_map(move |table| {
        let items = document.get(table.name).and_then(|items| items.get_ref().as_array());
        items.into_iter().flat_map(|items| items.iter()).enumerate().map(move |(index, item)| Entry {
            element: (table, index),
            name: item.get_ref().get("name").and_then(|name| name.get_ref().as_str()).unwrap_or_default(),
            place: (table.name != BODY.name).then_some((table.name, index)),
            copies: item.get_ref().get("repeat").and_then(|copies| Some(number(copies.get_ref())? as usize)),
        })
    })
}

/// What all elements are called: by name, else by place.
fn named<'d>(document: &'d DeTable<'_>) -> impl Iterator<Item = Cow<'d, str>> {
    entries(document).filter_map(|entry| match (entry.name, entry.place) {
        ("", place) => place.map(|(list, index)| Cow::Owned(format!("{list}[{index}]"))),
        (name, _) => Some(Cow::Borrowed(name)),
    })
}

fn element_mut<'d, 'a>(document: &'d mut DeTable<'a>, list: &str, index: usize) -> Option<&'d mut DeTable<'a>> {
    let DeValue::Array(items) = document.get_mut(list)?.get_mut() else { return None };
    match items.get_mut(index)?.get_mut() {
        DeValue::Table(table) => Some(table),
        _ => None,
    }
}
