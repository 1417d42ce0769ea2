//! `--set path=value`: changes to a scenario from the command line.
//!
//! | path | sets |
//! |---|---|
//! | `title`, `gravity` | a key of the file |
//! | `model.base` | how a model is taken; its bodies and hinges are set by name like all others |
//! | `simulate.duration` | a key of `(simulate)`, `(statics)` or `[record]` |
//! | `upper.mass`, `upper.markers.tip` | a key of the body `upper`; of a repeated body for all its copies |
//! | `upper.hinge.position`, `upper.position` | a key of its hinge |
//! | `stay.stiffness`, `force[0].stiffness` | a key of a force |
//! | `hinge.damping` | a key of every hinge whose type has it, unless a body or force is called `hinge` |
//!
//! The value is written as in a file; what is no TOML value is taken as text, so `statics.want=any` needs no quotes.

use super::fields::listed;
use super::findings::{Finding, Findings};
use super::force::default_name;
use super::format::{BODY, FORCE, HINGE, SCENARIO};
use super::sources::Sources;
use crate::suggest::closest;
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
    /// There is no `=`.
    #[error("`--set {0}` sets nothing: write a path and a value, for example `--set upper.mass=2.0`")]
    NoValue(String),
    /// There is nothing before the `=`.
    #[error("`--set {0}` names nothing to set: write a path and a value, for example `--set upper.mass=2.0`")]
    NoPath(String),
}

impl Override {
    /// Reads `path=value`.
    ///
    /// # Errors
    /// Where the path or the `=` is missing. Whether the path exists and the value fits is told by
    /// [`parse`](super::parse) and [`load_with`](super::load_with).
    pub fn parse(text: &str) -> Result<Self, OverrideError> {
        const OPTION: &str = "--set ";
        let (path, value) = text.split_once('=').ok_or_else(|| OverrideError::NoValue(text.to_owned()))?;
        let part = |from: usize, text: &str| {
            let start = OPTION.len() + from + (text.len() - text.trim_start().len());
            start..start + text.trim().len()
        };
        if path.trim().is_empty() {
            return Err(OverrideError::NoPath(text.to_owned()));
        }
        if value.trim().is_empty() {
            return Err(OverrideError::NoValue(text.to_owned()));
        }
        Ok(Self { shown: format!("{OPTION}{text}"), path: part(0, path), value: part(path.len() + 1, value) })
    }

    fn path(&self) -> &str {
        &self.shown[self.path.clone()]
    }

    /// Whether it changes how a model is taken, which has to be known before there are any bodies.
    pub(super) fn is_of_model(&self) -> bool {
        self.path() == "model" || self.path().starts_with("model.")
    }
}

/// Puts all overrides into a parsed file, so that they are checked as if they were written there.
pub(super) fn apply<'a>(
    overrides: impl Iterator<Item = &'a Override>,
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

/// The same value with all spans moved.
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
        let first = self.path.split('.').next().unwrap_or_default();
        if ["title", "gravity"].contains(&self.path) || ["simulate", "statics", "record", "model"].contains(&first) {
            let path = self.path;
            return self.set(document, path);
        }
        if let Some((list, index, rest)) = self.element(document)
            && let Some(table) = element_mut(document, list, index)
        {
            let path = if list == "body" { self.body_path(rest)? } else { self.force_path(rest)? };
            return self.set(table, &path);
        }
        match self.path.split_once('.') {
            Some(("hinge", key)) => self.every_hinge(document, key),
            _ => Err(self.unknown_target(document)),
        }
    }

    /// The body or force with the longest name that the path starts with.
    fn element(&self, document: &DeTable<'_>) -> Option<(&'static str, usize, &'a str)> {
        let rest = |name: &str| self.path.strip_prefix(name).and_then(|rest| rest.strip_prefix('.'));
        named(document)
            .filter_map(|(list, index, name)| Some((list, index, rest(&name)?)))
            .min_by_key(|(_, _, rest)| rest.len())
    }

    /// The keys of a hinge may be written without `hinge.`.
    fn body_path(&self, path: &'a str) -> Result<Cow<'a, str>, Finding> {
        let key = path.split('.').next().unwrap_or_default();
        if BODY.declarations(key).next().is_some() {
            return Ok(Cow::Borrowed(path));
        }
        if HINGE.declarations(key).next().is_some() || key == "type" {
            return Ok(Cow::Owned(format!("hinge.{path}")));
        }
        Err(self.unknown_key("a body and its hinge have", key, BODY.names(None).chain(HINGE.names(None)).collect()))
    }

    fn force_path(&self, path: &'a str) -> Result<Cow<'a, str>, Finding> {
        let key = path.split('.').next().unwrap_or_default();
        if FORCE.declarations(key).next().is_some() || key == "type" {
            return Ok(Cow::Borrowed(path));
        }
        Err(self.unknown_key("a force has", key, FORCE.names(None).collect()))
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
        let (target, key) = self.path.rsplit_once('.').unwrap_or((self.path, ""));
        let finding = Finding::error(self.span.clone(), format!("nothing is called `{target}`"));
        if let Some((name, rest)) = target.split_once('[')
            && rest.contains(']')
            && named(document).any(|(_, _, known)| known == name)
        {
            let all = if key.is_empty() { name.to_owned() } else { format!("{name}.{key}") };
            return finding.help(format!("the copies of `{name}` are set together: `{all}`"));
        }
        let names: Vec<String> = named(document).map(|(_, _, name)| name.into_owned()).collect();
        let fixed = SCENARIO.names(None).filter(|name| !["body", "force"].contains(name)).chain(["hinge"]);
        let fixed: Vec<&str> = fixed.collect();
        let help = match closest(target, names.iter().map(String::as_str).chain(fixed.iter().copied())) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("a path starts with the name of a body or force, or with {}", listed(fixed.into_iter())),
        };
        finding.help(help)
    }

    fn every_hinge(self, document: &mut DeTable<'a>, key: &'a str) -> Result<(), Finding> {
        let first = key.split('.').next().unwrap_or_default();
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
            let Some(DeValue::Table(hinge)) = body.get_mut("hinge").map(Spanned::get_mut) else { continue };
            let of_type = hinge.get("type").and_then(|of_type| of_type.get_ref().as_str()).unwrap_or_default();
            if HINGE.declarations(first).any(|key| key.belongs_to(of_type)) {
                found = true;
                let each = Change { path: self.path, span: self.span.clone(), value: self.value.clone() };
                each.set(hinge, key)?;
            }
        }
        let message = || format!("no hinge of this scenario has `{first}`");
        if found { Ok(()) } else { Err(Finding::error(self.span.clone(), message())) }
    }

    /// Sets what `path` leads to from `table`, making the tables on the way.
    fn set(self, table: &mut DeTable<'a>, path: &str) -> Result<(), Finding> {
        let key = |name: &str| Spanned::new(self.span.clone(), Cow::Owned(name.to_owned()));
        // Names of markers may hold dots.
        let (first, rest) = match path.split_once('.') {
            Some(("markers", rest)) if !rest.is_empty() => ("markers", rest),
            Some((first, rest)) => (first, rest),
            None => {
                table.remove(path);
                table.insert(key(path), self.value);
                return Ok(());
            }
        };
        if !table.contains_key(first) {
            table.insert(key(first), Spanned::new(self.span.clone(), DeValue::Table(DeTable::new())));
        }
        match table.get_mut(first).map(Spanned::get_mut) {
            Some(DeValue::Table(inner)) if first == "markers" => {
                inner.remove(rest);
                inner.insert(key(rest), self.value);
                Ok(())
            }
            Some(DeValue::Table(inner)) => self.set(inner, rest),
            _ => {
                let message = format!("`{}`: `{first}` is not a table, there is no `{rest}` in it", self.path);
                Err(Finding::error(self.span.clone(), message).help(format!("set `{first}` as a whole")))
            }
        }
    }
}

/// All bodies and forces: list, index, name.
fn named<'d>(document: &'d DeTable<'_>) -> impl Iterator<Item = (&'static str, usize, Cow<'d, str>)> {
    ["body", "force"].into_iter().flat_map(move |list| {
        let items = document.get(list).and_then(|items| items.get_ref().as_array());
        items.into_iter().flat_map(|items| items.iter()).enumerate().filter_map(move |(index, item)| {
            let name = item.get_ref().get("name").and_then(|name| name.get_ref().as_str());
            match name {
                Some(name) => Some((list, index, Cow::Borrowed(name))),
                None if list == "force" => Some((list, index, Cow::Owned(default_name(index)))),
                None => None,
            }
        })
    })
}

fn element_mut<'d, 'a>(document: &'d mut DeTable<'a>, list: &str, index: usize) -> Option<&'d mut DeTable<'a>> {
    let DeValue::Array(items) = document.get_mut(list)?.get_mut() else { return None };
    match items.get_mut(index)?.get_mut() {
        DeValue::Table(table) => Some(table),
        _ => None,
    }
}
