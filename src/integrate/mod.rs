//! Time stepping. Knows nothing of mechanics.

pub mod problem;
