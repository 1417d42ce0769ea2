//! `info`: what is in a recording.

use super::samples::clock;
use super::text::{self, count, number};
use super::{Exit, output};
use crate::record::file::{ChannelSurvey, Ending, Survey};
use crate::record::{Recording, Table};
use clap::Args;
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The recording, an MCAP file, finished or not
    recording: PathBuf,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
}

/// Long lists stop here; `--json` has all.
const MOST_NAMES: usize = 12;

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let recording = Recording::open(&arguments.recording)?;
    let survey = recording.survey()?;
    let (statics, outcome) = (parsed(&recording.statics), parsed(&recording.outcome));
    let text = match arguments.json {
        true => as_json(&recording, &survey, statics, outcome).to_string(),
        false => as_text(&recording, &survey, &statics, &outcome),
    };
    output::print(&text)?;
    Ok(if survey.damage.is_some() { Exit::No } else { Exit::Done })
}

fn parsed(json: &Option<String>) -> Value {
    json.as_deref().and_then(|json| serde_json::from_str(json).ok()).unwrap_or(Value::Null)
}

/// One word for scripts and a sentence for people.
fn state(recording: &Recording, survey: &Survey) -> (&'static str, String) {
    if let Some(damage) = &survey.damage {
        return ("damaged", format!("damaged: {damage}; `stillpoint recover` keeps what is intact"));
    }
    let ending = recording.ending();
    let sentence = match ending {
        Ending::Complete => "complete",
        Ending::Interrupted => "interrupted: the run was stopped before its end",
        Ending::Failed => "failed: the run could not go on",
        Ending::Recovered => "what was saved of a recording that was cut or damaged",
        Ending::Cut => "cut: the run was killed or is still going on, or the file lost its end",
    };
    (ending.name(), sentence.to_owned())
}

/// First and last time of whole samples (s).
fn span(survey: &Survey) -> Option<(f64, f64)> {
    seconds(whole(survey)?.span)
}

/// The channel that ends each sample: its poses.
fn whole(survey: &Survey) -> Option<&ChannelSurvey> {
    survey.channels.iter().find(|channel| channel.topic == "/tf")
}

fn seconds(span: Option<(u64, u64)>) -> Option<(f64, f64)> {
    span.map(|(first, last)| (first as f64 / 1e9, last as f64 / 1e9))
}

/// How many samples are whole.
fn samples(survey: &Survey) -> u64 {
    whole(survey).map_or(0, |channel| channel.messages)
}

fn as_json(recording: &Recording, survey: &Survey, statics: Value, outcome: Value) -> Value {
    let channel = |channel: &ChannelSurvey| {
        let span = seconds(channel.span);
        json!({
            "topic": channel.topic,
            "schema": channel.schema,
            "encoding": channel.encoding,
            "messages": channel.messages,
            "first_time": span.map(|(first, _)| first),
            "last_time": span.map(|(_, last)| last),
            "fields": channel.fields,
        })
    };
    let columns: Map<String, Value> = Table::all(&recording.scene)
        .into_iter()
        .map(|table| {
            let list = table.columns.iter().map(|column| json!({ "name": column.name, "unit": column.unit }));
            (table.name.to_owned(), list.collect())
        })
        .collect();
    let attachment = |(name, media_type, bytes): &(String, String, usize)| json!({ "name": name, "media_type": media_type, "bytes": bytes });
    let (state, _) = state(recording, survey);
    json!({
        "recording": recording.path.display().to_string(),
        "state": state,
        "complete": recording.complete,
        "damage": survey.damage,
        "recovered": parsed(&recording.recovered),
        "program": "stillpoint",
        "version": recording.version,
        "bytes": survey.bytes,
        "title": recording.scene.title,
        "samples": samples(survey),
        "first_time": span(survey).map(|(first, _)| first),
        "last_time": span(survey).map(|(_, last)| last),
        "bodies": recording.scene.bodies.iter().map(|body| &body.name).collect::<Vec<_>>(),
        "bushings": recording.scene.bushings.iter().map(|bushing| &bushing.name).collect::<Vec<_>>(),
        "lines": recording.scene.lines.iter().map(|line| &line.name).collect::<Vec<_>>(),
        "channels": survey.channels.iter().map(channel).collect::<Vec<_>>(),
        "columns": columns,
        "attachments": survey.attachments.iter().map(attachment).collect::<Vec<_>>(),
        "metadata": survey.metadata,
        "statics": statics,
        "run": outcome,
    })
}

fn as_text(recording: &Recording, survey: &Survey, statics: &Value, outcome: &Value) -> String {
    let scene = &recording.scene;
    let title = if scene.title.is_empty() { recording.path.display().to_string() } else { scene.title.clone() };
    let mut out = format!("{}\n", output::bold(&title));
    let mut line = |head: &str, text: &str| {
        let _ = writeln!(out, "  {head:<12} {text}");
    };
    line("state", &state(recording, survey).1);
    line("written by", &format!("stillpoint {}", recording.version));
    let samples = samples(survey);
    let along = clock(recording, &Table::all(scene));
    line(
        "samples",
        &match span(survey) {
            Some((first, last)) if samples > 0 && along.name == "time" => {
                format!("{samples}, from {} s to {} s", number(first), number(last))
            }
            Some((first, last)) if samples > 0 => {
                format!("{samples}, {} from {} to {}", along.name, number(first), number(last))
            }
            _ => "none".to_owned(),
        },
    );
    let bodies: Vec<&str> = scene.bodies.iter().map(|body| body.name.as_str()).collect();
    line("bodies", &format!("{}: {}", bodies.len(), some(&bodies)));
    line(
        "start",
        &match statics["stability"].as_str() {
            Some(verdict) => format!(
                "{verdict} equilibrium, residual {} of the forces that cancel",
                text::small(statics["relative_residual"].as_f64().unwrap_or(f64::NAN))
            ),
            None => "as given".to_owned(),
        },
    );
    if let (Some(end), Some(method)) = (outcome["end_time"].as_f64(), outcome["integrator"].as_str()) {
        let drift =
            outcome["energy_drift"].as_f64().map(|drift| format!(", energy unaccounted for {} J", text::small(drift)));
        line("run", &format!("to {} s with {method}{}", number(end), drift.unwrap_or_default()));
    } else if let Some(error) = outcome["error"].as_str() {
        line("run", &format!("failed: {error}"));
    }
    for (name, media_type, bytes) in &survey.attachments {
        line("attached", &format!("{name} ({media_type}, {bytes} bytes)"));
    }
    line("size", &format!("{} bytes", survey.bytes));
    let _ = write!(out, "  channels");
    let tables = Table::all(scene);
    for channel in &survey.channels {
        let _ = write!(
            out,
            "\n    {:<12} {}, {}",
            channel.topic,
            count(channel.messages as usize, "message", "messages"),
            channel.schema
        );
        let table = tables.iter().find(|table| channel.topic.strip_prefix('/') == Some(table.name));
        let columns: Vec<String> = table
            .iter()
            .flat_map(|table| &table.columns)
            .map(|column| format!("{} [{}]", column.name, column.unit))
            .collect();
        if !columns.is_empty() {
            let names: Vec<&str> = columns.iter().map(String::as_str).collect();
            let _ = write!(out, "\n                 {}", some(&names));
        }
    }
    out
}

/// The first names of a list.
fn some(names: &[&str]) -> String {
    match names.len() {
        0..=MOST_NAMES => names.join(", "),
        many => format!("{}, … ({} more)", names[..MOST_NAMES - 1].join(", "), many - MOST_NAMES + 1),
    }
}
