//! Reading recordings for commands that look at their numbers.

use super::output;
use crate::record::table::Column;
use crate::record::{OwnedSample, Recording, Table};
use crate::suggest;
use anyhow::anyhow;
use serde_json::Value;
use std::path::Path;

/// A recording; that it was not finished is said.
pub(super) fn open(path: &Path, quiet: bool) -> anyhow::Result<Recording> {
    let recording = Recording::open(path)?;
    warn_if_cut(&recording, quiet);
    Ok(recording)
}

/// Says that a recording was not finished.
pub(super) fn warn_if_cut(recording: &Recording, quiet: bool) {
    if !recording.complete && !quiet {
        output::warning(&format!("`{}` was not finished: this is what was kept of it", recording.path.display()));
    }
}

/// The column of a recorded path that has its parameter; `None` of a run.
pub(super) fn parameter(recording: &Recording, tables: &[Table]) -> Option<Place> {
    let outcome: Value = serde_json::from_str(recording.outcome.as_deref()?).ok()?;
    outcome["branches"].as_array()?;
    let table = tables.iter().position(|table| table.name == "outputs")?;
    let index = tables[table].columns.len().checked_sub(1)?;
    Some(Place { table, index, column: tables[table].columns[index].clone() })
}

/// What a recording goes along: time, of a path arclength.
pub(super) fn clock(recording: &Recording, tables: &[Table]) -> Column {
    let (name, unit) = if parameter(recording, tables).is_some() { ("arclength", "1") } else { ("time", "s") };
    Column { name: name.to_owned(), unit: unit.to_owned() }
}

/// Calls `take` with every sample.
pub(super) fn each(
    recording: &Recording,
    mut take: impl FnMut(&OwnedSample) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    for sample in recording.samples()? {
        take(&sample?)?;
    }
    Ok(())
}

/// One column: which table, which place in its rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) table: usize,
    pub(super) index: usize,
    pub(super) column: Column,
}

/// What a column is one number of: `tip` for `tip[2]`.
fn whole(column: &str) -> Option<&str> {
    let (name, index) = column.strip_suffix(']')?.rsplit_once('[')?;
    index.parse::<usize>().is_ok().then_some(name)
}

/// The columns that a name stands for: a column's own name, all numbers of an output, or all columns of the channel of that name.
pub(super) fn columns(tables: &[Table], name: &str) -> anyhow::Result<Vec<Place>> {
    let bare = name.strip_prefix('/').unwrap_or(name);
    let mut found = Vec::new();
    for (table, content) in tables.iter().enumerate() {
        for (index, column) in content.columns.iter().enumerate() {
            if content.name == bare || column.name == name || whole(&column.name) == Some(name) {
                found.push(Place { table, index, column: column.clone() });
            }
        }
    }
    // A channel of a scene without bodies has no columns.
    if found.is_empty() && !tables.iter().any(|table| table.name == bare) {
        return Err(unknown(tables, name));
    }
    Ok(found)
}

/// No channel was named: which there are, a line each with its columns, and an example.
pub(super) fn none_named(tables: &[Table], file: &str) -> anyhow::Error {
    let tables = || tables.iter().filter(|table| !table.columns.is_empty());
    let mut text = "no channel is named; there are".to_owned();
    for table in tables() {
        let names: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
        let more = match names.len().saturating_sub(MOST_OF_CHANNEL) {
            0 => String::new(),
            more => format!(", … and {more} more"),
        };
        let shown = format!("{}{more}", names[..names.len().min(MOST_OF_CHANNEL)].join(", "));
        text += &format!("\n  {:<12} {}", table.name, wrapped(&shown));
    }
    let column = tables().next().map_or("energy", |table| table.columns[0].name.as_str());
    anyhow!(
        "{text}\nhint: `stillpoint plot {file} {column}` plots a column, the name of a channel in its place all of it; `stillpoint info \
         --json` lists all"
    )
}

/// Columns of a channel that are listed where none is named.
const MOST_OF_CHANNEL: usize = 24;
/// Letters of a line of such a list.
const WIDE: usize = 100;

/// A list in lines, below each other where the first begins.
fn wrapped(list: &str) -> String {
    let (mut text, mut width) = (String::new(), 0);
    for name in list.split_inclusive(", ") {
        let length = name.chars().count();
        if width > 0 && width + length > WIDE {
            text.truncate(text.trim_end().len());
            text += &format!("\n  {:<12} ", "");
            width = 0;
        }
        text += name;
        width += length;
    }
    text
}

/// Names of a list that are printed.
const MOST_NAMES: usize = 40;

/// Names of columns as a list.
pub(super) fn listed(places: &[Place]) -> String {
    let names = places.iter().take(MOST_NAMES).map(|place| format!("`{}`", place.column.name));
    let more = if places.len() > MOST_NAMES { ", …" } else { "" };
    format!("{}{more}", names.collect::<Vec<_>>().join(", "))
}

fn unknown(tables: &[Table], name: &str) -> anyhow::Error {
    let known = || tables.iter().flat_map(|table| &table.columns).map(|column| column.name.as_str());
    let names = || tables.iter().map(|table| table.name).chain(known().filter_map(whole)).chain(known());
    // What else the body that is named has.
    let of_body = name.rsplit_once('.').map(|(body, last)| (format!("{body}."), last));
    let own = of_body.as_ref().map_or(Vec::new(), |(body, _)| {
        known().filter(|column| column.starts_with(body.as_str())).take(MOST_NAMES).collect::<Vec<_>>()
    });
    // The body that is named is meant: other bodies are looked at if there is none of this name.
    let near = match &of_body {
        Some((_, last)) if !own.is_empty() => {
            let ends = own.iter().find(|column| column.ends_with(last)).copied();
            suggest::closest(name, own.iter().copied()).or(ends)
        }
        _ => suggest::closest(name, names()),
    };
    let hint = match near {
        Some(near) => format!("did you mean `{near}`?"),
        None if !own.is_empty() => format!("of it there are {}", own.join(", ")),
        None => {
            let part: Vec<&str> = known().filter(|column| column.contains(name)).take(MOST_NAMES).collect();
            let (what, list) = match part.is_empty() {
                true => ("channels are ".to_owned(), known().take(MOST_NAMES).collect()),
                false => (format!("channels with `{name}` in their names are "), part),
            };
            let more = if list.len() == MOST_NAMES { ", … (`stillpoint info --json` lists all)" } else { "" };
            format!("{what}{}{more}", list.join(", "))
        }
    };
    anyhow!("there is no channel `{name}` in the recording\nhint: {hint}")
}

/// The table whose rows are not in samples.
const CONTACTS: &str = "contacts";

/// A recording's rows of chosen columns.
pub(super) struct Rows<'a> {
    tables: &'a [Table],
    places: &'a [Place],
    rows: Vec<Vec<f64>>,
    /// The rows of the table `contacts`, which are not in samples.
    contacts: std::slice::Iter<'a, Vec<f64>>,
}

impl<'a> Rows<'a> {
    pub(super) fn new(tables: &'a [Table], places: &'a [Place]) -> Self {
        Self { tables, places, rows: vec![Vec::new(); tables.len()], contacts: [].iter() }
    }

    /// With the rows of the table `contacts`, one for each sample that is read.
    pub(super) fn with_contacts(self, rows: &'a [Vec<f64>]) -> Self {
        Self { contacts: rows.iter(), ..self }
    }

    /// The chosen numbers of a sample, in the order of the places.
    pub(super) fn read(&mut self, sample: &OwnedSample) -> impl Iterator<Item = f64> + '_ {
        let touching = self.contacts.next();
        for (index, (table, row)) in self.tables.iter().zip(&mut self.rows).enumerate() {
            if table.name == CONTACTS {
                row.clear();
                // A recording that was cut may have lost the last ones.
                row.extend_from_slice(touching.map_or(&[][..], Vec::as_slice));
                row.resize(table.columns.len(), f64::NAN);
            } else if self.places.iter().any(|place| place.table == index) {
                table.fill(sample, row);
            }
        }
        self.places.iter().map(|place| self.rows[place.table][place.index])
    }
}

#[cfg(test)]
mod tests {
    use super::whole;

    #[test]
    fn numbers_of_lists_know_their_list() {
        assert_eq!(whole("tip[2]"), Some("tip"));
        assert_eq!((whole("link[3].angle"), whole("tip"), whole("tip[a]")), (None, None, None));
    }
}
