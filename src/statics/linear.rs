//! Dense linear algebra of the static search.

use faer::linalg::solvers::{Llt, PartialPivLu, Solve};
use faer::{Mat, Side};

/// A positive definite matrix, factorized.
pub(super) struct Definite(Llt<f64>);

impl Definite {
    /// Cholesky of `K + diag(shift)`; `None` where that is not positive definite.
    pub(super) fn of(stiffness: &Mat<f64>, shift: &[f64]) -> Option<Self> {
        let mut shifted = stiffness.clone();
        for (i, s) in shift.iter().enumerate() {
            shifted[(i, i)] += s;
        }
        shifted.llt(Side::Lower).ok().map(Self)
    }

    pub(super) fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        column(&self.0.solve(&as_mat(rhs)))
    }
}

/// A general matrix, factorized by LU with pivoting.
pub(super) struct General {
    matrix: Mat<f64>,
    factor: PartialPivLu<f64>,
}

impl General {
    pub(super) fn of(matrix: &Mat<f64>) -> Self {
        Self { matrix: matrix.clone(), factor: matrix.partial_piv_lu() }
    }

    /// With one step of refinement.
    pub(super) fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        let b = as_mat(rhs);
        let x = self.factor.solve(&b);
        let correction = self.factor.solve(&(&b - &self.matrix * &x));
        column(&(x + correction))
    }
}

fn as_mat(list: &[f64]) -> Mat<f64> {
    Mat::from_fn(list.len(), 1, |i, _| list[i])
}

fn column(matrix: &Mat<f64>) -> Vec<f64> {
    (0..matrix.nrows()).map(|i| matrix[(i, 0)]).collect()
}
