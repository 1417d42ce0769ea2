//! `plot`: numbers of recordings over time, as a quick picture.

pub(super) mod draw;

use super::inputs::Inputs;
use super::number::count;
use super::palette::Theme;
use super::samples::{self, Place, Rows};
use super::sizes::{Sizes, Still};
use super::{Exit, output, pixels};
use crate::record::{Recording, Table};
use anyhow::{Context, bail};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Recordings, then the columns to plot: `upper.angle`, `kinetic`, an output with all its numbers, or a whole channel (hinges, energy, reactions, couplings, outputs, tf)
    #[arg(value_name = "FILE... CHANNEL", required = true)]
    what: Vec<String>,
    /// Where the picture goes: its name ends in .svg, .png or .pdf; default: the first recording's name with .svg in this folder
    #[arg(long, short = 'o', value_name = "FILE.svg|png|pdf")]
    out: Option<PathBuf>,
    /// The column along x, in place of the time; of a path, in place of its parameter
    #[arg(long, value_name = "COLUMN")]
    x: Option<String>,
    /// Paper and ink
    #[arg(long, value_enum, value_name = "THEME", default_value_t)]
    theme: Theme,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

/// More lines than this cannot be distinguished.
const MOST_LINES: usize = 32;

/// One column of one recording.
pub(super) struct Line {
    pub(super) label: String,
    pub(super) unit: String,
    /// Which of the recordings, which of its columns: the dashes and the colour.
    pub(super) file: usize,
    pub(super) column: usize,
    /// Time (s), or what stands along x, and value.
    pub(super) points: Vec<(f64, f64)>,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let (files, names): (Vec<&String>, Vec<&String>) = arguments.what.iter().partition(|text| is_recording(text));
    let Some(first) = files.first() else { bail!("`{}` is no recording: name a .mcap file first", arguments.what[0]) };
    let recordings: Vec<Recording> =
        files.iter().map(|file| samples::open(Path::new(file), arguments.quiet)).collect::<Result<_, _>>()?;
    if names.is_empty() {
        let tables = Table::all(&recordings[0].scene);
        return Err(samples::none_named(&tables, first));
    }
    let mut lines = Vec::new();
    for (index, (file, recording)) in files.iter().zip(&recordings).enumerate() {
        let before = (recordings.len() > 1).then_some(file.as_str());
        lines.extend(read(recording, &names, arguments.x.as_deref(), index, before)?);
    }
    if lines.len() > MOST_LINES {
        bail!(
            "these are {} lines, and more than {MOST_LINES} cannot be distinguished: name fewer columns",
            lines.len()
        );
    }
    if lines.iter().all(|line| line.points.is_empty()) {
        bail!(
            "nothing can be plotted of `{}`: there are no samples in it",
            files.iter().map(|file| file.as_str()).collect::<Vec<_>>().join("`, `")
        );
    }
    let out = match &arguments.out {
        Some(path) => path.clone(),
        None => Path::new(Path::new(first).file_stem().unwrap_or("plot".as_ref())).with_extension("svg"),
    };
    let inputs = Inputs::new(recordings.iter().map(|recording| recording.path.as_path()));
    let title = &recordings[0].scene.title;
    let tables = Table::all(&recordings[0].scene);
    let across = along(&recordings[0], &tables, arguments.x.as_deref())?
        .map_or_else(|| samples::clock(&recordings[0], &tables), |place| place.column);
    let across = draw::with_unit(&across.name, &across.unit);
    inputs.spare(&out)?;
    let encode = pixels::by_name(&out)?;
    let (title, sizes) = (if title.is_empty() { first } else { title }, Sizes::of(&recordings[0].scene));
    let plot = draw::Plot { lines: &lines, title, across: &across, sizes, theme: arguments.theme };
    let picture = draw::draw(&plot)?;
    output::save(&out, &encode(picture)?)?;
    if arguments.json {
        let line = |line: &Line| json!({ "label": line.label, "unit": line.unit, "points": line.points.len() });
        let lines: Vec<_> = lines.iter().map(line).collect();
        output::print(&json!({ "plot": out.display().to_string(), "lines": lines }).to_string())?;
    } else if !arguments.quiet {
        output::print(&format!("{}: {}", out.display(), count(lines.len(), "line", "lines")))?;
    }
    Ok(Exit::Done)
}

fn is_recording(text: &str) -> bool {
    let path = Path::new(text);
    path.is_file() || path.extension().is_some_and(|extension| extension == "mcap" || extension == "partial")
}

/// The column along x: what is asked for, else the parameter of a path; `None` for the time, or the arclength.
fn along(recording: &Recording, tables: &[Table], name: Option<&str>) -> anyhow::Result<Option<Place>> {
    let Some(name) = name else { return Ok(samples::parameter(recording, tables)) };
    if name == samples::clock(recording, tables).name {
        return Ok(None);
    }
    let found = samples::columns(tables, name)
        .with_context(|| format!("nothing can be plotted of `{}`", recording.path.display()))?;
    match &found[..] {
        [one] => Ok(Some(one.clone())),
        _ => bail!("`--x {name}` is no single column: name one of {}", samples::listed(&found)),
    }
}

fn read(
    recording: &Recording,
    names: &[&String],
    x: Option<&str>,
    file: usize,
    before: Option<&str>,
) -> anyhow::Result<Vec<Line>> {
    let tables = Table::all(&recording.scene);
    let mut places: Vec<Place> = Vec::new();
    for name in names {
        let found = samples::columns(&tables, name)
            .with_context(|| format!("nothing can be plotted of `{}`", recording.path.display()))?;
        places.extend(found);
    }
    let mut lines: Vec<Line> = places
        .iter()
        .enumerate()
        .map(|(column, place)| Line {
            file,
            column,
            label: match before {
                Some(file) => format!("{file}: {}", place.column.name),
                None => place.column.name.clone(),
            },
            unit: place.column.unit.clone(),
            points: Vec::new(),
        })
        .collect();
    let x = along(recording, &tables, x)?;
    places.extend(x.clone());
    let mut rows = Rows::new(&tables, &places);
    let mut row = Vec::new();
    let mut still = Still::new(Sizes::of(&recording.scene));
    samples::each(recording, |sample| {
        still.see(sample);
        row.clear();
        row.extend(rows.read(sample));
        let across = if x.is_some() { row.pop() } else { None }.unwrap_or(sample.time);
        for (line, value) in lines.iter_mut().zip(&row) {
            line.points.push((across, *value));
        }
        Ok(())
    })?;
    if still.lasts() {
        let is_rate = |line: &&mut Line| matches!(line.unit.as_str(), "m/s" | "rad/s" | "m/s²" | "rad/s²");
        let of_hinges = lines.iter_mut().zip(&places).filter(|(_, place)| tables[place.table].name == "hinges");
        let rates = of_hinges.map(|(line, _)| line).filter(is_rate);
        rates.flat_map(|line| &mut line.points).for_each(|(_, rate)| *rate = 0.0);
    }
    Ok(lines)
}
