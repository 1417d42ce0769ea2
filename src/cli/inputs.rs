//! The files that a command reads: none of them is ever written by it.

use super::Common;
use crate::model::shape::Geometry;
use crate::scenario::Scenario;
use crate::whole_file;
use anyhow::bail;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Every file that a command reads.
#[derive(Debug, Default)]
pub(super) struct Inputs(Vec<PathBuf>);

impl Inputs {
    /// These files.
    pub(super) fn new<'p>(paths: impl IntoIterator<Item = &'p Path>) -> Self {
        Self(paths.into_iter().map(Path::to_owned).collect())
    }

    /// The scenario with its models and meshes, and the start file.
    pub(super) fn of_scenario(common: &Common, scenario: &Scenario, start: Option<&Path>) -> Self {
        let own = Some(common.scenario.as_path()).filter(|path| path.as_os_str() != "-");
        let mut all: Vec<PathBuf> =
            own.into_iter().chain(start).map(Path::to_owned).chain(Self::files(scenario)).collect();
        all.sort_unstable();
        all.dedup();
        Self(all)
    }

    /// The models, meshes and files of finite elements of a scenario.
    pub(super) fn files(scenario: &Scenario) -> impl Iterator<Item = PathBuf> {
        let models = scenario.models.iter().flat_map(|model| &model.sources).map(|source| source.path.clone());
        let shapes = scenario.description.bodies.iter().flat_map(|body| &body.shapes);
        let meshes = shapes.filter_map(|shape| match &shape.geometry {
            Geometry::Mesh { file, .. } => Some(file.clone()),
            _ => None,
        });
        let finite = scenario.description.modals.iter().filter_map(|modal| modal.file.clone());
        models.chain(meshes).chain(finite)
    }

    /// All of them.
    pub(super) fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.0.iter()
    }

    /// When each of them was last written, and how long it is; `None` of one that is not there.
    pub(super) fn stamps(&self) -> Vec<Option<(SystemTime, u64)>> {
        let stamp = |path: &PathBuf| {
            let about = std::fs::metadata(path).ok()?;
            Some((about.modified().ok()?, about.len()))
        };
        self.0.iter().map(stamp).collect()
    }

    /// Refuses an output that is one of these files, by whatever name or link.
    ///
    /// # Errors
    /// If writing it would replace an input.
    pub(super) fn spare(&self, output: &Path) -> anyhow::Result<()> {
        if let Some(input) = self.0.iter().find(|input| whole_file::is_same(input, output)) {
            bail!(
                "`{}` is not written: it would replace `{}`, which this command reads",
                output.display(),
                input.display()
            );
        }
        Ok(())
    }
}
