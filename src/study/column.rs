//! Columns of a table of cases, and what stands in them.

use std::borrow::Cow;
use std::fmt;

/// What a column holds. Any column may be empty in a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Finite numbers.
    Number,
    /// Whole numbers.
    Whole,
    /// Words.
    Word,
    /// Yes or no.
    Flag,
}

impl Kind {
    /// Its name in manifests.
    pub fn name(self) -> &'static str {
        match self {
            Self::Number => "number",
            Self::Whole => "whole",
            Self::Word => "word",
            Self::Flag => "flag",
        }
    }
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// What it is called, without its unit.
    pub name: String,
    /// What it holds.
    pub kind: Kind,
    /// SI unit of its numbers; empty for none.
    pub unit: Cow<'static, str>,
}

impl Column {
    /// A column.
    pub fn new(name: impl Into<String>, kind: Kind, unit: impl Into<Cow<'static, str>>) -> Self {
        Self { name: name.into(), kind, unit: unit.into() }
    }
}

/// What stands in one column of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Nothing: the case has no such answer.
    Empty,
    /// A finite number.
    Number(f64),
    /// A whole number.
    Whole(i64),
    /// A word.
    Word(Cow<'static, str>),
    /// Yes or no.
    Flag(bool),
}

impl fmt::Display for Cell {
    /// As in CSV: numbers in full, nothing for an empty one.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => Ok(()),
            Self::Number(number) => write!(f, "{number:?}"),
            Self::Whole(number) => write!(f, "{number}"),
            Self::Word(word) => f.write_str(word),
            Self::Flag(flag) => write!(f, "{flag}"),
        }
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Self::Empty, Self::Number)
    }
}
