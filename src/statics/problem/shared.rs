//! Rows of loops, drives and gears that share what they bear with what holds coordinates: locks, and stops that bear.
//!
//! Multipliers `λ` are unique together with the forces of held coordinates unless some other ones balance as well:
//!
//! ```text
//! (1)  G_Fᵀ μ = 0,  μ ≠ 0        over the coordinates `F` that are not held; those that are take `G_Hᵀ μ`
//! (2)  P = 1 − U Uᵀ              projects rows onto such μ;  U spans the columns of G_F
//! ```
//!
//! A row shares what it bears if its entry on the diagonal of `P` is not zero, and a held coordinate if `P` leaves something of its column.

use super::Landscape;
use super::split::DEPENDENT;
use crate::round_off::EIGENVECTOR;
use faer::Mat;

/// Rows and coordinates up to which it is looked for: singular values of a dense matrix.
const MOST_DENSE: usize = 200;

/// What shares.
pub(in crate::statics) struct Shared {
    /// Which of the independent rows do.
    pub rows: Vec<bool>,
    /// Velocity coordinates that are held and do.
    pub held: Vec<usize>,
    /// Whether the rows are linearly independent if nothing is held: no singular position then.
    pub regular: bool,
}

impl Landscape<'_> {
    /// What shares at a position; `None` if nothing is held, or if there are too many rows to look at.
    pub(in crate::statics) fn shared(&mut self, q: &[f64]) -> Option<Shared> {
        let n = self.steady.len();
        if self.free.len() == n {
            return None;
        }
        let rank = self.system.constraint_rank();
        if rank == 0 || rank > MOST_DENSE || n > MOST_DENSE {
            return None;
        }
        let all = self.system.at(0.0, q, &self.steady).constraint_matrix();
        let (of_row, of_velocity) = self.system.row_units();
        let entry = |i: usize, j: usize| all[(i, j)] * of_velocity[j] / of_row[i];
        let size = |i: usize| (0..n).map(|j| entry(i, j).powi(2)).sum::<f64>().sqrt();
        let sizes: Vec<f64> = (0..rank).map(size).map(|size| if size > 0.0 { size } else { 1.0 }).collect();
        let rows = Mat::from_fn(rank, n, |i, j| entry(i, j) / sizes[i]);
        let free = Mat::from_fn(rank, self.free.len(), |i, j| rows[(i, self.free[j])]);
        let (left, regular) = (across(&free)?, across(&rows)?);
        let is_large = |x: f64| x > EIGENVECTOR.of(1.0);
        let is_held = |j: &usize| !self.free.contains(j);
        let of_column = |j: &usize| is_large((&left * rows.col(*j)).norm_l2());
        Some(Shared {
            rows: (0..rank).map(|i| is_large(left[(i, i)])).collect(),
            held: (0..n).filter(is_held).filter(of_column).collect(),
            regular: !is_large(regular.norm_max()),
        })
    }
}

/// (2) for the columns of a matrix.
fn across(matrix: &Mat<f64>) -> Option<Mat<f64>> {
    let (m, n) = (matrix.nrows(), matrix.ncols());
    if n == 0 {
        return Some(Mat::identity(m, m));
    }
    let svd = matrix.thin_svd().ok()?;
    let largest = svd.S()[0];
    let kept: Vec<usize> = (0..m.min(n)).filter(|k| svd.S()[*k] > DEPENDENT * largest.max(DEPENDENT)).collect();
    let u = Mat::from_fn(m, kept.len(), |i, k| svd.U()[(i, kept[k])]);
    Some(Mat::<f64>::identity(m, m) - &u * u.transpose())
}
