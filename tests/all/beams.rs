//! Flexible beams.

mod cables;
mod closed;
mod scenes;
mod statics;
mod sweeps;
