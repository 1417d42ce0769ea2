//! A multibody simulator that starts at rest.

pub mod cli;
pub mod dynamics;
pub mod forces;
pub mod integrate;
pub mod model;
pub mod motion;
pub mod record;
pub mod scenario;
pub mod simulate;
pub mod spatial;
pub mod statics;
pub mod suggest;
pub mod transfer;
