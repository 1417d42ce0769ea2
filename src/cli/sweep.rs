//! `sweep`: the same question for many values of some numbers, one row per case.

mod rows;
#[cfg(feature = "parquet")]
mod shard;

use super::inputs::Inputs;
use super::number::in_unit;
use super::output::{self, Interrupt, Progress};
use super::{Common, Exit};
use crate::scenario::{LoadError, Override, Scenario, load_with};
use crate::simulate::Start;
use crate::study::axis::{Axis, OPTION};
use crate::study::case::VARY;
#[cfg(feature = "parquet")]
use crate::study::dataset::Dataset;
use crate::study::plan::MOST_CASES;
use crate::study::{Cases, Draw, Plan, Question, Refusal, Row, Sampling, Variation, pool};
use crate::whole_file::WholeFile;
use anyhow::{Context, anyhow, bail};
use clap::Args;
use clap::builder::PossibleValuesParser;
use rows::Rows;
use serde_json::json;
#[cfg(feature = "parquet")]
use shard::Shard;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// What is varied: `path=from:to:count`, or `path=1,2,5`; given several times, every combination
    #[arg(long, value_name = "PATH=VALUES", value_parser = Axis::parse)]
    over: Vec<Axis>,
    /// What is drawn: normal(mean,deviation), lognormal(mean,deviation) of the number itself, uniform(low,high) or
    /// triangular(low,mode,high), in absolute values; may be repeated
    #[arg(long, value_name = "PATH=DISTRIBUTION", requires = "cases", value_parser = Variation::parse)]
    vary: Vec<Variation>,
    /// Correlations of what is drawn: a CSV file with a line of paths, and a line of numbers for each of them
    #[arg(long, value_name = "FILE.csv")]
    correlate: Option<PathBuf>,
    /// How to draw: independent samples, a Latin hypercube, or Sobol points
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(Sampling::ALL.map(Sampling::name)))]
    sample: Option<String>,
    /// Samples at every point of the grid: the same at each
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = samples)]
    cases: Option<u64>,
    /// What the samples follow from; default 0
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = seed)]
    seed: Option<u64>,
    /// Simulate each case, too; without it the equilibrium is all that is asked
    #[arg(long)]
    run: bool,
    /// Give up a case after so many seconds: its row says so
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    time_limit: Option<f64>,
    /// Cases that are worked on at once; default: one per processor. The answers do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Whether cases are computed side by side in the lanes of the processor's registers: whenever that pays, or never. The
    /// answers are the same to round-off
    #[arg(long, value_enum, value_name = "WHEN", default_value_t)]
    lanes: Lanes,
    /// Write the rows there: a name ending in .csv is one file; any other a folder, a dataset of Parquet parts that are
    /// written as they are done
    #[arg(long, short = 'o', value_name = "FILE.csv|DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    dataset: DatasetOptions,
}

/// When cases are computed side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum Lanes {
    /// Whenever it pays
    #[default]
    Auto,
    /// Never
    Off,
}

/// What else a dataset may be told.
#[derive(Debug, Args)]
struct DatasetOptions {
    /// Continue the dataset of this plan that is there; begin it if there is none
    #[arg(long, requires = "out")]
    resume: bool,
    /// Number of processes that share the dataset
    #[arg(long, value_name = "K", requires = "out", value_parser = clap::value_parser!(u64).range(1..))]
    shards: Option<u64>,
    /// Which of them this is, 0 to K − 1; default: the index of the task in the environment of HyperQueue, Kubernetes or
    /// Slurm
    #[arg(long, value_name = "k", requires = "shards")]
    shard: Option<u64>,
    /// Print which shards, or without `--shards` which parts, are not done, and do nothing
    #[arg(long, requires = "out")]
    missing: bool,
    /// Rows of a part; default: a hundredth of all, at most 10 000, or as many as have 262 144 cells
    #[arg(long, value_name = "N", requires = "out", value_parser = clap::value_parser!(u64).range(1..))]
    part_rows: Option<u64>,
}

/// More cases than this are written as they come, or not at all.
const MOST_IN_MEMORY: u64 = 1_000_000;
/// Rows that are handed over at once without a dataset.
const ROWS: u64 = 64;

fn seconds(text: &str) -> Result<f64, String> {
    match in_unit(text, "s")? {
        limit if limit > 0.0 => Ok(limit),
        _ => Err("a time limit is a number of seconds above 0".to_owned()),
    }
}

fn samples(text: &str) -> Result<u64, String> {
    let allowed = || format!("allowed: a whole number from 1 to {MOST_CASES}");
    text.parse().ok().filter(|count| (1..=MOST_CASES).contains(count)).ok_or_else(allowed)
}

fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("allowed: a whole number from 0 to {}", u64::MAX))
}

/// Refuses a call that varies nothing, and what only draws have.
fn refuse_nothing_varied(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { over, vary, correlate, sample, cases, seed, .. } = arguments;
    if over.is_empty() && vary.is_empty() {
        bail!("nothing is varied: give `--over PATH=VALUES` or `--vary PATH=DISTRIBUTION` with `--cases N`");
    }
    let of_draws = [
        ("--cases", cases.is_some()),
        ("--seed", seed.is_some()),
        ("--sample", sample.is_some()),
        ("--correlate", correlate.is_some()),
    ];
    match of_draws.into_iter().find(|(_, given)| *given && vary.is_empty()) {
        Some((name, _)) => bail!("`{name}` is for what is drawn, and nothing is: give `--vary PATH=DISTRIBUTION`, too"),
        None => Ok(()),
    }
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    refuse_nothing_varied(arguments)?;
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
    refuse_overlaps(arguments, &scenario, &set)?;
    let inputs = Inputs::of_scenario(common, &scenario, arguments.correlate.as_deref());
    let plan = plan(arguments)?;
    let question = Question { run: arguments.run, time_limit: arguments.time_limit.unwrap_or(f64::INFINITY) };
    let mut cases = match Cases::new(scenario, set, plan, question) {
        Ok(cases) => cases,
        // A name that is not there is no answer, it is a wrong call.
        Err(Refusal::Problems(problems)) => {
            output::note(problems.render(output::errors_in_color()).trim_end());
            return Ok(Exit::Wrong);
        }
        Err(other) => return Err(other.into()),
    };
    if arguments.lanes == Lanes::Off {
        cases.go_alone();
    }
    let sweep = Sweep { arguments, cases, interrupt: Interrupt::install()? };
    arguments.out.as_deref().map_or(Ok(()), refuse_other_formats)?;
    match &arguments.out {
        Some(folder) if !is_table(folder) => {
            if folder.is_file() {
                inputs.spare(folder)?;
                bail!("`{}` is a file: name a folder, or a file that ends in .csv", folder.display());
            }
            sweep.dataset(folder)
        }
        out => {
            refuse_dataset(&arguments.dataset)?;
            sweep.table(out.as_deref(), &inputs)
        }
    }
}

/// Whether an output is one file of all rows.
fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("csv")) || path.starts_with("/dev")
}

/// What files of tables, archives and texts end in that a sweep does not write: a folder of such a name is hardly meant.
const OTHER_FORMATS: [&str; 16] = [
    "arrow", "db", "feather", "h5", "hdf5", "json", "jsonl", "mat", "npz", "ods", "parquet", "sqlite", "tsv", "txt",
    "xls", "xlsx",
];

/// Refuses a name that would become a folder and looks like something else.
fn refuse_other_formats(out: &Path) -> anyhow::Result<()> {
    if out.as_os_str() == "-" {
        bail!("`--out -` is no file: without `--out` the rows are printed, and `--out /dev/stdout` prints them as CSV");
    }
    let end = out.extension().map(|end| end.to_string_lossy().to_lowercase()).unwrap_or_default();
    if OTHER_FORMATS.contains(&end.as_str()) && !out.exists() {
        bail!(
            "`{}`: no .{end} is written: name a file that ends in .csv, or a folder for a dataset of Parquet parts",
            out.display()
        );
    }
    Ok(())
}

/// Refuses what only a dataset has.
fn refuse_dataset(options: &DatasetOptions) -> anyhow::Result<()> {
    let DatasetOptions { resume, shards, shard, missing, part_rows } = options;
    let given = [
        ("--resume", *resume),
        ("--shards", shards.is_some()),
        ("--shard", shard.is_some()),
        ("--missing", *missing),
        ("--part-rows", part_rows.is_some()),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        Some((name, _)) => bail!("`{name}` needs a dataset: let `--out` name a folder, not a file"),
        None => Ok(()),
    }
}

fn plan(arguments: &Arguments) -> anyhow::Result<Plan> {
    let matrix = arguments.correlate.as_ref().map(|path| {
        let text = crate::text_file::read(path, "correlation matrix")?;
        Ok::<_, anyhow::Error>((path, text))
    });
    let matrix = matrix.transpose()?;
    let named = |name: &String| Sampling::ALL.into_iter().find(|sampling| sampling.name() == name);
    let draw = Draw {
        sampling: arguments.sample.as_ref().and_then(named).unwrap_or_default(),
        samples: arguments.cases.unwrap_or(1),
        seed: arguments.seed.unwrap_or(0),
    };
    let text = matrix.as_ref().map(|(_, text)| text.as_str());
    Plan::new(arguments.over.clone(), arguments.vary.clone(), draw, text).map_err(|error| match &matrix {
        Some((path, _)) => anyhow!("{}: {error}", path.display()),
        None => anyhow!(error),
    })
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
    let paths = varied(arguments);
    for (index, (option, path)) in paths.iter().enumerate() {
        let is_same = |other: &str| short(other) == short(path);
        if paths[..index].iter().any(|(_, other)| is_same(other)) {
            bail!("`{option}` varies `{path}` twice: write all of its values into one");
        }
        if set.iter().any(|other| is_same(other.path())) {
            bail!("`{path}` is set and varied at once: leave out `--set` or `{option}`");
        }
        let why = match path.split(['.', '[']).next().unwrap_or_default() {
            // Least, largest and mean square of outputs are those of the samples, and so is the drift of the energy.
            "record" if *path == "record.rate" && arguments.run => continue,
            "record" if *path == "record.rate" => "only the cases of `--run` have samples",
            "record" => "a sweep records nothing",
            "title" => "nothing depends on it",
            "simulate" if !arguments.run => "only `--run` simulates the cases",
            "statics" if arguments.run && !from_start => "the runs start as given, without statics",
            _ => continue,
        };
        bail!("`{option} {path}=…` changes nothing: {why}");
    }
    Ok(())
}

/// What is varied, and by which option.
fn varied(arguments: &Arguments) -> Vec<(&'static str, &str)> {
    let over = arguments.over.iter().map(|axis| (OPTION, axis.path.as_str()));
    over.chain(arguments.vary.iter().map(|one| (VARY, one.path.as_str()))).collect()
}

/// Refuses paths of which one would undo what another sets: the rows would show values that did not act.
fn refuse_overlaps(arguments: &Arguments, scenario: &Scenario, set: &[Override]) -> anyhow::Result<()> {
    let varied = varied(arguments);
    let paths: Vec<&str> = varied.iter().map(|(_, path)| *path).collect();
    let shown = |index: usize| format!("`{} {}`", varied[index].0, varied[index].1);
    if let Some((first, later, shared)) = scenario.overlap(set, &paths) {
        bail!(
            "{} and {} both vary {shared}: the one would overwrite the other; vary only one of them, or what they do not share",
            shown(first),
            shown(later)
        );
    }
    if let Some((place, by, lost)) = scenario.lost(set, &paths) {
        let by: Vec<String> = by.into_iter().map(shown).collect();
        bail!(
            "`--set {}` would be lost: all that it sets, {lost}, is varied by {}; leave out one of them",
            set[place].path(),
            by.join(" and ")
        );
    }
    Ok(())
}

struct Sweep<'a> {
    arguments: &'a Arguments,
    cases: Cases,
    interrupt: Interrupt,
}

impl Sweep<'_> {
    /// All rows of the parts, handed to `take`; whether none was interrupted.
    fn answer(
        &self,
        parts: impl Iterator<Item = pool::Part> + Send,
        count: u64,
        take: pool::Take<'_, anyhow::Error>,
    ) -> anyhow::Result<bool> {
        let available = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let threads = self.arguments.threads.map_or(available, usize::from).min(count.max(1) as usize);
        let common = &self.arguments.common;
        let (done, bar) = (AtomicU64::new(0), Mutex::new(Progress::new(1.0, common.quiet || common.json)));
        let progress = || {
            let done = done.fetch_add(1, Ordering::Relaxed);
            if let Ok(mut bar) = bar.try_lock() {
                bar.part(done as f64 / count.max(1) as f64);
            }
        };
        pool::answer(&self.cases, parts, threads, &|| !self.interrupt.requested(), &progress, take)
    }

    /// All rows on the terminal, as JSON, and in one file.
    fn table(&self, out: Option<&Path>, inputs: &Inputs) -> anyhow::Result<Exit> {
        let (common, count) = (&self.arguments.common, self.cases.plan.cases());
        if count > MOST_IN_MEMORY {
            bail!(
                "`{OPTION}` asks for more than {MOST_IN_MEMORY} cases at once: with `--out FOLDER` they are written as they come"
            );
        }
        // What cannot be written is told before the work.
        let failed = |path: &Path| format!("cannot write `{}`", path.display());
        let table = out.map(|path| {
            inputs.spare(path)?;
            WholeFile::create(path).with_context(|| failed(path))
        });
        let rows = Mutex::new(Rows::new(&self.cases, table.transpose()?, common.json)?);
        let parts = (0..count.div_ceil(ROWS)).map(|part| (part, part * ROWS..((part + 1) * ROWS).min(count)));
        let take = |part, answered: Vec<Row>| {
            let mut rows = rows.lock().unwrap_or_else(PoisonError::into_inner);
            rows.take(part, answered).with_context(|| out.map_or(String::new(), failed))
        };
        if !self.answer(parts, count, &take)? {
            output::warning("interrupted: nothing is written; a dataset (`--out FOLDER`) keeps what is done");
            return Ok(Exit::Interrupted);
        }
        let mut rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
        let list = rows.finish().with_context(|| out.map_or(String::new(), failed))?;
        if let Some(list) = list {
            let (name, beside) = (&self.cases.scenario().name, self.cases.width());
            let answer = json!({ "scenario": name, "cases": list, "failed": rows.failed, "side_by_side": beside });
            output::print(&answer.to_string())?;
        } else if !common.quiet {
            output::print(&rows.report(count))?;
        }
        Ok(if rows.failed == 0 { Exit::Done } else { Exit::No })
    }

    #[cfg(not(feature = "parquet"))]
    fn dataset(&self, _: &Path) -> anyhow::Result<Exit> {
        bail!(
            "this program was built without Parquet; build it with `--features parquet`, or let `--out` name a .csv file"
        )
    }

    /// Rows in the parts of a dataset, those that are not there yet.
    #[cfg(feature = "parquet")]
    fn dataset(&self, folder: &Path) -> anyhow::Result<Exit> {
        let (common, options) = (&self.arguments.common, &self.arguments.dataset);
        let dataset = Dataset::new(folder, &self.cases, options.part_rows)?;
        if options.missing {
            return self.missing(&dataset);
        }
        let environment = |name: &str| std::env::var(name).ok();
        let (shard, source) = Shard::chosen(options.shards, options.shard, environment)?;
        if let Some(source) = source.filter(|_| !common.quiet) {
            output::note(&format!("shard {} of 0 to {}, by {source}", shard.index, shard.of - 1));
        }
        dataset.begin(&self.cases, options.resume || options.shards.is_some())?;
        let own = || (0..dataset.parts()).filter(|part| shard.has(*part));
        self.refuse_strays(&dataset, own())?;
        let rows = |part: u64| dataset.part(part).1.count() as u64;
        let count = own().filter(|part| !dataset.is_done(*part)).map(rows).sum();
        // Another process may have written a part meanwhile.
        let parts = own().filter(|part| !dataset.is_done(*part)).map(|part| dataset.part(part));
        let take = |part, answered: Vec<Row>| Ok(dataset.write(part, &answered)?);
        let complete = self.answer(parts, count, &take).with_context(|| {
            format!("`{}` is not complete: what is there stays, and `--resume` continues it", folder.display())
        })?;
        if !complete {
            output::warning(&format!("interrupted: `{}` is not complete; `--resume` continues it", folder.display()));
            return Ok(Exit::Interrupted);
        }
        let failed = own().map(|part| dataset.failed(part)).sum::<Result<u64, _>>()?;
        let cases = own().map(rows).sum();
        if common.json {
            let answer = json!({
                "scenario": self.cases.scenario().name, "out": folder.display().to_string(), "hash": dataset.hash, "side_by_side": self.cases.width(),
                "cases": cases, "answered": count, "failed": failed, "shard": shard.index, "shards": shard.of,
            });
            output::print(&answer.to_string())?;
        } else if !common.quiet {
            let before = cases - count;
            let before = if before > 0 { format!(" ({before} of them were there already)") } else { String::new() };
            let beside = rows::side_by_side(&self.cases);
            output::print(&format!("{}: {}{before}{beside}", folder.display(), rows::counted(cases, failed)))?;
        }
        Ok(if failed == 0 { Exit::Done } else { Exit::No })
    }

    /// Refuses parts that belong to another study or have other cases, and says how many do not say what they are.
    #[cfg(feature = "parquet")]
    fn refuse_strays(&self, dataset: &Dataset, parts: impl Iterator<Item = u64>) -> anyhow::Result<()> {
        let silent = dataset.refuse_strays(parts)?;
        if silent > 0 && !self.arguments.common.quiet {
            output::warning(&super::study::silent(silent));
        }
        Ok(())
    }

    /// Prints shards or parts that are not done, as an array of tasks takes them; of parts that are damaged, too, what to do.
    #[cfg(feature = "parquet")]
    fn missing(&self, dataset: &Dataset) -> anyhow::Result<Exit> {
        dataset.is_there()?;
        self.refuse_strays(dataset, 0..dataset.parts())?;
        let mut parts = Vec::new();
        for part in 0..dataset.parts() {
            if !dataset.is_done(part) {
                parts.push(part);
            } else if let Err(damaged) = dataset.failed(part) {
                output::warning(&damaged.to_string());
                parts.push(part);
            }
        }
        let parts = parts.into_iter();
        let missing: std::collections::BTreeSet<u64> = match self.arguments.dataset.shards {
            Some(shards) => parts.map(|part| part % shards).collect(),
            None => parts.collect(),
        };
        if self.arguments.common.json {
            output::print(&json!({ "missing": missing }).to_string())?;
        } else {
            let list: Vec<String> = missing.iter().map(ToString::to_string).collect();
            output::print(&list.join(","))?;
        }
        Ok(Exit::Done)
    }
}
