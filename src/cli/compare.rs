//! `statics --compare`: every method from the same guess, side by side.

use super::output::{self, bold};
use super::{Common, Exit, statics, text};
use crate::model::Model;
use crate::scenario::Scenario;
use crate::statics::{Equilibrium, Method, Settings, equilibrium_observed};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
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

pub(super) fn main(scenario: &Scenario, model: &Model, common: &Common, out: Option<&Path>) -> anyhow::Result<Exit> {
    let mut rows: Vec<Row> = Vec::new();
    for method in Method::ALL {
        let mut row = measured(model, &Settings { method, ..scenario.statics });
        row.distance = match (&rows.first().unwrap_or(&row).found, &row.found) {
            (Ok(reference), Ok(found)) if reference.converged && found.balanced => Some(apart(reference, found)),
            _ => None,
        };
        rows.push(row);
    }
    let table = json!({ "scenario": scenario.name, "methods": rows.iter().map(Row::json).collect::<Vec<_>>() });
    if let Some(prefix) = out {
        let with = |ending: &str| {
            let mut name = prefix.as_os_str().to_owned();
            name.push(ending);
            PathBuf::from(name)
        };
        statics::write(&with(".csv"), &csv(&rows))?;
        statics::write(&with(".json"), &format!("{table:#}\n"))?;
    }
    if common.json {
        output::print(&table.to_string())?;
    } else if !common.quiet {
        output::print(&text::heading(model, &scenario.name))?;
        output::print(&report(&rows))?;
    }
    let cascade = rows.first().and_then(|row| row.found.as_ref().ok());
    Ok(if cascade.is_some_and(|found| found.converged) { Exit::Done } else { Exit::No })
}

/// One method: its answer, and the time of its search.
fn measured(model: &Model, settings: &Settings) -> Row {
    let (begin, mut best) = (Instant::now(), Duration::MAX);
    let mut run = || {
        let before = Instant::now();
        let mut searched = || best = best.min(before.elapsed());
        equilibrium_observed(model, settings, &model.start_position, &mut searched)
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

/// One line per method; a number that does not exist is empty.
fn csv(rows: &[Row]) -> String {
    let mut out = format!("{}\n", COLUMNS.join(","));
    for row in rows {
        let values = row.json();
        let field = |name: &&str| match &values[*name] {
            Value::Null => String::new(),
            Value::String(text) => format!("\"{}\"", text.replace('"', "\"\"")),
            other => other.to_string(),
        };
        let _ = writeln!(out, "{}", COLUMNS.iter().map(field).collect::<Vec<_>>().join(","));
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
