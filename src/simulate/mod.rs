//! Runs: a model stepped through time, recorded, and checked to stay where it rests.

mod bordered;
mod choice;
mod complementarity;
mod couplings;
mod dead_centre;
mod error;
pub mod events;
mod finite;
mod holding;
mod instant;
mod ledger;
mod nonsmooth;
mod occurrence;
pub mod outputs;
mod pace;
mod passage;
pub mod precision;
pub mod problem;
pub mod rest;
mod resting;
mod run;
mod sampler;
mod scene;
mod search;
pub mod settings;
mod state;
mod stiffness;
mod switching;
mod timetable;
pub mod verify;

pub use error::RunError;
pub use resting::check;
pub use run::{Summary, run};
pub use scene::scene;
pub use settings::{Grid, Integrator, Resume, Settings, Start};
pub use state::State;
