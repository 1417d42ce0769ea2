//! `[statics.path]`: the number that moves, and over which range.

use super::findings::Finding;
use super::quantities::Numbers;
use super::reader::{Reader, Value};
use super::unknown::is_guess;
use crate::model::parameter::{Field, Parameter};
use crate::model::{Description, Model};
use crate::quantity::Dimension;
use crate::statics::path::PathSettings;
use toml::Spanned;

/// The path that is asked for; `None` if there is none, or too little of it can be read.
pub(super) fn read(scenario: &Reader<'_>, description: &Description, texts: &Numbers) -> Option<PathSettings> {
    let table = scenario.table("statics")?.table("path")?;
    let refuse = |key: &str, message: String, help: Option<String>| {
        table.findings.push(Finding::error(table.span_of(key), message).maybe_help(help));
    };
    if scenario.table("statics").is_some_and(|statics| statics.has("unknown")) {
        let help = "a path follows the equilibrium of given numbers";
        refuse("parameter", "`path` and `unknown` do not go together".to_owned(), Some(help.to_owned()));
    }
    let numbers = numbers(&table, description)?;
    let first = numbers.first()?;
    check_units(&table, first, texts);
    let from = table.number("from").unwrap_or_else(|| first.value(description));
    let to = table.number("to")?;
    if from == to {
        refuse("to", format!("the path goes from {from} to {to}: there is no way"), None);
    }
    for (key, value) in [("from", from), ("to", to)] {
        let mut end = description.clone();
        if let Err(why) = numbers.iter().try_for_each(|one| one.set(&mut end, value)) {
            refuse(key, why, None);
        }
        // What is wrong with the scene itself is said elsewhere.
        if Model::build(description).is_ok()
            && let Some(problem) = Model::build(&end).err().and_then(|problems| problems.into_iter().next())
        {
            refuse(key, problem.message, problem.help);
        }
    }
    let at: Vec<f64> = table.numbers("at").unwrap_or_default();
    if let Some(outside) = at.iter().find(|at| !(from.min(to)..=from.max(to)).contains(*at)) {
        refuse("at", format!("{outside} is not between {from} and {to}"), None);
    }
    Some(PathSettings {
        parameter: table.text("parameter")?.to_owned(),
        coordinate: coordinate(&table, description),
        numbers,
        from,
        to,
        at,
        step: table.number("step").unwrap_or(0.02),
        points: table.count("points").unwrap_or(1000),
        branches: table.flag("branches").unwrap_or(true),
    })
}

/// Quantities of the range must be those of the parameter.
fn check_units(table: &Reader<'_>, parameter: &Parameter, texts: &Numbers) {
    let unit = parameter.quantity.unit();
    if unit.is_empty() {
        return;
    }
    let own = |value: &Value<'_>| vec![value.span()];
    let spans = ["from", "to", "at"].into_iter().filter_map(|key| table.value(key)).flat_map(|value| {
        value.get_ref().as_array().map_or_else(|| own(&value), |items| items.iter().map(Spanned::span).collect())
    });
    for span in spans {
        let Some(measure) = texts.measure(&span) else { continue };
        if !Dimension::of(unit).is_ok_and(|dimension| measure.fits(dimension)) {
            let message = format!("`{}` is measured in {unit}, not in this unit", parameter.address);
            table.findings.push_value(Finding::error(span, message));
        }
    }
}

/// What the parameter's address stands for: one number of every element that it names.
fn numbers(table: &Reader<'_>, description: &Description) -> Option<Vec<Parameter>> {
    let address = table.text("parameter")?;
    let refuse = |message: String, help: Option<String>| {
        table.findings.push_value(Finding::error(table.span_of("parameter"), message).maybe_help(help));
    };
    let found = match Parameter::find(description, address) {
        Ok(found) => found,
        Err(error) => {
            refuse(error.message, error.help);
            return None;
        }
    };
    if let Some(pair) = found.windows(2).find(|pair| pair[0].element == pair[1].element) {
        let help = format!("a path moves one of them, for example `{}`", pair[0].address);
        refuse(format!("`{address}` has several components"), Some(help));
        return None;
    }
    if let Some(other) = found.iter().find(|one| one.quantity != found[0].quantity) {
        let units = (found[0].quantity.unit(), other.quantity.unit());
        refuse(format!("`{address}` stands for numbers in {} and in {}", units.0, units.1), None);
        return None;
    }
    if let Some(one) = found.iter().find(|one| is_guess(one, description)) {
        let help = "a path can move a hinge that is held: add `lock = true` to it, or a drive";
        refuse(format!("`{}` is a guess, statics finds it", one.address), Some(help.to_owned()));
        return None;
    }
    Some(found)
}

fn coordinate(table: &Reader<'_>, description: &Description) -> Option<Parameter> {
    let address = table.text("coordinate")?;
    let refuse = |message: String, help: Option<String>| {
        table.findings.push(Finding::error(table.span_of("coordinate"), message).maybe_help(help));
    };
    match Parameter::find(description, &by_place(description, address)).as_deref() {
        Ok([one]) if one.field == Field::Position => return Some(one.clone()),
        Ok([one]) => refuse(
            format!("`{}` is no coordinate of a hinge", one.address),
            Some("coordinates are addressed as `body.position` or `body.position[1]`".to_owned()),
        ),
        Ok(many) => refuse(
            format!("`{address}` stands for {} numbers", many.len()),
            Some(format!("choose one, for example `{}`", many[0].address)),
        ),
        Err(error) => refuse(error.message.clone(), error.help.clone()),
    }
    None
}

/// The address of a coordinate that is called as in reports: `bar.angle` is `bar.position`, `slider.y` is `slider.position[1]`.
fn by_place(description: &Description, address: &str) -> String {
    let named = |(body, name): (&str, &str)| {
        let body = description.bodies.iter().find(|one| one.name == body)?;
        let positions = body.hinge.kind.positions();
        let place = positions.iter().position(|(own, _)| *own == name)?;
        Some(if positions.len() == 1 {
            format!("{}.position", body.name)
        } else {
            format!("{}.position[{place}]", body.name)
        })
    };
    address.rsplit_once('.').and_then(named).unwrap_or_else(|| address.to_owned())
}
