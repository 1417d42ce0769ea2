//! Flexible beams.

mod closed;
mod scenes;
mod statics;
mod sweeps;
