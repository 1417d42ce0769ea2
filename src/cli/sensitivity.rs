//! `statics --sensitivity`: what an equilibrium and its outputs answer to the numbers of the scene.

use super::text::{aligned, number};
use crate::model::{Description, Model, Parameter};
use crate::round_off::EQUILIBRIUM;
use crate::statics::{Equilibrium, Sensitivities, sensitivities};
use anyhow::anyhow;
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::sync::Arc;

/// Numbers that are listed for an output; `--json` has all.
const MOST_LINES: usize = 12;

/// The sensitivities of outputs by their names to numbers by their addresses; without any to all numbers of the scene.
///
/// # Errors
/// An address or an output that is not known, an equilibrium that has no derivatives.
pub(super) fn of(
    description: &Description,
    model: &Arc<Model>,
    found: &Equilibrium,
    outputs: &[String],
    addresses: &[String],
    go_on: &dyn Fn() -> bool,
) -> anyhow::Result<Sensitivities> {
    let mut numbers: Vec<Parameter> = Vec::new();
    for address in addresses {
        let all = Parameter::find(description, address).map_err(|unknown| match unknown.help {
            Some(help) => anyhow!("{}; {help}", unknown.message),
            None => anyhow!(unknown.message),
        })?;
        numbers.extend(all.into_iter().filter(|one| !numbers.contains(one)).collect::<Vec<_>>());
    }
    let numbers = (!addresses.is_empty()).then_some(numbers);
    Ok(sensitivities(description, model, found, outputs, numbers, go_on)?)
}

/// `{output: {address: derivative}}`; `null` where there is none.
pub(super) fn json(table: &Sensitivities) -> Value {
    let row = |derivatives: &Vec<Option<f64>>| -> Value {
        let numbers = table.parameters.iter().map(|one| one.address.clone());
        Value::Object(numbers.zip(derivatives.iter().map(|x| json!(x))).collect())
    };
    let rows = table.outputs.iter().zip(&table.derivatives);
    Value::Object(rows.map(|(output, derivatives)| (output.name.clone(), row(derivatives))).collect::<Map<_, _>>())
}

/// For every output the numbers that move it, largest relative influence first: by how many per cent the output changes if the number
/// changes by one. Of an output or a number that is zero there are no per cents: these come after, by their derivatives.
pub(super) fn text(table: &Sensitivities) -> String {
    let mut out = String::new();
    for (output, derivatives) in table.outputs.iter().zip(&table.derivatives) {
        let unit = if output.unit == "1" { "" } else { &output.unit };
        let _ = writeln!(out, "  sensitivity  {} = {} {unit}", output.name, number(output.value));
        let mut felt: Vec<(usize, f64, Option<f64>)> = Vec::new();
        for (column, derivative) in derivatives.iter().enumerate() {
            let value = table.parameters[column].value;
            let Some(derivative) = derivative.filter(|x| *x != 0.0) else { continue };
            let share = derivative * value / output.value;
            felt.push((column, derivative, (value != 0.0 && output.value != 0.0).then_some(share)));
        }
        if felt.iter().any(|(_, _, share)| share.is_some_and(|share| EQUILIBRIUM.of(share.abs()) > 1.0)) {
            felt.iter_mut().for_each(|(_, _, share)| *share = None);
        }
        let size = |share: Option<f64>| share.map_or(-1.0, f64::abs);
        felt.sort_by(|a, b| size(b.2).total_cmp(&size(a.2)).then(b.1.abs().total_cmp(&a.1.abs())));
        let shown = aligned(felt.iter().take(MOST_LINES).map(|(_, derivative, _)| *derivative));
        for ((column, _, share), shown) in felt.iter().zip(shown) {
            let one = &table.parameters[*column];
            let share = share.map_or_else(|| "      –  ".to_owned(), |share| format!("{share:>+9.4}"));
            let per = per(unit, one.unit);
            let _ = writeln!(out, "  {:<12} {share}  {:<28} {} {per}", "", one.address, shown);
        }
        let rest = felt.len().saturating_sub(MOST_LINES);
        let none = derivatives.iter().filter(|x| **x == Some(0.0)).count();
        let unknown = derivatives.iter().filter(|x| x.is_none()).count();
        for (count, what) in [(rest, "more move it less"), (none, "do not move it"), (unknown, "have no derivative")] {
            if count > 0 {
                let _ = writeln!(out, "  {:<12} … {count} {what}", "");
            }
        }
    }
    for note in &table.notes {
        let _ = writeln!(out, "  {:<12} {note}", "note");
    }
    out.truncate(out.trim_end().len());
    out
}

/// A unit by another.
fn per(unit: &str, by: &str) -> String {
    match (unit, by) {
        (unit, "") => unit.to_owned(),
        (unit, by) => {
            let by = if by.contains([' ', '/']) { format!("({by})") } else { by.to_owned() };
            format!("{}/{by}", if unit.is_empty() { "1" } else { unit })
        }
    }
}
