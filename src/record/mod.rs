//! Recordings: what a run leaves behind, and how it is looked at.
//!
//! A run hands every [`Sample`] to one [`Recorder`]:
//!
//! - [`Memory`] keeps the samples, for tests and reports;
//! - [`FileWriter`] writes an MCAP file (see [`mod@file`] for what is in it), [`Recording`] reads it back;
//! - [`view::Viewer`] draws into the Rerun viewer or into an `.rrd` file;
//! - [`Fanout`] feeds several of them, and lets none but the first stop the run.
//!
//! [`view::view`] plays a recording file into the same picture that a running simulation draws.
//!
//! Files and pictures need the feature `record`, and pictures `view`; samples in memory need neither.
//!
//! Nothing here knows how a simulation works, and nothing outside `file` and `view` knows MCAP or Rerun.

pub mod beam;
mod contact;
#[cfg(feature = "record")]
mod contact_table;
#[cfg(feature = "record")]
pub mod drawing;
mod error;
mod event;
mod fanout;
#[cfg(feature = "record")]
pub mod file;
#[cfg(feature = "record")]
mod footage;
#[cfg(feature = "record")]
mod form;
#[cfg(feature = "record")]
pub mod gltf;
mod memory;
mod meshes;
#[cfg(feature = "record")]
pub mod picture;
pub mod sample;
pub mod scene;
#[cfg(feature = "record")]
mod solids;
#[cfg(feature = "record")]
mod stems;
#[cfg(feature = "record")]
pub mod table;
#[cfg(feature = "record")]
mod tubes;
#[cfg(feature = "record")]
pub mod view;

pub use contact::{ContactInstants, ContactPush};
#[cfg(feature = "record")]
pub use contact_table::ContactTable;
pub use error::RecordError;
pub use event::Event;
pub use fanout::Fanout;
#[cfg(feature = "record")]
pub use file::{FileWriter, Recording, RecordingFile, Samples};
#[cfg(feature = "record")]
pub use footage::{Beyond, Footage, Moment, mode_name};
pub use memory::Memory;
pub use sample::{Energy, OwnedSample, Sample};
pub use scene::Scene;
#[cfg(feature = "record")]
pub use table::Table;
#[cfg(feature = "record")]
pub use tubes::Tubes;

/// The `[record]` table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Samples per second of simulated time, > 0.
    pub rate: f64,
    /// Whether the scene is told to programs that know ROS, too; see [`RecordingFile::with_ros`].
    pub ros: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { rate: 100.0, ros: false }
    }
}

/// What is known before the first sample.
#[derive(Debug, Clone, Copy)]
pub struct Opening<'a> {
    /// The still part of the picture; says how long the arrays of every sample are.
    pub scene: &'a Scene,
    /// The scenario file, word for word.
    pub scenario: &'a str,
    /// The statics result as JSON text, where the run started from an equilibrium.
    pub statics: Option<&'a str>,
}

/// What is known after the last sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outcome {
    /// The run's summary as JSON text.
    pub summary: String,
}

/// Takes the samples of a run. Constructing one opens what has to be opened and writes what is known before.
pub trait Recorder {
    /// Takes one sample. Times must not decrease.
    ///
    /// # Errors
    /// When the arrays do not fit the scene, or when the sample cannot be kept (disk full, viewer gone).
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError>;

    /// Marks an event, after the samples before it. Not every recorder has a use for them.
    ///
    /// # Errors
    /// When the mark cannot be kept.
    fn event(&mut self, _event: &Event) -> Result<(), RecordError> {
        Ok(())
    }

    /// Takes what contacts push with at the time of the sample that follows (s); of scenes with contact alone. Not every recorder has a
    /// use for it.
    ///
    /// # Errors
    /// When it cannot be kept.
    fn contacts(&mut self, _time: f64, _contacts: &[ContactPush]) -> Result<(), RecordError> {
        Ok(())
    }

    /// Between two steps of a run, after the samples and events of the first: the next ones may take long to come.
    ///
    /// # Errors
    /// When what was taken cannot be kept.
    fn pause(&mut self) -> Result<(), RecordError> {
        Ok(())
    }

    /// Ends the recording: of a run that reached its end and of one that was stopped alike. Later calls do nothing.
    ///
    /// # Errors
    /// When the end cannot be written; what was kept before stays readable.
    fn finish(&mut self, outcome: &Outcome) -> Result<(), RecordError>;
}
