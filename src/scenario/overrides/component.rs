//! Changes to a part of a value: one component of a list, the value of one copy.
//!
//! A value that is written once for several components or copies is written out before its part is changed.

use super::super::fields::Table;
use super::super::findings::Finding;
use super::super::findings::Findings;
use super::super::format::HINGE;
use super::super::hinge::kind;
use super::super::reader::{Reader, number};
use super::{Change, walk};
use crate::model::problem::counted;
use crate::quantity::Quantity;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

type Value<'a> = Spanned<DeValue<'a>>;

/// Which part of a value is meant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    /// `None`: all copies.
    pub(super) copy: Option<usize>,
    /// `None`: all components.
    pub(super) component: Option<usize>,
}

/// Keys of a hinge that hold a number for each coordinate or velocity, and may differ from copy to copy: whether they
/// have one for each coordinate, and whether one number stands for all.
const PER_COPY: [(&str, bool, bool); 7] = [
    ("position", true, false),
    ("velocity", false, false),
    ("stiffness", false, true),
    ("damping", false, true),
    ("rest", true, false),
    ("armature", false, true),
    ("force", false, false),
];

/// How many numbers a key of a body or its hinge holds for one copy; `None` for other keys and hinges of no known type.
pub(super) fn count(body: &DeTable<'_>, path: &str) -> Option<usize> {
    if path == "mass" {
        return Some(1);
    }
    let key = path.strip_prefix("hinge.").unwrap_or(path);
    let (_, coordinates, _) = PER_COPY.into_iter().find(|(known, ..)| *known == key)?;
    let findings = Findings::default();
    let hinge = body.get("hinge")?;
    let (positions, velocities) = kind(&Reader::new(hinge.get_ref().as_table()?, hinge.span(), &findings))?.counts();
    Some(if coordinates { positions } else { velocities })
}

/// The value at `path` with one part of it changed.
///
/// # Errors
/// If it has no such part.
pub(super) fn with<'a>(
    change: &Change<'a>,
    table: &DeTable<'a>,
    declared: &'static Table,
    path: &str,
    part: Part,
) -> Result<Value<'a>, Finding> {
    let whole = Whole { change, table, declared, path };
    match (part.copy, part.component) {
        (Some(copy), component) => whole.of_copy(copy, component),
        (None, Some(index)) => whole.of_component(index),
        (None, None) => Ok(change.value.clone()),
    }
}

struct Whole<'w, 'a> {
    change: &'w Change<'a>,
    table: &'w DeTable<'a>,
    declared: &'static Table,
    path: &'w str,
}

impl<'a> Whole<'_, 'a> {
    fn refuse(&self, message: &str, help: String) -> Finding {
        Finding::error(self.change.span.clone(), format!("`{}`: {message}", self.change.path)).help(help)
    }

    fn list(&self, items: Vec<Value<'a>>) -> Value<'a> {
        Spanned::new(self.change.span.clone(), DeValue::Array(items.into_iter().collect()))
    }

    fn key(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or_default()
    }

    /// The value as it is written, else the default of its key.
    fn current(&self) -> Option<Value<'a>> {
        if let Some(value) = walk(self.table, self.path, true) {
            return Some(value.clone());
        }
        let key = self.key();
        let of_hinge = self.path.strip_prefix("hinge.").map(|_| &HINGE);
        let tables = [of_hinge.unwrap_or(self.declared)];
        let keys = tables.into_iter().flat_map(|table| table.declarations(key));
        let nested = self.path.contains('.') && of_hinge.is_none();
        let default = keys.map(|key| key.default).find(|default| !default.is_empty() && !nested)?;
        let value = DeValue::parse(default).ok()?;
        Some(Spanned::new(self.change.span.clone(), value.into_inner()))
    }

    fn of_component(&self, index: usize) -> Result<Value<'a>, Finding> {
        let repeat = self.table.get("repeat").and_then(|repeat| number(repeat.get_ref()));
        if repeat.is_some()
            && let Some(value) = walk(self.table, self.path, true)
            && is_nested(value)
            && let Some(count) = count(self.table, self.path)
        {
            let rows = self.rows(repeat.unwrap_or(0.0) as usize, count)?;
            let rows = rows.into_iter().map(|row| self.replaced(row, index)).collect::<Result<Vec<_>, _>>()?;
            return Ok(self.list(rows.into_iter().map(|row| self.list(row)).collect()));
        }
        let Some(value) = self.current() else {
            let help = format!("set `{}` as a whole", self.path);
            return Err(self.refuse(&format!("`{}` is not given", self.key()), help));
        };
        let items = match value.get_ref() {
            DeValue::Array(items) => items.iter().cloned().collect(),
            DeValue::Table(parts) if parts.contains_key("translation") || parts.contains_key("rotation") => {
                six(parts, &value)
            }
            DeValue::String(text) if !Quantity::is_meant(text) => return Err(self.missing(index, 1)),
            _ => match count(self.table, self.path) {
                Some(count) if count > 1 => self.row(&value, count)?,
                _ if index == 0 => return Ok(self.change.value.clone()),
                _ => return Err(self.missing(index, 1)),
            },
        };
        Ok(self.list(self.replaced(items, index)?))
    }

    fn replaced(&self, mut items: Vec<Value<'a>>, index: usize) -> Result<Vec<Value<'a>>, Finding> {
        match items.get_mut(index) {
            Some(item) => *item = self.change.value.clone(),
            None => return Err(self.missing(index, items.len())),
        }
        Ok(items)
    }

    fn missing(&self, index: usize, count: usize) -> Finding {
        let help = match count {
            1 => "it is one number, without a component".to_owned(),
            _ => format!("its components are 0 to {}", count.max(1) - 1),
        };
        self.refuse(&format!("there is no component {index}"), help)
    }

    /// The value of a key for every copy, with that of one copy changed.
    fn of_copy(&self, copy: usize, component: Option<usize>) -> Result<Value<'a>, Finding> {
        let key = self.key();
        let copies = self.table.get("repeat").and_then(|repeat| number(repeat.get_ref())).unwrap_or(0.0) as usize;
        let differs = self.path == "mass" || self.path.starts_with("hinge.");
        let Some(count) = count(self.table, self.path).filter(|count| differs && *count > 0) else {
            let name = self.table.get("name").and_then(|name| name.get_ref().as_str()).unwrap_or_default();
            let help = format!("set it for all of them: `{name}.{}`", self.path);
            return Err(self.refuse(&format!("all copies have the same `{key}`"), help));
        };
        let mut rows = self.rows(copies, count)?;
        let row = std::mem::take(&mut rows[copy]);
        rows[copy] = match component {
            Some(index) => self.replaced(row, index)?,
            None => self.row(&self.change.value, count)?,
        };
        let item = |mut row: Vec<Value<'a>>| match (count, row.pop()) {
            (1, Some(one)) => one,
            (_, last) => self.list(row.into_iter().chain(last).collect()),
        };
        Ok(self.list(rows.into_iter().map(item).collect()))
    }

    /// The numbers of every copy.
    fn rows(&self, copies: usize, count: usize) -> Result<Vec<Vec<Value<'a>>>, Finding> {
        let Some(value) = self.current() else {
            let help = "set it for all copies first".to_owned();
            return Err(self.refuse(&format!("`{}` is not given", self.key()), help));
        };
        match value.get_ref() {
            DeValue::Array(items) if is_nested(&value) && items.len() == copies => {
                items.iter().map(|item| self.row(item, count)).collect()
            }
            DeValue::Array(items) if count == 1 && items.len() == copies => {
                Ok(items.iter().map(|item| vec![item.clone()]).collect())
            }
            _ => Ok(vec![self.row(&value, count)?; copies]),
        }
    }

    /// The numbers of one copy: as many as the hinge has, or one that stands for all.
    fn row(&self, value: &Value<'a>, count: usize) -> Result<Vec<Value<'a>>, Finding> {
        let key = self.key();
        let (_, coordinates, widens) =
            PER_COPY.into_iter().find(|(known, ..)| *known == key).unwrap_or(("", false, false));
        if let DeValue::Array(items) = value.get_ref() {
            return if items.len() == count {
                Ok(items.iter().cloned().collect())
            } else {
                Err(self.refuse(
                    &format!("`{key}` has {}, not {}", counted(count, "number", "numbers"), items.len()),
                    "give all of them".into(),
                ))
            };
        }
        let is_zero = number(value.get_ref()) == Some(0.0);
        if count == 1 || widens || is_zero && !(coordinates && count != 1 && self.has_quaternion()) {
            return Ok(vec![value.clone(); count]);
        }
        if is_zero {
            return Ok(self.identity(count));
        }
        Err(self.refuse(
            &format!("`{key}` has {}", counted(count, "number", "numbers")),
            format!("set it as a list of {count}"),
        ))
    }

    fn has_quaternion(&self) -> bool {
        let of = |key: &str| count(self.table, key);
        of("position") != of("velocity")
    }

    /// Coordinates of a hinge with a quaternion that has not turned: zero but for its first number.
    fn identity(&self, count: usize) -> Vec<Value<'a>> {
        let number = |text: &'static str| match DeValue::parse(text) {
            Ok(value) => Spanned::new(self.change.span.clone(), value.into_inner()),
            Err(_) => self.change.value.clone(),
        };
        (0..count).map(|i| number(if i + 4 == count { "1.0" } else { "0.0" })).collect()
    }
}

fn is_nested(value: &Value<'_>) -> bool {
    value.get_ref().as_array().is_some_and(|items| items.iter().next().is_some_and(|item| item.get_ref().is_array()))
}

/// Six numbers of a bushing out of three along and three about.
fn six<'a>(parts: &DeTable<'a>, whole: &Value<'a>) -> Vec<Value<'a>> {
    let zero =
        || DeValue::parse("0.0").map_or_else(|_| whole.clone(), |zero| Spanned::new(whole.span(), zero.into_inner()));
    let three = |key: &str| -> Vec<Value<'a>> {
        match parts.get(key) {
            None => vec![zero(); 3],
            Some(value) => match value.get_ref() {
                DeValue::Array(items) => items.iter().cloned().collect(),
                _ => vec![value.clone(); 3],
            },
        }
    };
    three("translation").into_iter().chain(three("rotation")).collect()
}
