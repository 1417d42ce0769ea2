//! What rows hold and what they leave free, at one position.
//!
//! With the rows `G` in the metric (row by row of unit size) and forces `b` in it:
//!
//! ```text
//! G = U S Vᵀ     motions: the null space of Vᵀ;     multipliers: U S⁻¹ V₁ᵀ b
//! Gᵀ = Q [R; 0]  the same from Q₂ and R⁻¹ Q₁ᵀ b where the rows are clearly independent: 1/|R⁻¹| tells
//! ```
//!
//! The second costs a small part of the first; singular values are left to the places where rows are linearly dependent: there
//! `S⁻¹ Uᵀ G` of those that count takes the place of `G`. Which count is asked without the masses.
//!
//! Few rows across a large scene are represented by what they hold, `Q₁` or `V₁`, instead of by what they leave: `n × m` numbers
//! instead of `n × (n − m)`. Where rows are linearly dependent the branch decides what is held beside `V₁`: of what was held
//! before, the part that no row feels here, `Q y` with `V₁ᵀ Q y = 0`.

use super::row_space::RowSpace;
use crate::sparse::{Gram, SparseRows};
use crate::transfer::tangent::Pull;
use faer::linalg::solvers::Qr;
use faer::{Mat, Par};
use std::sync::Arc;

/// A singular value below this part of the largest belongs to a linearly dependent row.
pub(in crate::statics) const DEPENDENT: f64 = 1e-10;

/// Below this part of what it was elsewhere a row is left to the branch that the search came along.
pub(in crate::statics) const NEARLY: f64 = 1e-2;

/// Rows whose smallest singular value is below this have squares, in `A`, that lose half of their digits.
const CLEAR: f64 = 1e-6;

/// The motions where the last step began.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Branch {
    pub(in crate::statics) motions: Motions,
    /// The largest of the smallest singular values met.
    pub(in crate::statics) regular: f64,
}

/// What rows leave free, in free coordinates.
#[derive(Debug, Clone)]
pub(in crate::statics) enum Motions {
    /// By a basis `Z` of it, `Zᵀ B Z = 1`.
    Spanned(Mat<f64>),
    /// By rows `C` that hold everything else, `Cᵀ B⁻¹ C = 1`.
    Across(Mat<f64>),
    /// By sparse rows that hold everything else.
    Sparse(Arc<RowSpace>),
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
    pub(in crate::statics) fn felt(&self, force: &[f64], metric: &[f64]) -> Vec<f64> {
        let n = force.len();
        let times = |columns: &Mat<f64>, j: usize, x: &dyn Fn(usize) -> f64| {
            (0..n).map(|i| columns[(i, j)] * x(i)).sum::<f64>()
        };
        match self {
            Self::Sparse(space) => space.felt(force, metric),
            Self::Spanned(z) => {
                let along: Vec<f64> = (0..z.ncols()).map(|j| times(z, j, &|i| force[i])).collect();
                let part = |i: usize| metric[i] * along.iter().enumerate().map(|(j, a)| z[(i, j)] * a).sum::<f64>();
                (0..n).map(part).collect()
            }
            Self::Across(c) => {
                let mut left = force.to_vec();
                // Twice: the residual is small compared with what the rows take.
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
    pub(in crate::statics) fn felt_size(&self, squares: &[f64], metric: &[f64]) -> Vec<f64> {
        let columns = match self {
            Self::Sparse(space) => return space.felt_size(squares, metric),
            Self::Spanned(columns) | Self::Across(columns) => columns,
        };
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
    pub(in crate::statics) fn basis(&self, metric: &[f64]) -> Mat<f64> {
        match self {
            Self::Spanned(z) => z.clone(),
            Self::Across(c) => left(c.as_ref(), metric),
            Self::Sparse(space) => {
                let rows = space.rows();
                let mut c = Mat::zeros(metric.len(), rows.len());
                (0..rows.len()).for_each(|j| rows.row(j).for_each(|(i, value)| c[(i, j)] = value));
                left(c.as_ref(), metric)
            }
        }
    }

    /// The rows that hold everything else; none of a basis.
    pub(in crate::statics) fn rows(&self) -> Across {
        match self {
            Self::Spanned(_) => Across::Full(Vec::new()),
            Self::Across(c) => {
                Across::Full((0..c.ncols()).map(|j| (0..c.nrows()).map(|i| c[(i, j)]).collect()).collect())
            }
            Self::Sparse(space) => Across::Sparse(Arc::clone(space)),
        }
    }
}

/// Rows that hold what is not a motion, over the free coordinates.
#[derive(Debug, Clone)]
pub(in crate::statics) enum Across {
    /// One list for each row.
    Full(Vec<Vec<f64>>),
    /// For a tangent that is a sparse matrix.
    Sparse(Arc<RowSpace>),
}

/// `Z` of what rows, the columns of `c`, leave.
fn left(c: faer::MatRef<'_, f64>, metric: &[f64]) -> Mat<f64> {
    let (n, m) = (c.nrows(), c.ncols());
    let held = Mat::from_fn(n, m, |i, j| c[(i, j)] / metric[i].sqrt());
    let q = Qr::new(held.as_ref()).compute_Q();
    Mat::from_fn(n, n - m, |i, j| q[(i, m + j)] / metric[i].sqrt())
}

/// Motions and multipliers.
pub(in crate::statics) struct Split {
    pub(in crate::statics) motions: Motions,
    pub(in crate::statics) multipliers: Vec<f64>,
    pub(in crate::statics) singular: bool,
    /// The largest of the smallest singular values met.
    pub(in crate::statics) regular: f64,
}

/// The rows at one position, and the forces that they may take.
pub(in crate::statics) struct Given {
    /// In the metric, each of about unit size.
    pub(in crate::statics) rows: Mat<f64>,
    /// These rows over turns and parts of their component's lever, of about unit size there: whether they are linearly
    /// dependent is a matter of geometry. A body a million times heavier than its neighbours does not make rows dependent.
    pub(in crate::statics) plain: Mat<f64>,
    /// In the metric.
    pub(in crate::statics) forces: Vec<f64>,
    /// Root of the metric.
    pub(in crate::statics) root: Vec<f64>,
    /// Size of each row of `plain` over that of the one in `rows`.
    pub(in crate::statics) sizes: Vec<f64>,
}

/// Splits at a position to which the search came along `branch`. With `held` the motions are represented by what holds the rest.
pub(in crate::statics) fn split(given: &Given, branch: Option<&Branch>, held: bool) -> Split {
    let Given { rows, plain, forces, root, sizes } = given;
    let met = branch.map_or(1.0, |branch| branch.regular);
    if let Some(least) = clear(plain).filter(|least| *least >= NEARLY * met)
        && let Some((columns, multipliers)) = independent(rows, forces, held)
    {
        let regular = branch.map_or(least, |branch| branch.regular.max(least));
        return Split { motions: Motions::of(&columns, root, held), multipliers, singular: false, regular };
    }
    let n = rows.ncols();
    let parts = Parts::of(plain);
    let smallest = parts.values.iter().copied().filter(|s| *s > DEPENDENT).fold(f64::INFINITY, f64::min);
    let regular = branch.map_or(smallest, |before| before.regular.max(smallest));
    let limit = if branch.is_some() { NEARLY * regular } else { DEPENDENT };
    let singular = parts.values.iter().any(|s| *s < NEARLY * regular);
    let rank = parts.values.iter().filter(|s| **s > limit).count();
    // The combinations of rows that stay, `S⁻¹ Uᵀ G`, in the metric.
    let weights = Mat::from_fn(rank, rows.nrows(), |k, i| parts.left[(i, k)] / (parts.values[k] * sizes[i]));
    let kept = &weights * rows;
    let Some((columns, along)) = independent(&kept, forces, held) else {
        let motions = Motions::of(&Mat::zeros(n, 0), root, held);
        return Split { motions, multipliers: vec![0.0; rows.nrows()], singular: true, regular };
    };
    let multipliers = (0..rows.nrows()).map(|i| (0..rank).map(|k| weights[(k, i)] * along[k]).sum()).collect();
    let columns = match (held, branch.map(|branch| &branch.motions)) {
        (true, Some(Motions::Across(before))) if before.ncols() > rank => with_held(&columns, before, root),
        (false, Some(Motions::Spanned(before))) if before.ncols() < columns.ncols() => nearest(&columns, before, root),
        _ => columns,
    };
    Split { motions: Motions::of(&columns, root, held), multipliers, singular, regular }
}

/// A bound below the smallest singular value; `None` if there are more rows than coordinates.
fn clear(rows: &Mat<f64>) -> Option<f64> {
    let (m, n) = (rows.nrows(), rows.ncols());
    if m > n {
        return None;
    }
    if m == 0 {
        return Some(1.0);
    }
    let least = 1.0 / inverse(Qr::new(rows.transpose()).thin_R()).norm_l2();
    least.is_finite().then_some(least)
}

/// What independent rows hold or leave, orthonormal columns in the metric, and their multipliers.
fn independent(rows: &Mat<f64>, forces: &[f64], held: bool) -> Option<(Mat<f64>, Vec<f64>)> {
    let (m, n) = (rows.nrows(), rows.ncols());
    let qr = Qr::new(rows.transpose());
    let q = if held { qr.compute_thin_Q() } else { qr.compute_Q() };
    let inverse = inverse(qr.thin_R());
    let along: Vec<f64> = (0..m).map(|j| (0..n).map(|i| q[(i, j)] * forces[i]).sum()).collect();
    let multipliers: Vec<f64> = (0..m).map(|i| (i..m).map(|j| inverse[(i, j)] * along[j]).sum()).collect();
    let columns = if held { q } else { q.subcols(m, n - m).to_owned() };
    multipliers.iter().all(|x: &f64| x.is_finite()).then_some((columns, multipliers))
}

/// Of an upper triangle.
fn inverse(upper: faer::MatRef<'_, f64>) -> Mat<f64> {
    let mut inverse = Mat::<f64>::identity(upper.nrows(), upper.nrows());
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(upper, inverse.as_mut(), Par::Seq);
    inverse
}

/// Singular values and the vectors on the side of the rows.
struct Parts {
    left: Mat<f64>,
    values: Vec<f64>,
}

impl Parts {
    fn of(matrix: &Mat<f64>) -> Self {
        let (m, n) = (matrix.nrows(), matrix.ncols());
        match matrix.thin_svd() {
            Ok(svd) => Self { left: svd.U().to_owned(), values: (0..m.min(n)).map(|i| svd.S()[i]).collect() },
            Err(_) => Self { left: Mat::identity(m, m), values: vec![0.0; m.min(n)] },
        }
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

/// Rows at one position, as in [`Given`].
pub(super) struct SparseGiven<'a> {
    /// Over the free coordinates, of unit size in the metric.
    pub(super) rows: SparseRows,
    /// These rows over turns and levers.
    pub(super) plain: SparseRows,
    /// What the rows pull at, of the same size.
    pub(super) pulls: Vec<Pull>,
    pub(super) force: &'a [f64],
    pub(super) metric: &'a [f64],
}

/// Splits at a position where rows are independent by more than round-off, also compared with the largest of the smallest singular
/// values `met` so far; else `None`. `before` are the motions of another position, if there are any.
pub(super) fn split_clearly(given: SparseGiven<'_>, met: Option<f64>, before: Option<&Motions>) -> Option<Split> {
    let SparseGiven { rows, plain, pulls, force, metric } = given;
    let ones = vec![1.0; metric.len()];
    let like = match before {
        Some(Motions::Sparse(space)) => Some(space.gram()),
        _ => None,
    };
    let of_plain = Gram::of_like(&plain, &ones, like)?;
    let least = of_plain.smallest_singular_value();
    // Not a number is not clear. A long chain of loops has small values everywhere: only beside those met before do they mean
    // that this position is singular.
    if !(least >= met.map_or(CLEAR, |met| CLEAR.max(NEARLY * met))) {
        return None;
    }
    let space = RowSpace::of(rows, pulls, metric, &of_plain)?;
    let multipliers = space.multipliers(force, metric);
    let regular = met.map_or(least, |met| met.max(least));
    Some(Split { motions: Motions::Sparse(Arc::new(space)), multipliers, singular: false, regular })
}
