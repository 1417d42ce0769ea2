//! Flexible beams.

mod bearing;
mod cables;
mod closed;
mod coarse;
mod reference;
mod scenes;
mod sliders;
mod standing;
mod statics;
mod sweeps;
