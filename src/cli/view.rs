//! `view`: a recording in the Rerun viewer.

use super::{Exit, output, text};
use crate::record::view::{Sink, Wishes, view};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The recording, an MCAP file
    recording: PathBuf,
    /// Write an .rrd file instead of opening the viewer
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Send it to a running viewer
    #[arg(long, value_name = "URL", conflicts_with = "save")]
    connect: Option<String>,
    /// Show one instant alone, the sample nearest to this time
    #[arg(long, value_name = "SECONDS")]
    at: Option<f64>,
    /// Draw what the hinges pass to the bodies as arrows
    #[arg(long)]
    reactions: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let sink = match (&arguments.save, &arguments.connect) {
        (Some(file), _) => Sink::Save(file.clone()),
        (None, Some(url)) => Sink::Connect(url.clone()),
        (None, None) => Sink::Spawn,
    };
    let wishes = Wishes { at: arguments.at, reactions: arguments.reactions };
    let shown = view(&arguments.recording, &sink, &wishes)?;
    if !shown.complete {
        output::warning("the recording was not finished: this is what was kept of it");
    }
    if !arguments.quiet {
        shown.notes.iter().for_each(|note| output::note(note));
        let samples = text::count(shown.samples, "sample", "samples");
        output::print(&match &arguments.save {
            Some(file) => format!("{samples} written; to see them: rerun {}", file.display()),
            None => format!("{samples} shown"),
        })?;
    }
    Ok(Exit::Done)
}
