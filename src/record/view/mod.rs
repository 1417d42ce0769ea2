//! The picture in the Rerun viewer: of a run while it goes on, and of a recording.
//!
//! Both ways draw the same: bodies as solids under `/world`, springs under `/springs` (blue where they push, red where
//! they pull) and bushings beside them, loads as arrows under `/loads`, the centre of mass and its way; energies, hinge coordinates and
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
//! Built without the `view` feature, the functions here return an error that says so.

#[cfg(not(feature = "view"))]
mod absent;
#[cfg(feature = "view")]
mod beams;
#[cfg(feature = "view")]
mod bounds;
#[cfg(feature = "view")]
mod camera;
#[cfg(feature = "view")]
mod columns;
#[cfg(feature = "view")]
mod connect;
#[cfg(feature = "view")]
mod crowd;
#[cfg(feature = "view")]
mod curves;
#[cfg(feature = "view")]
mod entity;
#[cfg(feature = "view")]
mod forces;
#[cfg(feature = "view")]
mod layout;
#[cfg(feature = "view")]
mod link;
#[cfg(feature = "view")]
mod marks;
#[cfg(feature = "view")]
mod mounts;
#[cfg(feature = "view")]
mod picture;
#[cfg(feature = "view")]
mod remote;
#[cfg(feature = "view")]
mod sdk;
#[cfg(feature = "view")]
mod sent;
#[cfg(feature = "view")]
mod stream;
#[cfg(feature = "view")]
mod survey;
#[cfg(feature = "view")]
mod text;
#[cfg(feature = "view")]
mod viewer;

#[cfg(not(feature = "view"))]
pub use absent::{Viewer, view};
#[cfg(feature = "view")]
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
