//! Flexible beams.

mod statics;
mod sweeps;
