//! Closed positions: the landscape of a scene with loops, drives and gears.
//!
//! ```text
//! r(q): the residual at rest,   G: gradients of the rows,   B: the inertia each coordinate sees
//! (1)  G B^(−1/2) = U S Vᵀ,   Z = B^(−1/2) V₂: the motions that keep every row (V₂ spans the null space)
//! (2)  λ = U S⁻¹ V₁ᵀ B^(−1/2) r: what the rows have to hold;   f = −B Z Zᵀ r: what they cannot
//! (3)  H = Zᵀ (∂(r − Gᵀλ)/∂q) Z: the stiffness along the closed positions, their curvature in it
//! ```
//!
//! Searches see the coordinates of the tree, forces `f` that make no rows work, and steps `Z y` after which the rows are
//! closed again: to them it is a landscape like any other. Everything is dense: O(n³).
//!
//! **Drives** stay where they are at t = 0, and where the rest can be at rest beside a driven motion (a governor that
//! spins), they keep their velocity: the kinetic energy then counts as a potential of the opposite sign.
//! **Locks** take their coordinates out of all of this.
//! **Singular positions**: where rows hang on each other that are independent elsewhere, the motions that only exist
//! there do not count: the branch that the search came along is kept.

use super::{Landscape, Scales};
use crate::constraint::Closer;
use crate::dynamics::{Fault, System};
use crate::model::Model;
use faer::Mat;

/// A singular value below this part of the largest belongs to a row that hangs on the others.
const DEPENDENT: f64 = 1e-10;
/// Below this part of what it was elsewhere a row is left to the branch that the search came along.
const NEARLY: f64 = 1e-2;
/// Largest turn (rad), and part of the scene's length, of one step.
const LONGEST_STEP: f64 = 0.6;

/// The rows of a model, and where its search stands on the closed positions.
pub(in super::super) struct Ties<'m> {
    closer: Closer<'m>,
    /// Drives whose velocity cannot be kept.
    pub(in super::super) frozen: Vec<String>,
    /// The problem at the last position.
    pub(in super::super) view: Option<View>,
    branch: Option<Branch>,
}

/// The motions where the last step began.
#[derive(Debug, Clone)]
pub(in super::super) struct Branch {
    tangent: Mat<f64>,
    /// The largest of the smallest singular values met.
    regular: f64,
}

/// The rows at one position. Lists are over free coordinates.
#[derive(Debug, Clone)]
pub(in super::super) struct View {
    q: Vec<f64>,
    /// `Z`, one column per motion.
    pub(in super::super) tangent: Mat<f64>,
    /// `λ`, one per independent row.
    pub(in super::super) multipliers: Vec<f64>,
    /// Rows hang on each other here that do not elsewhere.
    pub(in super::super) singular: bool,
    force: Vec<f64>,
    scales: Scales,
    regular: f64,
}

impl<'m> Ties<'m> {
    pub(super) fn new(model: &'m Model, frozen: Vec<String>) -> Self {
        Self { closer: Closer::new(model), frozen, view: None, branch: None }
    }
}

impl Landscape<'_, '_> {
    /// Brings a position onto the rows; false where that cannot be done.
    pub(in super::super) fn close(&mut self, q: &mut [f64]) -> bool {
        self.ties.as_mut().is_none_or(|ties| ties.closer.close(q))
    }

    /// What the search remembers of where it came from.
    pub(in super::super) fn branch(&self) -> Option<Branch> {
        self.ties.as_ref().and_then(|ties| ties.branch.clone())
    }

    pub(in super::super) fn set_branch(&mut self, branch: Option<Branch>) {
        if let Some(ties) = &mut self.ties {
            ties.branch = branch;
        }
    }

    /// Forces and sizes at a closed position.
    pub(super) fn tied_forces(&mut self, q: &[f64]) -> Result<(Vec<f64>, Scales), Fault> {
        self.take_view(q)?;
        let view = self.ties.as_ref().and_then(|ties| ties.view.as_ref());
        Ok(view.map_or((Vec::new(), Scales::default()), |view| (view.force.clone(), view.scales.clone())))
    }

    /// The problem at `q`, and its multipliers in the system.
    pub(super) fn take_view(&mut self, q: &[f64]) -> Result<(), Fault> {
        let known = self.ties.as_ref().and_then(|ties| ties.view.as_ref()).is_some_and(|view| view.q == q);
        if !known {
            let view = self.view(q)?;
            if let Some(ties) = &mut self.ties {
                ties.view = Some(view);
            }
        }
        if let Some(view) = self.ties.as_ref().and_then(|ties| ties.view.as_ref()) {
            self.system.set_multipliers(&view.multipliers);
        }
        Ok(())
    }

    /// `Z` at a closed position, and its multipliers in the system.
    pub(in super::super) fn tangent(&mut self, q: &[f64]) -> Result<Mat<f64>, Fault> {
        self.take_view(q)?;
        let view = self.ties.as_ref().and_then(|ties| ties.view.as_ref());
        Ok(view.map_or_else(Mat::new, |view| view.tangent.clone()))
    }

    /// What is left of a force when the rows have taken their part, `B Z Zᵀ f`; without rows all of it.
    pub(in super::super) fn along_rows(&mut self, q: &[f64], force: &[f64]) -> Result<Vec<f64>, Fault> {
        if self.ties.is_none() {
            return Ok(force.to_vec());
        }
        let z = self.tangent(q)?;
        let along: Vec<f64> =
            (0..z.ncols()).map(|j| force.iter().enumerate().map(|(i, f)| z[(i, j)] * f).sum()).collect();
        let part = |(i, b): (usize, &f64)| b * (0..z.ncols()).map(|j| z[(i, j)] * along[j]).sum::<f64>();
        Ok(self.metric.iter().enumerate().map(part).collect())
    }

    /// Takes the last view as the place where steps begin; its tangent.
    pub(super) fn step_from_view(&mut self) -> Option<Mat<f64>> {
        let ties = self.ties.as_mut()?;
        let view = ties.view.as_ref()?;
        ties.branch = Some(Branch { tangent: view.tangent.clone(), regular: view.regular });
        Some(view.tangent.clone())
    }

    fn view(&mut self, q: &[f64]) -> Result<View, Fault> {
        let free = self.free.clone();
        let n = free.len();
        let rows = self.system.constraints().map_or(0, |rows| rows.rank());
        self.system.set_multipliers(&vec![0.0; rows]);
        self.system.residual(q, &self.steady, &self.rest, &mut self.full)?;
        let force: Vec<f64> = free.iter().map(|i| self.full[*i]).collect();
        let magnitudes = self.system.balance_magnitudes(q);
        let of_rows = self.system.constraint_matrix(q);
        let all = Mat::from_fn(rows, n, |i, j| of_rows[(i, free[j])]);
        let root: Vec<f64> = self.metric.iter().map(|b| b.sqrt()).collect();
        // Rows of one size: a turn's beside a slide's.
        let size = |i: usize| (0..n).map(|j| (all[(i, j)] / root[j]).powi(2)).sum::<f64>().sqrt();
        let sizes: Vec<f64> = (0..rows).map(|i| size(i).max(f64::MIN_POSITIVE)).collect();
        let largest = sizes.iter().fold(0.0_f64, |m, s| m.max(*s));
        let weigh = |i: usize| if sizes[i] > NEARLY * largest { sizes[i] } else { largest };
        let scaled = Mat::from_fn(rows, n, |i, j| all[(i, j)] / (root[j] * weigh(i)));
        let parts = Parts::of(&scaled);
        let branch = self.ties.as_ref().and_then(|ties| ties.branch.as_ref());
        let smallest = parts.values.iter().copied().filter(|s| *s > DEPENDENT).fold(f64::INFINITY, f64::min);
        let regular = branch.map_or(smallest, |before| before.regular.max(smallest));
        let limit = if branch.is_some() { NEARLY * regular } else { DEPENDENT };
        let singular = parts.values.iter().any(|s| *s < NEARLY * regular);
        let rank = parts.values.iter().filter(|s| **s > limit).count();
        let mut null = Mat::from_fn(n, n - rank, |i, j| parts.right[(i, rank + j)]);
        if let Some(before) = branch
            && before.tangent.ncols() < null.ncols()
        {
            null = nearest(&null, &before.tangent, &root);
        }
        let tangent = Mat::from_fn(n, null.ncols(), |i, j| null[(i, j)] / root[i]);
        let gradient: Vec<f64> = (0..null.ncols()).map(|j| (0..n).map(|i| tangent[(i, j)] * force[i]).sum()).collect();
        let left: Vec<f64> =
            (0..n).map(|i| root[i] * (0..gradient.len()).map(|j| null[(i, j)] * gradient[j]).sum::<f64>()).collect();
        let multipliers: Vec<f64> = parts
            .solve(rank, &(0..n).map(|i| force[i] / root[i]).collect::<Vec<_>>())
            .iter()
            .enumerate()
            .map(|(i, x)| x / weigh(i))
            .collect();
        let held = |i: usize| (0..rows).map(|row| (all[(row, i)] * multipliers[row]).abs()).sum::<f64>();
        // A coordinate in which next to nothing acts still feels the round-off of the loops around it.
        let unit = |i: usize| if self.slides[free[i]] { 1.0 } else { self.length };
        let per_move = |i: usize| if self.slides[free[i]] { self.length } else { 1.0 };
        let size = |i: usize| magnitudes.force[free[i]] + held(i);
        let strongest = (0..n).map(|i| size(i) / unit(i)).fold(0.0, f64::max);
        let stiffness = |i: usize| size(i) / per_move(i) + magnitudes.stiffness[free[i]];
        // Where rows nearly hang on each other, closed positions are known to the round-off of a gap over their angle.
        let slightest = sizes.iter().map(|size| size / largest).filter(|part| *part > DEPENDENT).fold(1.0, f64::min);
        let least = parts.values.get(rank.wrapping_sub(1)).map_or(1.0, |least| *least);
        let unsure = f64::EPSILON / (least * slightest);
        let noise = |i: usize| {
            let terms = magnitudes.noise[free[i]] + held(i) + strongest * unit(i);
            f64::EPSILON * terms + unsure * stiffness(i) * per_move(i)
        };
        let scales = Scales {
            force: (0..n).map(size).collect(),
            noise: (0..n).map(noise).collect(),
            stiffness: (0..n).map(stiffness).collect(),
        };
        let force = left.iter().map(|r| -r).collect();
        Ok(View { q: q.to_vec(), tangent, multipliers, singular, force, scales, regular })
    }

    /// How long a step may be (in the metric) for no coordinate to change by more than [`LONGEST_STEP`], whatever its
    /// direction: from further away the loops might close in another assembly. Without loops any.
    pub(in super::super) fn longest(&self) -> f64 {
        let Some(view) = self.ties.as_ref().and_then(|ties| ties.view.as_ref()) else { return f64::INFINITY };
        let of = |(row, i): (usize, &usize)| {
            let allowed = if self.slides[*i] { LONGEST_STEP * self.length } else { LONGEST_STEP };
            let most = (0..view.tangent.ncols()).map(|j| view.tangent[(row, j)].powi(2)).sum::<f64>().sqrt();
            allowed / most.max(f64::MIN_POSITIVE)
        };
        self.free.iter().enumerate().map(of).fold(f64::INFINITY, f64::min)
    }
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

/// Velocities of the drives where they leave the rest at rest, and the drives that cannot be kept moving.
pub(super) fn steady(system: &mut System<'_>, start: &[f64]) -> (Vec<f64>, Vec<String>) {
    let model = system.model();
    let mut velocity = vec![0.0; model.velocity_count()];
    let mut moving = Vec::new();
    for drive in &model.drives {
        let now = drive.motion.at(0.0);
        if now.velocity != 0.0 {
            velocity[drive.coordinate.velocity] = now.velocity;
            moving.push(format!("`{}`", drive.name));
        }
    }
    if moving.is_empty() {
        return (velocity, Vec::new());
    }
    let mut settled = (start.to_vec(), velocity.clone());
    let size = velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let kept = system.settle(&mut settled.0, &mut settled.1).is_ok()
        && settled.1.iter().zip(&velocity).all(|(a, b)| (a - b).abs() <= 1e-9 * size)
        && model.drives.iter().all(|drive| drive.motion.is_steady());
    if kept { (velocity, Vec::new()) } else { (vec![0.0; model.velocity_count()], moving) }
}
