//! Flexible beams.

mod bearing;
mod cables;
mod closed;
mod reference;
mod scenes;
mod standing;
mod statics;
mod sweeps;
