//! Statics: where the system stays. Finds `q` with q̈(q, 0) = 0, proves it, and says what kind of equilibrium it is.
//!
//! | want | loads have a potential | first stage |
//! |---|---|---|
//! | stable | yes | Newton within a trust region, down the potential; saddles are left |
//! | stable | no | Newton with line search; what runs away is left with the motion itself |
//! | any | either | Newton with line search: the nearest equilibrium, whatever it is |
//!
//! Where that fails, later stages of the [`cascade`] take over: continuation in the load, then dynamic relaxation.
//!
//! Two baselines stand beside it, to compare with: `relaxation` (explicit motion with kinetic damping) and `lagrange`
//! (maximal coordinates with multipliers). Neither uses the tangent of the tree, nor the steps that the others end with.
//!
//! Where the pose is given and inputs are unknown, `inverse` finds those.
//!
//! Each of the stages above ends with Newton steps until round-off. Nothing is called an equilibrium unless its residual says so.

pub mod answer;
mod assembled;
mod bordered;
mod bounded;
pub mod cascade;
mod cone;
mod copositive;
pub mod damped;
pub mod equilibrium;
pub mod inverse;
mod lagrange;
pub mod landscape;
mod linear;
mod newton;
pub mod path;
mod relaxation;
mod release;
mod saddle;
pub mod search;
pub mod settings;
pub mod stability;
mod stiffness;
mod stops;
mod subspace;
mod tied;
mod trust_region;
mod unheld;
mod watch;

pub use answer::answer;
pub use cascade::Stage;
pub use damped::DampedMode;
pub use equilibrium::{
    Equilibrium, Leftover, equilibrium, equilibrium_observed, equilibrium_watched, equilibrium_while, leftover,
};
pub use inverse::{Held, hold};
pub use settings::{Method, Settings, Want};
pub use stability::{Mode, Stability, Verdict};
pub use stops::Bearing;
