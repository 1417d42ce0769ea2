//! The picture in the Rerun viewer: of a run while it goes on, and of a recording.
//!
//! Both ways draw the same: bodies as solids under `/world`, springs under `/springs`, energies and hinge coordinates
//! as curves, all on the timeline `sim_time`. The viewer computes in single precision: it is for looking, never for
//! checking numbers.
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
mod curves;
#[cfg(feature = "rerun")]
mod layout;
#[cfg(feature = "rerun")]
mod link;
#[cfg(feature = "rerun")]
mod picture;
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
