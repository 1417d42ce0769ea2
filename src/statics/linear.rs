//! Dense linear algebra of the static search.

use faer::linalg::solvers::{Llt, Solve};
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

/// Solves with LU and one step of refinement; `None` where the answer is not finite.
pub(super) fn solve(matrix: &Mat<f64>, rhs: &[f64]) -> Option<Vec<f64>> {
    let lu = matrix.partial_piv_lu();
    let b = as_mat(rhs);
    let x = lu.solve(&b);
    let correction = lu.solve(&(&b - matrix * &x));
    let x = column(&(x + correction));
    x.iter().all(|x| x.is_finite()).then_some(x)
}

fn as_mat(list: &[f64]) -> Mat<f64> {
    Mat::from_fn(list.len(), 1, |i, _| list[i])
}

fn column(matrix: &Mat<f64>) -> Vec<f64> {
    (0..matrix.nrows()).map(|i| matrix[(i, 0)]).collect()
}
