//! `precision`: what every integrator costs for the error it makes.

mod plot;

use super::number::exact;
use super::output::{self, Interrupt, Progress};
use super::{Common, Exit, run, scene, text};
use crate::integrate::Method;
use crate::simulate::precision::{Plan, Point, Setting, Study, precision};
use crate::whole_file::WholeFile;
use anyhow::Context;
use clap::Args;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Beginning of the names of the files written, PREFIX.precision.csv and .svg; default: the scenario's name
    #[arg(long, short = 'o', value_name = "PREFIX")]
    out: Option<PathBuf>,
    /// Recommend a method for this error
    #[arg(long, value_name = "ERROR", default_value_t = 1e-6, allow_negative_numbers = true, value_parser = positive)]
    error: f64,
    /// Give up a run after this many seconds; more show smaller errors of the slow methods
    #[arg(long, value_name = "SECONDS", default_value_t = 0.5, allow_negative_numbers = true, value_parser = positive)]
    limit: f64,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number < 1e9 => Ok(number),
        _ => Err("allowed is a number above 0 and below 1e9".to_owned()),
    }
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let (mut scenario, mut model) = match scene::load(common)? {
        Ok(loaded) => loaded,
        Err(exit) => return Ok(exit),
    };
    let interrupt = Interrupt::install()?;
    if !common.json && !common.quiet {
        output::print(&text::heading(&model, &scenario.name))?;
    }
    let Some((start, found)) = run::start(common, &mut scenario, &mut model, false)? else { return Ok(Exit::No) };
    let plan = Plan::new(&model, scenario.simulate.duration, Duration::from_secs_f64(arguments.limit));
    let outcome = {
        let mut progress = Progress::new(1.0, common.quiet || common.json);
        precision(&model, &start, &plan, &mut |part| {
            progress.part(part);
            !interrupt.requested()
        })
    };
    let study = match outcome {
        Ok(Some(study)) => study,
        Ok(None) => {
            output::warning("stopped before there was a reference to compare with; nothing was written");
            return Ok(Exit::Interrupted);
        }
        Err(error) => {
            output::error(&anyhow::Error::new(error).context("there is no reference to compare with"));
            return Ok(Exit::No);
        }
    };
    let [csv, svg] = ["csv", "svg"].map(|kind| path(arguments.out.as_deref(), &common.scenario, kind));
    write_csv(&study, &csv).with_context(|| format!("cannot write `{}`", csv.display()))?;
    let title = if model.title.is_empty() { &scenario.name } else { &model.title };
    let drawn = plot::draw(&study, title)?;
    if let Some(picture) = &drawn {
        output::save(&svg, picture.as_bytes())?;
    }
    if common.json {
        output::print(&to_json(&study, &scenario.name, found, arguments.error).to_string())?;
    } else if !common.quiet {
        let plot = drawn.map(|_| svg.display().to_string());
        output::print(&to_text(&study, arguments.error, &csv.display().to_string(), plot.as_deref()))?;
    }
    let measured = study.points.iter().any(|point| point.outcome.is_ok());
    Ok(match (study.interrupted, measured) {
        (true, _) => Exit::Interrupted,
        (false, true) => Exit::Done,
        (false, false) => Exit::No,
    })
}

/// `scenarios/arm.toml` → `arm.precision.csv`.
fn path(out: Option<&Path>, scenario: &Path, kind: &str) -> PathBuf {
    let stem = scenario.file_stem().filter(|stem| *stem != "-").unwrap_or("scenario".as_ref());
    let mut name = out.map_or(stem, Path::as_os_str).to_owned();
    name.push(format!(".precision.{kind}"));
    name.into()
}

/// The tolerance and the step of a point; it has one of them.
fn setting(point: &Point) -> (Option<f64>, Option<f64>) {
    match point.setting {
        Setting::Tolerance(tolerance) => (Some(tolerance), None),
        Setting::Step(step) => (None, Some(step)),
    }
}

fn write_csv(study: &Study, path: &Path) -> anyhow::Result<()> {
    let mut csv = csv::Writer::from_writer(WholeFile::create(path)?);
    csv.write_record([
        "integrator",
        "tolerance",
        "step",
        "error",
        "energy_error",
        "wall_seconds",
        "steps",
        "rejected_steps",
        "acceleration_evaluations",
        "residual_evaluations",
        "jacobian_evaluations",
        "failed",
    ])?;
    for point in &study.points {
        let (tolerance, step) = setting(point);
        let (errors, counters) = (point.outcome.as_ref().ok(), &point.statistics);
        let number = |x: Option<f64>| x.map_or(String::new(), exact);
        csv.write_record([
            point.method.name().to_owned(),
            number(tolerance),
            number(step),
            number(errors.map(|errors| errors.state)),
            number(errors.map(|errors| errors.energy)),
            number(errors.map(|_| point.wall.as_secs_f64())),
            counters.steps.to_string(),
            counters.rejected_steps.to_string(),
            counters.acceleration_evaluations.to_string(),
            counters.residual_evaluations.to_string(),
            counters.jacobian_evaluations.to_string(),
            point.outcome.as_ref().err().cloned().unwrap_or_default(),
        ])?;
    }
    Ok(output::whole(csv)?.finish()?)
}

fn point_json(point: &Point) -> Value {
    let (tolerance, step) = setting(point);
    let (errors, counters) = (point.outcome.as_ref().ok(), &point.statistics);
    let mut value = json!({
        "integrator": point.method.name(),
        "error": errors.map(|errors| errors.state),
        "energy_error": errors.map(|errors| errors.energy),
        "wall_seconds": errors.map(|_| point.wall.as_secs_f64()),
        "steps": counters.steps,
        "rejected_steps": counters.rejected_steps,
        "acceleration_evaluations": counters.acceleration_evaluations,
        "residual_evaluations": counters.residual_evaluations,
        "jacobian_evaluations": counters.jacobian_evaluations,
        "failed": point.outcome.is_err(),
        "why": point.outcome.as_ref().err(),
    });
    match step {
        Some(step) => value["step"] = json!(step),
        None => value["tolerance"] = json!(tolerance),
    }
    value
}

fn to_json(study: &Study, scenario: &str, start: Value, wanted: f64) -> Value {
    let [reference, second] = study.references.map(Method::name);
    json!({
        "scenario": scenario,
        "start": start,
        "reference": { "method": reference, "tolerance": study.tolerance },
        "second_reference": {
            "method": second, "tolerance": study.tolerance, "for": reference,
            "difference": study.agreement.state, "energy_difference": study.agreement.energy,
        },
        "points": study.points.iter().map(point_json).collect::<Vec<_>>(),
        "wanted_error": wanted,
        "recommended": study.recommend(wanted).map(point_json),
        "interrupted": study.interrupted,
    })
}

fn to_text(study: &Study, wanted: f64, csv: &str, svg: Option<&str>) -> String {
    let [reference, second] = study.references.map(Method::name);
    let mut out = format!(
        "  reference    {reference} at {:.0e}; for {reference} itself {second} at {:.0e}; they differ by {} (energy {} J)\n",
        study.tolerance,
        study.tolerance,
        text::small(study.agreement.state),
        text::small(study.agreement.energy)
    );
    if study.agreement.state > wanted {
        let _ = writeln!(out, "               smaller errors than that cannot be told: shorten the run to see more");
    }
    let _ = writeln!(
        out,
        "\n  {:<17} {:>16}  {:>8} {:>10}  {:>9} {:>8} {:>12} {:>11}",
        "method", "tolerance / step", "error", "energy (J)", "time", "steps", "evaluations", "factorized"
    );
    for point in &study.points {
        let _ = writeln!(out, "  {}", row(point));
    }
    let advice = match study.recommend(wanted) {
        Some(point) => format!(
            "{} with {} is the fastest with an error of at most {wanted:.0e}: {}",
            point.method.name(),
            point.setting,
            text::duration(point.wall)
        ),
        None => format!("no point has an error of at most {wanted:.0e}"),
    };
    let _ = writeln!(out, "\n  recommended  {advice}");
    if study.interrupted {
        let _ = writeln!(out, "  interrupted  the table ends where it was stopped");
    }
    let _ = write!(out, "  written      {csv}{}", svg.map_or(String::new(), |svg| format!(", {svg}")));
    out
}

fn row(point: &Point) -> String {
    let setting = match point.setting {
        Setting::Tolerance(tolerance) => format!("{tolerance:.0e}"),
        Setting::Step(step) => format!("{} s", text::number(step)),
    };
    let begin = format!("{:<17} {setting:>16}", point.method.name());
    match &point.outcome {
        Err(why) => format!("{begin}  {why}"),
        Ok(errors) => {
            let counters = &point.statistics;
            format!(
                "{begin}  {:>8} {:>10}  {:>9} {:>8} {:>12} {:>11}",
                text::small(errors.state),
                text::small(errors.energy),
                text::duration(point.wall),
                counters.steps,
                counters.acceleration_evaluations + counters.residual_evaluations,
                counters.jacobian_evaluations
            )
        }
    }
}
