//! Time stepping. Knows nothing of mechanics: it sees a system only through [`Problem`] and [`ImplicitProblem`].
//!
//! ```text
//! q̇ = N(q) v,   v̇ = a(t, q, v),   state x = (q, v)
//! ```
//!
//! | method | order | step | for |
//! |---|---|---|---|
//! | [`Rk4`] | 4 | fixed | comparison with other programs, equally spaced results |
//! | [`Dopri5`] | 5 | adaptive | smooth systems that are not stiff |
//! | [`Dop853`] | 8 | adaptive | the same at tight tolerances |
//! | [`Adams`] | 1 to 12 | adaptive | smooth systems that are not stiff, at the fewest evaluations |
//! | [`Sdirk4`] | 4 | adaptive | stiff systems: hard springs, strong dampers, light parts |
//! | [`Radau`] | 5 or 9 | adaptive | the same at tight tolerances |
//! | [`GeneralizedAlpha`] | 2 | adaptive | structures, where the user chooses how much of what is not resolved lives on |
//! | [`Gauss`] | 6 | fixed | long runs without dissipation: symmetric, energy stays in bounds |
//!
//! One error norm (the largest weighted component), one step controller and one dense output serve
//! them all. Every buffer is made when a stepper is built; a step allocates nothing.
//!
//! # Example
//!
//! A unit oscillator released at `q = 1`.
//!
//! ```
//! use stillpoint::integrate::{Dopri5, Failure, Options, Problem, Start, Stepper};
//!
//! struct Oscillator;
//!
//! impl Problem for Oscillator {
//!     fn position_count(&self) -> usize { 1 }
//!     fn velocity_count(&self) -> usize { 1 }
//!     fn acceleration(&mut self, _t: f64, q: &[f64], _v: &[f64], a: &mut [f64]) -> Result<(), Failure> {
//!         a[0] = -q[0];
//!         Ok(())
//!     }
//!     fn position_rate(&self, _q: &[f64], v: &[f64], rate: &mut [f64]) { rate.copy_from_slice(v); }
//!     fn normalize(&self, _q: &mut [f64]) {}
//!     fn scales(&self) -> (&[f64], &[f64]) { (&[1.0], &[1.0]) }
//! }
//!
//! let mut oscillator = Oscillator;
//! let start = Start { time: 0.0, position: &[1.0], velocity: &[0.0], end: 10.0 };
//! let mut stepper: Box<dyn Stepper<_>> = Box::new(Dopri5::new(&mut oscillator, &Options::default(), start)?);
//! while !stepper.finished() {
//!     stepper.step(&mut oscillator)?;
//! }
//! assert_eq!(stepper.time(), 10.0);
//! assert!((stepper.position()[0] - 10.0_f64.cos()).abs() < 1e-4);
//! # Ok::<(), stillpoint::integrate::StepError>(())
//! ```

pub mod problem;

mod implicit;
mod method;
mod step;

pub use method::{Adams, Dop853, Dopri5, Gauss, GeneralizedAlpha, Method, Radau, Rk4, Sdirk4};
pub use problem::{Failure, ImplicitProblem, Point, Problem};
pub use step::error::{Component, Limit, StepError};
pub use step::options::{Options, Start};
pub use step::progress::Progress;
pub use step::staged::{Evaluate, Staged};
pub use step::stages::StepStages;
pub use step::statistics::Statistics;
pub use step::stepper::Stepper;
