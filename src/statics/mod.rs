//! Statics.

pub mod settings;
