//! The format as a page of Markdown, for people.

use super::fields::{Key, Kind, Range, Table, listed};
use super::format::SCENARIO;
use std::fmt::Write;

/// The reference of scenario files in Markdown, from the same declarations that check them: every table, key, unit,
/// range and default.
pub fn reference() -> String {
    let mut page = PREFACE.to_owned();
    section(&mut page, "A whole file", &SCENARIO);
    for (heading, table) in tables() {
        section(&mut page, &heading, table);
    }
    page
}

const PREFACE: &str = "\
# Scenario reference

Every table and key of the scenario format. Printed by

```console
$ stillpoint schema --markdown
```

from the declarations that check the files, so it cannot say anything else than the program does. Values are in SI units
and radians. **Bold** keys must be there. `stillpoint schema` prints the same as JSON Schema, for completion and checks in
editors. [Scenario files](scenario_files.md) explains with examples.
";

/// Every table below the whole file, outer ones first, each once, with its heading.
fn tables() -> Vec<(String, &'static Table)> {
    let mut found: Vec<(String, &'static Table)> = Vec::new();
    collect(&SCENARIO, true, &mut found);
    found
}

fn collect(table: &'static Table, top: bool, found: &mut Vec<(String, &'static Table)>) {
    for key in table.keys {
        let mut inner = Vec::new();
        tables_of(&key.kind, false, &mut inner);
        for (table, listed) in inner {
            if found.iter().any(|(_, known)| std::ptr::eq(*known, table)) {
                continue;
            }
            let heading = match (top, listed) {
                (true, true) => format!("`[[{}]]`", key.name),
                (true, false) => format!("`[{}]`", key.name),
                (false, _) => format!("`{}`", table.name),
            };
            found.push((heading, table));
            collect(table, false, found);
        }
    }
}

/// The tables that a value may be, and whether it is a list of them.
fn tables_of(kind: &'static Kind, in_list: bool, found: &mut Vec<(&'static Table, bool)>) {
    match kind {
        Kind::Table(table) => found.push((table, in_list)),
        Kind::List(of, _) => tables_of(of, true, found),
        Kind::Either(kinds) => kinds.iter().for_each(|kind| tables_of(kind, in_list, found)),
        Kind::Map(of) => tables_of(of, in_list, found),
        Kind::Text | Kind::Flag | Kind::Integer(_) | Kind::Number(_) | Kind::Choice(_) | Kind::Refused(_) => {}
    }
}

// Writing to a `String` cannot fail: results of `write!` are dropped here.
fn section(page: &mut String, heading: &str, table: &'static Table) {
    let _ = write!(page, "\n## {heading}\n\n{}\n", table.doc);
    if !table.types.is_empty() {
        page.push_str("\n| `type` | |\n|---|---|\n");
        for (name, doc) in table.types {
            let _ = writeln!(page, "| `\"{name}\"` | {} |", cell(doc));
        }
    }
    let keys = || table.keys.iter().filter(|key| !matches!(key.kind, Kind::Refused(_)));
    if keys().next().is_none() {
        return;
    }
    let by_type = keys().any(|key| !key.only.is_empty());
    page.push_str(if by_type {
        "\n| key | value | default | of type | meaning |\n|---|---|---|---|---|\n"
    } else {
        "\n| key | value | default | meaning |\n|---|---|---|---|\n"
    });
    for key in keys() {
        let name = if key.required { format!("**`{}`**", key.name) } else { format!("`{}`", key.name) };
        let default = if key.default.is_empty() { String::new() } else { format!("`{}`", key.default) };
        let _ = write!(page, "| {name} | {} | {default} ", cell(&value(key)));
        if by_type {
            let _ = write!(page, "| {} ", of_types(key, table));
        }
        let _ = writeln!(page, "| {} |", cell(&meaning(key)));
    }
    for key in keys() {
        if let Kind::Choice(words) = &key.kind {
            let _ = write!(page, "\n`{}` is one of\n\n", key.name);
            for (word, doc) in *words {
                let _ = writeln!(page, "- `\"{word}\"`: {doc}");
            }
        }
    }
}

/// The types that have a key: the shorter list of those and the others.
fn of_types(key: &Key, table: &Table) -> String {
    if key.only.is_empty() {
        return "all".to_owned();
    }
    let others: Vec<&str> = table.types.iter().map(|(name, _)| *name).filter(|name| !key.belongs_to(name)).collect();
    match others.len() {
        0 => "all".to_owned(),
        count if 2 * count < key.only.len() => format!("all but {}", listed(others.into_iter())),
        _ => listed(key.only.iter().copied()),
    }
}

fn meaning(key: &Key) -> String {
    if key.example.is_empty() { key.doc.to_owned() } else { format!("{} Example: `{}`.", key.doc, key.example) }
}

/// What may stand there, with range and unit.
fn value(key: &Key) -> String {
    let what = of_kind(&key.kind);
    if key.unit.is_empty() { what } else { format!("{what} [{}]", key.unit) }
}

fn of_kind(kind: &Kind) -> String {
    match kind {
        Kind::Text => "text".to_owned(),
        Kind::Flag => "`true` or `false`".to_owned(),
        Kind::Integer(range) => ranged("whole number", *range),
        Kind::Number(range) => ranged("number", *range),
        Kind::Choice(_) => "a word, see below".to_owned(),
        Kind::List(of, []) => format!("list of {}", several(of)),
        Kind::List(of, lengths) => {
            let counts: Vec<String> = lengths.iter().map(usize::to_string).collect();
            format!("list of {} {}", counts.join(" or "), several(of))
        }
        Kind::Either(kinds) => kinds.iter().map(of_kind).collect::<Vec<_>>().join("; or "),
        Kind::Table(table) => format!("table `{}`", table.name),
        Kind::Map(of) => format!("table of names, each with a {}", of_kind(of)),
        Kind::Refused(_) => String::new(),
    }
}

fn several(kind: &Kind) -> String {
    match kind {
        Kind::Text => "texts".to_owned(),
        Kind::Number(range) => ranged("numbers", *range),
        Kind::Integer(range) => ranged("whole numbers", *range),
        Kind::Table(table) => format!("tables `{}`", table.name),
        Kind::List(of, []) => format!("lists of {}", several(of)),
        Kind::List(of, lengths) => {
            let counts: Vec<String> = lengths.iter().map(usize::to_string).collect();
            format!("lists of {} {}", counts.join(" or "), several(of))
        }
        Kind::Either(kinds) => {
            format!("items, each a {}", kinds.iter().map(of_kind).collect::<Vec<_>>().join(" or a "))
        }
        other => of_kind(other),
    }
}

fn ranged(what: &str, range: Range) -> String {
    match range {
        Range::Any => what.to_owned(),
        _ => format!("{what} {}", range.allowed("")),
    }
}

/// Text that stays within its cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}
