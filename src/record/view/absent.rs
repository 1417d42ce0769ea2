//! What stands here when the `view` feature is left out.

use super::{Shown, Sink, Wishes};
use crate::record::{Opening, Outcome, RecordError, Recorder, Sample};
use std::path::Path;

/// A recorder that draws; never constructed in this build.
#[derive(Debug)]
pub struct Viewer {
    never: std::convert::Infallible,
}

impl Viewer {
    /// Always an error in this build.
    ///
    /// # Errors
    /// Always.
    pub fn open(_sink: &Sink, _opening: &Opening) -> Result<Self, RecordError> {
        Err(absent())
    }

    /// What the picture leaves out, in words.
    pub fn notes(&self) -> &[String] {
        match self.never {}
    }
}

impl Recorder for Viewer {
    fn sample(&mut self, _sample: &Sample) -> Result<(), RecordError> {
        match self.never {}
    }

    fn finish(&mut self, _outcome: &Outcome) -> Result<(), RecordError> {
        match self.never {}
    }
}

/// Always an error in this build.
///
/// # Errors
/// Always.
pub fn view(_recording: &Path, _sink: &Sink, _wishes: &Wishes) -> Result<Shown, RecordError> {
    Err(absent())
}

fn absent() -> RecordError {
    RecordError::View {
        what: "this program was built without the `view` feature".into(),
        hint: "build it with the feature (it is on by default), or open the MCAP recording in Foxglove or Lichtblick"
            .into(),
    }
}
