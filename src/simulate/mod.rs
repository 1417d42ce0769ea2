//! Runs: a model stepped through time, recorded, and checked to stay where it rests.
//!
//! | file | its one job |
//! |---|---|
//! | `entry` | runs of a scene as it is, or through its stages |
//! | [`settings`], `asked`, `state`, `error` | what a user asks of a run, what a run is given, where it is, and why it ended early |
//! | `run` | the time loop of one structure: steps, instants of controllers, transitions, contact; several models at once in `run/together` |
//! | `staged` | one run after the other, each of the structure of its stage |
//! | [`problem`] | a system as a problem of time stepping: the only place where mechanics and integrators meet |
//! | `choice`, `stiffness` | which method steps, and how fast the fastest motion is |
//! | `stride` | how far a step may go so that nothing on its way is overlooked |
//! | [`events`] | the functions that are watched, and the transition that is found first |
//! | `stops` | what stops and dry friction of hinges hold, and what follows at an instant |
//! | `contact` | bodies that touch: their rows, instants, events, and steps that capture many events |
//! | `mode` | the discrete state of a run as one value: what its stops, dry friction and contacts do |
//! | `resting` | scenes that contact holds at rest: nothing is integrated |
//! | `passage` | singular positions of loops, and how a run passes them |
//! | `implicit`, `coordinates` | Newton's matrices of implicit steps, and rates of hinge coordinates |
//! | [`control`] | controllers: what they set and remember, and when they act next |
//! | `samples` | what is told of a run, energies and outputs among it |
//! | `checks` | whether a run is right and gets anywhere |

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
mod mode;
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
mod stride;

pub use checks::{precision, rest, verify};
pub use entry::{run, run_controlled, scene};
pub use error::RunError;
pub use mode::Mode;
pub use resting::check;
pub use run::Summary;
pub use run::prepared::check_given;
pub use run::together::{covers as runs_together, run_together};
pub use samples::outputs;
pub use settings::{Grid, Integrator, Resume, Settings, Start, TOLERANCES};
pub use staged::at_stage;
pub use state::State;
