//! Rows of a study as they are shown: on a terminal, as JSON, as CSV.

use super::super::output;
use super::super::text::{count, number, without_noise};
use crate::model::Model;
use crate::study::axis::word;
use crate::study::plan::Value;
use crate::study::{Cases, Cell, Row};
use crate::whole_file::WholeFile;
use serde_json::{Map, json};
use std::collections::BTreeMap;

/// Rows that are printed; `--json` and `--out` have all.
const MOST_LINES: usize = 40;

/// Takes parts in any order and their rows in the order of the cases.
pub(super) struct Rows<'c> {
    cases: &'c Cases,
    /// The part whose rows come next, and parts that came too early.
    next: u64,
    early: BTreeMap<u64, Vec<Row>>,
    table: Option<csv::Writer<WholeFile>>,
    list: Option<Vec<serde_json::Value>>,
    lines: Vec<String>,
    pub(super) failed: u64,
    /// Length of the scene (m), with which smaller numbers are compared: round-off or not.
    length: f64,
}

impl<'c> Rows<'c> {
    /// `table` gets all rows as CSV, `json` keeps all for an answer in JSON.
    pub(super) fn new(cases: &'c Cases, table: Option<WholeFile>, json: bool) -> anyhow::Result<Self> {
        let mut table = table.map(csv::Writer::from_writer);
        if let Some(table) = &mut table {
            table.write_record(cases.columns().iter().map(|column| &column.name))?;
        }
        let list = json.then(Vec::new);
        let length = Model::build(&cases.scenario().description).map_or(0.0, |model| model.length_scale());
        Ok(Self { cases, next: 0, early: BTreeMap::new(), table, list, lines: Vec::new(), failed: 0, length })
    }

    pub(super) fn take(&mut self, part: u64, rows: Vec<Row>) -> anyhow::Result<()> {
        self.early.insert(part, rows);
        while let Some(rows) = self.early.remove(&self.next) {
            rows.iter().try_for_each(|row| self.row(row))?;
            self.next += 1;
        }
        Ok(())
    }

    fn row(&mut self, row: &Row) -> anyhow::Result<()> {
        self.failed += u64::from(row.error.is_some());
        if let Some(table) = &mut self.table {
            table.write_record(row.cells.iter().map(ToString::to_string))?;
        }
        if let Some(list) = &mut self.list {
            list.push(json(self.cases, row));
        } else if self.lines.len() < MOST_LINES {
            self.lines.push(line(self.cases, row, self.length));
        }
        Ok(())
    }

    /// Gives the table its name; the rows in JSON, if they were asked for.
    pub(super) fn finish(&mut self) -> anyhow::Result<Option<Vec<serde_json::Value>>> {
        if let Some(table) = self.table.take() {
            output::whole(table)?.finish()?;
        }
        Ok(self.list.take())
    }

    /// The report for a terminal.
    pub(super) fn report(&self, cases: u64) -> String {
        let mut out = self.lines.concat();
        if cases > self.lines.len() as u64 {
            out += &format!("… and {} more (`--out` and `--json` have all)\n", cases - self.lines.len() as u64);
        }
        out + &counted(cases, self.failed) + &side_by_side(self.cases)
    }
}

/// How many cases there were, and how many failed.
pub(super) fn counted(cases: u64, failed: u64) -> String {
    let cases = count(cases as usize, "case", "cases");
    if failed == 0 { cases } else { format!("{failed} of {cases} failed") }
}

/// How many cases were computed at once; nothing if it was one by one.
pub(super) fn side_by_side(cases: &Cases) -> String {
    match cases.width() {
        1 => String::new(),
        4 => ", computed four side by side".to_owned(),
        8 => ", computed eight side by side".to_owned(),
        width => format!(", computed {width} side by side"),
    }
}

/// The answers of a row with the names of their columns, those that there are.
fn answers<'r>(cases: &'r Cases, row: &'r Row) -> impl Iterator<Item = (&'r str, &'r Cell)> {
    let (columns, inputs) = (cases.columns(), cases.plan.paths().count());
    let answers = inputs + 3..columns.len() - 1;
    let named = columns[answers.clone()].iter().map(|column| column.name.as_str()).zip(&row.cells[answers]);
    named.filter(|(_, cell)| **cell != Cell::Empty)
}

fn json(cases: &Cases, row: &Row) -> serde_json::Value {
    let value = |value: Value<'_>| match value {
        Value::Written(text, _) => text.parse::<f64>().map_or_else(|_| json!(word(text)), |number| json!(number)),
        Value::Drawn(number) => json!(number),
    };
    let named = cases.plan.paths().zip(cases.plan.values(row.case));
    let values: Map<_, _> = named.map(|(path, one)| (path.to_owned(), value(one))).collect();
    if let Some(why) = &row.error {
        return json!({ "case": row.case, "values": values, "ok": false, "error": why });
    }
    let cell = |cell: &Cell| match cell {
        Cell::Empty => serde_json::Value::Null,
        Cell::Number(number) => json!(number),
        Cell::Whole(number) => json!(number),
        Cell::Word(word) => json!(word),
        Cell::Flag(flag) => json!(flag),
    };
    let result: Map<_, _> = answers(cases, row).map(|(name, one)| (name.to_owned(), cell(one))).collect();
    json!({ "case": row.case, "values": values, "ok": true, "result": result })
}

fn line(cases: &Cases, row: &Row, length: f64) -> String {
    let shown = |value: Value<'_>| match value {
        Value::Written(text, _) => word(text).to_owned(),
        Value::Drawn(drawn) => number(drawn),
    };
    let named = cases.plan.paths().zip(cases.plan.values(row.case));
    let named: Vec<String> = named.map(|(path, value)| format!("{path} = {}", shown(value))).collect();
    let said = match &row.error {
        Some(why) => format!("failed: {why}"),
        None => {
            let shown = |(name, cell): (&str, &Cell)| match cell {
                Cell::Number(x) => {
                    let column = cases.columns().iter().find(|column| column.name == name);
                    let scale = column.map_or(0.0, |column| match &*column.unit {
                        "m" => length,
                        "rad" | "1" => 1.0,
                        _ => 0.0,
                    });
                    format!("{name} {}", number(without_noise(*x, scale)))
                }
                Cell::Word(word) => word.to_string(),
                other => format!("{name} {other}"),
            };
            // Of the modes the first one: the line is short.
            let left_out = |name: &str| {
                let mode = name.contains("_hz[") || name.starts_with("damping_ratios[");
                name.starts_with("residual_") || name == "iterations" || mode && name != "frequencies_hz[0]"
            };
            answers(cases, row).filter(|(name, _)| !left_out(name)).take(5).map(shown).collect::<Vec<_>>().join(", ")
        }
    };
    format!("{:<40} {said}\n", named.join(", "))
}
