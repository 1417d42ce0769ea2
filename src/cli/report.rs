//! `report`: one page that opens anywhere, without a network.

mod curves;
pub(super) mod material;
mod page;
mod tables;
pub(super) mod words;

use super::inputs::Inputs;
use super::output::{Interrupt, Work};
use super::{Common, Exit, output};
use anyhow::bail;
use clap::Args;
use material::Material;
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A scenario, which is run first, or a recording (.mcap)
    #[arg(value_name = "SCENARIO|RECORDING")]
    source: PathBuf,
    /// Where the page goes
    #[arg(long, short = 'o', value_name = "FILE.html")]
    out: PathBuf,
    /// Of a scenario: its equilibrium alone, without a run
    #[arg(long)]
    statics: bool,
    /// Of a scenario: run once more, tighter and by another method, and say what the run is wrong by at its end
    #[arg(long, conflicts_with = "statics")]
    verify: bool,
    /// Change a value of the scenario, as `simulate.duration=2`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Read mesh files of a recording wherever it says that they are, not only in its own folder
    #[arg(long)]
    meshes: bool,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
    /// What the page says it was made by, in place of this command
    #[arg(long, hide = true, value_name = "TEXT")]
    called: Option<String>,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    if arguments.out.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("html")) {
        bail!("`{}`: the name of a report ends in .html", arguments.out.display());
    }
    Inputs::new([arguments.source.as_path()]).spare(&arguments.out)?;
    let mut material = match arguments.gather()? {
        Ok(material) => material,
        Err(exit) => return Ok(exit),
    };
    material.called.clone_from(&arguments.called);
    let page = {
        let _work = arguments.work("writing", &arguments.out);
        write(&material, &arguments.out)?
    };
    if !arguments.quiet {
        page.notes.iter().for_each(|note| output::note(note));
    }
    let file = arguments.out.display().to_string();
    if arguments.json {
        let verdict = words::verdict(&material);
        let said = json!({ "report": file, "bytes": page.text.len(), "verdict": verdict.text, "fine": verdict.fine });
        output::print(&said.to_string())?;
    } else if !arguments.quiet {
        let verdict = words::verdict(&material).text;
        output::print(&format!("{file}: {verdict} ({:.0} kB)", page.text.len() as f64 / 1e3))?;
    }
    Ok(if Interrupt::install()?.requested() { Exit::Interrupted } else { material.exit })
}

/// Writes the page whole or not at all.
pub(super) fn write(material: &Material, file: &Path) -> anyhow::Result<page::Page> {
    let page = page::page(material)?;
    output::save(file, page.text.as_bytes())?;
    Ok(page)
}

impl Arguments {
    fn work(&self, what: &str, file: &Path) -> Work {
        Work::new(format!("{what} {}", file.display()), self.quiet || self.json)
    }

    fn gather(&self) -> anyhow::Result<Result<Material, Exit>> {
        let is_recording =
            |path: &Path| path.extension().is_some_and(|extension| extension == "mcap" || extension == "partial");
        if is_recording(&self.source) {
            if self.statics || self.verify || !self.set.is_empty() {
                bail!(
                    "`--statics`, `--verify` and `--set` are for scenarios; `{}` is a recording",
                    self.source.display()
                );
            }
            let _work = self.work("reading", &self.source);
            return Ok(Ok(Material::of_recording(&self.source, self.meshes, self.quiet)?));
        }
        let common =
            Common { scenario: self.source.clone(), set: self.set.clone(), json: self.json, quiet: self.quiet };
        Material::of_scenario(&common, self.statics, self.verify)
    }
}
