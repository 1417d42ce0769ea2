//! `sweep`: the same question for many values of some numbers, one row per case.

pub(super) mod grid;

use super::inputs::Inputs;
use super::output::{self, Progress};
use super::text::{count, number};
use super::{Common, Exit, statics};
use crate::constraint;
use crate::model::Model;
use crate::record::Fanout;
use crate::scenario::{Diagnostics, LoadError, Override, Scenario, load_with, parse};
use crate::simulate::{self, Start, State};
use crate::statics::Equilibrium;
use crate::whole_file::WholeFile;
use anyhow::{Context, anyhow, bail};
use clap::Args;
use grid::{Axis, OPTION};
use serde_json::{Map, Value, json};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// What is varied: `path=from:to:count`, or `path=1,2,5`; given several times, every combination
    #[arg(long, required = true, value_name = "PATH=VALUES", value_parser = Axis::parse)]
    over: Vec<Axis>,
    /// Simulate each case, too; without it the equilibrium is all that is asked
    #[arg(long)]
    run: bool,
    /// Cases that are worked on at once; default: one per processor. The answers do not depend on it
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Write the rows there
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
}

/// Rows that are printed; `--json` and `--out` have all.
const MOST_LINES: usize = 40;

/// Numbers and words by name.
type Found = Vec<(String, Value)>;

/// What became of one case.
type Row = Result<Found, Failed>;

enum Failed {
    /// The values make no scene.
    Refused(Diagnostics),
    /// The answer is no.
    No(String),
}

impl Failed {
    /// One line.
    fn text(&self) -> String {
        match self {
            Self::Refused(problems) => problems.iter().next().map_or(String::new(), |first| first.message.clone()),
            Self::No(text) => text.clone(),
        }
    }
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let set: Vec<Override> = common.set.iter().map(|text| Override::parse(text)).collect::<Result<_, _>>()?;
    // The file is read once: it may be standard input.
    let scenario = match load_with(&common.scenario, &set) {
        Ok(scenario) => scenario,
        Err(LoadError::Problems(problems)) => {
            output::note(problems.render(output::errors_in_color()).trim_end());
            return Ok(Exit::Wrong);
        }
        Err(other) => return Err(other.into()),
    };
    if !common.quiet && !scenario.warnings.is_empty() {
        output::note(scenario.warnings.render(output::errors_in_color()).trim_end());
    }
    refuse_unheeded(arguments, &scenario, &set)?;
    let cases = grid::cases(&arguments.over).map_err(|error| anyhow!(error))?;
    // What cannot be written is told before the work.
    let table = arguments.out.as_ref().map(|path| {
        Inputs::of_scenario(common, &scenario, None).spare(path)?;
        WholeFile::create(path).with_context(|| format!("cannot write `{}`", path.display()))
    });
    let table = table.transpose()?;
    let sweep = Sweep { arguments, scenario: &scenario, set };
    let rows = sweep.all(&cases)?;
    // A name that is not there is no answer, it is a wrong call.
    if let Some(Err(Failed::Refused(problems))) = rows.first()
        && rows.iter().all(|row| matches!(row, Err(Failed::Refused(_))))
    {
        output::note(problems.render(output::errors_in_color()).trim_end());
        return Ok(Exit::Wrong);
    }
    let failed = rows.iter().filter(|row| row.is_err()).count();
    if let Some((path, table)) = arguments.out.as_ref().zip(table) {
        sweep.write(table, &cases, &rows).with_context(|| format!("cannot write `{}`", path.display()))?;
    }
    if common.json {
        let list: Vec<Value> = cases.iter().zip(&rows).map(|(case, row)| sweep.json(case, row)).collect();
        let answer = json!({ "scenario": scenario.name, "cases": list, "failed": failed });
        output::print(&answer.to_string())?;
    } else if !common.quiet {
        output::print(&sweep.report(&cases, &rows, failed))?;
    }
    Ok(if failed == 0 { Exit::Done } else { Exit::No })
}

/// Refuses what would be asked for in vain.
fn refuse_unheeded(arguments: &Arguments, scenario: &Scenario, set: &[Override]) -> anyhow::Result<()> {
    if scenario.path.is_some() {
        bail!(
            "{}: `sweep` does not follow `[statics.path]`: `statics` does; or leave it out, and vary its parameter with `{OPTION}`",
            scenario.name
        );
    }
    // The keys of a hinge may be written without `hinge.`.
    let short = |path: &str| path.replacen(".hinge.", ".", 1);
    let from_start = scenario.simulate.start == Start::Equilibrium;
    for (index, axis) in arguments.over.iter().enumerate() {
        let is_same = |other: &str| short(other) == short(&axis.path);
        if arguments.over[..index].iter().any(|other| is_same(&other.path)) {
            bail!("`{OPTION}` varies `{}` twice: write all of its values into one", axis.path);
        }
        if set.iter().any(|other| is_same(other.path())) {
            bail!("`{}` is set and varied at once: leave out `--set` or `{OPTION}`", axis.path);
        }
        let why = match axis.path.split(['.', '[']).next().unwrap_or_default() {
            "record" => "a sweep records nothing",
            "title" => "nothing depends on it",
            "simulate" if !arguments.run => "only `--run` simulates the cases",
            "statics" if arguments.run && !from_start => "the runs start as given, without statics",
            _ => continue,
        };
        bail!("`{OPTION} {}=…` changes nothing: {why}", axis.path);
    }
    Ok(())
}

struct Sweep<'a> {
    arguments: &'a Arguments,
    scenario: &'a Scenario,
    set: Vec<Override>,
}

impl Sweep<'_> {
    /// Every case, by as many threads as asked for: each for itself, so that none sees what another one did.
    fn all(&self, cases: &[Vec<&str>]) -> anyhow::Result<Vec<Row>> {
        let available = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let threads = self.arguments.threads.map_or(available, NonZeroUsize::get).min(cases.len());
        let quiet = self.arguments.common.quiet || self.arguments.common.json;
        let (next, progress) = (AtomicUsize::new(0), Mutex::new(Progress::new(1.0, quiet)));
        let work = || {
            let mut done = Vec::new();
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(case) = cases.get(index) else { return done };
                done.push((index, self.one(case)));
                if let Ok(mut progress) = progress.lock() {
                    progress.part(index as f64 / cases.len() as f64);
                }
            }
        };
        let done = std::thread::scope(|scope| {
            // As many as the system gives, and this one if it gives none.
            let spawn = |_| std::thread::Builder::new().spawn_scoped(scope, work).ok();
            let workers: Vec<_> = (0..threads).map_while(spawn).collect();
            let here = if workers.is_empty() { Some(Ok(work())) } else { None };
            workers.into_iter().map(std::thread::ScopedJoinHandle::join).chain(here).collect::<Vec<_>>()
        });
        let mut rows = Vec::new();
        for one in done {
            rows.extend(one.map_err(|_| anyhow!("a case ended in a panic"))?);
        }
        rows.sort_by_key(|(index, _)| *index);
        rows.into_iter().map(|(_, row)| row).collect()
    }

    /// One case; an error where the call itself is wrong.
    fn one(&self, case: &[&str]) -> anyhow::Result<Row> {
        let mut changes = self.set.clone();
        for (axis, value) in self.arguments.over.iter().zip(case) {
            changes.push(Override::of_option(OPTION, &format!("{}={value}", axis.path))?);
        }
        let mut scenario = match parse(&self.scenario.name, &self.scenario.text, &changes) {
            Ok(scenario) => scenario,
            Err(problems) => return Ok(Err(Failed::Refused(problems))),
        };
        Ok(answer(&mut scenario, self.arguments.run).map_err(Failed::No))
    }

    fn json(&self, case: &[&str], row: &Row) -> Value {
        let values: Map<String, Value> = self
            .arguments
            .over
            .iter()
            .zip(case)
            .map(|(axis, value)| {
                (axis.path.clone(), value.parse::<f64>().map_or_else(|_| json!(value), |number| json!(number)))
            })
            .collect();
        match row {
            Ok(found) => {
                json!({ "values": values, "ok": true, "result": found.iter().cloned().collect::<Map<_, _>>() })
            }
            Err(why) => json!({ "values": values, "ok": false, "error": why.text() }),
        }
    }

    /// Names of what any case has found, in the order of their first appearance.
    fn columns(rows: &[Row]) -> Vec<&str> {
        let mut seen = std::collections::HashSet::new();
        let names = rows.iter().flatten().flat_map(|found| found.iter().map(|(name, _)| name.as_str()));
        names.filter(|name| seen.insert(*name)).collect()
    }

    fn write(&self, table: WholeFile, cases: &[Vec<&str>], rows: &[Row]) -> anyhow::Result<()> {
        let columns = Self::columns(rows);
        let mut csv = csv::Writer::from_writer(table);
        let head = self.arguments.over.iter().map(|axis| axis.path.as_str()).chain(["ok"]);
        csv.write_record(head.chain(columns.iter().copied()).chain(["error"]))?;
        for (case, row) in cases.iter().zip(rows) {
            let cell = |name: &&str| match row
                .as_ref()
                .ok()
                .and_then(|found| found.iter().find(|(known, _)| known == name))
                .map(|(_, value)| value)
            {
                None | Some(Value::Null) => String::new(),
                Some(Value::String(text)) => text.clone(),
                Some(other) => other.to_string(),
            };
            let error = row.as_ref().err().map_or(String::new(), Failed::text);
            let before = case.iter().map(|value| (*value).to_owned()).chain([row.is_ok().to_string()]);
            csv.write_record(before.chain(columns.iter().map(cell)).chain([error]))?;
        }
        Ok(output::whole(csv)?.finish()?)
    }

    fn report(&self, cases: &[Vec<&str>], rows: &[Row], failed: usize) -> String {
        let mut out = String::new();
        for (case, row) in cases.iter().zip(rows).take(MOST_LINES) {
            let named = self.arguments.over.iter().zip(case).map(|(axis, value)| format!("{} = {value}", axis.path));
            let said = match row {
                Err(why) => format!("failed: {}", why.text()),
                Ok(found) => {
                    let shown = |(name, value): &(String, Value)| match value {
                        Value::Number(x) => format!("{name} {}", number(x.as_f64().unwrap_or(f64::NAN))),
                        Value::String(text) => text.clone(),
                        _ => String::new(),
                    };
                    found.iter().filter(|(_, value)| !value.is_null()).take(5).map(shown).collect::<Vec<_>>().join(", ")
                }
            };
            out += &format!("{:<40} {said}\n", named.collect::<Vec<_>>().join(", "));
        }
        if cases.len() > MOST_LINES {
            out += &format!("… and {} more (`--out` and `--json` have all)\n", cases.len() - MOST_LINES);
        }
        let cases = count(cases.len(), "case", "cases");
        out + &if failed == 0 { cases } else { format!("{failed} of {cases} failed") }
    }
}

/// Equilibrium and, if it is asked for, run of one case.
fn answer(scenario: &mut Scenario, with_run: bool) -> Result<Found, String> {
    let model = Model::build(&scenario.description).map_err(listed)?;
    let (mut model, _) = constraint::assemble(model).map_err(listed)?;
    let mut row = Found::new();
    let mut start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    if !with_run || scenario.simulate.start == Start::Equilibrium {
        let (found, _) = statics::find(scenario, &mut model).map_err(|error| format!("{error:#}"))?;
        if !found.converged {
            let why = found.notes.first().map(|note| format!(": {note}"));
            return Err(format!("no equilibrium found{}", why.unwrap_or_default()));
        }
        insert_statics(&model, &found, &mut row);
        start = State { position: found.position, velocity: found.velocity };
    }
    if with_run {
        let mut nobody = Fanout::new();
        let (settings, rate) = (&scenario.simulate, scenario.record.rate);
        let end = simulate::run(&model, settings, rate, &start, &mut nobody, &mut |_, _| true)
            .map_err(|error| error.to_string())?;
        row.push(("end_time".into(), json!(end.end_time)));
        row.push(("steps".into(), json!(end.statistics.steps)));
        row.push(("energy_drift".into(), json!(end.energy_drift)));
        insert_positions(&model, "final ", &end.state.position, &mut row);
    }
    Ok(row)
}

/// What statics found, the inputs that were unknown first.
fn insert_statics(model: &Model, found: &Equilibrium, row: &mut Found) {
    row.extend(found.unknowns.iter().map(|(address, value)| (address.clone(), json!(value))));
    let stability = found.stability.as_ref();
    let frequency =
        stability.and_then(|s| s.modes.iter().find(|mode| mode.growth_rate == 0.0)).map(|mode| mode.frequency_hz);
    row.push(("stability".into(), json!(stability.map(|s| s.verdict.name()))));
    row.push(("frequency_hz".into(), json!(frequency)));
    insert_positions(model, "", &found.position, row);
    row.push(("residual_force".into(), json!(found.residual_force)));
    row.push(("iterations".into(), json!(found.iterations)));
}

fn listed(problems: Vec<crate::model::Problem>) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

fn insert_positions(model: &Model, before: &str, position: &[f64], row: &mut Found) {
    for body in &model.bodies {
        for (index, (name, _)) in body.hinge.kind.positions().iter().enumerate() {
            row.push((format!("{before}{}.{name}", body.name), json!(position[body.hinge.position + index])));
        }
    }
}
