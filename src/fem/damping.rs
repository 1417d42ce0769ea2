//! Damping of a modal body.

use super::Flaw;
use nalgebra::{DMatrix, SymmetricEigen};

/// How a modal body is damped.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ModalDamping {
    /// Not at all.
    #[default]
    None,
    /// Every mode of the body with its root held by this part of the critical damping.
    Ratio(f64),
    /// `mass · M + stiffness · K` (1/s, s).
    Rayleigh {
        /// Factor of the mass matrix (1/s).
        mass: f64,
        /// Factor of the stiffness matrix (s).
        stiffness: f64,
    },
}

impl ModalDamping {
    /// `D` of a reduced mass and stiffness matrix, by rows; empty for none.
    ///
    /// # Errors
    /// A mass matrix that is not positive definite.
    pub(super) fn matrix(self, mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Result<Vec<f64>, Flaw> {
        let damping = match self {
            Self::None | Self::Ratio(0.0) => return Ok(Vec::new()),
            Self::Rayleigh { mass: 0.0, stiffness: 0.0 } => return Ok(Vec::new()),
            Self::Rayleigh { mass: by_mass, stiffness: by_stiffness } => by_mass * mass + by_stiffness * stiffness,
            Self::Ratio(ratio) => {
                let refused = || Flaw::new("the mass matrix of its coordinates is not positive definite");
                let lower = mass.clone().cholesky().ok_or_else(refused)?.l();
                let half = lower.solve_lower_triangular(stiffness).ok_or_else(refused)?;
                let whole = lower.solve_lower_triangular(&half.transpose()).ok_or_else(refused)?;
                let eigen = SymmetricEigen::new(0.5 * (&whole + whole.transpose()));
                let rates = eigen.eigenvalues.map(|square| 2.0 * ratio * square.max(0.0).sqrt());
                let shapes = &lower * eigen.eigenvectors;
                &shapes * DMatrix::from_diagonal(&rates) * shapes.transpose()
            }
        };
        let m = damping.nrows();
        Ok((0..m * m).map(|at| 0.5 * (damping[(at / m, at % m)] + damping[(at % m, at / m)])).collect())
    }
}
