//! Scenario text in the making: tables with comments, and for every value where it came from.

use super::log::Place;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value};

/// A scenario that is being written.
#[derive(Debug)]
pub(super) struct Draft {
    document: DocumentMut,
    /// Parts by address, and where they came from.
    pub(super) origins: Vec<(String, Place)>,
    /// Joints, and the bodies that name their hinges.
    pub(super) joints: Vec<(String, String)>,
    /// Bodies, and the most that a motor may do in their hinges.
    pub(super) efforts: Vec<(String, String)>,
}

/// A table of a scenario: `[[body]]`, or one within another.
#[derive(Debug, Default)]
pub(super) struct Entry {
    comment: String,
    place: Option<Place>,
    items: Vec<(String, Piece, Option<Place>)>,
}

#[derive(Debug)]
enum Piece {
    Value(Value),
    /// Written in one line, as `hinge = { … }`.
    Inline(Entry),
    /// A list with one line per table, as `shape = [ … ]`.
    Lines(Vec<Entry>),
}

impl Entry {
    /// A table that comes from this place.
    pub(super) fn new(place: Option<Place>) -> Self {
        Self { place, ..Self::default() }
    }

    /// Adds a line of comment above it.
    pub(super) fn comment(&mut self, line: &str) {
        // A name may hold anything; a comment ends with its line.
        let line: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        self.comment += &format!("# {line}\n");
    }

    /// Adds a value that comes from `from`.
    pub(super) fn set(&mut self, key: &str, value: impl Into<Value>, from: Option<Place>) {
        self.items.push((key.to_owned(), Piece::Value(value.into()), from));
    }

    /// Adds a list of numbers.
    pub(super) fn numbers(&mut self, key: &str, numbers: &[f64], from: Option<Place>) {
        self.set(key, Value::Array(numbers.iter().copied().collect::<Array>()), from);
    }

    /// Adds a table, written in one line.
    pub(super) fn inline(&mut self, key: &str, entry: Entry) {
        let place = entry.place.clone();
        self.items.push((key.to_owned(), Piece::Inline(entry), place));
    }

    /// Adds a list of tables, one line each; a single one without a list.
    pub(super) fn lines(&mut self, key: &str, mut entries: Vec<Entry>) {
        match entries.len() {
            0 => {}
            1 => self.inline(key, entries.remove(0)),
            _ => self.items.push((key.to_owned(), Piece::Lines(entries), None)),
        }
    }

    fn into_table(self, address: &str, origins: &mut Vec<(String, Place)>) -> Table {
        let mut table = Table::new();
        table.decor_mut().set_prefix(format!("\n{}", self.comment));
        for (key, piece, place) in self.items {
            let value = piece.into_value(&format!("{address}.{key}"), place, origins);
            table.insert(&key, Item::Value(value));
        }
        table
    }

    fn into_inline(self, address: &str, origins: &mut Vec<(String, Place)>) -> InlineTable {
        let mut table = InlineTable::new();
        for (key, piece, place) in self.items {
            let value = piece.into_value(&format!("{address}.{key}"), place, origins);
            table.insert(&key, value);
        }
        table
    }
}

impl Piece {
    fn into_value(self, address: &str, place: Option<Place>, origins: &mut Vec<(String, Place)>) -> Value {
        origins.extend(place.map(|place| (address.to_owned(), place)));
        match self {
            Self::Value(value) => value,
            Self::Inline(entry) => Value::InlineTable(entry.into_inline(address, origins)),
            Self::Lines(entries) => {
                let mut array = Array::new();
                for (index, entry) in entries.into_iter().enumerate() {
                    let address = format!("{address}[{index}]");
                    origins.extend(entry.place.clone().map(|place| (address.clone(), place)));
                    let mut value = Value::InlineTable(entry.into_inline(&address, origins));
                    value.decor_mut().set_prefix("\n  ");
                    array.push_formatted(value);
                }
                array.set_trailing("\n");
                array.set_trailing_comma(true);
                Value::Array(array)
            }
        }
    }
}

impl Draft {
    /// An empty scenario.
    pub(super) fn new() -> Self {
        Self { document: DocumentMut::new(), origins: Vec::new(), joints: Vec::new(), efforts: Vec::new() }
    }

    /// Adds a comment and a key at the top: `title`, `gravity`.
    pub(super) fn set(&mut self, key: &str, comment: &str, value: impl Into<Value>, from: Option<Place>) {
        self.document.insert(key, Item::Value(value.into()));
        if let Some(mut key) = self.document.key_mut(key) {
            let lines: String = comment.lines().map(|line| format!("# {line}\n")).collect();
            key.leaf_decor_mut().set_prefix(lines);
        }
        self.origins.extend(from.map(|place| (key.to_owned(), place)));
    }

    /// Adds a table of settings, as `[simulate]`.
    pub(super) fn settings(&mut self, name: &str, entry: Entry) {
        self.origins.extend(entry.place.clone().map(|place| (name.to_owned(), place)));
        let table = entry.into_table(name, &mut self.origins);
        self.document.insert(name, Item::Table(table));
    }

    /// Adds a table to a list, as `[[body]]`.
    pub(super) fn add(&mut self, list: &str, entry: Entry) {
        let item = self.document.entry(list).or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
        let Item::ArrayOfTables(tables) = item else { return };
        let address = format!("{list}[{}]", tables.len());
        self.origins.extend(entry.place.clone().map(|place| (address.clone(), place)));
        tables.push(entry.into_table(&address, &mut self.origins));
    }

    /// The hinge of `body` is what the file calls `joint`.
    pub(super) fn joint(&mut self, joint: &str, body: &str) {
        self.joints.push((joint.to_owned(), body.to_owned()));
    }

    /// The scenario as text.
    pub(super) fn text(&self) -> String {
        self.document.to_string()
    }
}
