//! Flexible beams.

mod cables;
mod closed;
mod scenes;
mod standing;
mod statics;
mod sweeps;
