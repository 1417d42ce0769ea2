//! The methods: one file each, and the table of them.

mod adams;
mod differences;
mod dop853;
mod dopri5;
mod explicit;
mod gauss;
mod generalized_alpha;
mod predict;
mod radau;
mod rk4;
mod sdirk4;
mod tableau;

pub use adams::Adams;
pub use dop853::Dop853;
pub use dopri5::Dopri5;
pub use gauss::Gauss;
pub use generalized_alpha::GeneralizedAlpha;
pub use radau::Radau;
pub use rk4::Rk4;
pub use sdirk4::Sdirk4;

use crate::integrate::{
    problem::{ImplicitProblem, Problem},
    step::{
        error::StepError,
        options::{Options, Start},
        staged::Staged,
        stepper::Stepper,
    },
};

/// The methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// [`Rk4`]: classical Runge–Kutta, order 4, fixed step.
    Rk4,
    /// [`Dopri5`]: Dormand–Prince 5(4), adaptive.
    Dopri5,
    /// [`Dop853`]: Dormand–Prince 8(5,3), adaptive.
    Dop853,
    /// [`Adams`]: Adams methods of orders 1 to 12, adaptive.
    Adams,
    /// [`Sdirk4`]: L-stable diagonally implicit Runge–Kutta 4(3), adaptive.
    Sdirk4,
    /// [`Radau`]: Radau IIA of order 5, L-stable, adaptive.
    Radau5,
    /// [`Radau`]: Radau IIA of order 9, L-stable, adaptive.
    Radau9,
    /// [`GeneralizedAlpha`]: order 2, numerical damping as chosen, adaptive.
    GeneralizedAlpha,
    /// [`Gauss`]: Gauss collocation of order 6, symmetric, fixed step.
    Gauss,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Rk4,
        Self::Dopri5,
        Self::Dop853,
        Self::Adams,
        Self::Sdirk4,
        Self::Radau5,
        Self::Radau9,
        Self::GeneralizedAlpha,
        Self::Gauss,
    ];

    /// Whether the step has to be given and stays the same.
    pub fn needs_step(self) -> bool {
        match self {
            Self::Rk4 | Self::Gauss => true,
            Self::Dopri5
            | Self::Dop853
            | Self::Adams
            | Self::Sdirk4
            | Self::Radau5
            | Self::Radau9
            | Self::GeneralizedAlpha => false,
        }
    }

    /// For explicit methods, the largest `h |λ|` that is stable on the negative real axis.
    pub fn stability_reach(self) -> Option<f64> {
        match self {
            Self::Rk4 => Some(2.78),
            Self::Dopri5 => Some(3.3),
            Self::Dop853 => Some(6.1),
            Self::Adams => Some(1.0),
            Self::Sdirk4 | Self::Radau5 | Self::Radau9 | Self::GeneralizedAlpha | Self::Gauss => None,
        }
    }

    /// Whether [`Method::start_staged`] has it.
    pub fn is_staged(self) -> bool {
        match self {
            Self::Rk4 | Self::Dopri5 | Self::Dop853 => true,
            Self::Adams | Self::Sdirk4 | Self::Radau5 | Self::Radau9 | Self::GeneralizedAlpha | Self::Gauss => false,
        }
    }

    /// Its name in scenario files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rk4 => "rk4",
            Self::Dopri5 => "dopri5",
            Self::Dop853 => "dop853",
            Self::Adams => "adams",
            Self::Sdirk4 => "sdirk4",
            Self::Radau5 => "radau5",
            Self::Radau9 => "radau9",
            Self::GeneralizedAlpha => "generalized-alpha",
            Self::Gauss => "gauss",
        }
    }

    /// Starts a run with this method.
    ///
    /// # Errors
    /// If an option is out of its range, the start does not fit the system, or the system cannot be evaluated there.
    pub fn start<P: ImplicitProblem>(
        self,
        problem: &mut P,
        options: &Options,
        start: Start<'_>,
    ) -> Result<Box<dyn Stepper<P>>, StepError> {
        Ok(match self {
            Self::Rk4 => Box::new(Rk4::new(problem, options, start)?),
            Self::Dopri5 => Box::new(Dopri5::new(problem, options, start)?),
            Self::Dop853 => Box::new(Dop853::new(problem, options, start)?),
            Self::Adams => Box::new(Adams::new(problem, options, start)?),
            Self::Sdirk4 => Box::new(Sdirk4::new(problem, options, start)?),
            Self::Radau5 => Box::new(Radau::order_5(problem, options, start)?),
            Self::Radau9 => Box::new(Radau::order_9(problem, options, start)?),
            Self::GeneralizedAlpha => Box::new(GeneralizedAlpha::new(problem, options, start)?),
            Self::Gauss => Box::new(Gauss::new(problem, options, start)?),
        })
    }

    /// Starts a run that is stepped evaluation by evaluation; `None` for methods that are not.
    ///
    /// # Errors
    /// As [`Method::start`].
    pub fn start_staged<P: Problem>(
        self,
        problem: &mut P,
        options: &Options,
        start: Start<'_>,
    ) -> Option<Result<Box<dyn Staged<P>>, StepError>> {
        /// As a trait object.
        fn boxed<P: Problem>(stepper: impl Staged<P> + 'static) -> Box<dyn Staged<P>> {
            Box::new(stepper)
        }
        match self {
            Self::Rk4 => Some(Rk4::new(problem, options, start).map(boxed)),
            Self::Dopri5 => Some(Dopri5::new(problem, options, start).map(boxed)),
            Self::Dop853 => Some(Dop853::new(problem, options, start).map(boxed)),
            Self::Adams | Self::Sdirk4 | Self::Radau5 | Self::Radau9 | Self::GeneralizedAlpha | Self::Gauss => None,
        }
    }
}
