//! Dense linear algebra of the static search.

use faer::linalg::solvers::{Llt, PartialPivLu, Solve};
use faer::{Mat, Side};

/// A positive definite matrix, factorized.
pub(in crate::statics) struct Definite(Llt<f64>);

impl Definite {
    /// Cholesky of `K + diag(shift)`; `None` if that is not positive definite.
    pub(in crate::statics) fn of(stiffness: &Mat<f64>, shift: &[f64]) -> Option<Self> {
        shifted(stiffness, shift).llt(Side::Lower).ok().map(Self)
    }

    pub(in crate::statics) fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        column(&self.0.solve(&as_mat(rhs)))
    }
}

/// A general matrix, factorized by LU with pivoting.
pub(in crate::statics) struct General {
    matrix: Mat<f64>,
    factor: PartialPivLu<f64>,
}

impl General {
    /// LU of `K + diag(shift)`.
    pub(in crate::statics) fn of(stiffness: &Mat<f64>, shift: &[f64]) -> Self {
        let matrix = shifted(stiffness, shift);
        Self { factor: matrix.partial_piv_lu(), matrix }
    }

    /// With one step of refinement.
    pub(in crate::statics) fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        let b = as_mat(rhs);
        let x = self.factor.solve(&b);
        let correction = self.factor.solve(&(&b - &self.matrix * &x));
        column(&(x + correction))
    }
}

fn shifted(matrix: &Mat<f64>, shift: &[f64]) -> Mat<f64> {
    let mut shifted = matrix.clone();
    shift.iter().enumerate().for_each(|(i, s)| shifted[(i, i)] += s);
    shifted
}

fn as_mat(list: &[f64]) -> Mat<f64> {
    Mat::from_fn(list.len(), 1, |i, _| list[i])
}

fn column(matrix: &Mat<f64>) -> Vec<f64> {
    (0..matrix.nrows()).map(|i| matrix[(i, 0)]).collect()
}
