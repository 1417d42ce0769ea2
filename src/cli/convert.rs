//! `convert`: a model of another program as a scenario.

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
    /// Write the scenario here instead of printing it
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
    /// Let joints of a URDF move that follow others (<mimic>)
    #[arg(long)]
    no_mimics: bool,
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
        without_mimics: arguments.no_mimics,
        folder: arguments.out.as_deref().map(folder),
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
    if let Some(out) = &arguments.out {
        std::fs::write(out, &imported.scenario).with_context(|| format!("cannot write `{}`", out.display()))?;
    }
    if !arguments.quiet {
        imported.notes.iter().for_each(|one| output::note(&line(one)));
        output::note(&summary(&arguments.model, &imported.notes));
    }
    if arguments.json {
        output::print(&object(arguments, &imported).to_string())?;
    } else if arguments.out.is_none() {
        output::print(imported.scenario.trim_end())?;
    }
    Ok(Exit::Done)
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
fn line(note: &Note) -> String {
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
        "out": arguments.out.as_ref().map(|out| out.display().to_string()),
        "scenario": imported.scenario,
        "joints": joints,
        "notes": imported.notes.iter().map(note).collect::<Vec<_>>(),
    })
}
