//! Studies: many cases of one scenario, one row each.
//!
//! ```text
//!  axes, distributions ─ Plan ─► values of case c ─► scenario ─► statics, run ─► row
//!                          │                                                     │
//!  seed, c ────────────────┘                                     columns: decided before the first case
//! ```
//!
//! | file | its one job |
//! |---|---|
//! | [`axis`] | the values of one number of a grid |
//! | [`distribution`] | how a number is distributed |
//! | [`sample`] | probabilities of a sample: random, Latin hypercube, [`sobol`]; correlated by [`correlation`] |
//! | [`plan`] | which cases there are |
//! | [`answer`] | the columns of an answer, and what stands in them |
//! | [`case`] | one case: its scene, its answer, its row, whatever happens on the way |
//! | `together` | cases whose runs are computed side by side |
//! | [`pool`] | threads over cases |
//! | [`fit`] | numbers of a scene that bring its answers closest to measurements |
//! | `dataset`, `parquet`, `reader` | rows on disk, written and read (feature `parquet`) |
//! | [`statistics`] | moments, quantiles, regression of a column on the inputs |
//! | [`additive`] | what the inputs do by themselves: functions of one of them each |
//! | [`variance`] | what each input explains alone: first-order Sobol indices |
//!
//! A row follows from plan, scenario and number of its case alone: it does not matter which thread, process or machine
//! computes it, nor in which order.

pub mod additive;
pub mod answer;
pub mod axis;
pub mod case;
mod clash;
pub mod column;
pub mod correlation;
#[cfg(feature = "parquet")]
pub mod dataset;
pub mod distribution;
pub mod fit;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod plan;
pub mod pool;
#[cfg(feature = "parquet")]
pub mod reader;
pub mod sample;
mod scenes;
pub mod sobol;
pub mod statistics;
mod together;
pub mod variance;

pub use answer::Question;
pub use axis::Axis;
pub use case::{Cases, Refusal, Row};
pub use column::{Cell, Column, Kind};
pub use plan::{Draw, Plan, Variation};
pub use sample::Sampling;
