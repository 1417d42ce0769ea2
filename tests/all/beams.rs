//! Flexible beams.

mod sweeps;
