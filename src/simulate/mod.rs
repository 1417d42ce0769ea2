//! Runs.

pub mod settings;
