//! From a checked file to a description, and back from the description's elements to the file.

use super::beam::{beam, cable, close};
use super::body::{Names, Template, template};
use super::contact::{contact, find_parts};
use super::controller::controller;
use super::couplings::{closed_loop, drive, gear};
use super::event::event;
use super::findings::{Finding, Findings};
use super::force::force;
use super::format::MOST_BODIES;
use super::motor::motor;
use super::output::outputs;
use super::quantities::Parameters;
use super::reader::Reader;
use super::spans::SpanTable;
use super::stage::stage;
use crate::model::description::Description;
use std::path::Path;
use toml::de::DeTable;

/// Reads the scene. What cannot be read is left out or stood in for; that has been or is said in `findings`.
pub(super) fn lower<'a>(
    document: &'a DeTable<'a>,
    folder: &Path,
    findings: &'a Findings,
) -> (Description, SpanTable<'a>) {
    let scenario = Reader::new(document, 0..0, findings);
    let mut description = Description::default();
    if let Some(title) = scenario.text("title") {
        description.title = title.to_owned();
    }
    description.gravity = scenario.vector("gravity").unwrap_or(description.gravity);
    let mut spans = SpanTable::new(document);
    let parameters = Parameters::read(document);
    bodies(&scenario, (folder, &parameters), &mut description, &mut spans);
    for (index, table) in scenario.tables("beam").iter().enumerate() {
        match beam(table, &parameters) {
            Some(beam) => {
                description.beams.push(beam);
                spans.beams.push(("beam", index));
            }
            None => spans.add_nameless(),
        }
    }
    let cables = cables(&scenario, &mut description, &mut spans);
    let names = Names::new(&description.bodies, &description.beams);
    // Bodies and beams, cables among them, keep their names from here on.
    let first = description.beams.len() - cables.len();
    let mut closed = description.beams[first..].to_vec();
    closed.iter_mut().zip(&cables).for_each(|(cable, table)| close(cable, table, &names));
    for (index, table) in scenario.tables("force").iter().enumerate() {
        if let Some(force) = force(table, index, &names) {
            description.forces.push(force);
            spans.add_force(index);
        }
    }
    for (index, table) in scenario.tables("loop").iter().enumerate() {
        if let Some(closed) = closed_loop(table, index, &names) {
            description.loops.push(closed);
            spans.loops.push(index);
        }
    }
    each(&scenario, "drive", &mut description.drives, &mut spans.drives, |table, index| {
        drive(table, index, &parameters)
    });
    each(&scenario, "gear", &mut description.gears, &mut spans.gears, gear);
    each(&scenario, "motor", &mut description.motors, &mut spans.motors, |table, index| {
        motor(table, index, &parameters)
    });
    for (index, table) in scenario.tables("event").iter().enumerate() {
        if let Some(event) = event(table, index, &names) {
            description.events.push(event);
            spans.add_event(index);
        }
    }
    each(&scenario, "stage", &mut description.stages, &mut spans.stages, stage);
    each(&scenario, "contact", &mut description.contacts, &mut spans.contacts, contact);
    outputs(&scenario, &names, &parameters, &mut description.outputs, &mut spans);
    description.beams.truncate(first);
    description.beams.extend(closed);
    each(&scenario, "controller", &mut description.controllers, &mut spans.controllers, |table, index| {
        controller(table, index, &parameters)
    });
    find_parts(&scenario, &mut description, &spans);
    (description, spans)
}

/// Reads all tables of one name, and keeps the places of those that could be read.
fn each<'r, T>(
    scenario: &Reader<'r>,
    name: &str,
    list: &mut Vec<T>,
    places: &mut Vec<usize>,
    read: impl Fn(&Reader<'r>, usize) -> Option<T>,
) {
    for (index, table) in scenario.tables(name).iter().enumerate() {
        if let Some(one) = read(table, index) {
            list.push(one);
            places.push(index);
        }
    }
}

/// The cables among the beams, after the others, without their ends; and their tables.
fn cables<'r, 'a>(scenario: &Reader<'r>, description: &mut Description, spans: &mut SpanTable<'a>) -> Vec<Reader<'r>> {
    let mut read = Vec::new();
    for (index, table) in scenario.tables("cable").into_iter().enumerate() {
        match cable(&table) {
            Some(cable) => {
                description.beams.push(cable);
                spans.beams.push(("cable", index));
                spans.cables.push(index);
                read.push(table);
            }
            None => spans.add_nameless(),
        }
    }
    read
}

fn bodies(
    scenario: &Reader<'_>,
    (folder, parameters): (&Path, &Parameters),
    description: &mut Description,
    spans: &mut SpanTable<'_>,
) {
    let tables = scenario.tables("body");
    let templates: Vec<Option<Template>> = tables.iter().map(|table| template(table, folder, parameters)).collect();
    // All of them before any: every one is made of memory.
    let mut total = 0_usize;
    for (table, template) in tables.iter().zip(&templates) {
        total = total.saturating_add(template.as_ref().map_or(0, Template::count));
        if total > MOST_BODIES {
            let message = format!("{total} bodies are more than the {MOST_BODIES} that a scenario may have");
            scenario.findings.push(Finding::error(table.span_of("repeat"), message));
            return;
        }
    }
    for (index, template) in templates.iter().enumerate() {
        let Some(template) = template else {
            spans.add_nameless();
            continue;
        };
        template.expand(description);
        spans.add_bodies(index, template.repeat);
    }
}
