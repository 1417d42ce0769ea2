//! What is simulated: immutable, validated, no numbers that change in time.

pub mod description;
pub mod problem;
pub mod shape;

pub use description::Description;
pub use problem::{Element, Problem};
