//! The files of a scenario, as they lie beside each other.
//!
//! Names within the scenario stay as they are: all files are laid out from the deepest folder that holds all of them, and what is named
//! from elsewhere (by an absolute path, or as a file of a package) is refused.

use super::super::inputs::Inputs;
use crate::scenario::{Scenario, parse};
use anyhow::{Context, bail};
use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path, PathBuf};

pub(super) struct Resources {
    /// The scenario file among them.
    pub(super) scenario: String,
    /// Names, with `/` between folders, and contents.
    pub(super) files: BTreeMap<String, Vec<u8>>,
}

impl Resources {
    /// The resources of a scenario that was read from `path`, with all files that it takes.
    ///
    /// # Errors
    /// If one of them cannot be read, or would not be found from another folder.
    pub(super) fn of(scenario: &Scenario, path: &Path, read: &Inputs) -> anyhow::Result<Self> {
        let of_model = std::fs::read_to_string(path).is_ok_and(|text| text != scenario.text);
        let path = match path.as_os_str() == "-" {
            true => PathBuf::from("scene.toml"),
            // The scenario that takes nothing but this model stands beside it.
            false if of_model => path.with_extension("toml"),
            false => path.to_owned(),
        };
        let own = plain(&path)?;
        let mut found = BTreeMap::from([(own.clone(), scenario.text.clone().into_bytes())]);
        for file in read.paths().filter(|file| **file != path && file.is_file()) {
            let bytes = std::fs::read(file).with_context(|| format!("cannot read `{}`", file.display()))?;
            found.entry(plain(file)?).or_insert(bytes);
        }
        let shared = shared(found.keys());
        let name = |path: &Path| -> String {
            let parts = path.strip_prefix(&shared).unwrap_or(path).components();
            parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
        };
        let all = Self {
            scenario: name(&own),
            files: found.iter().map(|(path, bytes)| (name(path), bytes.clone())).collect(),
        };
        all.check(&scenario.text)?;
        Ok(all)
    }

    /// Writes them into a folder.
    pub(super) fn write(&self, folder: &Path) -> io::Result<()> {
        for (name, bytes) in &self.files {
            let path = folder.join(name);
            path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
            std::fs::write(path, bytes)?;
        }
        Ok(())
    }

    /// Whether the scenario finds all its files from another folder.
    fn check(&self, text: &str) -> anyhow::Result<()> {
        if self.files.len() == 1 {
            return Ok(());
        }
        let folder = tempfile::tempdir().context("there is no temporary folder")?;
        self.write(folder.path()).context("the resources cannot be written to a temporary folder")?;
        let name = folder.path().join(&self.scenario).display().to_string();
        let copy = parse(&name, text, &[]);
        let copy = copy.map_err(|problems| anyhow::anyhow!("{}", problems.render(false).trim_end().to_owned()))?;
        for file in Inputs::files(&copy).filter(|file| file.is_file()) {
            if !plain(&file)?.starts_with(plain(folder.path())?) {
                bail!(
                    "`{}` is not found from within an FMU\nhint: name it by a path from the scenario file, not by an absolute one or as a file of a package",
                    file.display()
                );
            }
        }
        Ok(())
    }
}

/// An absolute path without `.` and `..`, links not followed.
fn plain(path: &Path) -> anyhow::Result<PathBuf> {
    let absolute = std::path::absolute(path).with_context(|| format!("`{}` has no absolute path", path.display()))?;
    let mut plain = PathBuf::new();
    for part in absolute.components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            Component::CurDir => {}
            other => plain.push(other),
        }
    }
    Ok(plain)
}

/// The deepest folder that holds all files.
fn shared<'p>(files: impl Iterator<Item = &'p PathBuf>) -> PathBuf {
    let folders = files.filter_map(|file| file.parent().map(Path::to_owned));
    let both = |one: PathBuf, other: PathBuf| -> PathBuf {
        let parts = one.components().zip(other.components()).take_while(|(a, b)| a == b);
        parts.map(|(part, _)| part).collect()
    };
    folders.reduce(both).unwrap_or_default()
}
