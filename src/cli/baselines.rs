//! `statics --compare`: every method from the same guess, side by side; `--over`: for several values of a number.

mod plot;

use super::output::{self, bold};
use super::{Common, Exit, scene, text};
use crate::model::Model;
use crate::scenario::{Override, Scenario};
use crate::statics::{Equilibrium, Method, Observers, Settings, equilibrium_observed};
use crate::study::axis::{Axis, OPTION};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The time is that of the best of this many runs, and of as many as fit into [`PATIENCE`].
const MOST_RUNS: usize = 10;
const PATIENCE: Duration = Duration::from_millis(500);

/// What one method did.
struct Row {
    method: Method,
    /// The answer, or why there is none.
    found: Result<Equilibrium, String>,
    /// Best time of the search, without the certificate that all answers get alike.
    search: Duration,
    /// Largest distance between root markers (m) and angle between bodies (rad), this answer against the cascade's.
    distance: Option<(f64, f64)>,
}

/// One scene.
struct Run {
    /// What was changed, as on the command line; empty for the scene as it stands.
    value: String,
    degrees_of_freedom: usize,
    rows: Vec<Row>,
}

/// There is one method for unknown inputs.
fn ensure_comparable(scenario: &Scenario) -> anyhow::Result<()> {
    anyhow::ensure!(scenario.unknown.is_empty(), "there is one method for `statics.unknown`: nothing to compare");
    Ok(())
}

pub(super) fn main(
    scenario: &Scenario,
    model: &Arc<Model>,
    common: &Common,
    out: Option<&Path>,
) -> anyhow::Result<Exit> {
    ensure_comparable(scenario)?;
    let run = run(String::new(), scenario, model);
    let table = json!({ "scenario": scenario.name, "methods": methods(&run.rows) });
    let title = title(scenario, model);
    if let Some(prefix) = out {
        write_all(prefix, &csv(std::slice::from_ref(&run)), &plot::residuals(&run.rows, title)?, &table)?;
    }
    if common.json {
        output::print(&table.to_string())?;
    } else if !common.quiet {
        output::print(&text::heading(model, &scenario.name))?;
        output::print(&report(&run.rows))?;
    }
    Ok(exit([&run]))
}

/// Compares the methods for several values of a number of the file.
pub(super) fn over(common: &Common, axis: &Axis, out: Option<&Path>) -> anyhow::Result<Exit> {
    let path = &axis.path;
    anyhow::ensure!(
        common.scenario != Path::new("-"),
        "`--over` reads its file again and again: standard input cannot"
    );
    let mut runs = Vec::new();
    let mut named = None;
    for value in &axis.values {
        let change = Override::of_option(OPTION, &format!("{path}={value}"))?;
        let (scenario, model) = match scene::load_changed(common, Some(change))? {
            Ok(loaded) => loaded,
            Err(exit) => return Ok(exit),
        };
        ensure_comparable(&scenario)?;
        let run = run(value.clone(), &scenario, &model);
        if !common.json && !common.quiet {
            output::print(&format!("{path} = {value}\n{}", text::heading(&model, &scenario.name)))?;
            output::print(&report(&run.rows))?;
        }
        runs.push(run);
        named.get_or_insert_with(|| (scenario.name.clone(), title(&scenario, &model).to_owned()));
    }
    let (name, title) = named.unwrap_or_default();
    let of_run = |run: &Run| json!({ "value": run.value, "degrees_of_freedom": run.degrees_of_freedom, "methods": methods(&run.rows) });
    let table = json!({ "scenario": name, "over": path, "runs": runs.iter().map(of_run).collect::<Vec<_>>() });
    if let Some(prefix) = out {
        write_all(prefix, &csv(&runs), &plot::times(&runs, &title)?, &table)?;
    }
    if common.json {
        output::print(&table.to_string())?;
    }
    Ok(exit(&runs))
}

fn title<'t>(scenario: &'t Scenario, model: &'t Model) -> &'t str {
    if model.title.is_empty() { &scenario.name } else { &model.title }
}

fn methods(rows: &[Row]) -> Vec<Value> {
    rows.iter().map(Row::json).collect()
}

/// Every method on one scene.
fn run(value: String, scenario: &Scenario, model: &Arc<Model>) -> Run {
    let mut rows: Vec<Row> = Vec::new();
    for method in Method::ALL {
        let mut row = measured(model, &Settings { method, ..scenario.statics });
        row.distance = match (&rows.first().unwrap_or(&row).found, &row.found) {
            (Ok(reference), Ok(found)) if reference.converged && found.balanced => Some(apart(reference, found)),
            _ => None,
        };
        rows.push(row);
    }
    Run { value, degrees_of_freedom: model.velocity_count(), rows }
}

/// What `--out` gets.
const ENDINGS: [&str; 3] = [".csv", ".svg", ".json"];

fn write_all(prefix: &Path, csv: &str, svg: &str, table: &Value) -> anyhow::Result<()> {
    // `table.svg` stands for `table` as well.
    let named = |ending: &str| prefix.extension().is_some_and(|given| given == &ending[1..]);
    let stem = if ENDINGS.into_iter().any(named) { prefix.with_extension("") } else { prefix.to_owned() };
    let with = |ending: &str| {
        let mut name = stem.as_os_str().to_owned();
        name.push(ending);
        PathBuf::from(name)
    };
    let [sheet, plot, all] = ENDINGS.map(with);
    output::save(&sheet, csv.as_bytes())?;
    output::save(&plot, svg.as_bytes())?;
    output::save(&all, format!("{table:#}\n").as_bytes())
}

/// The cascade has to find what was wanted, everywhere.
fn exit<'r>(runs: impl IntoIterator<Item = &'r Run>) -> Exit {
    let found = |run: &Run| run.rows.first().is_some_and(|row| row.found.as_ref().is_ok_and(|found| found.converged));
    if runs.into_iter().all(found) { Exit::Done } else { Exit::No }
}

/// One method: its answer, and the time of its search.
fn measured(model: &Arc<Model>, settings: &Settings) -> Row {
    let (begin, mut best) = (Instant::now(), Duration::MAX);
    let mut run = || {
        let before = Instant::now();
        let mut searched = || best = best.min(before.elapsed());
        let observers = Observers { searched: Some(&mut searched), ..Observers::default() };
        equilibrium_observed(model, settings, &model.start_position, observers)
    };
    let mut found = run();
    for _ in 1..MOST_RUNS {
        if found.is_err() || begin.elapsed() > PATIENCE {
            break;
        }
        found = run();
    }
    Row { method: settings.method, found: found.map_err(|error| error.to_string()), search: best, distance: None }
}

/// Largest distance and largest angle between the bodies of two answers.
fn apart(a: &Equilibrium, b: &Equilibrium) -> (f64, f64) {
    let mut largest = (0.0_f64, 0.0_f64);
    for (a, b) in a.poses.iter().zip(&b.poses) {
        largest.0 = largest.0.max((a.translation.vector - b.translation.vector).norm());
        largest.1 = largest.1.max(a.rotation.angle_to(&b.rotation));
    }
    largest
}

impl Row {
    /// `converged`, or what went wrong.
    fn outcome(&self) -> String {
        match &self.found {
            Err(reason) => reason.clone(),
            Ok(found) if found.converged => "converged".to_owned(),
            Ok(found) => format!("failed: {}", found.notes.join("; ")),
        }
    }

    fn stability(&self) -> Option<&'static str> {
        let found = self.found.as_ref().ok()?;
        found.stability.as_ref().map(|stability| stability.verdict.name())
    }

    fn json(&self) -> Value {
        let found = self.found.as_ref().ok();
        json!({
            "method": self.method.name(),
            "converged": found.is_some_and(|found| found.converged),
            "balanced": found.is_some_and(|found| found.balanced),
            "stage": found.map(|found| found.stage),
            "search_seconds": found.map(|_| self.search.as_secs_f64()),
            "iterations": found.map(|found| found.iterations),
            "force_evaluations": found.map(|found| found.force_evaluations),
            "acceleration_evaluations": found.map(|found| found.acceleration_evaluations),
            "stiffness_evaluations": found.map(|found| found.stiffness_evaluations),
            "factorizations": found.map(|found| found.factorizations),
            "relative_residual": found.map(|found| found.relative_residual),
            "residual_acceleration": found.map(|found| found.residual_acceleration),
            "stability": self.stability(),
            "distance_m": self.distance.map(|(distance, _)| distance),
            "angle_rad": self.distance.map(|(_, angle)| angle),
            "outcome": self.outcome(),
            "history": found.map_or(Vec::new(), |found| found.history.iter().map(|at| at.residual).collect()),
        })
    }
}

const COLUMNS: [&str; 14] = [
    "method",
    "converged",
    "stage",
    "search_seconds",
    "iterations",
    "force_evaluations",
    "acceleration_evaluations",
    "stiffness_evaluations",
    "factorizations",
    "relative_residual",
    "stability",
    "distance_m",
    "angle_rad",
    "outcome",
];

/// One line per method; a number that does not exist is empty. Of several scenes each with its value before.
fn csv(runs: &[Run]) -> String {
    let several = runs.iter().any(|run| !run.value.is_empty());
    let first = if several { "value,degrees_of_freedom," } else { "" };
    let mut out = format!("{first}{}\n", COLUMNS.join(","));
    for (run, row) in runs.iter().flat_map(|run| run.rows.iter().map(move |row| (run, row))) {
        let values = row.json();
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let field = |name: &&str| match &values[*name] {
            Value::Null => String::new(),
            Value::String(text) => quoted(text),
            other => other.to_string(),
        };
        let first = if several { format!("{},{},", quoted(&run.value), run.degrees_of_freedom) } else { String::new() };
        let _ = writeln!(out, "{first}{}", COLUMNS.iter().map(field).collect::<Vec<_>>().join(","));
    }
    out
}

/// The table for people.
fn report(rows: &[Row]) -> String {
    let head =
        ["method", "time", "iterations", "forces", "accelerations", "factorizations", "residual", "kind", "apart"];
    let widths = [11, 10, 11, 9, 14, 15, 9, 9, 0];
    let line = |cells: &[String]| {
        let padded = cells.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}"));
        format!("  {}\n", padded.collect::<String>().trim_end())
    };
    let mut out = format!("{}\n", bold("every method from the same guess"));
    out += &line(&head.map(str::to_owned));
    for row in rows {
        let Ok(found) = &row.found else {
            out += &line(&[row.method.name().to_owned(), "failed".to_owned()]);
            continue;
        };
        let apart = match row.distance {
            Some((distance, angle)) => format!("{} m, {} rad", text::small(distance), text::small(angle)),
            None => "-".to_owned(),
        };
        out += &line(&[
            row.method.name().to_owned(),
            text::duration(row.search),
            found.iterations.to_string(),
            found.force_evaluations.to_string(),
            found.acceleration_evaluations.to_string(),
            found.factorizations.to_string(),
            text::small(found.relative_residual),
            row.stability().unwrap_or(if found.balanced { "-" } else { "failed" }).to_owned(),
            apart,
        ]);
    }
    out += "  apart: the largest distance and angle of a body from where the first line has it";
    for row in rows.iter().filter(|row| !row.found.as_ref().is_ok_and(|found| found.converged)) {
        let _ = write!(out, "\n  {:<11}{}", row.method.name(), row.outcome());
    }
    out
}
