//! Statics: where the system stays. Finds `q` with q̈(q, 0) = 0, proves it, and says what kind of equilibrium it is.
//!
//! | folder | its one job |
//! |---|---|
//! | `problem` | forces, stiffness and potential of the free coordinates, of closed positions where there are loops |
//! | `certify` | whether a residual proves an equilibrium, what kind it is, what holds it |
//! | `search` | from a guess to an equilibrium: the stages, and their cascade |
//! | `baseline` | two methods to compare with: dynamic relaxation, and Lagrange's equations of the first kind |
//! | [`path`] | an equilibrium followed while one number of the scene moves |
//! | `sensitivity` | how much every number of the scene moves an equilibrium, its outputs and frequencies |
//!
//! If the pose is given and inputs are unknown, `inverse` finds those; `aim` finds those that give outputs of the equilibrium.
//!
//! The search and the baselines end with Newton steps until round-off. Nothing is called an equilibrium unless its residual says
//! so.

mod aim;
pub mod answer;
mod baseline;
mod certify;
mod effort;
mod family;
mod inverse;
mod outputs;
pub mod path;
mod problem;
mod search;
mod sensitivity;
pub mod settings;
pub mod standing;
mod watch;

pub use answer::answer;
pub use certify::damped::DampedMode;
pub use certify::equilibrium::{BearingStop, Equilibrium};
pub use certify::modes::NaturalMode;
pub use certify::stability::{Stability, StabilityVerdict, most_modes};
pub use effort::{Iteration, Stage};
pub use inverse::{InverseAnswer, hold};
pub use outputs::{beams, diagrams, outputs};
pub use search::{Balance, Observers, Residual, balance, equilibrium, equilibrium_observed};
pub use sensitivity::{Influence, Response, Sensitivities, SensitivityError, idle_stops, influences, sensitivities};
pub use settings::{Aim, Method, Settings, Sought, Want};
