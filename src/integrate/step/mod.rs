//! What every method shares: how a run is started, how long a step is, when it is good enough, what lies between its ends.

pub(crate) mod control;
pub(crate) mod dense;
pub(crate) mod error;
pub(crate) mod norm;
pub(crate) mod options;
pub(crate) mod progress;
pub(crate) mod rates;
pub(crate) mod reach;
pub(crate) mod staged;
pub(crate) mod stages;
pub(crate) mod start;
pub(crate) mod statistics;
pub(crate) mod stepper;
