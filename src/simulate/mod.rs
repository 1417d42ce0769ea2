//! Runs: a model stepped through time, recorded, and checked to stay where it rests.

mod asked;
mod checks;
mod choice;
mod contact;
pub mod control;
mod coordinates;
mod entry;
mod error;
pub mod events;
mod implicit;
mod passage;
pub mod problem;
mod resting;
mod run;
mod samples;
pub mod settings;
mod staged;
mod state;
mod stiffness;
mod stops;

pub use checks::{precision, rest, verify};
pub use entry::{run, run_controlled, scene};
pub use error::RunError;
pub use resting::check;
pub use run::Summary;
pub use run::together::{covers as runs_together, run_together};
pub use samples::outputs;
pub use settings::{Grid, Integrator, Resume, Settings, Start};
pub use staged::at_stage;
pub use state::State;
