//! A dataset on disk: a folder with a manifest and Parquet parts, each there whole or not at all.
//!
//! | file | holds |
//! |---|---|
//! | `_study.json` | the manifest: plan, scenario, columns, and the hash of all that the rows follow from |
//! | `part-0000012.parquet` | the rows of part 12 |
//!
//! Part `p` has the cases `p r … (p + 1) r − 1`, `r` being the rows of a part, so that which parts there are does not
//! depend on who writes them. A part that is there is done. Several processes may write one dataset: the manifest is made
//! by the first and has to be the same for all others, and a part that two of them write has the same rows.

use super::answer::Question;
use super::case::{Cases, Row};
use super::column::Column;
use super::parquet::{self, Origin};
use super::pool::Part;
use crate::model::shape::Geometry;
use crate::spatial::lanes::WIDTH;
use crate::whole_file::{self, WholeFile};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The name of the manifest.
pub const MANIFEST: &str = "_study.json";

/// Counts up when the meaning of a column or of a plan changes.
const FORMAT: u32 = 1;

/// Rows of a part at most.
const MOST_ROWS: u64 = 10_000;
/// Cells of a part at most: what a thread holds in memory (24 bytes each).
const MOST_CELLS: u64 = 1 << 18;
/// Parts of a small study: what a kill can lose is a hundredth of it.
const PARTS: u64 = 100;

/// Why a dataset cannot be begun, continued or written.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// A dataset of the same plan is there.
    #[error("`{0}` holds a dataset of this plan already: `--resume` continues it, another folder begins a new one")]
    Exists(PathBuf),
    /// A dataset of another plan is there.
    #[error(
        "`{folder}` holds a dataset of another plan (hash {there}, this one has {here}): scenario, plan, options or program \
         have changed; choose another folder"
    )]
    Other {
        /// The folder.
        folder: PathBuf,
        /// The hash in its manifest.
        there: String,
        /// The hash of the plan.
        here: String,
    },
    /// The folder has Parquet files of something else.
    #[error(
        "`{0}` holds Parquet files and no `{MANIFEST}`: they would be read as rows of the dataset; choose another folder"
    )]
    Foreign(PathBuf),
    /// The manifest is none.
    #[error("`{0}` is no manifest of a dataset: {1}")]
    Manifest(PathBuf, String),
    /// A file cannot be read or written.
    #[error("cannot write `{0}`: {1}")]
    Write(PathBuf, #[source] io::Error),
    /// A file is there that would be read as rows.
    #[error("`{0}` is no part of this dataset: {1}; move it away")]
    Beside(PathBuf, String),
    /// A part is there and has other rows.
    #[error("`{0}` is no part of this dataset: {1}; move it away, and `--resume` computes the part")]
    Stray(PathBuf, String),
    /// A part is there and cannot be read.
    #[error("`{0}` is damaged: {1}; delete it, and `--resume` computes it again")]
    Damaged(PathBuf, String),
    /// A part cannot be written.
    #[error("`{0}`: {1}")]
    Part(PathBuf, #[source] ::parquet::errors::ParquetError),
}

/// A dataset of a study.
#[derive(Debug)]
pub struct Dataset {
    folder: PathBuf,
    /// Of all that the rows follow from.
    pub hash: String,
    columns: Vec<Column>,
    cases: u64,
    /// Rows of a part.
    pub rows: u64,
}

impl Dataset {
    /// The dataset of a study in a folder; nothing is written yet. `rows` are those of a part, if not as many as fit.
    ///
    /// # Errors
    /// If a file that the scenario names cannot be read.
    pub fn new(folder: &Path, cases: &Cases, rows: Option<u64>) -> Result<Self, DatasetError> {
        let count = cases.plan.cases();
        let fit = MOST_ROWS.min((MOST_CELLS / cases.columns().len() as u64).max(1));
        // What is computed side by side is in one part.
        let beside = if cases.may_go_together() { WIDTH as u64 } else { 1 };
        let rows = rows.unwrap_or(count.div_ceil(PARTS).clamp(1, fit).next_multiple_of(beside));
        let hash = hash(cases, rows)?;
        Ok(Self { folder: folder.to_owned(), hash, columns: cases.columns().to_vec(), cases: count, rows })
    }

    /// Makes the folder and the manifest, or finds them there. A dataset that is there is continued only if `continues`.
    ///
    /// # Errors
    /// As [`is_there`](Self::is_there), and if the folder cannot be written.
    pub fn begin(&self, cases: &Cases, continues: bool) -> Result<(), DatasetError> {
        let manifest = self.folder.join(MANIFEST);
        let is_there = self.is_there()?;
        if continues {
            self.remove_abandoned();
        }
        let found = || if continues { Ok(()) } else { Err(DatasetError::Exists(self.folder.clone())) };
        if is_there {
            return found();
        }
        let failed = |error| DatasetError::Write(manifest.clone(), error);
        fs::create_dir_all(&self.folder).map_err(|error| DatasetError::Write(self.folder.clone(), error))?;
        let mut file = Self::locked(&manifest).map_err(failed)?;
        // At once: each of its numbers by itself is a call of the system.
        file.write_all(format!("{:#}\n", self.manifest(cases)).as_bytes()).map_err(failed)?;
        match file.finish_new() {
            // Somebody was faster: it has to be the same.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && self.is_there()? => found(),
            other => other.map_err(failed),
        }
    }

    /// Whether the folder holds this dataset.
    ///
    /// # Errors
    /// If it holds another one, or Parquet files that are no parts of it.
    pub fn is_there(&self) -> Result<bool, DatasetError> {
        // Before the manifest: parts of another process, which has just begun the dataset, come after theirs.
        let files = match files(&self.folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            other => other.map_err(|error| DatasetError::Manifest(self.folder.clone(), error.to_string()))?,
        };
        if !self.has_manifest()? {
            return if files.is_empty() { Ok(false) } else { Err(DatasetError::Foreign(self.folder.clone())) };
        }
        for path in files {
            number(&path, self.parts()).map_err(|why| DatasetError::Beside(path, why))?;
        }
        Ok(true)
    }

    /// Whether the manifest of this dataset is there.
    fn has_manifest(&self) -> Result<bool, DatasetError> {
        let path = self.folder.join(MANIFEST);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound) => return Ok(false),
            Err(error) => return Err(DatasetError::Manifest(path, error.to_string())),
        };
        let manifest: Value =
            serde_json::from_str(&text).map_err(|error| DatasetError::Manifest(path.clone(), error.to_string()))?;
        match manifest["hash"].as_str() {
            Some(hash) if hash == self.hash => Ok(true),
            Some(hash) => Err(DatasetError::Other {
                folder: self.folder.clone(),
                there: hash.chars().take(12).collect(),
                here: self.hash.chars().take(12).collect(),
            }),
            None => Err(DatasetError::Manifest(path, "it has no `hash`".to_owned())),
        }
    }

    fn manifest(&self, cases: &Cases) -> Value {
        let Question { run, time_limit } = cases.question;
        let columns = self.columns.iter();
        let columns = columns.map(|one| json!({ "name": one.name, "kind": one.kind.name(), "unit": one.unit }));
        let plan = &cases.plan;
        json!({
            "format": FORMAT,
            "hash": self.hash,
            "stillpoint": env!("CARGO_PKG_VERSION"),
            "scenario": cases.scenario().name,
            "inputs": plan.paths().collect::<Vec<_>>(),
            "over": plan.axes.iter().map(|axis| json!({ "path": axis.path, "values": axis.values })).collect::<Vec<_>>(),
            "vary": plan.varied.iter().map(|one| format!("{}={}", one.path, one.distribution)).collect::<Vec<_>>(),
            "sample": plan.draw.sampling.name(),
            "cases_per_point": plan.draw.samples,
            "seed": plan.draw.seed,
            "run": run,
            "time_limit": time_limit.is_finite().then_some(time_limit),
            "side_by_side": cases.width(),
            "cases": self.cases,
            "rows_per_part": self.rows,
            "parts": self.parts(),
            "columns": columns.collect::<Vec<_>>(),
            "text": cases.scenario().text,
        })
    }

    /// Number of parts.
    pub fn parts(&self) -> u64 {
        self.cases.div_ceil(self.rows)
    }

    /// A part and its cases.
    pub fn part(&self, part: u64) -> Part {
        (part, part * self.rows..((part + 1) * self.rows).min(self.cases))
    }

    fn path(&self, part: u64) -> PathBuf {
        self.folder.join(name(part))
    }

    /// Whether a part is done.
    pub fn is_done(&self, part: u64) -> bool {
        self.path(part).exists()
    }

    /// Writes a part.
    ///
    /// # Errors
    /// If it cannot be written; then it is not there.
    pub fn write(&self, part: u64, rows: &[Row]) -> Result<(), DatasetError> {
        let path = self.path(part);
        let failed = |error| DatasetError::Write(path.clone(), error);
        let bytes = parquet::encoded(&self.columns, rows, &self.origin(part));
        let bytes = bytes.map_err(|error| DatasetError::Part(path.clone(), error))?;
        let mut file = Self::locked(&path).map_err(failed)?;
        file.write_all(&bytes).and_then(|()| file.finish()).map_err(failed)
    }

    /// A file of the dataset, under another name and locked for as long as it is written: [`remove_abandoned`](Self::remove_abandoned)
    /// leaves it alone.
    fn locked(path: &Path) -> io::Result<WholeFile> {
        loop {
            let file = WholeFile::create(path)?;
            let handle = file.handle()?;
            // Where there are no locks nobody removes anything.
            if handle.lock().is_err() || whole_file::is_still(&handle, file.path())? {
                return Ok(file);
            }
            file.abandon();
        }
    }

    /// Removes unfinished parts and manifests that nobody writes any more: those of processes that were killed.
    fn remove_abandoned(&self) {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().filter_map(Result::ok);
        let ours = |name: &str| {
            let part = name.starts_with("part-") && name.ends_with(".parquet.partial");
            part || name.starts_with("_study.") && name.ends_with("json.partial")
        };
        for entry in entries.filter(|entry| entry.file_name().to_str().is_some_and(ours)) {
            let path = entry.path();
            // By now the name may be that of a new file, which somebody writes: nobody else removes or renames what is locked here.
            if let Ok(file) = File::options().write(true).open(&path)
                && file.try_lock().is_ok()
                && whole_file::is_still(&file, &path).is_ok_and(|still| still)
            {
                // If it cannot be removed it does no harm.
                let _ = fs::remove_file(&path);
            }
        }
    }

    /// Where the rows of a part come from.
    fn origin(&self, part: u64) -> Origin {
        Origin { study: self.hash.clone(), cases: self.part(part).1 }
    }

    /// Refuses parts that are there and say that they come from elsewhere; how many do not say that or have no sum, as those of earlier
    /// versions.
    ///
    /// # Errors
    /// The first of them.
    pub fn refuse_strays(&self, parts: impl Iterator<Item = u64>) -> Result<u64, DatasetError> {
        let mut silent = 0;
        for part in parts.filter(|part| self.is_done(*part)) {
            let path = self.path(part);
            // What cannot be read is told of by whoever needs it.
            let Ok(told) = File::open(&path).map_err(Into::into).and_then(parquet::told) else {
                continue;
            };
            let says = self.origin(part).check(&told);
            silent += u64::from(!says.map_err(|why| DatasetError::Stray(path, why))?);
        }
        Ok(silent)
    }

    /// How many cases failed in a part that is done.
    ///
    /// # Errors
    /// If it cannot be read, comes from elsewhere, or has not as many rows as it should.
    pub fn failed(&self, part: u64) -> Result<u64, DatasetError> {
        let path = self.path(part);
        let damaged = |why: String| DatasetError::Damaged(path.clone(), why);
        let told = File::open(&path).map_err(Into::into).and_then(parquet::told);
        let told = told.map_err(|error| damaged(error.to_string()))?;
        self.origin(part).check(&told).map_err(|why| DatasetError::Stray(path.clone(), why))?;
        let none = "it does not say how many cases failed: it is no part of a study";
        let failed = told.failed.ok_or_else(|| damaged(none.to_owned()))?;
        match self.part(part).1.count() as u64 {
            wanted if wanted == told.rows => Ok(failed),
            wanted => Err(damaged(format!("it has {} rows, not {wanted}", told.rows))),
        }
    }
}

/// The Parquet files of a folder, in order.
pub(super) fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?;
    let mut files: Vec<PathBuf> =
        paths.into_iter().filter(|path| path.extension() == Some("parquet".as_ref())).collect();
    files.sort();
    Ok(files)
}

fn name(part: u64) -> String {
    format!("part-{part:07}.parquet")
}

/// The number of a file among so many parts.
pub(super) fn number(path: &Path, parts: u64) -> Result<u64, String> {
    let called = path.file_name().and_then(|called| called.to_str());
    let digits = called.and_then(|called| called.strip_prefix("part-")?.strip_suffix(".parquet"));
    let number = digits.and_then(|digits| digits.parse().ok());
    let number = number.filter(|part| *part < parts && called == Some(&name(*part)));
    number.ok_or_else(|| match parts {
        1 => format!("its only part is called {}", name(0)),
        _ => format!("its parts are called {} to {}", name(0), name(parts - 1)),
    })
}

/// Of all that the rows follow from: program, plan, question, scenario with everything that it reads, columns.
fn hash(cases: &Cases, rows: u64) -> Result<String, DatasetError> {
    let mut hash = Sha256::new();
    let mut add = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    add(format!("stillpoint {} study {FORMAT}", env!("CARGO_PKG_VERSION")).as_bytes());
    add(cases.plan.text().as_bytes());
    add(format!("{:?} {rows}", cases.question).as_bytes());
    cases.sources().iter().for_each(|source| add(source.as_bytes()));
    let shapes = cases.scenario().description.bodies.iter().flat_map(|body| &body.shapes);
    for shape in shapes {
        if let Geometry::Mesh { file, .. } = &shape.geometry {
            add(&fs::read(file).map_err(|error| DatasetError::Write(file.clone(), error))?);
        }
    }
    cases.columns().iter().for_each(|column| add(format!("{column:?}").as_bytes()));
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}
