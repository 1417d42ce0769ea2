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
//!
//! Few rows across a large scene are told by what they hold, `Q₁` or `V₁`, instead of by what they leave: `n × m` numbers
//! instead of `n × (n − m)`. Where rows hang on each other the branch decides what is held beside `V₁`: of what was held
//! before, the part that no row feels here, `Q y` with `V₁ᵀ Q y = 0`.

use super::tied::Branch;
use faer::linalg::solvers::Qr;
use faer::{Mat, Par};

/// A singular value below this part of the largest belongs to a row that hangs on the others.
pub(super) const DEPENDENT: f64 = 1e-10;
/// Below this part of what it was elsewhere a row is left to the branch that the search came along.
pub(super) const NEARLY: f64 = 1e-2;

/// What rows leave free, in free coordinates.
#[derive(Debug, Clone)]
pub(in super::super) enum Motions {
    /// By a basis `Z` of it, `Zᵀ B Z = 1`.
    Spanned(Mat<f64>),
    /// By rows `C` that hold everything else, `Cᵀ B⁻¹ C = 1`.
    Across(Mat<f64>),
}

impl Motions {
    /// From orthonormal columns in the metric, `held` or free.
    fn of(columns: &Mat<f64>, root: &[f64], held: bool) -> Self {
        let (n, count) = (columns.nrows(), columns.ncols());
        match held {
            true => Self::Across(Mat::from_fn(n, count, |i, j| columns[(i, j)] * root[i])),
            false => Self::Spanned(Mat::from_fn(n, count, |i, j| columns[(i, j)] / root[i])),
        }
    }

    /// The part of a force that does work on them: `B Z Zᵀ f`.
    pub(super) fn felt(&self, force: &[f64], metric: &[f64]) -> Vec<f64> {
        let n = force.len();
        let times = |columns: &Mat<f64>, j: usize, x: &dyn Fn(usize) -> f64| {
            (0..n).map(|i| columns[(i, j)] * x(i)).sum::<f64>()
        };
        match self {
            Self::Spanned(z) => {
                let along: Vec<f64> = (0..z.ncols()).map(|j| times(z, j, &|i| force[i])).collect();
                let part = |i: usize| metric[i] * along.iter().enumerate().map(|(j, a)| z[(i, j)] * a).sum::<f64>();
                (0..n).map(part).collect()
            }
            Self::Across(c) => {
                let mut left = force.to_vec();
                // Twice: what is left is small beside what is taken.
                for _ in 0..2 {
                    let along: Vec<f64> = (0..c.ncols()).map(|j| times(c, j, &|i| left[i] / metric[i])).collect();
                    let held = |i: usize| along.iter().enumerate().map(|(j, a)| c[(i, j)] * a).sum::<f64>();
                    (0..n).for_each(|i| left[i] -= held(i));
                }
                left
            }
        }
    }

    /// How large [`Motions::felt`] is of forces whose squares are expected to be these, independently of each other:
    /// the roots of `Σ_j (B Z Zᵀ)ᵢⱼ² sⱼ`.
    pub(super) fn felt_size(&self, squares: &[f64], metric: &[f64]) -> Vec<f64> {
        let (Self::Spanned(columns) | Self::Across(columns)) = self;
        let held = matches!(self, Self::Across(_));
        let weight = |j: usize| squares[j].sqrt() / if held { metric[j] } else { 1.0 };
        let weighted = Mat::from_fn(columns.nrows(), columns.ncols(), |j, k| weight(j) * columns[(j, k)]);
        let along = columns * (weighted.transpose() * &weighted);
        let sum = |i: usize| (0..columns.ncols()).map(|k| along[(i, k)] * columns[(i, k)]).sum::<f64>();
        // What rows hold is taken off the whole force, and its round-off stays.
        let size = |i: usize| if held { squares[i] + sum(i) } else { metric[i].powi(2) * sum(i) };
        (0..squares.len()).map(|i| size(i).max(0.0).sqrt()).collect()
    }

    /// `Z`.
    pub(super) fn basis(&self, metric: &[f64]) -> Mat<f64> {
        match self {
            Self::Spanned(z) => z.clone(),
            Self::Across(c) => {
                let (n, m) = (c.nrows(), c.ncols());
                let held = Mat::from_fn(n, m, |i, j| c[(i, j)] / metric[i].sqrt());
                let q = Qr::new(held.as_ref()).compute_Q();
                Mat::from_fn(n, n - m, |i, j| q[(i, m + j)] / metric[i].sqrt())
            }
        }
    }

    /// The rows of [`Motions::Across`], one list each; none of a basis.
    pub(super) fn rows(&self) -> Vec<Vec<f64>> {
        let Self::Across(c) = self else { return Vec::new() };
        (0..c.ncols()).map(|j| (0..c.nrows()).map(|i| c[(i, j)]).collect()).collect()
    }
}

/// Motions and multipliers.
pub(super) struct Split {
    pub(super) motions: Motions,
    pub(super) multipliers: Vec<f64>,
    /// The smallest singular value that counts, or a bound below it.
    pub(super) least: f64,
    pub(super) singular: bool,
    /// The largest of the smallest singular values met.
    pub(super) regular: f64,
}

/// Splits at a position to which the search came along `branch`; `root` is the root of the metric. With `held` the motions
/// are told by what holds the rest.
pub(super) fn split(rows: &Mat<f64>, forces: &[f64], branch: Option<&Branch>, root: &[f64], held: bool) -> Split {
    let met = branch.map_or(1.0, |branch| branch.regular);
    if let Some(split) = independent(rows, forces, root, held).filter(|split| split.least >= NEARLY * met) {
        let regular = branch.map_or(split.least, |branch| branch.regular.max(split.least));
        return Split { regular, ..split };
    }
    let n = rows.ncols();
    let parts = Parts::of(rows, held);
    let smallest = parts.values.iter().copied().filter(|s| *s > DEPENDENT).fold(f64::INFINITY, f64::min);
    let regular = branch.map_or(smallest, |before| before.regular.max(smallest));
    let limit = if branch.is_some() { NEARLY * regular } else { DEPENDENT };
    let singular = parts.values.iter().any(|s| *s < NEARLY * regular);
    let rank = parts.values.iter().filter(|s| **s > limit).count();
    let columns = match (held, branch.map(|branch| &branch.motions)) {
        (true, before) => {
            let taken = Mat::from_fn(n, rank, |i, j| parts.right[(i, j)]);
            match before {
                Some(Motions::Across(before)) if before.ncols() > rank => with_held(&taken, before, root),
                _ => taken,
            }
        }
        (false, before) => {
            let null = Mat::from_fn(n, n - rank, |i, j| parts.right[(i, rank + j)]);
            match before {
                Some(Motions::Spanned(before)) if before.ncols() < null.ncols() => nearest(&null, before, root),
                _ => null,
            }
        }
    };
    let least = parts.values.get(rank.wrapping_sub(1)).map_or(1.0, |least| *least);
    let motions = Motions::of(&columns, root, held);
    Split { motions, multipliers: parts.solve(rank, forces), least, singular, regular }
}

/// Where all rows are independent; `None` where there are more rows than coordinates.
fn independent(rows: &Mat<f64>, forces: &[f64], root: &[f64], held: bool) -> Option<Split> {
    let (m, n) = (rows.nrows(), rows.ncols());
    if m > n {
        return None;
    }
    let qr = Qr::new(rows.transpose());
    let (q, r) = (if held { qr.compute_thin_Q() } else { qr.compute_Q() }, qr.thin_R());
    let mut inverse = Mat::<f64>::identity(m, m);
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(r, inverse.as_mut(), Par::Seq);
    let least = if m == 0 { 1.0 } else { 1.0 / inverse.norm_l2() };
    if !least.is_finite() {
        return None;
    }
    let along: Vec<f64> = (0..m).map(|j| (0..n).map(|i| q[(i, j)] * forces[i]).sum()).collect();
    let multipliers = (0..m).map(|i| (i..m).map(|j| inverse[(i, j)] * along[j]).sum()).collect();
    let columns = if held { q } else { q.subcols(m, n - m).to_owned() };
    let motions = Motions::of(&columns, root, held);
    Some(Split { motions, multipliers, least, singular: false, regular: least })
}

/// Singular values and vectors of a wide matrix.
struct Parts {
    left: Mat<f64>,
    values: Vec<f64>,
    right: Mat<f64>,
}

impl Parts {
    fn of(matrix: &Mat<f64>, thin: bool) -> Self {
        let (m, n) = (matrix.nrows(), matrix.ncols());
        match if thin { matrix.thin_svd() } else { matrix.svd() } {
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

/// What is held here, and the part of what was held before that no row feels here; orthonormal.
fn with_held(taken: &Mat<f64>, before: &Mat<f64>, root: &[f64]) -> Mat<f64> {
    let (n, rank, count) = (taken.nrows(), taken.ncols(), before.ncols());
    let old = Mat::from_fn(n, count, |i, j| before[(i, j)] / root[i]);
    let old = Qr::new(old.as_ref()).compute_thin_Q();
    let Ok(svd) = (taken.transpose() * &old).svd() else { return taken.clone() };
    let rest = &old * svd.V().subcols(rank, count - rank);
    Mat::from_fn(n, count, |i, j| if j < rank { taken[(i, j)] } else { rest[(i, j - rank)] })
}
