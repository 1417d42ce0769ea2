//! `convert`: a model of another program as a scenario.

use super::inputs::Inputs;
use super::{Exit, output};
use crate::import::{Imported, Note, Options};
use crate::scenario::{LoadError, convert};
use anyhow::{Context, anyhow};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The model: a URDF or an MJCF file
    model: PathBuf,
    /// Write the scenario here instead of printing it (`-` prints it); another file of that name is kept with `~` behind its
    /// name
    #[arg(long, short, value_name = "SCENARIO.toml")]
    out: Option<PathBuf>,
    /// Let the root move freely instead of fixing it to the ground
    #[arg(long)]
    floating: bool,
    /// The keyframe of an MJCF model to start from, by name or number from 0 [default: the first one]
    #[arg(long, value_name = "NAME")]
    key: Option<String>,
    /// Leave out the limits of joints
    #[arg(long)]
    no_limits: bool,
    /// Leave out the dry friction of joints
    #[arg(long)]
    no_friction: bool,
    /// Let what collides in the model touch: shapes of `<collision>`, geoms
    #[arg(long)]
    contact: bool,
    /// Let joints of a URDF move that follow others (<mimic>)
    #[arg(long)]
    no_mimics: bool,
    /// Fix the joints that carry nothing with mass, instead of refusing the model
    #[arg(long)]
    weld_massless: bool,
    /// Put this before the name of every body
    #[arg(long, default_value = "")]
    prefix: String,
    /// Where a package lies, for meshes of `package://NAME/…`; may be repeated
    #[arg(long = "package", value_name = "NAME=FOLDER")]
    packages: Vec<String>,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let options = Options {
        prefix: arguments.prefix.clone(),
        floating: arguments.floating,
        key: arguments.key.clone(),
        without_limits: arguments.no_limits,
        without_friction: arguments.no_friction,
        contact: arguments.contact,
        without_mimics: arguments.no_mimics,
        weld_massless: arguments.weld_massless,
        folder: arguments.out.as_deref().filter(|out| out.as_os_str() != "-").map(folder),
        packages: arguments.packages.iter().map(|text| package(text)).collect::<Result<_, _>>()?,
        ..Options::from_environment()
    };
    let imported = match convert(&arguments.model, &options) {
        Ok(imported) => imported,
        Err(LoadError::Problems(problems)) => {
            output::note(problems.render(output::errors_in_color()).trim_end());
            return Ok(Exit::Wrong);
        }
        Err(other) => return Err(other.into()),
    };
    let out = arguments.out.as_deref().filter(|out| out.as_os_str() != "-");
    let read = Inputs::new(imported.sources.iter().map(|source| source.path.as_path()));
    out.map(|out| read.spare(out)).transpose()?;
    let kept = out.map(|out| write(out, &imported.scenario)).transpose()?.flatten();
    if !arguments.quiet {
        if let (Some(out), Some(kept)) = (out, &kept) {
            output::note(&format!("`{}` was there already, and is kept as `{}`", out.display(), kept.display()));
        }
        imported.notes.iter().for_each(|one| output::note(&line(one)));
        output::note(&summary(&arguments.model, &imported.notes));
    }
    if arguments.json {
        output::print(&object(arguments, &imported).to_string())?;
    } else if out.is_none() {
        output::print(imported.scenario.trim_end())?;
    }
    Ok(Exit::Done)
}

/// Writes the scenario. A file that says something else may be one that somebody went on from: it is kept, under the name
/// that is given back.
fn write(out: &Path, scenario: &str) -> anyhow::Result<Option<PathBuf>> {
    let kept = match differs(out, scenario) {
        false => None,
        true => {
            let mut name = out.as_os_str().to_owned();
            name.push("~");
            let kept = PathBuf::from(name);
            let failed = || {
                format!(
                    "`{}` is there already, and cannot be kept as `{}`: it is left as it is",
                    out.display(),
                    kept.display()
                )
            };
            std::fs::copy(out, &kept).with_context(failed)?;
            Some(kept)
        }
    };
    output::save(out, scenario.as_bytes())?;
    Ok(kept)
}

/// Whether a file is there with another text in it.
fn differs(out: &Path, scenario: &str) -> bool {
    let Ok(there) = out.metadata() else { return false };
    let same =
        || there.len() == scenario.len() as u64 && std::fs::read(out).is_ok_and(|text| text == scenario.as_bytes());
    there.is_file() && there.len() > 0 && !same()
}

/// The folder that a file lies in.
fn folder(file: &Path) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).to_owned()
}

fn package(text: &str) -> anyhow::Result<(String, PathBuf)> {
    let split = text.split_once('=').filter(|(name, path)| !name.is_empty() && !path.is_empty());
    let (name, path) = split.ok_or_else(|| {
        anyhow!("`--package {text}` names no folder: write a name and a folder, for example `--package arm=../arm`")
    })?;
    Ok((name.to_owned(), path.into()))
}

/// `robot.urdf:12: ignored: limit of joint `elbow`: …`
pub(super) fn line(note: &Note) -> String {
    format!("{}:{}: {}: {}: {}", note.file.display(), note.line, note.verdict.word(), note.element, note.what)
}

/// `robot.urdf: 3 ignored, 1 approximated`
fn summary(model: &Path, notes: &[Note]) -> String {
    let count = crate::import::counted(notes);
    format!("{}: {}", model.display(), if count.is_empty() { "everything was taken".to_owned() } else { count })
}

fn object(arguments: &Arguments, imported: &Imported) -> Value {
    let note = |note: &Note| {
        json!({
            "file": note.file.display().to_string(),
            "line": note.line,
            "element": note.element,
            "verdict": note.verdict.word(),
            "what": note.what,
        })
    };
    let joints: serde_json::Map<String, Value> =
        imported.joints.iter().map(|(joint, body)| (joint.clone(), json!(body))).collect();
    json!({
        "model": arguments.model.display().to_string(),
        "out": arguments.out.as_ref().filter(|out| out.as_os_str() != "-").map(|out| out.display().to_string()),
        "scenario": imported.scenario,
        "joints": joints,
        "notes": imported.notes.iter().map(note).collect::<Vec<_>>(),
    })
}
