//! Closed positions: the landscape of a scene with loops, drives and gears.
//!
//! ```text
//! r(q): the residual at rest,   G: gradients of the rows,   B: the inertia each coordinate sees
//! (1)  G B^(−1/2) = U S Vᵀ,   Z = B^(−1/2) V₂: the motions that keep every row (V₂ spans the null space)
//! (2)  λ = U S⁻¹ V₁ᵀ B^(−1/2) r: what the rows have to hold;   f = −B Z Zᵀ r: what they cannot      (see `split`)
//! (3)  H = Zᵀ (∂(r − Gᵀλ)/∂q) Z: the stiffness along the closed positions, their curvature in it
//! ```
//!
//! Searches see the coordinates of the tree, forces `f` that make no rows work, and steps `Z y` after which the rows are
//! closed again: to them it is a landscape like any other.
//!
//! **Where few rows reach across a large scene** (`by_sweeps`) neither `Z` nor `H` is made: what the rows hold, `C = B^(1/2) U'`,
//! borders the tangent of the tree, whose sweep is the solver (see `bordered`). Elsewhere matrices are dense: with few
//! motions left `H` takes a sweep for each of them; the factorization of `G` is cubic in the number of rows, that of `H`
//! in the number of motions.
//!
//! **Drives** stay where they are at t = 0, and where the rest can be at rest beside a driven motion (a governor that
//! spins), they keep their velocity: the kinetic energy then counts as a potential of the opposite sign.
//! **Locks** take their coordinates out of all of this.
//! **Singular positions**: where rows are linearly dependent that are independent elsewhere, the motions that only exist
//! there do not count: the branch that the search came along is kept. Dependent rows whose prestress stiffens motions push
//! with the rest (see `prestress`).

use super::bordered::Bordered;
use super::prestress::Prestress;
use super::split::{Across, Branch, Given, Motions, NEARLY, SparseGiven, Split, split, split_clearly};
use super::stiffness::Stiffness;
use super::{Landscape, Scales};
use crate::constraint::{Closer, Constraints};
use crate::dynamics::{Fault, Magnitudes, System, TangentSolver};
use crate::model::Model;
use crate::round_off::EXPECTED_FORCE;
use crate::sparse::SparseRows;
use faer::Mat;
use std::sync::Arc;

/// Largest turn (rad), and part of the scene's length, of one step.
const LONGEST_STEP: f64 = 0.6;

/// Up to so many free coordinates all modes are computed, by matrices; above only the lowest, by sweeps.
pub(in crate::statics) const MOST_MODES: usize = 64;

/// Sweeps are the faster way in scenes of more than [`MOST_MODES`] free coordinates, where a factorization needs no more
/// right sides than this part of them.
const FEW: usize = 4;

/// The rows of a model, and where its search stands on the closed positions.
pub(in crate::statics) struct Ties {
    /// Once there is something to close: places that are closed ask for none.
    closer: Option<Closer>,
    /// Whether rows border a sweep; else matrices are dense.
    pub(in crate::statics) sweeps: bool,
    /// Whether the tangent is a sparse matrix with all of them.
    sparse: bool,
    /// Drives whose velocity cannot be kept.
    pub(in crate::statics) frozen: Vec<String>,
    /// The problem at the last position.
    pub(in crate::statics) view: Option<View>,
    pub(in crate::statics) branch: Option<Branch>,
    /// Whether prestress of dependent rows stiffens motions; `None` before it has been looked at.
    pub(in crate::statics) stiffens: Option<bool>,
    /// What it did where the search ended.
    pub(in crate::statics) prestress: Prestress,
}

/// The rows at one position. Lists are over free coordinates.
#[derive(Debug, Clone)]
pub(in crate::statics) struct View {
    q: Vec<f64>,
    motions: Motions,
    /// `λ`, one per independent row.
    pub(in crate::statics) multipliers: Vec<f64>,
    /// Rows are linearly dependent here that are not elsewhere.
    pub(in crate::statics) singular: bool,
    force: Vec<f64>,
    scales: Scales,
    regular: f64,
}

impl Ties {
    pub(in crate::statics) fn new(frozen: Vec<String>, [sweeps, sparse]: [bool; 2]) -> Self {
        let (view, branch, stiffens, prestress) = (None, None, None, Prestress::None);
        Self { closer: None, sweeps, sparse, frozen, view, branch, stiffens, prestress }
    }

    /// Takes matrices from now on: what was seen by other ways is forgotten.
    pub(in crate::statics) fn go_densely(&mut self) {
        (self.sweeps, self.sparse, self.view, self.branch) = (false, false, None, None);
    }
}

impl Landscape<'_> {
    /// Brings a position onto the rows; false if that cannot be done.
    pub(in crate::statics) fn close(&mut self, q: &mut [f64]) -> bool {
        let model = self.system.model();
        self.ties.as_mut().is_none_or(|ties| ties.closer.get_or_insert_with(|| Closer::new(model)).close(model, q))
    }

    /// What the search remembers of where it came from.
    pub(in crate::statics) fn branch(&self) -> Option<Branch> {
        self.ties.as_ref().and_then(|ties| ties.branch.clone())
    }

    pub(in crate::statics) fn set_branch(&mut self, branch: Option<Branch>) {
        if let Some(ties) = &mut self.ties {
            ties.branch = branch;
        }
    }

    /// Forces and sizes at a closed position.
    pub(in crate::statics) fn tied_forces(&mut self, q: &[f64]) -> Result<(Vec<f64>, Scales), Fault> {
        self.take_view(q)?;
        let view = self.ties.as_ref().and_then(|ties| ties.view.as_ref());
        Ok(view.map_or((Vec::new(), Scales::default()), |view| (view.force.clone(), view.scales.clone())))
    }

    /// The problem at `q`, and its multipliers in the system.
    pub(in crate::statics) fn take_view(&mut self, q: &[f64]) -> Result<(), Fault> {
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
    pub(in crate::statics) fn tangent(&mut self, q: &[f64]) -> Result<Mat<f64>, Fault> {
        self.take_view(q)?;
        let view = self.ties.as_ref().and_then(|ties| ties.view.as_ref());
        Ok(view.map_or_else(Mat::new, |view| view.motions.basis(&self.metric)))
    }

    /// The part of a force that the rows do not take, `B Z Zᵀ f`; without rows all of it.
    pub(in crate::statics) fn along_rows(&mut self, q: &[f64], force: &[f64]) -> Result<Vec<f64>, Fault> {
        if self.ties.is_none() {
            return Ok(force.to_vec());
        }
        self.take_view(q)?;
        let view = self.ties.as_ref().and_then(|ties| ties.view.as_ref());
        Ok(view.map_or_else(Vec::new, |view| view.motions.felt(force, &self.metric)))
    }

    /// The rows that hold what is not a motion at a closed position, where sweeps are the way; and its multipliers in the
    /// system.
    pub(in crate::statics) fn rows_across(&mut self, q: &[f64]) -> Result<Across, Fault> {
        self.take_view(q)?;
        let view = self.ties.as_ref().and_then(|ties| ties.view.as_ref());
        Ok(view.map_or_else(|| Across::Full(Vec::new()), |view| view.motions.rows()))
    }

    /// Takes the stiffness along the closed positions for solutions by sweeps.
    pub(in crate::statics) fn look_along(&mut self, q: &[f64]) -> Result<(), Fault> {
        let (rows, springs) = (self.rows_across(q)?, self.braces());
        self.step_from_view();
        if !matches!(self.stiffness, Stiffness::Bordered(_)) {
            self.stiffness = Stiffness::Bordered(Bordered::new(self.model(), &self.free));
        }
        let Stiffness::Bordered(bordered) = &mut self.stiffness else { return Ok(()) };
        bordered.look(self.system, q, (rows, springs))
    }

    /// A spring for each free coordinate, at the place of the view: of one frequency in the metric, as stiff as the stiffest terms.
    fn braces(&self) -> Vec<f64> {
        let Some(view) = self.ties.as_ref().and_then(|ties| ties.view.as_ref()) else { return Vec::new() };
        let curvatures = view.scales.stiffness.iter().zip(&self.metric).map(|(k, b)| k / b);
        let largest = curvatures.fold(0.0, f64::max);
        self.metric.iter().map(|b| largest * b).collect()
    }

    /// `Z` and `H` at a closed position.
    pub(in crate::statics) fn stiffness_along(&mut self, q: &[f64]) -> Result<(Mat<f64>, Mat<f64>), Fault> {
        let z = self.tangent(q)?;
        let shares = self.share_prestress(q, &z)?;
        let (n, count) = (z.nrows(), z.ncols());
        let along = match 2 * count < n || shares {
            // A sweep for each motion.
            true => {
                let mut all = Mat::zeros(self.steady.len(), count);
                for (row, i) in self.free.iter().enumerate() {
                    (0..count).for_each(|j| all[(*i, j)] = z[(row, j)]);
                }
                let pushed = self.system.at(0.0, q, &self.steady).stiffness_times(&all)?;
                Mat::from_fn(n, count, |row, j| pushed[(self.free[row], j)])
            }
            false => self.dense_stiffness(q)? * &z,
        };
        let h = z.transpose() * along;
        let h = match self.conservative {
            true => Mat::from_fn(count, count, |i, j| 0.5 * (h[(i, j)] + h[(j, i)])),
            false => h,
        };
        if shares && self.conservative {
            // No step leads along what only first order allows.
            let magnitude = self.ties.as_ref().and_then(|ties| ties.view.as_ref()).map(|view| &view.scales.stiffness);
            let sizes = magnitude.map_or(vec![1.0; count], |magnitude| super::sizes::sizes(Some(&z), magnitude));
            let held = self.certified(q, &z, &h, &sizes)?;
            return Ok((z, held.unwrap_or(h)));
        }
        Ok((z, h))
    }

    /// Takes the last view as the place where steps begin.
    pub(in crate::statics) fn step_from_view(&mut self) {
        let Some(ties) = &mut self.ties else { return };
        if let Some(view) = &ties.view {
            ties.branch = Some(Branch { motions: view.motions.clone(), regular: view.regular });
        }
    }

    fn view(&mut self, q: &[f64]) -> Result<View, Fault> {
        if self.ties.as_ref().is_some_and(|ties| ties.sparse) {
            if let Some(view) = self.sparse_view(q)? {
                return Ok(view);
            }
            // Rows are nearly dependent here: singular values decide.
            self.ties.iter_mut().for_each(|ties| ties.go_densely());
        }
        let free = self.free.clone();
        let n = free.len();
        let (magnitudes, force) = self.unheld(q)?;
        let of_rows = self.system.at(0.0, q, &self.steady).constraint_matrix();
        let rows = of_rows.nrows();
        let all = Mat::from_fn(rows, n, |i, j| of_rows[(i, free[j])]);
        let root: Vec<f64> = self.metric.iter().map(|b| b.sqrt()).collect();
        let (of_row, per) = self.units();
        let geometric = Mat::from_fn(rows, n, |i, j| all[(i, j)] / of_row[i]);
        let squares = |rows: &Mat<f64>, units: &[f64]| {
            let square = |i: usize| units.iter().enumerate().map(|(j, unit)| (rows[(i, j)] / unit).powi(2)).sum();
            row_sizes((0..rows.nrows()).map(square).collect())
        };
        let sizes = squares(&all, &root);
        let plain: Vec<f64> = squares(&geometric, &per).iter().zip(&of_row).map(|(size, unit)| size * unit).collect();
        let given = Given {
            rows: Mat::from_fn(rows, n, |i, j| all[(i, j)] / (root[j] * sizes[i])),
            plain: Mat::from_fn(rows, n, |i, j| all[(i, j)] / (per[j] * plain[i])),
            forces: force.iter().zip(&root).map(|(f, root)| f / root).collect(),
            sizes: plain.iter().zip(&sizes).map(|(plain, size)| plain / size).collect(),
            root,
        };
        let branch = self.ties.as_ref().and_then(|ties| ties.branch.as_ref());
        let sweeps = self.ties.as_ref().is_some_and(|ties| ties.sweeps);
        let split = split(&given, branch, sweeps);
        let entries = |j: usize| (0..rows).map(|i| (i, all[(i, j)])).filter(|entry| entry.1 != 0.0).collect();
        Ok(self.seen(split, &sizes, (0..n).map(entries).collect(), (q, magnitudes), &force))
    }

    /// The view of a position by sparse rows; `None` if they are not independent by more than round-off.
    fn sparse_view(&mut self, q: &[f64]) -> Result<Option<View>, Fault> {
        let (magnitudes, force) = self.unheld(q)?;
        let (of_rows, mut pulls) = self.system.at(0.0, q, &self.steady).constraint_rows_and_pulls();
        let mut place = vec![usize::MAX; self.steady.len()];
        self.free.iter().enumerate().for_each(|(j, i)| place[*i] = j);
        let entries = |row: usize| of_rows.row(row).map(|(i, value)| (place[i], value));
        let free = |row: usize| entries(row).filter(|(j, _)| *j != usize::MAX).collect();
        let all = SparseRows::of((0..of_rows.len()).map(free).collect());
        let (of_row, per) = self.units();
        let metric = &self.metric;
        let square = |row: usize| all.row(row).map(|(j, value)| value * value / metric[j]).sum();
        let sizes = row_sizes((0..all.len()).map(square).collect());
        let square = |row: usize| all.row(row).map(|(j, value)| (value / (of_row[row] * per[j])).powi(2)).sum();
        let plain = row_sizes((0..all.len()).map(square).collect());
        pulls.iter_mut().zip(&sizes).for_each(|(pull, size)| pull.scale(1.0 / size));
        let given = SparseGiven {
            pulls,
            rows: all.map(|row, _, value| value / sizes[row]),
            plain: all.map(|row, j, value| value / (per[j] * plain[row] * of_row[row])),
            force: &force,
            metric,
        };
        let branch = self.ties.as_ref().and_then(|ties| ties.branch.as_ref());
        let before = self.ties.as_ref().and_then(|ties| ties.view.as_ref()).map(|view| &view.motions);
        let Some(split) = split_clearly(given, branch.map(|branch| branch.regular), before) else { return Ok(None) };
        let mut columns = vec![Vec::new(); self.free.len()];
        for row in 0..all.len() {
            all.row(row).for_each(|(j, value)| columns[j].push((row, value)));
        }
        Ok(Some(self.seen(split, &sizes, columns, (q, magnitudes), &force)))
    }

    /// Sizes of all terms, and the residual of the free coordinates, without multipliers.
    fn unheld(&mut self, q: &[f64]) -> Result<(Magnitudes, Vec<f64>), Fault> {
        let rows = self.system.constraints().map_or(0, |rows| rows.rank());
        self.system.set_multipliers(&vec![0.0; rows]);
        let magnitudes = self.system.at(0.0, q, &self.steady).residual(&self.rest, &mut self.full)?.magnitudes();
        Ok((magnitudes, self.free.iter().map(|i| self.full[*i]).collect()))
    }

    /// Units of the rows, and of the free coordinates.
    fn units(&self) -> (Vec<f64>, Vec<f64>) {
        let (of_row, of_velocity) = self.system.row_units();
        let per = |i: &usize| 1.0 / if of_velocity[*i] > 0.0 { of_velocity[*i] } else { 1.0 };
        (of_row, self.free.iter().map(per).collect())
    }

    /// The view of a split of rows of these sizes, with the entries of the rows column by column.
    fn seen(
        &mut self,
        Split { motions, multipliers, singular, regular }: Split,
        sizes: &[f64],
        columns: Vec<Vec<(usize, f64)>>,
        (q, magnitudes): (&[f64], Magnitudes),
        force: &[f64],
    ) -> View {
        let multipliers: Vec<f64> = multipliers.iter().zip(sizes).map(|(x, size)| x / size).collect();
        let left = motions.felt(force, &self.metric);
        let scales = self.scales(&columns, &multipliers, &motions, (q, magnitudes));
        let force = left.iter().map(|r| -r).collect();
        View { q: q.to_vec(), motions, multipliers, singular, force, scales, regular }
    }

    /// Sizes of what cancels in the forces that are left to the motions, with the rows column by column, and its
    /// round-off. Each motion feels the terms of all coordinates that work on it, and their errors.
    fn scales(
        &mut self,
        columns: &[Vec<(usize, f64)>],
        multipliers: &[f64],
        motions: &Motions,
        (q, magnitudes): (&[f64], Magnitudes),
    ) -> Scales {
        let (free, n) = (&self.free, self.free.len());
        self.system.set_multipliers(multipliers);
        let mut squares = magnitudes.squares;
        self.system.at(0.0, q, &self.steady).add_multiplier_squares(&mut squares);
        let errors: Vec<f64> = free.iter().map(|i| squares[*i]).collect();
        let pushes = |i: usize| columns[i].iter().map(|(row, value)| (*row, value * multipliers[*row]));
        let held = |i: usize| self.system.constraints().map_or(0.0, |of| of.sum_of_elements(pushes(i)));
        let sizes: Vec<f64> = (0..n).map(|i| (magnitudes.force[free[i]] + held(i)).powi(2)).collect();
        let stiffness = |i: usize| {
            let per_move = if self.slides[free[i]] { self.length } else { 1.0 };
            let pushes = pushes(i).map(|(_, push)| push.abs()).sum::<f64>();
            (magnitudes.force[free[i]] + pushes) / per_move + magnitudes.stiffness[free[i]]
        };
        let noise = motions.felt_size(&errors, &self.metric);
        Scales {
            force: motions.felt_size(&sizes, &self.metric),
            noise: noise.iter().map(|error| EXPECTED_FORCE.of(*error)).collect(),
            stiffness: (0..n).map(stiffness).collect(),
        }
    }

    /// How many times further than [`LONGEST_STEP`] a step from `q` changes a coordinate: from further away the loops might
    /// close in another assembly. Bodies that have gone many lengths of the scene may go as far again. Zero without loops.
    pub(in crate::statics) fn stretch(&self, q: &[f64], step: &[f64]) -> f64 {
        if self.ties.is_none() {
            return 0.0;
        }
        let gone = self.origin.as_ref().map_or(Vec::new(), |origin| super::apart(self.model(), &origin.q, q));
        let distances = gone.iter().zip(&self.slides).filter(|(_, slides)| **slides);
        let farthest = distances.fold(self.length, |most, (gone, _)| most.max(gone.abs()));
        let of =
            |(x, i): (&f64, &usize)| x.abs() / if self.slides[*i] { LONGEST_STEP * farthest } else { LONGEST_STEP };
        step.iter().zip(&self.free).map(of).fold(0.0, f64::max)
    }
}

/// What makes rows of one size (a turn's beside a slide's), from the sums of the squares of their entries in equal units; nearly
/// nothing stays that.
fn row_sizes(squares: Vec<f64>) -> Vec<f64> {
    let sizes: Vec<f64> = squares.into_iter().map(|square: f64| square.sqrt().max(f64::MIN_POSITIVE)).collect();
    let largest = sizes.iter().fold(0.0_f64, |m, s| m.max(*s));
    sizes.into_iter().map(|size| if size > NEARLY * largest { size } else { largest }).collect()
}

/// Whether the tangent of a scene that is at rest is a sparse matrix with its rows.
pub(in crate::statics) fn by_sparse_rows(model: &Model, free: &[usize], steady: &[f64]) -> bool {
    free.len() > MOST_MODES && steady.iter().all(|v| *v == 0.0) && TangentSolver::is_sparse(model)
}

/// Whether the rows of a scene and its forces that reach far border the sweep of its tree: few of them across a large
/// scene that is at rest.
pub(in crate::statics) fn by_sweeps(model: &Model, free: &[usize], steady: &[f64]) -> bool {
    let sides = || TangentSolver::further_sides(model) + Constraints::new(model).map_or(0, |rows| rows.rank());
    free.len() > MOST_MODES && steady.iter().all(|v| *v == 0.0) && FEW * sides() <= free.len()
}

/// Velocities of the drives where they leave the rest at rest, and the drives that cannot be kept moving.
pub(in crate::statics) fn steady(system: &mut System, start: &[f64]) -> (Vec<f64>, Vec<String>) {
    let model = &Arc::clone(system.model());
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
    let kept = system.settle(0.0, &mut settled.0, &mut settled.1).is_ok()
        && settled.1.iter().zip(&velocity).all(|(a, b)| (a - b).abs() <= 1e-9 * size)
        && model.drives.iter().all(|drive| drive.motion.is_steady());
    if kept { (velocity, Vec::new()) } else { (vec![0.0; model.velocity_count()], moving) }
}
