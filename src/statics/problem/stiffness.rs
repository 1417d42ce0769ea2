//! The stiffness of the free coordinates, factorized: by the O(n) tangent sweep where that covers the forces or few rows
//! or forces that reach far border it, else dense.

use super::bordered::Bordered;
use super::linear::{self, Definite};
use super::split::Across;
use crate::dynamics::{Coefficients, Fault, System, TangentSolver};
use crate::model::Model;
use crate::transfer::tangent::Breakdown;
use faer::{Mat, Side};

/// The stiffness at one place, and its last factorization.
pub(in crate::statics) enum Stiffness {
    /// By sweeps; locked coordinates are held by an infinite shift.
    Sweep { solver: Box<TangentSolver>, free: Vec<usize>, shift: Vec<f64>, rest: Vec<f64>, full: Vec<f64> },
    /// By sweeps, along the motions that loops leave.
    Bordered(Bordered),
    /// By matrices, along the motions that loops leave: `Z` and `H = Zᵀ K Z`.
    Closed { tangent: Mat<f64>, matrix: Mat<f64>, factor: Option<Factor> },
    /// By matrices.
    Dense { matrix: Mat<f64>, factor: Option<Factor> },
}

/// A dense factorization.
pub(in crate::statics) enum Factor {
    Definite(Definite),
    General(linear::General),
}

impl Factor {
    fn of(matrix: &Mat<f64>, shift: &[f64], definite: bool) -> Option<Self> {
        match definite {
            true => Definite::of(matrix, shift).map(Self::Definite),
            false => Some(Self::General(linear::General::of(matrix, shift))),
        }
    }

    fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        match self {
            Self::Definite(factor) => factor.solve(rhs),
            Self::General(factor) => factor.solve(rhs),
        }
    }
}

impl Stiffness {
    /// Of a model without loops, drives and gears; with `bordered` forces that reach far border the sweep.
    pub(in crate::statics) fn new(model: &Model, free: &[usize], bordered: bool) -> Self {
        if !TangentSolver::covers(model) {
            return match bordered {
                true => Self::Bordered(Bordered::new(model, free)),
                false => Self::Dense { matrix: Mat::zeros(0, 0), factor: None },
            };
        }
        let n = model.velocity_count();
        let mut shift = vec![f64::INFINITY; n];
        free.iter().for_each(|i| shift[*i] = 0.0);
        let solver = Box::new(TangentSolver::new(model));
        Self::Sweep { solver, free: free.to_vec(), shift, rest: vec![0.0; n], full: vec![0.0; n] }
    }

    /// Lets only these coordinates move.
    pub(in crate::statics) fn hold_all_but(&mut self, moving: &[usize]) {
        match self {
            Self::Sweep { free, shift, .. } => {
                shift.fill(f64::INFINITY);
                moving.iter().for_each(|i| shift[*i] = 0.0);
                *free = moving.to_vec();
            }
            Self::Bordered(bordered) => bordered.hold_all_but(moving),
            Self::Closed { .. } | Self::Dense { .. } => {}
        }
    }

    pub(in crate::statics) fn is_dense(&self) -> bool {
        !matches!(self, Self::Sweep { .. } | Self::Bordered(_))
    }

    /// Whether it is written down as a sparse matrix.
    pub(in crate::statics) fn is_sparse(&self) -> bool {
        matches!(self, Self::Bordered(bordered) if bordered.is_sparse())
    }

    /// The solver of a sweep that may be bordered; nothing is left.
    pub(in crate::statics) fn take_solver(&mut self) -> Option<Box<TangentSolver>> {
        match std::mem::replace(self, Self::Dense { matrix: Mat::zeros(0, 0), factor: None }) {
            Self::Bordered(bordered) => Some(bordered.into_solver()),
            _ => None,
        }
    }

    pub(in crate::statics) fn set_dense(&mut self, new: Mat<f64>) {
        *self = Self::Dense { matrix: new, factor: None };
    }

    /// Gathers what the sweep needs at `q`.
    pub(in crate::statics) fn look(
        &mut self,
        system: &mut System,
        q: &[f64],
        rest: &[f64],
        symmetric: bool,
    ) -> Result<(), Fault> {
        let solver = match self {
            Self::Sweep { solver, .. } => solver,
            Self::Bordered(bordered) => return bordered.look(system, q, (Across::Full(Vec::new()), Vec::new())),
            Self::Closed { .. } | Self::Dense { .. } => return Ok(()),
        };
        system.at(0.0, q, rest).gather_tangent(solver, rest, &Coefficients { symmetric, ..Coefficients::default() })
    }

    /// Negative directions of `K + diag(by)`, where sweeps can tell.
    pub(in crate::statics) fn negatives(&mut self, system: &System, by: &[f64]) -> Option<usize> {
        if let Self::Sweep { .. } = self
            && self.sweep(system, by, false).is_err()
        {
            return None;
        }
        match self {
            Self::Sweep { solver, .. } => solver.negatives(),
            Self::Bordered(bordered) => bordered.factorize(system, by, false).then(|| bordered.negatives())?,
            Self::Closed { .. } | Self::Dense { .. } => None,
        }
    }

    /// `K + diag(by)`; false if it is singular, or not definite and that was wanted.
    pub(in crate::statics) fn factorize(&mut self, system: &System, by: &[f64], definite: bool) -> bool {
        match self {
            Self::Sweep { .. } => self.sweep(system, by, definite).is_ok(),
            Self::Bordered(bordered) => bordered.factorize(system, by, definite),
            Self::Closed { tangent, matrix, factor } => {
                *factor = Factor::of(&shifted_along(tangent, matrix, by), &[], definite);
                factor.is_some()
            }
            Self::Dense { matrix, factor } => {
                *factor = Factor::of(matrix, by, definite);
                factor.is_some()
            }
        }
    }

    /// `H + σ 1` along the motions that loops leave, in whose coordinates the metric is the identity.
    pub(in crate::statics) fn factorize_along(&mut self, shift: f64) -> bool {
        let Self::Closed { matrix, factor, .. } = self else { return false };
        *factor = Factor::of(matrix, &vec![shift; matrix.nrows()], true);
        factor.is_some()
    }

    fn sweep(&mut self, system: &System, by: &[f64], definite: bool) -> Result<(), Breakdown> {
        let Self::Sweep { solver, free, shift, rest, .. } = self else { return Ok(()) };
        for (i, by) in free.iter().zip(by) {
            shift[*i] = *by;
        }
        let with = Coefficients { shift, definite, ..Coefficients::default() };
        system.factorize_shifted(solver, rest, &with)
    }

    pub(in crate::statics) fn solve(&mut self, rhs: &[f64]) -> Vec<f64> {
        match self {
            Self::Sweep { solver, free, full, .. } => {
                full.fill(0.0);
                for (i, value) in free.iter().zip(rhs) {
                    full[*i] = *value;
                }
                solver.solve(full);
                free.iter().map(|i| full[*i]).collect()
            }
            Self::Bordered(bordered) => bordered.solve(rhs),
            Self::Closed { tangent, .. } if tangent.ncols() == 0 => vec![0.0; rhs.len()],
            Self::Closed { tangent, factor: Some(factor), .. } => {
                let (n, count) = (tangent.nrows(), tangent.ncols());
                let along: Vec<f64> = (0..count).map(|j| (0..n).map(|i| tangent[(i, j)] * rhs[i]).sum()).collect();
                combined(tangent, &factor.solve(&along))
            }
            Self::Dense { factor: Some(factor), .. } => factor.solve(rhs),
            Self::Closed { factor: None, .. } | Self::Dense { factor: None, .. } => vec![f64::NAN; rhs.len()],
        }
    }

    /// [`Stiffness::solve`] to half the digits where each of them costs.
    pub(in crate::statics) fn solve_roughly(&mut self, rhs: &[f64]) -> Vec<f64> {
        let Self::Bordered(bordered) = self else { return self.solve(rhs) };
        bordered.be_rough(true);
        let x = bordered.solve(rhs);
        bordered.be_rough(false);
        x
    }

    /// The damped step of Levenberg and Marquardt, `(Kᵀ B⁻¹ K + λ B) x = Kᵀ B⁻¹ f`, λ being `part` of the largest
    /// curvature. Needs matrices; `matrix` is the one of a sweep.
    pub(in crate::statics) fn levenberg(
        &self,
        swept: &Mat<f64>,
        metric: &[f64],
        force: &[f64],
        part: f64,
    ) -> Option<Vec<f64>> {
        let Self::Closed { tangent, matrix, .. } = self else { return levenberg(swept, metric, force, part) };
        let (n, count) = (tangent.nrows(), tangent.ncols());
        let along: Vec<f64> = (0..count).map(|j| (0..n).map(|i| tangent[(i, j)] * force[i]).sum()).collect();
        // Along the motions the metric is the identity.
        Some(combined(tangent, &levenberg(matrix, &vec![1.0; count], &along, part)?))
    }

    /// Where `K + diag(by)` is negative somewhere, a direction to look for that from; else none.
    pub(in crate::statics) fn negative_direction(&mut self, system: &System, by: &[f64]) -> Option<Vec<f64>> {
        match self {
            Self::Sweep { .. } => {}
            Self::Bordered(bordered) => return bordered.negative_direction(system, by),
            Self::Closed { tangent, matrix, .. } => {
                return lowest(&shifted_along(tangent, matrix, by)).map(|y| combined(tangent, &y));
            }
            Self::Dense { matrix, .. } => {
                let n = by.len();
                return lowest(&Mat::from_fn(n, n, |i, j| matrix[(i, j)] + if i == j { by[i] } else { 0.0 }));
            }
        }
        let breakdown = self.sweep(system, by, true).err()?;
        let Self::Sweep { solver, free, full, .. } = self else { return None };
        solver.negative_direction(system.model(), breakdown, full);
        Some(free.iter().map(|i| full[*i]).collect())
    }
}

/// `H + Zᵀ diag(by) Z`.
fn shifted_along(tangent: &Mat<f64>, matrix: &Mat<f64>, by: &[f64]) -> Mat<f64> {
    if by.iter().all(|by| *by == 0.0) {
        return matrix.clone();
    }
    let weighted = Mat::from_fn(tangent.nrows(), tangent.ncols(), |i, j| by[i] * tangent[(i, j)]);
    matrix + tangent.transpose() * weighted
}

/// `Z y`.
fn combined(tangent: &Mat<f64>, y: &[f64]) -> Vec<f64> {
    (0..tangent.nrows()).map(|i| y.iter().enumerate().map(|(j, y)| tangent[(i, j)] * y).sum()).collect()
}

/// The direction of the lowest eigenvalue where that is negative.
fn lowest(matrix: &Mat<f64>) -> Option<Vec<f64>> {
    let n = matrix.nrows();
    if n == 0 {
        return None;
    }
    let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    (eigen.S()[0] < 0.0).then(|| (0..n).map(|i| eigen.U()[(i, 0)]).collect())
}

fn levenberg(k: &Mat<f64>, b: &[f64], force: &[f64], part: f64) -> Option<Vec<f64>> {
    let n = force.len();
    let weighted = Mat::from_fn(n, n, |i, j| k[(i, j)] / b[i]);
    let normal = k.transpose() * &weighted;
    let curvature = (0..n).map(|i| normal[(i, i)] / b[i]).fold(0.0, f64::max);
    let shift: Vec<f64> = b.iter().map(|b| part * curvature * b).collect();
    let rhs: Vec<f64> = (0..n).map(|j| (0..n).map(|i| weighted[(i, j)] * force[i]).sum()).collect();
    Some(Definite::of(&normal, &shift)?.solve(&rhs))
}
