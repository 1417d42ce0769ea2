//! How the format is declared: tables of keys, each with its kind, unit, default and one sentence.
//!
//! The declarations themselves are in [`format`](mod@super::format). Everything that knows the format reads them: the
//! check, the JSON Schema and whoever prints a reference.

use crate::budget::LARGEST;

/// One table of the format.
#[derive(Debug)]
pub struct Table {
    /// What one of it is called: `body`, `hinge`.
    pub name: &'static str,
    /// One sentence.
    pub doc: &'static str,
    /// The values of its `type` key, each with one sentence; empty where it has none.
    pub types: &'static [(&'static str, &'static str)],
    /// The other keys.
    pub keys: &'static [Key],
}

/// One key of a table.
#[derive(Debug)]
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// What it holds.
    pub kind: Kind,
    /// SI unit, empty where there is none.
    pub unit: &'static str,
    /// Its absence is an error.
    pub required: bool,
    /// What its absence means, as written in a file; empty where there is nothing to write.
    pub default: &'static str,
    /// A value as written in a file.
    pub example: &'static str,
    /// The values of `type` that have this key; empty for all.
    pub only: &'static [&'static str],
    /// One sentence.
    pub doc: &'static str,
}

/// In place of a unit: it is that of another number of the scene.
pub const ANY_UNIT: &str = "unit of what it stands for";

/// What a key holds.
#[derive(Debug)]
pub enum Kind {
    /// Text.
    Text,
    /// `true` or `false`.
    Flag,
    /// A whole number.
    Integer(Range),
    /// A finite number, with or without a decimal point.
    Number(Range),
    /// One of these words, each with one sentence.
    Choice(&'static [(&'static str, &'static str)]),
    /// A list of one of these lengths; no lengths for any but none, of [elements](Self::elements) for any.
    List(&'static Kind, &'static [usize]),
    /// One of these, distinguished by their TOML types.
    Either(&'static [Kind]),
    /// A table with declared keys.
    Table(&'static Table),
    /// A table whose keys are names that the user chooses.
    Map(&'static Kind),
    /// In the format, but refused by this version, and why.
    Refused(&'static str),
}

/// The numbers that are allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Every finite number.
    Any,
    /// `≥`
    AtLeast(f64),
    /// `>`
    Above(f64),
    /// Both ends belong to it.
    Between(f64, f64),
}

impl Range {
    /// Whether the number is allowed.
    pub fn contains(&self, number: f64) -> bool {
        number.abs() <= LARGEST
            && match *self {
                Self::Any => true,
                Self::AtLeast(low) => number >= low,
                Self::Above(low) => number > low,
                Self::Between(low, high) => (low..=high).contains(&number),
            }
    }

    /// `≥ 0 kg`
    pub fn allowed(&self, unit: &str) -> String {
        let range = match *self {
            Self::Any => "every finite number".to_owned(),
            Self::AtLeast(low) => format!("≥ {low}"),
            Self::Above(low) => format!("> {low}"),
            Self::Between(low, high) => format!("{low} … {high}"),
        };
        // Which of several units it is depends on the hinge.
        if unit.is_empty() || unit.contains(" or ") { range } else { format!("{range} {unit}") }
    }
}

impl Kind {
    /// The table that a list of the scene's elements is made of: `[[body]]`, `[[force]]`. There may be none of them.
    pub fn elements(&self) -> Option<&'static Table> {
        match self {
            Self::List(Self::Table(table), []) => Some(table),
            _ => None,
        }
    }

    /// `a number`, `a list of 3 numbers`
    pub fn expected(&self) -> String {
        match self {
            Self::Text => "text".to_owned(),
            Self::Flag => "`true` or `false`".to_owned(),
            Self::Integer(_) => "a whole number".to_owned(),
            Self::Number(_) => "a number".to_owned(),
            Self::Choice(words) => {
                format!("one of {}", listed(words.iter().map(|(word, _)| *word)))
            }
            Self::List(item, lengths) => format!("a list of {}", item.several(lengths)),
            Self::Either(kinds) => {
                let all: Vec<String> = kinds.iter().map(Kind::expected).collect();
                all.join(" or ")
            }
            Self::Table(table) if table.keys.len() <= 4 => format!("a table with {}", listed(table.names(None))),
            Self::Table(_) => "a table".to_owned(),
            Self::Map(item) => format!("a table of names, each with {}", item.expected()),
            Self::Refused(_) => "nothing".to_owned(),
        }
    }

    fn several(&self, lengths: &[usize]) -> String {
        let count = lengths.iter().map(usize::to_string).collect::<Vec<_>>().join(" or ");
        let items = match self {
            Self::Number(_) => "numbers".to_owned(),
            Self::Table(_) => "tables".to_owned(),
            Self::List(item, lengths) => format!("lists of {}", item.several(lengths)),
            Self::Either(kinds) => format!("items, each {}", Kind::Either(kinds).expected()),
            other => format!("items, each {}", other.expected()),
        };
        if count.is_empty() { items } else { format!("{count} {items}") }
    }
}

impl Table {
    /// The declarations of a key: several where its meaning depends on `type`.
    pub fn declarations(&self, name: &str) -> impl Iterator<Item = &'static Key> {
        self.keys.iter().filter(move |key| key.name == name)
    }

    /// The names of the keys that a table of this `type` may have, `type` itself first; all of them for no type.
    pub fn names(&self, of_type: Option<&str>) -> impl Iterator<Item = &'static str> {
        let tag = if self.types.is_empty() { None } else { Some("type") };
        let keys = self.keys.iter().filter(move |key| of_type.is_none_or(|t| key.belongs_to(t)));
        tag.into_iter().chain(keys.filter(|key| !matches!(key.kind, Kind::Refused(_))).map(|key| key.name))
    }
}

impl Key {
    /// Whether tables of this `type` have it.
    pub fn belongs_to(&self, of_type: &str) -> bool {
        self.only.is_empty() || self.only.contains(&of_type)
    }

    /// A key that may be left out.
    pub(super) const fn new(name: &'static str, kind: Kind, doc: &'static str) -> Self {
        Self { name, kind, unit: "", required: false, default: "", example: "", only: &[], doc }
    }

    pub(super) const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    pub(super) const fn required(mut self) -> Self {
        self.required = true;
        self
    }

    pub(super) const fn default(mut self, default: &'static str) -> Self {
        self.default = default;
        self
    }

    pub(super) const fn example(mut self, example: &'static str) -> Self {
        self.example = example;
        self
    }

    pub(super) const fn only(mut self, types: &'static [&'static str]) -> Self {
        self.only = types;
        self
    }
}

/// `` `a`, `b`, `c` ``
pub(super) fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut seen = Vec::new();
    for name in names.map(|name| format!("`{name}`")) {
        if !seen.contains(&name) {
            seen.push(name);
        }
    }
    seen.join(", ")
}
