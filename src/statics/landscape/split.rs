//! What rows hold and what they leave free, at one position.
//!
//! With the rows `G` in the metric (row by row of unit size) and forces `b` in it:
//!
//! ```text
//! G = U S Vᵀ     motions: the null space of Vᵀ;     multipliers: U S⁻¹ V₁ᵀ b
//! Gᵀ = Q [R; 0]  the same from Q₂ and R⁻¹ Q₁ᵀ b where the rows are clearly independent: 1/|R⁻¹| tells
//! ```
//!
//! The second costs a small part of the first; singular values are left to the places where rows hang on each other.

use super::tied::Branch;
use faer::linalg::solvers::Qr;
use faer::{Mat, Par};

/// A singular value below this part of the largest belongs to a row that hangs on the others.
pub(super) const DEPENDENT: f64 = 1e-10;
/// Below this part of what it was elsewhere a row is left to the branch that the search came along.
pub(super) const NEARLY: f64 = 1e-2;

/// Motions and multipliers.
pub(super) struct Split {
    /// Orthonormal columns that no row feels.
    pub(super) null: Mat<f64>,
    pub(super) multipliers: Vec<f64>,
    /// The smallest singular value that counts, or a bound below it.
    pub(super) least: f64,
    pub(super) singular: bool,
    /// The largest of the smallest singular values met.
    pub(super) regular: f64,
}

/// Splits at a position to which the search came along `branch`; `root` is the root of the metric.
pub(super) fn split(rows: &Mat<f64>, forces: &[f64], branch: Option<&Branch>, root: &[f64]) -> Split {
    let met = branch.map_or(1.0, |branch| branch.regular);
    if let Some(split) = independent(rows, forces).filter(|split| split.least >= NEARLY * met) {
        let regular = branch.map_or(split.least, |branch| branch.regular.max(split.least));
        return Split { regular, ..split };
    }
    let n = rows.ncols();
    let parts = Parts::of(rows);
    let smallest = parts.values.iter().copied().filter(|s| *s > DEPENDENT).fold(f64::INFINITY, f64::min);
    let regular = branch.map_or(smallest, |before| before.regular.max(smallest));
    let limit = if branch.is_some() { NEARLY * regular } else { DEPENDENT };
    let singular = parts.values.iter().any(|s| *s < NEARLY * regular);
    let rank = parts.values.iter().filter(|s| **s > limit).count();
    let mut null = Mat::from_fn(n, n - rank, |i, j| parts.right[(i, rank + j)]);
    if let Some(before) = branch
        && before.tangent.ncols() < null.ncols()
    {
        null = nearest(&null, &before.tangent, root);
    }
    let least = parts.values.get(rank.wrapping_sub(1)).map_or(1.0, |least| *least);
    Split { null, multipliers: parts.solve(rank, forces), least, singular, regular }
}

/// Where all rows are independent; `None` where there are more rows than coordinates.
fn independent(rows: &Mat<f64>, forces: &[f64]) -> Option<Split> {
    let (m, n) = (rows.nrows(), rows.ncols());
    if m > n {
        return None;
    }
    let qr = Qr::new(rows.transpose());
    let (q, r) = (qr.compute_Q(), qr.thin_R());
    let mut inverse = Mat::<f64>::identity(m, m);
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(r, inverse.as_mut(), Par::Seq);
    let least = if m == 0 { 1.0 } else { 1.0 / inverse.norm_l2() };
    if !least.is_finite() {
        return None;
    }
    let held: Vec<f64> = (0..m).map(|j| (0..n).map(|i| q[(i, j)] * forces[i]).sum()).collect();
    let multipliers = (0..m).map(|i| (i..m).map(|j| inverse[(i, j)] * held[j]).sum()).collect();
    let null = q.subcols(m, n - m).to_owned();
    Some(Split { null, multipliers, least, singular: false, regular: least })
}

/// Singular values and vectors of a wide matrix.
struct Parts {
    left: Mat<f64>,
    values: Vec<f64>,
    right: Mat<f64>,
}

impl Parts {
    fn of(matrix: &Mat<f64>) -> Self {
        let (m, n) = (matrix.nrows(), matrix.ncols());
        match matrix.svd() {
            Ok(svd) => {
                let values = (0..m.min(n)).map(|i| svd.S()[i]).collect();
                Self { left: svd.U().to_owned(), values, right: svd.V().to_owned() }
            }
            Err(_) => Self { left: Mat::identity(m, m), values: vec![0.0; m.min(n)], right: Mat::identity(n, n) },
        }
    }

    /// `U S⁻¹ Vᵀ x` with the first `rank` values.
    fn solve(&self, rank: usize, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.left.nrows()];
        for k in 0..rank {
            let part: f64 = (0..x.len()).map(|i| self.right[(i, k)] * x[i]).sum::<f64>() / self.values[k];
            for (i, out) in out.iter_mut().enumerate() {
                *out += self.left[(i, k)] * part;
            }
        }
        out
    }
}

/// Within a null space that has become larger, the part nearest to the motions there were before, orthonormal.
fn nearest(null: &Mat<f64>, before: &Mat<f64>, root: &[f64]) -> Mat<f64> {
    let old = Mat::from_fn(before.nrows(), before.ncols(), |i, j| before[(i, j)] * root[i]);
    let inside = null * (null.transpose() * &old);
    match inside.thin_svd() {
        Ok(svd) => svd.U() * svd.V().transpose(),
        Err(_) => inside,
    }
}
