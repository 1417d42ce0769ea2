//! `view`: a recording in the Rerun viewer, or as glTF.

use super::inputs::Inputs;
use super::number::{shown_digits, time};
use super::output::Work;
use super::{Exit, number, output, picture, samples};
use crate::record::drawing::Extras;
use crate::record::gltf::glb;
use crate::record::view::{Shown, Sink, Wishes, view};
use crate::record::{Footage, RecordError};
use crate::whole_file::WholeFile;
use anyhow::Context;
use clap::Args;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The recording, an MCAP file
    recording: PathBuf,
    /// Write a file instead of opening the viewer: .glb (animated glTF, for browsers, Blender and office programs) or .rrd (Rerun)
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Send it to a running viewer
    #[arg(long, value_name = "URL", conflicts_with = "save")]
    connect: Option<String>,
    /// Show one instant alone, the sample nearest to this time
    #[arg(long, value_name = "SECONDS", value_parser = time)]
    at: Option<f64>,
    /// Draw what the hinges pass to the bodies as arrows
    #[arg(long)]
    reactions: bool,
    /// Read mesh files wherever the recording says that they are, not only in its own folder
    #[arg(long)]
    meshes: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let ends_in =
        |file: &Path, with: &str| file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(with));
    match arguments.save.as_deref() {
        Some(file) if ends_in(file, "glb") => return save_gltf(arguments, file),
        Some(file) if !ends_in(file, "rrd") => {
            anyhow::bail!("`{}` has to end in .rrd (for the Rerun viewer) or .glb (animated glTF)", file.display())
        }
        _ => {}
    }
    let sink = arguments.connect.clone().map_or(Sink::Spawn, Sink::Connect);
    let wishes = Wishes { at: arguments.at, reactions: arguments.reactions, meshes: arguments.meshes };
    let shown = match &arguments.save {
        None => view(&arguments.recording, &sink, &wishes)?,
        Some(file) => save(arguments, file, &wishes)?,
    };
    if !shown.complete {
        output::warning("the recording was not finished: this is what was kept of it");
    }
    if !arguments.quiet {
        shown.notes.iter().for_each(|note| output::note(note));
        let samples = number::count(shown.samples, "sample", "samples");
        output::print(&match &arguments.save {
            Some(file) => format!("{samples} written; to see them: rerun {}", file.display()),
            None => format!("{samples} shown"),
        })?;
    }
    Ok(Exit::Done)
}

/// Saves all that moves as glTF; in the order of the command's options, what has no place there is refused.
fn save_gltf(arguments: &Arguments, file: &Path) -> anyhow::Result<Exit> {
    Inputs::new([arguments.recording.as_path()]).spare(file)?;
    if arguments.reactions {
        anyhow::bail!(
            "`--reactions` cannot be saved as glTF: arrows that change are drawn by `picture` and by the viewer"
        );
    }
    let work = Work::new(format!("drawing {}", arguments.recording.display()), arguments.quiet);
    let footage = Footage::open(&arguments.recording, arguments.meshes)?;
    samples::warn_if_cut(&footage.recording, false);
    let first = picture::sample(&footage, arguments.at, arguments.quiet)?;
    let mut drawing = footage.drawing(&first.bodies, Extras::default());
    if let Some(loads) = footage.loads(&first) {
        drawing = drawing.shaded(&loads, loads.iter().copied().fold(0.0, f64::max), shown_digits());
    }
    let clips = if arguments.at.is_some() { Vec::new() } else { footage.clips()? };
    let written = glb(&drawing, &footage.recording.scene.title, &first.bodies, &clips);
    output::save(file, &written.bytes)?;
    drop(work);
    if !arguments.quiet {
        footage.notes.iter().chain(&drawing.notes).for_each(|note| output::warning(note));
        let frames = clips.iter().map(|clip| clip.times.len()).sum::<usize>().max(1);
        let samples = number::count(frames, "sample", "samples");
        let motions = match written.animations {
            0 => "no animation: nothing moves".to_owned(),
            animations => number::count(animations, "animation", "animations"),
        };
        output::print(&format!("{}: {samples}, {motions}", file.display()))?;
    }
    Ok(Exit::Done)
}

/// Saves the picture whole or not at all. Its writer works in another thread and may not say why it failed; the disk does.
fn save(arguments: &Arguments, file: &Path, wishes: &Wishes) -> anyhow::Result<Shown> {
    Inputs::new([arguments.recording.as_path()]).spare(file)?;
    let context = || format!("cannot write `{}`", file.display());
    let mut whole = WholeFile::create(file).with_context(context)?;
    let _work = Work::new(format!("drawing {}", arguments.recording.display()), arguments.quiet);
    let shown = match view(&arguments.recording, &Sink::Save(whole.path().to_owned()), wishes) {
        Ok(shown) => shown,
        Err(error @ RecordError::View { .. }) => {
            whole.probe().with_context(context)?;
            return Err(error.into());
        }
        Err(error) => return Err(error.into()),
    };
    whole.finish().with_context(context)?;
    Ok(shown)
}
