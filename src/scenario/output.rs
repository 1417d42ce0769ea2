//! `[[output]]`: what is asked of a scene.

use super::body::Names;
use super::findings::Finding;
use super::force::{between, end};
use super::format::{COMPONENTS, SECTIONS};
use super::formulas::formula;
use super::quantities::Parameters;
use super::reader::Reader;
use super::spans::SpanTable;
use crate::model::description::{
    Attachment, Axes, DirectionDescription, EnergyKind, Order, OutputDescription, PowerKind, QuantityDescription,
};

/// The most numbers that an output has.
pub(super) const MOST_COMPONENTS: usize = 7;

/// Reads all of them.
pub(super) fn outputs(
    scenario: &Reader<'_>,
    bodies: &Names<'_>,
    parameters: &Parameters,
    into: &mut Vec<OutputDescription>,
    spans: &mut SpanTable<'_>,
) {
    let tables = scenario.tables("output");
    let labels = |name: &str| {
        let several = (0..MOST_COMPONENTS).map(|index| format!("{name}[{index}]")).collect::<Vec<_>>();
        several.into_iter().chain([name.to_owned()])
    };
    let names: Vec<String> =
        tables.iter().filter_map(|table| table.text("name")).flat_map(labels).chain(["t".to_owned()]).collect();
    let variables: Vec<&str> = names.iter().map(String::as_str).collect();
    for (index, table) in tables.iter().enumerate() {
        if let Some(output) = output(table, bodies, parameters, &variables) {
            into.push(output);
            spans.outputs.push(index);
        }
    }
}

/// One of them; `None` if too little of it is readable.
fn output(
    table: &Reader<'_>,
    bodies: &Names<'_>,
    parameters: &Parameters,
    variables: &[&str],
) -> Option<OutputDescription> {
    let name = table.text("name")?;
    let text = || table.text("of").map(str::to_owned);
    let axes = if table.text("in") == Some("body") { Axes::Body } else { Axes::Inertial };
    let component = table.text("component").and_then(|name| COMPONENTS.iter().position(|(one, _)| *one == name));
    let order = match table.text("type")? {
        "velocity" => Order::Velocity,
        "acceleration" => Order::Acceleration,
        _ => Order::Position,
    };
    let of = match table.text("type")? {
        "position" | "velocity" | "acceleration" => {
            let on = point(table, name, "of", bodies)?;
            QuantityDescription::Point { order, on, axis: table.vector("axis"), axes }
        }
        "distance" => QuantityDescription::Distance { between: points(table, name, bodies)? },
        "angle" => QuantityDescription::Angle {
            of: direction(table, "of")?,
            against: direction(table, "against")?,
            about: table.vector("about"),
        },
        "orientation" => QuantityDescription::Orientation { body: text()? },
        "coordinate" => QuantityDescription::Coordinate { of: text()? },
        "rate" => QuantityDescription::Rate { of: text()? },
        "force" => QuantityDescription::Force { of: text()?, component },
        "length" => QuantityDescription::Length { of: text()? },
        "reaction" => QuantityDescription::Reaction { body: text()?, component, axes },
        "section" => {
            let word = table.text("component");
            let component = word.and_then(|word| SECTIONS.iter().position(|(one, _)| *one == word));
            QuantityDescription::Section { of: text()?, s: table.number("s")?, component }
        }
        "energy" => QuantityDescription::Energy(match table.text("of")? {
            "kinetic" => EnergyKind::Kinetic,
            "potential" => EnergyKind::Potential,
            "input" => EnergyKind::Input,
            _ => EnergyKind::Dissipated,
        }),
        "power" => QuantityDescription::Power(match table.text("of")? {
            "input" => PowerKind::Input,
            _ => PowerKind::Dissipated,
        }),
        "expression" => QuantityDescription::Expression {
            text: formula(table, &format!("output `{name}`"), variables, parameters)?,
            unit: table.text("unit").unwrap_or("1").to_owned(),
        },
        _ => return None,
    };
    Some(OutputDescription { name: name.to_owned(), of })
}

/// A point that must be there.
fn point(table: &Reader<'_>, name: &str, key: &str, bodies: &Names<'_>) -> Option<Attachment> {
    if !table.has(key) {
        let message = format!("output `{name}`: `{key}` is missing");
        let help = "write a point, for example `of = \"arm.tip\"` or `of = { body = \"arm\", at = [0.0, 0.0, 1.0] }`";
        table.findings.push(Finding::error(table.span.clone(), message).help(help));
    }
    end(table, table.value(key)?, bodies)
}

/// Two points: `between`, or `of` and `against`.
fn points(table: &Reader<'_>, name: &str, bodies: &Names<'_>) -> Option<[Attachment; 2]> {
    let apart = table.has("of") || table.has("against");
    if table.has("between") && !apart {
        return between(table, bodies);
    }
    if table.has("between") || !apart {
        let message = format!("output `{name}`: two points are given by `between`, or by `of` and `against`");
        let help = "for example `between = [\"chassis.strut\", \"lower arm.seat\"]`";
        table.findings.push(Finding::error(table.span.clone(), message).help(help));
        return None;
    }
    Some([point(table, name, "against", bodies)?, point(table, name, "of", bodies)?])
}

fn direction(table: &Reader<'_>, key: &str) -> Option<DirectionDescription> {
    let inner = table.table(key)?;
    Some(DirectionDescription { body: inner.text("body")?.to_owned(), axis: inner.vector("axis")? })
}
