//! The picture in the Rerun viewer: of a run while it goes on, and of a recording.
//!
//! Both ways draw the same: bodies as solids under `/world`, springs under `/springs` (blue where they push, red where
//! they pull), constant loads as arrows under `/loads`, the centre of mass and its way; energies, hinge coordinates and
//! rates, the pull of springs and what drives, motors, gears and loops push as curves; what statics found as text, and
//! what happened as a log; all on the timeline `sim_time`. Of a recording it
//! is known before what moves and pulls how much; a running motion is drawn by what its first sample shows. The viewer
//! computes in single precision: it is for looking, never for checking numbers.
//!
//! Scenes of many bodies are drawn as few things, and of very many samples every second, fourth, … is drawn; `notes`
//! say so. The curves have them all.
//!
//! A viewer that is missing, slow or closed is an error in good time, never a wait without end: everything it is told
//! goes through a thread of its own.
//!
//! Built without the `rerun` feature, the functions here return an error that says so.

#[cfg(not(feature = "rerun"))]
mod absent;
#[cfg(feature = "rerun")]
mod bounds;
#[cfg(feature = "rerun")]
mod camera;
#[cfg(feature = "rerun")]
mod columns;
#[cfg(feature = "rerun")]
mod connect;
#[cfg(feature = "rerun")]
mod crowd;
#[cfg(feature = "rerun")]
mod curves;
#[cfg(feature = "rerun")]
mod forces;
#[cfg(feature = "rerun")]
mod layout;
#[cfg(feature = "rerun")]
mod link;
#[cfg(feature = "rerun")]
mod marks;
#[cfg(feature = "rerun")]
mod picture;
#[cfg(feature = "rerun")]
mod survey;
#[cfg(feature = "rerun")]
mod text;
#[cfg(feature = "rerun")]
mod viewer;

#[cfg(not(feature = "rerun"))]
pub use absent::{Viewer, view};
#[cfg(feature = "rerun")]
pub use viewer::{Viewer, view};

use std::path::PathBuf;

/// Where the picture goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Sink {
    /// To a viewer on this machine: the one that listens on the usual port, or a new one, reachable from this machine
    /// alone.
    Spawn,
    /// To a running viewer, such as `rerun+http://127.0.0.1:9876/proxy`; a bare `host:port` will do.
    Connect(String),
    /// To an `.rrd` file.
    Save(PathBuf),
}

/// What is asked of the picture of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wishes {
    /// One instant alone (s): the sample that is nearest.
    pub at: Option<f64>,
    /// What the hinges pass to the bodies, as arrows.
    pub reactions: bool,
    /// Mesh files from anywhere. A recording of somebody else may name any file: without this only those in its own folder
    /// are read.
    pub meshes: bool,
}

/// What was shown of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shown {
    /// Number of samples.
    pub samples: usize,
    /// Whether the recording is whole; a killed run's is shown as far as it goes.
    pub complete: bool,
    /// What the picture leaves out, in words.
    pub notes: Vec<String>,
}
