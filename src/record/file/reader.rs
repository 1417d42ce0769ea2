//! Reading a recording: what it says beside its samples.

use super::chunks::{Records, Stop};
use super::*;
use crate::record::{RecordError, Scene};
use mcap::records::Record;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// A recording on disk, finished or not.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The file.
    pub path: PathBuf,
    /// The still part of the picture.
    pub scene: Scene,
    /// The scenario file, word for word.
    pub scenario: String,
    /// The statics result as JSON text, where the run started from an equilibrium.
    pub statics: Option<String>,
    /// The run's summary as JSON text; `None` when the run was killed or is still going on.
    pub outcome: Option<String>,
    /// Version of the program that wrote it.
    pub version: String,
    /// Whether the file is whole: written to its end and not cut since.
    pub complete: bool,
}

impl Recording {
    /// Reads what a file says beside its samples. The file is read once from front to back without unpacking; a killed
    /// run's file is read to its last whole chunk.
    ///
    /// # Errors
    /// When the file cannot be read, is not MCAP, is not one of ours, was written by a newer version, or ends before its
    /// description does.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        let mut records = Records::outline(open(path)?);
        let mut found = Found::default();
        let ended = loop {
            match records.next() {
                Some(Ok(record)) => found.take(record),
                Some(Err(stop)) => break Err(stop),
                None => break Ok(()),
            }
        };
        if let Err(Stop::Io(source)) = ended {
            return Err(RecordError::Read { path: path.into(), source });
        }
        found.into_recording(path, ended)
    }

    /// The samples, read from disk as they are asked for.
    ///
    /// # Errors
    /// When the file cannot be opened.
    pub fn samples(&self) -> Result<Samples, RecordError> {
        Ok(Samples::new(self.path.clone(), open(&self.path)?, &self.scene))
    }
}

pub(super) fn open(path: &Path) -> Result<BufReader<File>, RecordError> {
    let failed = |source| RecordError::Read { path: path.into(), source };
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(failed(std::io::ErrorKind::IsADirectory.into()));
    }
    Ok(BufReader::new(file))
}

/// What the scan met, before it is judged.
#[derive(Default)]
struct Found {
    any_record: bool,
    scenario: Option<String>,
    program: Option<std::collections::BTreeMap<String, String>>,
    scene: Option<String>,
    statics: Option<String>,
    outcome: Option<String>,
}

impl Found {
    fn take(&mut self, record: Record) {
        self.any_record = true;
        match record {
            Record::Attachment { header, data, .. } if header.name == SCENARIO => {
                self.scenario = Some(String::from_utf8_lossy(&data).into_owned());
            }
            Record::Metadata(mut metadata) => match metadata.name.as_str() {
                PROGRAM => self.program = Some(metadata.metadata),
                SCENE => self.scene = metadata.metadata.remove(JSON),
                STATICS => self.statics = metadata.metadata.remove(JSON),
                RUN => self.outcome = metadata.metadata.remove(JSON),
                _ => {}
            },
            _ => {}
        }
    }

    fn into_recording(self, path: &Path, ended: Result<(), Stop>) -> Result<Recording, RecordError> {
        let not_ours = |why: &str| RecordError::NotARecording { path: path.into(), why: why.into() };
        let Some(mut program) = self.program else {
            return Err(not_ours(match ended {
                _ if std::fs::metadata(path).is_ok_and(|file| file.len() == 0) => "the file is empty",
                Err(Stop::Truncated) => "it ends before its description",
                Err(_) if !self.any_record => "it is not an MCAP file",
                _ => "it is an MCAP file of another program: it has no metadata called `stillpoint`",
            }));
        };
        let format = program.remove("format").unwrap_or_default();
        if !format.parse::<u32>().is_ok_and(|format| format <= FORMAT) {
            let why = format!("its format is `{format}`, this version reads up to {FORMAT}; use a newer stillpoint");
            return Err(not_ours(&why));
        }
        let Some(scene) = self.scene else { return Err(not_ours("it ends before its description")) };
        let scene = read_scene(&scene)
            .map_err(|what| RecordError::Damaged { path: path.into(), what: format!("scene: {what}") })?;
        Ok(Recording {
            path: path.into(),
            scene,
            scenario: self.scenario.unwrap_or_default(),
            statics: self.statics,
            complete: ended.is_ok() && self.outcome.is_some(),
            outcome: self.outcome,
            version: program.remove("version").unwrap_or_default(),
        })
    }
}

fn read_scene(json: &str) -> Result<Scene, String> {
    let scene: Scene = serde_json::from_str(json).map_err(|error| error.to_string())?;
    let parents = scene.bodies.iter().filter_map(|body| body.parent);
    let ends = scene.lines.iter().flat_map(|line| &line.ends).filter_map(|(body, _)| *body);
    let loads = scene.loads.iter().map(|load| load.body);
    match parents.chain(ends).chain(loads).find(|index| *index >= scene.bodies.len()) {
        Some(index) => Err(format!("body {index} of {}", scene.bodies.len())),
        None => Ok(scene),
    }
}
