//! `[[controller]]`.

use super::couplings::name;
use super::findings::Finding;
use super::formulas::ambiguous;
use super::output::MOST_COMPONENTS;
use super::quantities::Parameters;
use super::reader::{Reader, rows};
use crate::formula::Formula;
use crate::model::controller::{ControlLawDescription, ControllerDescription};

/// Reads a `[[controller]]`; `None` if too little of it is readable.
pub(super) fn controller(table: &Reader<'_>, index: usize, parameters: &Parameters) -> Option<ControllerDescription> {
    let name = name(table, "controller", index);
    let (senses, drives) = (texts(table, "senses")?, texts(table, "drives")?);
    let law = match table.text("type")? {
        "gain" => ControlLawDescription::Gain {
            matrix: rows(table.value("matrix")?.get_ref())?,
            setpoint: table.numbers("setpoint").unwrap_or_default(),
            bias: table.numbers("bias").unwrap_or_default(),
        },
        "pid" => ControlLawDescription::Pid {
            proportional: table.number("proportional").unwrap_or(0.0),
            integral: table.number("integral").unwrap_or(0.0),
            derivative: table.number("derivative").unwrap_or(0.0),
            setpoint: table.number("setpoint").unwrap_or(0.0),
            bias: table.number("bias").unwrap_or(0.0),
            limit: table.number("limit"),
        },
        "expression" => ControlLawDescription::Expression { texts: formulas(table, &name, &senses, parameters)? },
        _ => return None,
    };
    Some(ControllerDescription { name, period: table.number("period")?, senses, drives, law, memory: Vec::new() })
}

/// The texts of a list, or the one that stands there alone.
fn texts(table: &Reader<'_>, key: &str) -> Option<Vec<String>> {
    let value = table.value(key)?.get_ref();
    match value.as_array() {
        Some(list) => list.iter().map(|item| Some(item.get_ref().as_str()?.to_owned())).collect(),
        None => Some(vec![value.as_str()?.to_owned()]),
    }
}

/// Formulas in what is sensed, the time and `[parameters]`, these put in.
fn formulas(table: &Reader<'_>, owner: &str, senses: &[String], parameters: &Parameters) -> Option<Vec<String>> {
    const KEY: &str = "expression";
    let labels = |name: &String| {
        let several = (0..MOST_COMPONENTS).map(|index| format!("{name}[{index}]")).collect::<Vec<_>>();
        several.into_iter().chain([name.clone()])
    };
    let own: Vec<String> = senses.iter().flat_map(labels).chain(["t".to_owned()]).collect();
    let variables: Vec<&str> = own.iter().map(String::as_str).collect();
    let names: Vec<&str> = variables.iter().copied().chain(parameters.names()).collect();
    let read = |text: String| {
        let error = match (Formula::parse(&text, &names), parameters.ambiguous(&text, &variables)) {
            (Ok(_), None) => return parameters.put_into(&text, &variables),
            (Ok(_), Some(both)) => ambiguous(both),
            (Err(error), _) => error,
        };
        let message = format!("controller `{owner}`: {}", error.in_words(&text));
        table.findings.push(Finding::error(table.span_of(KEY), message).maybe_help(error.help));
        // Stands in for it, so that nothing else is found wrong because of it.
        "0".to_owned()
    };
    Some(texts(table, KEY)?.into_iter().map(read).collect())
}
