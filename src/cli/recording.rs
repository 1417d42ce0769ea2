//! Where the recording of a command goes, and the pictures beside it.

use super::output;
use crate::record::view::{Sink, Viewer};
use crate::record::{self, Fanout, Opening, RecordingFile};
use clap::Args;
use std::path::{Path, PathBuf};

/// Where a picture goes beside what is written.
#[derive(Debug, Args)]
pub(super) struct Viewers {
    /// Open the Rerun viewer and stream to it
    #[arg(long)]
    view: bool,
    /// Stream to a running viewer, e.g. 127.0.0.1:9876
    #[arg(long, value_name = "URL")]
    connect: Option<String>,
    /// Write an .rrd file for the Rerun viewer
    #[arg(long, value_name = "FILE")]
    rrd: Option<PathBuf>,
}

impl Viewers {
    /// The file that a picture is saved in.
    pub(super) fn rrd(&self) -> &Option<PathBuf> {
        &self.rrd
    }

    pub(super) fn sinks(&self) -> Vec<Sink> {
        let view = self.view.then_some(Sink::Spawn);
        let connect = self.connect.clone().map(Sink::Connect);
        let save = self.rrd.clone().map(Sink::Save);
        view.into_iter().chain(connect).chain(save).collect()
    }
}

/// `scenarios/arm.toml` → `arm.mcap`.
pub(super) fn recording_path(out: Option<&Path>, scenario: &Path) -> PathBuf {
    match out {
        Some(path) => path.to_owned(),
        None => Path::new(scenario.file_stem().filter(|stem| *stem != "-").unwrap_or("recording".as_ref()))
            .with_extension("mcap"),
    }
}

/// Opens a recording; what earlier runs left there is said.
pub(super) fn recording_file(path: &Path, quiet: bool) -> anyhow::Result<RecordingFile> {
    let file = RecordingFile::create(path)?;
    for left in file.left().filter(|_| !quiet) {
        let left = left.display();
        output::warning(&format!(
            "`{left}` is what a run left that was cut; it is kept: `stillpoint recover {left}` makes a recording of it"
        ));
    }
    Ok(file)
}

/// Keeps a complete recording that one of a run that did not reach its end is about to replace, and says so.
pub(super) fn keep_complete(path: &Path, quiet: bool) -> anyhow::Result<()> {
    if let Some(kept) = record::file::keep_complete(path)?.filter(|_| !quiet) {
        let (path, kept) = (path.display(), kept.display());
        output::note(&format!("`{path}` was there already, of a run that reached its end: it is kept as `{kept}`"));
    }
    Ok(())
}

/// A viewer that cannot be reached stops nothing; a file that cannot be written is a wrong call.
pub(super) fn add_viewer(recorder: Fanout, sink: &Sink, opening: &Opening<'_>, quiet: bool) -> anyhow::Result<Fanout> {
    match Viewer::open(sink, opening) {
        Ok(viewer) => {
            if !quiet {
                viewer.notes().iter().for_each(|note| output::note(note));
            }
            Ok(recorder.onlooker(viewer))
        }
        Err(error) if matches!(sink, Sink::Save(_)) => Err(error.into()),
        Err(error) => {
            output::warning(&format!("{error}\nthe run goes on without a picture; its recording is not affected"));
            Ok(recorder)
        }
    }
}
