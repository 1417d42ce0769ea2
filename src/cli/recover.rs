//! `recover`: from a recording that was cut or damaged to a whole one.

use super::text::{count, number};
use super::{Exit, output};
use crate::record::Recording;
use crate::record::file::Recovered;
use anyhow::bail;
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The recording, as a killed run left it
    recording: PathBuf,
    /// Where the whole one goes; default: the name without `.partial`, else with `.recovered.mcap`
    #[arg(long, short = 'o', value_name = "PATH")]
    out: Option<PathBuf>,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let recording = Recording::open(&arguments.recording)?;
    let from = arguments.recording.display();
    if recording.complete && recording.survey()?.damage.is_none() && arguments.out.is_none() {
        if arguments.json {
            output::print(&json!({ "recording": from.to_string(), "complete": true }).to_string())?;
        } else if !arguments.quiet {
            output::print(&format!("{from} is whole: there is nothing to recover"))?;
        }
        return Ok(Exit::Done);
    }
    let target = match &arguments.out {
        Some(path) => path.clone(),
        None => default_target(&arguments.recording)?,
    };
    let recovered = recording.recover(&target)?;
    if arguments.json {
        let mut answer = json!(recovered);
        answer["recording"] = json!(target.display().to_string());
        answer["from"] = json!(from.to_string());
        answer["complete"] = json!(false);
        output::print(&answer.to_string())?;
    } else if !arguments.quiet {
        output::print(&report(&recovered, &arguments.recording, &target))?;
    }
    Ok(Exit::Done)
}

/// `run.mcap.partial` → `run.mcap`, `run.mcap` → `run.recovered.mcap`; never a file that is there.
fn default_target(from: &Path) -> anyhow::Result<PathBuf> {
    let target = match from.extension().is_some_and(|extension| extension == "partial") {
        true => from.with_extension(""),
        false => from.with_extension("recovered.mcap"),
    };
    if target.exists() {
        bail!(
            "`{}` is there already; choose another name with `--out`, or give this one to replace it",
            target.display()
        );
    }
    Ok(target)
}

fn report(recovered: &Recovered, from: &Path, target: &Path) -> String {
    let mut out = match recovered.span {
        Some((first, last)) => format!(
            "{}: {} saved, from {} s to {} s",
            target.display(),
            count(recovered.samples as usize, "sample", "samples"),
            number(first),
            number(last)
        ),
        None => format!("{}: the description of the scene saved, no samples", target.display()),
    };
    for lost in &recovered.lost {
        out += &format!("\n  lost: {} s to {} s ({})", number(lost.span.0), number(lost.span.1), lost.why);
    }
    if recovered.lost_bytes > 0 {
        let bytes = count(recovered.lost_bytes as usize, "byte", "bytes");
        out += &format!("\n  lost: the last {bytes} of {}, which are not whole", from.display());
    }
    if recovered.is_all() {
        out += "\n  all that had been written; a killed run keeps its last half second or so to itself";
    }
    out + &format!("\n  {} is as it was", from.display())
}
