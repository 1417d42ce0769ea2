//! Reading a recording: everything but its samples.

use super::chunks::{Records, Stop};
use super::*;
use crate::record::{ContactInstants, Event, RecordError, Scene, scene};
use mcap::records::Record;
use std::fs::File;
use std::io::{self, BufReader};
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
    /// What is missing, as JSON text, where this is what could be saved of another recording.
    pub recovered: Option<String>,
    /// Version of the program that wrote it.
    pub version: String,
    /// Whether the recording is whole: the run was recorded to its end, and the file was not cut since.
    pub complete: bool,
}

/// How a recording ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The run reached its end.
    Complete,
    /// The run was stopped by a person, in good order.
    Interrupted,
    /// The run could not go on.
    Failed,
    /// This is what was saved of another recording.
    Recovered,
    /// The run was killed or is still going on, or the file lost its end.
    Cut,
}

impl Ending {
    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Interrupted => "interrupted",
            Self::Failed => "failed",
            Self::Recovered => "recovered",
            Self::Cut => "cut",
        }
    }
}

impl Recording {
    /// Reads everything but the samples of a file. The file is read once from front to back without unpacking; a killed
    /// run's file is read to its last whole chunk.
    ///
    /// # Errors
    /// When the file cannot be read, is not MCAP, is not one of ours, was written by a newer version, or ends before its
    /// description does.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        let (source, bytes) = open(path)?;
        let mut records = Records::outline(source, bytes);
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

    /// How it ended.
    pub fn ending(&self) -> Ending {
        if self.recovered.is_some() {
            return Ending::Recovered;
        }
        if !self.complete {
            return Ending::Cut;
        }
        let summary = self.outcome.as_deref().and_then(|json| serde_json::from_str::<serde_json::Value>(json).ok());
        match summary.unwrap_or_default() {
            summary if summary.get("error").is_some_and(|error| !error.is_null()) => Ending::Failed,
            summary if summary["interrupted"] == true => Ending::Interrupted,
            _ => Ending::Complete,
        }
    }

    /// The samples, read from disk as they are asked for.
    ///
    /// # Errors
    /// When the file cannot be opened.
    pub fn samples(&self) -> Result<Samples, RecordError> {
        let (source, bytes) = open(&self.path)?;
        Ok(Samples::new(self.path.clone(), Records::contents(source, bytes), &self.scene))
    }

    /// What happened in the run, in the order it was written; the whole file is read.
    ///
    /// # Errors
    /// When the file cannot be read or its content is wrong.
    pub fn events(&self) -> Result<Vec<Event>, RecordError> {
        let (source, bytes) = open(&self.path)?;
        events::read(Records::contents(source, bytes))
            .map_err(|what| RecordError::Damaged { path: self.path.clone(), what })
    }

    /// What contacts pushed with: times of samples (s), and what bore then, one and the same list where nothing changed; the whole file is
    /// read.
    ///
    /// # Errors
    /// When the file cannot be read or its content is wrong.
    pub fn contacts(&self) -> Result<ContactInstants, RecordError> {
        let (source, bytes) = open(&self.path)?;
        contacts::read(Records::contents(source, bytes))
            .map_err(|what| RecordError::Damaged { path: self.path.clone(), what })
    }
}

/// The file and its length (bytes).
pub(super) fn open(path: &Path) -> Result<(BufReader<File>, u64), RecordError> {
    let failed = |source| RecordError::Read { path: path.into(), source };
    // Asked before it is opened: opening a pipe waits for its writer.
    let about = std::fs::metadata(path).map_err(failed)?;
    if about.is_dir() {
        return Err(failed(io::ErrorKind::IsADirectory.into()));
    }
    if !about.is_file() {
        return Err(failed(io::Error::other("it is a device or a pipe, and a recording is read more than once")));
    }
    let file = File::open(path).map_err(failed)?;
    Ok((BufReader::new(file), about.len()))
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
    recovered: Option<String>,
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
                RECOVERED => self.recovered = metadata.metadata.remove(JSON),
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
        let scene = scene::parse(&scene)
            .map_err(|what| RecordError::Damaged { path: path.into(), what: format!("scene: {what}") })?;
        Ok(Recording {
            path: path.into(),
            scene,
            scenario: self.scenario.unwrap_or_default(),
            statics: self.statics,
            complete: ended.is_ok() && self.outcome.is_some() && self.recovered.is_none(),
            outcome: self.outcome,
            recovered: self.recovered,
            version: program.remove("version").unwrap_or_default(),
        })
    }
}
