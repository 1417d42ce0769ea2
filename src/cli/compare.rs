//! `compare`: how far two recordings are apart.

use super::samples::{self, Rows};
use super::text::{count, number, small};
use super::{Exit, output};
use crate::record::{OwnedSample, RecordError, Recording, Table};
use anyhow::bail;
use clap::Args;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The first recording
    first: PathBuf,
    /// The second recording
    second: PathBuf,
    /// Differences up to this are none (in each column's unit)
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = not_negative, allow_negative_numbers = true)]
    tolerance: f64,
    /// Differences up to this part of a column's largest number are none either
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = not_negative, allow_negative_numbers = true)]
    relative: f64,
    /// Only this channel (hinges, energy, reactions, couplings, outputs, tf) or this column (upper.angle); may be repeated
    #[arg(long, value_name = "NAME")]
    channel: Vec<String>,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

/// Columns that are listed for people; `--json` has all.
const MOST_LINES: usize = 20;

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number >= 0.0 && number.is_finite() => Ok(number),
        _ => Err("a number ≥ 0 is wanted".to_owned()),
    }
}

/// What was found of one column.
struct Difference {
    name: String,
    unit: String,
    /// The largest difference; infinite where one of both is not a number.
    largest: f64,
    /// Samples in which one of both is not a number and the other is.
    not_numbers: usize,
    /// When (s).
    at: f64,
    /// The largest number of the column in either recording.
    size: f64,
}

impl Difference {
    fn take(&mut self, time: f64, [a, b]: [f64; 2]) {
        for number in [a, b] {
            if number.abs() > self.size {
                self.size = number.abs();
            }
        }
        let same = a == b || (a.is_nan() && b.is_nan());
        let apart = if same { 0.0 } else { (a - b).abs() };
        self.not_numbers += usize::from(a.is_nan() != b.is_nan());
        let apart = if apart.is_nan() { f64::INFINITY } else { apart };
        if apart > self.largest {
            (self.largest, self.at) = (apart, time);
        }
    }

    fn within(&self, arguments: &Arguments) -> bool {
        self.largest <= arguments.tolerance
            || self.largest <= arguments.relative * self.size && self.largest.is_finite()
    }

    fn json(&self, arguments: &Arguments) -> Value {
        json!({
            "name": self.name,
            "unit": self.unit,
            // JSON has no infinity.
            "largest": if self.largest.is_finite() { json!(self.largest) } else { json!("infinite") },
            "not_numbers": self.not_numbers,
            "time": self.at,
            "size": self.size,
            "same": self.within(arguments),
        })
    }
}

/// How the samples of both fit together.
#[derive(Default)]
struct Times {
    common: usize,
    only_first: usize,
    only_second: usize,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let open = |path: &Path| samples::open(path, arguments.quiet);
    let recordings = [open(&arguments.first)?, open(&arguments.second)?];
    let (mut differences, missing, times) = compare(arguments, &recordings)?;
    if times.common == 0 && times.only_first + times.only_second > 0 {
        bail!("the recordings have no time in common: {} samples and {}", times.only_first, times.only_second);
    }
    let different = differences.iter().filter(|one| !one.within(arguments)).count();
    let same = different == 0 && missing.iter().all(Vec::is_empty);
    differences.sort_by(|a, b| b.largest.total_cmp(&a.largest));
    if arguments.json {
        let answer = json!({
            "same": same,
            "tolerance": arguments.tolerance,
            "relative": arguments.relative,
            "common_samples": times.common,
            "only_first": times.only_first,
            "only_second": times.only_second,
            "missing_in_second": missing[0],
            "missing_in_first": missing[1],
            "columns": differences.iter().map(|one| one.json(arguments)).collect::<Vec<_>>(),
        });
        output::print(&answer.to_string())?;
    } else if !arguments.quiet {
        output::print(&report(arguments, &differences, &missing, &times))?;
    }
    Ok(if same { Exit::Done } else { Exit::No })
}

/// The columns that both have, the names of those that only the first and only the second has, and how times fit.
fn compare(
    arguments: &Arguments,
    recordings: &[Recording; 2],
) -> anyhow::Result<(Vec<Difference>, [Vec<String>; 2], Times)> {
    let tables = recordings.each_ref().map(|recording| Table::all(&recording.scene));
    let mut all: Vec<String> = tables.iter().flatten().map(|table| table.name.to_owned()).collect();
    all.sort_unstable();
    all.dedup();
    let names = if arguments.channel.is_empty() { &all } else { &arguments.channel };
    let mut places = [Vec::new(), Vec::new()];
    for name in names {
        for side in [0, 1] {
            // A column that one of both does not have is told below.
            match samples::columns(&tables[side], name) {
                Ok(found) => places[side].extend(found),
                Err(error) if samples::columns(&tables[1 - side], name).is_err() => return Err(error),
                Err(_) => {}
            }
        }
    }
    let index = |side: usize| -> HashMap<&str, usize> {
        places[side].iter().enumerate().map(|(at, place)| (place.column.name.as_str(), at)).collect()
    };
    let (in_first, in_second) = (index(0), index(1));
    let missing = [
        places[0]
            .iter()
            .map(|place| &place.column.name)
            .filter(|name| !in_second.contains_key(name.as_str()))
            .cloned()
            .collect(),
        places[1]
            .iter()
            .map(|place| &place.column.name)
            .filter(|name| !in_first.contains_key(name.as_str()))
            .cloned()
            .collect(),
    ];
    let pairs: Vec<[usize; 2]> = places[0]
        .iter()
        .enumerate()
        .filter_map(|(at, place)| Some([at, *in_second.get(place.column.name.as_str())?]))
        .collect();
    let mut differences: Vec<Difference> = pairs
        .iter()
        .map(|[at, _]| {
            let column = &places[0][*at].column;
            Difference {
                name: column.name.clone(),
                unit: column.unit.clone(),
                largest: 0.0,
                not_numbers: 0,
                at: f64::NAN,
                size: 0.0,
            }
        })
        .collect();
    let mut rows = [0, 1].map(|side: usize| Rows::new(&tables[side], &places[side]));
    let times = pair_samples(recordings, |first, second| {
        let numbers: [Vec<f64>; 2] = {
            let [a, b] = &mut rows;
            [a.read(first).collect(), b.read(second).collect()]
        };
        for ([a, b], difference) in pairs.iter().zip(&mut differences) {
            difference.take(first.time, [numbers[0][*a], numbers[1][*b]]);
        }
    })?;
    Ok((differences, missing, times))
}

/// Calls `take` with the samples of both that belong to one time (to the nanosecond of the file).
fn pair_samples(
    recordings: &[Recording; 2],
    mut take: impl FnMut(&OwnedSample, &OwnedSample),
) -> Result<Times, RecordError> {
    let nanoseconds = |sample: &OwnedSample| (sample.time * 1e9).round() as i64;
    let [mut first, mut second] = [recordings[0].samples()?, recordings[1].samples()?];
    let (mut a, mut b) = (first.next().transpose()?, second.next().transpose()?);
    let mut times = Times::default();
    loop {
        match (&a, &b) {
            (None, None) => return Ok(times),
            (Some(one), Some(other)) if nanoseconds(one) == nanoseconds(other) => {
                take(one, other);
                times.common += 1;
                (a, b) = (first.next().transpose()?, second.next().transpose()?);
            }
            (Some(one), other) if other.as_ref().is_none_or(|other| one.time < other.time) => {
                times.only_first += 1;
                a = first.next().transpose()?;
            }
            _ => {
                times.only_second += 1;
                b = second.next().transpose()?;
            }
        }
    }
}

fn report(arguments: &Arguments, differences: &[Difference], missing: &[Vec<String>; 2], times: &Times) -> String {
    let different: Vec<&Difference> = differences.iter().filter(|one| !one.within(arguments)).collect();
    let columns = count(differences.len(), "column", "columns");
    let said = match (different.len(), differences.first().filter(|one| one.largest > 0.0)) {
        (0, None) if times.only_first + times.only_second > 0 => {
            format!("{columns} are the same to the last bit at the times that both have")
        }
        (0, None) => format!("{columns} are the same to the last bit"),
        (0, Some(largest)) => {
            format!("{columns} are the same within the tolerance; furthest apart: {}", line(largest))
        }
        (many, _) => format!("{many} of {columns} {}", if many == 1 { "differs" } else { "differ" }),
    };
    let mut out = output::verdict(&said, different.is_empty());
    for one in different.iter().take(MOST_LINES) {
        out += &format!("\n  {}", line(one));
    }
    if different.len() > MOST_LINES {
        out += &format!("\n  … and {} more (`--json` has all)", different.len() - MOST_LINES);
    }
    let names = [&arguments.second, &arguments.first];
    for (list, file) in missing.iter().zip(names).filter(|(list, _)| !list.is_empty()) {
        out += &format!(
            "\n  not in {}: {}{}",
            file.display(),
            list[..list.len().min(8)].join(", "),
            if list.len() > 8 { ", …" } else { "" }
        );
    }
    out += &format!("\n  compared at {}", count(times.common, "common time", "common times"));
    for (count, file) in [(times.only_first, &arguments.first), (times.only_second, &arguments.second)] {
        if count > 0 {
            out += &format!("; {count} more only in {}", file.display());
        }
    }
    out
}

fn line(one: &Difference) -> String {
    if one.not_numbers > 0 {
        let samples = count(one.not_numbers, "sample", "samples");
        return format!(
            "{:<24} is not a number in one of both in {samples}, the first at {} s",
            one.name,
            number(one.at)
        );
    }
    let unit = if one.unit == "1" { String::new() } else { format!(" {}", one.unit) };
    format!("{:<24} {}{unit} at {} s (of {} at most)", one.name, small(one.largest), number(one.at), small(one.size))
}
