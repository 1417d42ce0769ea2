//! Residuals of which the sum of squares is made least, and where a search for that has ended.

use nalgebra::{DMatrix, DVector};

/// Why residuals have no value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Stop {
    /// There are none at these parameters.
    No(String),
    /// The caller ended it.
    Interrupted,
}

/// Residuals that depend on parameters.
pub(super) trait Residuals {
    /// Their values.
    fn at(&mut self, x: &[f64]) -> Result<DVector<f64>, Stop>;

    /// ∂r/∂x where they were evaluated last with success; `x` is that place.
    fn jacobian(&mut self, x: &[f64]) -> Result<DMatrix<f64>, Stop>;

    /// How many times a parameter may be multiplied to see what is far beyond: what costs more there is looked at less far.
    fn reach(&self) -> f64 {
        1e6
    }
}

/// Where the search has ended.
#[derive(Debug, Clone)]
pub(super) struct Minimum {
    pub x: Vec<f64>,
    pub residuals: DVector<f64>,
    pub jacobian: DMatrix<f64>,
    /// Parameters at a bound beyond which the sum of squares would fall.
    pub held: Vec<bool>,
    /// Steps that were taken.
    pub steps: usize,
    /// Whether it is a minimum.
    pub converged: bool,
    /// Parameters along which the sum of squares has no minimum, and where they run to.
    pub falls: Vec<(usize, Way)>,
    /// Why the last trial had no answer, if the search has ended by that.
    pub refused: Option<String>,
    /// The largest cosine between the residuals and a column of the Jacobian.
    pub cosine: f64,
}

/// Where a parameter runs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// To +∞.
    Up,
    /// To −∞.
    Down,
    /// To zero, where there is no answer.
    Zero,
    /// On with others.
    Together,
}
