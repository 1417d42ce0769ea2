//! Cases whose answers come from outside the project: `tests/reference`. Each test reads parameters, initial state,
//! expected numbers and tolerance from the case's file and goes in by the front door, as scenario text.

pub(crate) mod case;
mod chains;
mod drives;
mod follower;
mod hard_cases;
mod loops;
mod pendulums;
mod scene;
mod several_equilibria;
mod speed;
mod springs;
mod stiff;
mod survey;
mod tensegrity;
mod tops;
