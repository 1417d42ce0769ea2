//! Flexible beams.

mod scenes;
mod statics;
mod sweeps;
