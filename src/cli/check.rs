//! `check`: validate only.

use super::number::count;
use super::{Exit, conditioning, output};
use crate::contact::pairs::Pairs;
use crate::import::{Imported, Taken, counted, ignored_kinds};
use crate::model::Model;
use crate::scenario::{LoadError, Override, load_with, unreadable_meshes};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Scenario files, or models (URDF, MJCF); `-` reads standard input
    #[arg(required = true)]
    scenarios: Vec<PathBuf>,
    /// Check them with this change, as `simulate.duration=2`; may be repeated
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let overrides: Vec<Override> = arguments.set.iter().map(|text| Override::parse(text)).collect::<Result<_, _>>()?;
    let mut results = Vec::new();
    let mut wrong = 0;
    for path in &arguments.scenarios {
        let name = path.display().to_string();
        let mut models = Vec::new();
        let mut warnings = 0;
        let errors = match load_with(path, &overrides) {
            Ok(scenario) => {
                warnings = scenario.warnings.len();
                if !arguments.quiet && warnings > 0 {
                    output::note(scenario.warnings.findings(output::errors_in_color()).trim_end());
                }
                if !arguments.quiet {
                    // Nothing but a picture needs them, so other commands do not look.
                    for what in unreadable_meshes(&scenario.description) {
                        output::warning(&format!("{name}: {what}; it is not drawn"));
                    }
                    for model in scenario.models.iter().filter(|model| !model.notes.is_empty()) {
                        output::note(&said(model));
                    }
                }
                models.extend(scenario.models.iter().map(counts));
                let model = Model::build(&scenario.description).ok();
                // With loops, `inspect` says so: closing them takes as long as all the rest of a check.
                if !arguments.quiet
                    && let Some(model) = model.as_ref().filter(|model| !model.is_constrained())
                {
                    conditioning::warn(&name, &conditioning::ill_conditioned(model));
                }
                match model.filter(|model| !model.contacts.is_empty()).map(|model| Pairs::new(&model)) {
                    Some(Err(why)) => {
                        output::error(&anyhow::Error::new(why).context(name.clone()));
                        1
                    }
                    _ => 0,
                }
            }
            Err(LoadError::Problems(problems)) => {
                output::note(problems.render(output::errors_in_color()).trim_end());
                problems.errors()
            }
            Err(other) => {
                output::error(&other.into());
                1
            }
        };
        wrong += usize::from(errors > 0);
        if !arguments.json && !arguments.quiet && errors == 0 {
            let but = match warnings {
                0 => String::new(),
                some => format!(", but for {}", count(some, "warning", "warnings")),
            };
            output::print(&format!("{name}: {}{but}", output::verdict("fine", true)))?;
        }
        results.push(json!({ "scenario": name, "valid": errors == 0, "errors": errors, "models": models }));
    }
    if arguments.json {
        output::print(&json!({ "valid": wrong == 0, "scenarios": results }).to_string())?;
    }
    Ok(if wrong == 0 { Exit::Done } else { Exit::Wrong })
}

/// The file of a model.
fn file(model: &Imported) -> String {
    model.sources.first().map(|source| source.path.display().to_string()).unwrap_or_default()
}

/// `robot.xml: 2 approximated, 5 ignored (geom 3, sensor 2); …`
fn said(model: &Imported) -> String {
    let kinds: Vec<String> =
        ignored_kinds(&model.notes).into_iter().map(|(kind, count)| format!("{kind} {count}")).collect();
    let kinds = if kinds.is_empty() { String::new() } else { format!(" ({})", kinds.join(", ")) };
    let file = file(model);
    format!("{file}: {}{kinds}; `stillpoint convert {file}` lists them", counted(&model.notes))
}

/// How many notes there are of each kind.
fn counts(model: &Imported) -> Value {
    let count = |verdict: Taken| model.notes.iter().filter(|note| note.verdict == verdict).count();
    let kinds: serde_json::Map<String, Value> =
        ignored_kinds(&model.notes).into_iter().map(|(kind, count)| (kind, json!(count))).collect();
    json!({
        "file": file(model),
        "used": count(Taken::Used),
        "approximated": count(Taken::Approximated),
        "ignored": count(Taken::Ignored),
        "ignored_kinds": kinds,
    })
}
