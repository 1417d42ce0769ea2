//! The verdict, in words.

use super::super::text::{count, is_fine, number, small};
use super::material::Material;
use serde_json::Value;

/// What a report says first.
pub(in crate::cli) struct Headline {
    pub(in crate::cli) text: String,
    /// Whether it is what was hoped for.
    pub(in crate::cli) fine: bool,
}

pub(in crate::cli) fn verdict(material: &Material) -> Headline {
    let Material { statics, outcome, .. } = material;
    if let Some(error) = outcome["error"].as_str() {
        return Headline { text: format!("The run could not go on: {error}"), fine: false };
    }
    let mut text = match (statics["balanced"].as_bool(), statics["stability"].as_str()) {
        (None, _) => "The start was given".to_owned(),
        (Some(false), _) => "No equilibrium was found".to_owned(),
        (_, Some(kind)) => format!("{} equilibrium", capital(kind)),
        (_, None) => "Equilibrium".to_owned(),
    };
    let was_stopped = outcome["interrupted"] == true;
    match (outcome["end_time"].as_f64(), material.samples.last()) {
        (Some(end), _) => {
            let state = if was_stopped { "stopped at" } else { "simulated" };
            text += &format!("; {state} {} s", number(end));
        }
        (None, Some(last)) => text += &format!("; the recording breaks off at {} s", number(last.time)),
        (None, None) => {}
    }
    let is_whole = !was_stopped && (outcome.is_object() || material.samples.is_empty());
    let stands = statics.is_null() || is_fine(statics["converged"] == true, statics["stability"].as_str());
    Headline { text, fine: is_whole && stands }
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

/// What proves the equilibrium, one sentence each; none if nothing was looked for.
pub(super) fn certificate(statics: &Value) -> Vec<String> {
    let Some(relative) = statics["relative_residual"].as_f64() else { return Vec::new() };
    let residual = statics["residual_force"].as_f64().filter(|force| *force > 0.0);
    let place = statics["residual_unit"].as_str().zip(statics["residual_at"].as_str());
    let mut said = vec![match (relative, residual.zip(place)) {
        (0.0, _) => "Forces that must cancel do so to the last digit.".to_owned(),
        (_, Some((force, (unit, at)))) => format!(
            "Forces that must cancel do so to {} of their size: the residual is {} {unit} at most, in `{at}`.",
            small(relative),
            small(force)
        ),
        (_, None) => format!("Forces that must cancel do so to {} of their size.", small(relative)),
    }];
    match statics["stability"].as_str() {
        Some("stable") => said.push("Stable: each small displacement is pushed back.".to_owned()),
        Some("unstable") => said.push(format!(
            "Unstable: small displacements grow in {}.",
            count(statics["unstable_directions"].as_u64().unwrap_or(1) as usize, "direction", "directions")
        )),
        Some("neutral") => said.push(format!(
            "Neutral: in {} the stiffness is zero, and no force restores the pose.",
            count(statics["neutral_directions"].as_u64().unwrap_or(1) as usize, "direction", "directions")
        )),
        _ => {}
    }
    if let (Some(stage), Some(steps)) = (statics["stage"].as_str(), statics["iterations"].as_u64()) {
        said.push(format!("Found by the stage “{stage}” in {}.", count(steps as usize, "step", "steps")));
    }
    let standing = &statics["standing"];
    if let Some(verdict) = standing["verdict"].as_str() {
        said.push(format!("As it is put, with its contacts and dry friction, it {}.", standing_word(verdict)));
    }
    said
}

fn standing_word(verdict: &str) -> &str {
    match verdict {
        "wedged" => "is wedged: it may stand by forces that nothing determines",
        other => other,
    }
}

/// What is known of the run's error; empty without a run.
pub(super) fn errors(outcome: &Value) -> Vec<String> {
    let mut said = Vec::new();
    if let (Some(steps), Some(methods)) = (outcome["steps"].as_u64(), outcome["integrator"].as_str()) {
        let rejected = outcome["rejected_steps"].as_u64().unwrap_or_default();
        said.push(format!("{} ({rejected} rejected) by {methods}.", count(steps as usize, "step", "steps")));
    }
    if let Some(gap) = outcome["constraint_error"].as_f64().filter(|gap| *gap > 0.0) {
        said.push(format!("Loops, gears and drives were open by {} m at most.", small(gap)));
    }
    let verified = &outcome["verified"];
    if let Some(method) = verified["method"].as_str() {
        let units = [("length", "m"), ("angle", "rad"), ("speed", "m/s"), ("rate", "rad/s"), ("time", "s")];
        let part = |(key, unit): (&str, &str)| {
            verified[key].as_f64().filter(|error| *error > 0.0).map(|error| format!("{} {unit}", small(error)))
        };
        let parts: Vec<String> = units.into_iter().filter_map(part).collect();
        let error = if parts.is_empty() { "nothing".to_owned() } else { parts.join(", ") };
        said.push(format!("At its end the run is wrong by {error}, estimated by a second, tighter run ({method})."));
    } else if outcome["steps"].is_u64() {
        said.push("The run's error was not estimated; `--verify` does it.".to_owned());
    }
    said
}
