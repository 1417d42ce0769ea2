//! `fmu`: a scenario as an FMU for co-simulation (FMI 3.0).

mod archive;
mod library;
mod resources;

use super::inputs::Inputs;
use super::{Common, Exit, output, scene, text};
use crate::fmu::{FmuError, Instance, MANIFEST, Manifest, Role, Scene, Variables, at_start, describe};
use anyhow::{Context, anyhow, bail};
use clap::Args;
use resources::Resources;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Write the FMU there [default: the scenario's name with `.fmu`]
    #[arg(long, short = 'o', value_name = "FILE.fmu")]
    out: Option<PathBuf>,
    /// A number that importers may set before initialization, beside those of `[parameters]`; may be repeated
    #[arg(long = "parameter", value_name = "ADDRESS")]
    parameters: Vec<String>,
    /// The library to put into the FMU [default: the one beside the program]
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    /// Print the model description (XML) and write nothing
    #[arg(long, conflicts_with_all = ["out", "library", "json"])]
    describe: bool,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let (scenario, model) = match scene::load(common)? {
        Ok(loaded) => loaded,
        Err(exit) => return Ok(exit),
    };
    let out = path(arguments.out.as_deref(), &common.scenario)?;
    let read = Inputs::of_scenario(common, &scenario, None);
    read.spare(&out)?;
    let scene = Scene { scenario, model };
    let model = match at_start(&scene) {
        Ok((model, _)) => model,
        Err(error @ FmuError::NoEquilibrium(_)) => {
            output::error(&anyhow!("{error}\nan FMU is initialized at its equilibrium: without one it cannot begin"));
            return Ok(Exit::No);
        }
        Err(error) => return Err(error.into()),
    };
    let variables = Variables::of(&scene, &model, &arguments.parameters)?;
    if !variables.left_out.is_empty() && !common.quiet {
        let list = variables.left_out.join("`, `");
        output::note(&format!(
            "left out: `{list}`: energies that were put in or taken out since the start of a run, or outputs that follow from them"
        ));
    }
    let identifier = identifier(&out);
    let resources = Resources::of(&scene.scenario, &common.scenario, &read)?;
    let mut manifest = Manifest {
        token: String::new(),
        scenario: resources.scenario.clone(),
        set: common.set.clone(),
        parameters: arguments.parameters.clone(),
    };
    manifest.token = token(&manifest, &resources);
    let description = describe(&scene, &variables, &identifier, &manifest.token);
    if arguments.describe {
        output::print(description.trim_end())?;
        return Ok(Exit::Done);
    }
    let library = library::read(arguments.library.as_deref())?;
    prove(&resources, &manifest, &variables)?;
    let bytes = archive::archive(&description, &manifest, &resources, &library, &identifier)?;
    output::save(&out, &bytes)?;
    let counts = counts(&variables);
    if common.json {
        let counts = counts.iter().map(|(what, count)| ((*what).to_owned(), json!(count)));
        let mut answer = json!({
            "file": out.display().to_string(),
            "platform": library.platform,
            "token": manifest.token,
            "left_out": variables.left_out,
        });
        counts.for_each(|(what, count)| answer[what] = count);
        output::print(&Value::to_string(&answer))?;
    } else if !common.quiet {
        let word = |what: &'static str, count| if count == 1 { what.trim_end_matches('s') } else { what };
        let list: Vec<String> = counts.iter().map(|(what, count)| format!("{count} {}", word(what, *count))).collect();
        let heading = text::heading(&scene.model, &scene.scenario.name);
        output::print(&format!(
            "{heading}\n  variables    {}\n  platform     {}\n  wrote        {}",
            list.join(", "),
            library.platform,
            out.display()
        ))?;
    }
    Ok(Exit::Done)
}

/// `scenarios/arm.toml` → `arm.fmu`.
fn path(out: Option<&Path>, scenario: &Path) -> anyhow::Result<PathBuf> {
    let Some(out) = out else {
        let stem = scenario.file_stem().filter(|stem| *stem != "-").unwrap_or("scene".as_ref());
        return Ok(Path::new(stem).with_extension("fmu"));
    };
    match out.extension().is_some_and(|extension| extension == "fmu") {
        true => Ok(out.to_owned()),
        false => bail!("`{}`: the name of an FMU ends in .fmu", out.display()),
    }
}

/// The name of the file as a C identifier.
fn identifier(out: &Path) -> String {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    let name: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    match name.starts_with(|c: char| c.is_ascii_digit()) {
        true => format!("_{name}"),
        false => name,
    }
}

/// What ties description and resources together: a hash of all that the instances read.
fn token(manifest: &Manifest, resources: &Resources) -> String {
    let mut hash = Sha256::new();
    let mut add = |bytes: &[u8]| {
        hash.update(bytes.len().to_le_bytes());
        hash.update(bytes);
    };
    add(env!("CARGO_PKG_VERSION").as_bytes());
    add(manifest.to_json().as_bytes());
    for (name, bytes) in &resources.files {
        add(name.as_bytes());
        add(bytes);
    }
    hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}

/// Initializes an instance of what will be in the FMU, from a folder of its own: it finds all files there, and has the same variables.
fn prove(resources: &Resources, manifest: &Manifest, variables: &Variables) -> anyhow::Result<()> {
    let folder = tempfile::tempdir().context("there is no temporary folder")?;
    resources.write(folder.path()).context("the resources cannot be written to a temporary folder")?;
    std::fs::write(folder.path().join(MANIFEST), manifest.to_json())?;
    let of_copy = || "the scenario as it lies in the FMU is another one";
    let mut instance = Instance::new(folder.path(), &manifest.token).with_context(of_copy)?;
    instance.enter_initialization(None, 0.0, None)?;
    instance.exit_initialization().with_context(of_copy)?;
    let names = |variables: &Variables| variables.list.iter().map(|one| one.name.clone()).collect::<Vec<_>>();
    if names(instance.variables()) != names(variables) {
        bail!("{}", of_copy());
    }
    for reference in (0..).take(variables.list.len()) {
        instance.value(reference).with_context(of_copy)?;
    }
    Ok(())
}

fn counts(variables: &Variables) -> [(&'static str, usize); 3] {
    let count = |is: fn(&Role) -> bool| variables.list.iter().filter(|one| is(&one.role)).count();
    [
        ("inputs", count(|role| matches!(role, Role::Input(_)))),
        ("parameters", count(|role| matches!(role, Role::Parameter))),
        ("outputs", count(|role| matches!(role, Role::Position(_) | Role::Velocity(_) | Role::Output(_)))),
    ]
}
