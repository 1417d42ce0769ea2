//! Runs: a model stepped through time, recorded, and checked to stay where it rests.

mod bordered;
mod choice;
pub mod events;
mod ledger;
mod passage;
pub mod precision;
pub mod problem;
pub mod rest;
mod run;
mod sampler;
mod scene;
pub mod settings;
mod stiffness;
mod stops;
pub mod verify;

pub use run::{RunError, State, Summary, run};
pub use scene::scene;
pub use settings::{Integrator, Settings, Start};
