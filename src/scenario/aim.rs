//! `statics.aim`: what outputs of the equilibrium shall be.

use super::findings::Finding;
use super::measured;
use super::quantities::Numbers;
use super::reader::{Reader, number};
use crate::model::structure::Structure;
use crate::model::{Description, Model, Parameter};
use crate::statics::Aim;
use crate::suggest::closest;

/// The outputs that are aimed at, in the order of the file.
pub(super) fn read(
    scenario: &Reader<'_>,
    description: &Description,
    unknown: &[Parameter],
    texts: &Numbers,
) -> Vec<Aim> {
    let Some(table) = scenario.table("statics") else { return Vec::new() };
    let Some(aims) = table.table("aim") else { return Vec::new() };
    let refuse = |finding: Finding, help: &str| table.findings.push(finding.help(help));
    if !table.has("unknown") {
        let message = "`aim` needs `unknown`: numbers that are found so that the outputs are these".to_owned();
        refuse(Finding::error(table.key_span("aim"), message), "for example `unknown = [\"spring.length\"]`");
    } else if aims.table.is_empty() {
        let message = "`aim` names no output".to_owned();
        refuse(
            Finding::error(table.key_span("aim"), message),
            "give each its value, as `aim = { elevation = 0.8 }`; without `aim` the unknown numbers are those that hold the given pose",
        );
    } else if aims.table.len() > unknown.len() && !unknown.is_empty() {
        let message = format!("{} outputs are aimed at with {} unknown", aims.table.len(), unknown.len());
        refuse(Finding::error(table.key_span("aim"), message), "at least as many numbers have to be unknown");
    }
    let is_dry = description.bodies.iter().any(|body| !body.hinge.friction.is_empty());
    if is_dry || !description.contacts.is_empty() {
        let message = "`aim` goes without contact and dry friction".to_owned();
        refuse(
            Finding::error(table.key_span("aim"), message),
            "they hold a pose as it is, which then follows no number",
        );
    }
    // What is wrong with the scene itself is said elsewhere.
    let Ok(model) = Model::build(&Structure::first(description).describe(description)) else { return Vec::new() };
    let labels = model.outputs.iter().flat_map(|output| output.labels().zip(&output.units));
    let labels: Vec<(String, &String)> = labels.collect();
    let mut all: Vec<Aim> = Vec::new();
    let mut keys: Vec<_> = aims.table.iter().collect();
    keys.sort_by_key(|(key, _)| key.span().start);
    for (key, value) in keys {
        let name = key.get_ref().as_ref();
        let Some((_, unit)) = labels.iter().find(|(label, _)| label == name) else {
            let parts: Vec<&str> = labels
                .iter()
                .map(|(label, _)| label.as_str())
                .filter(|label| label.starts_with(&format!("{name}[")))
                .collect();
            let (message, help) =
                match (parts.is_empty(), closest(name, labels.iter().map(|(label, _)| label.as_str()))) {
                    (false, _) => (
                        format!("output `{name}` has several numbers"),
                        Some(format!("aim at one: `\"{}\"`", parts[0])),
                    ),
                    (true, Some(near)) => {
                        (format!("the scenario has no output `{name}`"), Some(format!("did you mean `{near}`?")))
                    }
                    (true, None) => (format!("the scenario has no output `{name}`"), None),
                };
            table.findings.push(Finding::error(key.span(), message).maybe_help(help));
            continue;
        };
        if let Some(wanted) = number(value.get_ref()) {
            let size = measured::size(scenario, texts, value.span(), name, unit);
            all.push(Aim { output: name.to_owned(), value: wanted / size });
        }
    }
    all
}
