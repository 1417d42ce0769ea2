//! `study --fit`: numbers of a scene that bring it closest to measurements, with their confidence.

use super::super::inputs::Inputs;
use super::super::output::{self, Interrupt};
use super::super::text::{count, number, small};
use super::super::{Exit, number::exact};
use super::Arguments;
use crate::scenario::{LoadError, Override, load_with};
use crate::study::fit::table::MeasuredTable;
use crate::study::fit::{Adjusted, Fit, FitQuestion, Fitted, Trouble, deviation, fit};
use crate::text_file;
use anyhow::{anyhow, bail};
use clap::Args;
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// What is asked of a fit.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Fit numbers of the scenario to this table: columns named after outputs (or coordinates, `frequencies_hz[0]`) were measured,
    /// those named by addresses were set
    #[arg(long, value_name = "DATA.csv", requires = "parameter")]
    pub(super) fit: Option<PathBuf>,
    /// A number that is fitted, as `spring.length`; with where to begin and within which range, as `spring.length=0.5,0.1..1`;
    /// may be repeated
    #[arg(long, value_name = "ADDRESS[=START,LOW..HIGH]", requires = "fit", num_args = 1.., value_parser = Adjusted::parse)]
    parameter: Vec<Adjusted>,
    /// What was measured is a run: at the times of the column `time`
    #[arg(long, requires = "fit")]
    run: bool,
    /// Standard deviation of a measured column; columns without one count by the spread of their numbers
    #[arg(long, value_name = "COLUMN=VALUE", requires = "fit", value_parser = deviation)]
    deviation: Vec<(String, f64)>,
    /// Leave this column of the table out; may be repeated
    #[arg(long, value_name = "COLUMN", requires = "fit")]
    ignore: Vec<String>,
    /// Probability of the intervals
    #[arg(long, value_name = "P", default_value_t = 0.95, requires = "fit")]
    confidence: f64,
    /// With `--fit`: change a value of the scenario, as `simulate.duration=2`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE", requires = "fit")]
    set: Vec<String>,
    /// Write the table there, with what the fitted scene answers beside what was measured
    #[arg(long, short = 'o', value_name = "FILE.csv", requires = "fit")]
    out: Option<PathBuf>,
}

pub(super) fn main(arguments: &Arguments, data: &Path) -> anyhow::Result<Exit> {
    let options = &arguments.fit;
    let set = options.set.iter().map(|text| Override::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let scenario = match load_with(&arguments.studied, &set) {
        Ok(scenario) => scenario,
        Err(LoadError::Problems(problems)) => return Ok(refused(&problems)),
        Err(other) => return Err(other.into()),
    };
    if !arguments.quiet && !scenario.warnings.is_empty() {
        output::note(scenario.warnings.render(output::errors_in_color()).trim_end());
    }
    if let Some(out) = &options.out {
        let read = Inputs::files(&scenario).chain([arguments.studied.clone(), data.to_owned()]);
        Inputs::new(read.collect::<Vec<_>>().iter().map(PathBuf::as_path)).spare(out)?;
    }
    let table = read(data)?;
    let question = FitQuestion {
        parameters: options.parameter.clone(),
        run: options.run,
        deviations: options.deviation.clone(),
        ignored: options.ignore.clone(),
        level: options.confidence,
    };
    let interrupt = Interrupt::install()?;
    let found = match fit(&scenario, &set, &table, &question, &|| !interrupt.requested()) {
        Ok(found) => found,
        Err(Trouble::Interrupted) => {
            output::warning("interrupted: there is no fit");
            return Ok(Exit::Interrupted);
        }
        Err(Trouble::Problems(problems)) => return Ok(refused(&problems)),
        Err(Trouble::Data(why)) => bail!("{}: {why}", data.display()),
        Err(Trouble::Wrong(why)) => bail!("{why}"),
    };
    if let Some(out) = &options.out {
        output::save(out, beside(&table, &found)?.as_bytes())?;
    }
    if arguments.json {
        let mut answer = json(&found);
        answer["scenario"] = scenario.name.as_str().into();
        answer["data"] = data.display().to_string().into();
        answer["confidence"] = options.confidence.into();
        output::print(&answer.to_string())?;
    } else if !arguments.quiet {
        output::print(&text(&found, &table, data, options.confidence))?;
    }
    Ok(if found.converged { Exit::Done } else { Exit::No })
}

fn refused(problems: &crate::scenario::Diagnostics) -> Exit {
    output::note(problems.render(output::errors_in_color()).trim_end());
    Exit::Wrong
}

/// A measured table: a line of headings, then numbers; `#` begins a comment.
fn read(path: &Path) -> anyhow::Result<MeasuredTable> {
    let text = text_file::read(path, "table of measurements")?;
    let context = |why: String| anyhow!("{}: {why}", path.display());
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let headings: Vec<String> =
        reader.headers().map_err(|why| context(why.to_string()))?.iter().map(str::to_owned).collect();
    let mut columns: Vec<(String, Vec<f64>)> = headings.into_iter().map(|name| (name, Vec::new())).collect();
    for record in reader.records() {
        let record = record.map_err(|why| context(why.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        for ((name, values), cell) in columns.iter_mut().zip(&record) {
            values.push(match cell {
                "" => f64::NAN,
                cell => cell.parse().map_err(|_| context(format!("line {line}: `{cell}` in `{name}` is no number")))?,
            });
        }
    }
    MeasuredTable::new(columns).map_err(context)
}

/// The table in SI units, with a column `fitted NAME` beside each one that was measured.
fn beside(table: &MeasuredTable, fit: &Fit) -> anyhow::Result<String> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    let measured = |name: &str| fit.columns.iter().find(|column| column.name == name);
    let headings = table.columns.iter().flat_map(|column| {
        let fitted = measured(&column.name).map(|_| format!("fitted {}", column.name));
        [column.name.clone()].into_iter().chain(fitted)
    });
    rows.write_record(headings)?;
    let cell = |x: f64| if x.is_nan() { String::new() } else { exact(x) };
    for row in 0..table.rows() {
        let cells = table.columns.iter().flat_map(|column| {
            let fitted =
                measured(&column.name).map(|fitted| fitted.left[row].map_or(f64::NAN, |x| x + column.values[row]));
            [column.values[row]].into_iter().chain(fitted).map(cell)
        });
        rows.write_record(cells)?;
    }
    Ok(String::from_utf8(rows.into_inner()?)?)
}

/// A number; `null` of one that is not finite.
fn finite(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { Value::Null }
}

/// What `--json` prints, without scenario and data.
pub(in crate::cli) fn json(fit: &Fit) -> Value {
    let parameter = |one: &Fitted| {
        json!({
            "address": one.address, "unit": one.unit, "start": one.start, "value": one.value,
            "standard_error": one.error, "interval": one.interval, "held": one.is_held, "runs_off": one.runs_off,
        })
    };
    let column = |one: &crate::study::fit::ColumnFit| {
        json!({
            "name": one.name, "unit": one.unit, "count": one.count, "rms": one.rms, "deviation": one.deviation,
            "residuals": one.left,
        })
    };
    let count = fit.parameters.len();
    let matrix = |of: &dyn Fn(usize, usize) -> Value| -> Vec<Vec<Value>> {
        (0..count).map(|i| (0..count).map(|j| of(i, j)).collect()).collect()
    };
    let together = |direction: &Vec<(String, f64)>| -> Map<String, Value> {
        direction.iter().map(|(address, part)| (address.clone(), json!(part))).collect()
    };
    json!({
        "converged": fit.converged, "steps": fit.steps, "evaluations": fit.evaluations,
        "parameters": fit.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "columns": fit.columns.iter().map(column).collect::<Vec<_>>(),
        "covariance": matrix(&|i, j| finite(fit.covariance[i][j])),
        "correlations": matrix(&|i, j| json!(fit.correlation(i, j))),
        "degrees_of_freedom": fit.freedom,
        "not_determined": fit.unfelt, "only_together": fit.together.iter().map(together).collect::<Vec<_>>(),
        "by_differences": fit.by_differences, "notes": fit.notes,
        "set": fit.parameters.iter().map(set).collect::<Vec<_>>(),
    })
}

/// As it is written after `--set`.
fn set(one: &Fitted) -> String {
    format!("{}={}", one.address, exact(one.value))
}

fn text(fit: &Fit, table: &MeasuredTable, data: &Path, level: f64) -> String {
    let names: Vec<String> = fit.columns.iter().map(|column| format!("`{}`", column.name)).collect();
    let measurements: usize = fit.columns.iter().map(|column| column.count).sum();
    let mut out = format!(
        "{}: {} of {} in {}, {}\n",
        data.display(),
        count(measurements, "measurement", "measurements"),
        names.join(", "),
        count(table.rows(), "row", "rows"),
        match fit.converged {
            true => format!("least squares after {}", count(fit.steps, "step", "steps")),
            false => format!("NOT converged after {}", count(fit.steps, "step", "steps")),
        }
    );
    let width = fit.parameters.iter().map(|one| one.address.chars().count()).max().unwrap_or(0).max(9);
    let mut row = |[name, value, half, start, unit]: [&str; 5]| {
        let line = format!("  {name:width$}  {value:<12} {half:<14} {start:<12} {unit}");
        let _ = writeln!(out, "{}", line.trim_end());
    };
    row(["parameter", "value", &format!("± {} %", small(100.0 * level)), "start", ""]);
    for one in &fit.parameters {
        let half = match (one.is_held, one.interval) {
            _ if one.runs_off => "runs off".to_owned(),
            (true, _) => "at its bound".to_owned(),
            (false, Some(interval)) => format!("± {}", small(0.5 * (interval[1] - interval[0]))),
            (false, None) => "not determined".to_owned(),
        };
        row([&one.address, &number(one.value), &half, &number(one.start), one.unit]);
    }
    for column in &fit.columns {
        let unit = if column.unit == "1" { "" } else { &column.unit };
        let _ = writeln!(out, "  residual     {} {unit} rms of `{}`", number(column.rms), column.name);
    }
    for note in &fit.notes {
        let _ = writeln!(out, "  note         {note}");
    }
    for one in &fit.parameters {
        let _ = writeln!(out, "  --set {}", set(one));
    }
    out.truncate(out.trim_end().len());
    out
}
