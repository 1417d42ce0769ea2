//! Recordings.

pub mod sample;
pub mod scene;

/// The `[record]` table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Samples per second of simulated time, > 0.
    pub rate: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { rate: 100.0 }
    }
}
