//! The stiffness of the free coordinates, factorized: by the O(n) tangent sweep where that covers the forces, else dense.

use super::linear::{self, Definite};
use crate::dynamics::{Coefficients, Fault, System, TangentSolver};
use crate::model::Model;
use crate::transfer::tangent::Breakdown;
use faer::{Mat, Side};

/// The stiffness at one place, and its last factorization.
pub(super) enum Stiffness {
    /// By sweeps; locked coordinates are held by an infinite shift.
    Sweep { solver: Box<TangentSolver>, free: Vec<usize>, shift: Vec<f64>, rest: Vec<f64>, full: Vec<f64> },
    /// By matrices.
    Dense { matrix: Mat<f64>, factor: Option<Factor> },
}

/// A dense factorization.
pub(super) enum Factor {
    Definite(Definite),
    General(linear::General),
}

impl Stiffness {
    pub(super) fn new(model: &Model, free: &[usize]) -> Self {
        if !TangentSolver::covers(model) {
            return Self::Dense { matrix: Mat::zeros(0, 0), factor: None };
        }
        let n = model.velocity_count();
        let mut shift = vec![f64::INFINITY; n];
        free.iter().for_each(|i| shift[*i] = 0.0);
        let solver = Box::new(TangentSolver::new(model));
        Self::Sweep { solver, free: free.to_vec(), shift, rest: vec![0.0; n], full: vec![0.0; n] }
    }

    pub(super) fn is_dense(&self) -> bool {
        matches!(self, Self::Dense { .. })
    }

    pub(super) fn set_dense(&mut self, new: Mat<f64>) {
        *self = Self::Dense { matrix: new, factor: None };
    }

    /// Gathers what the sweep needs at `q`.
    pub(super) fn look(
        &mut self,
        system: &mut System<'_>,
        q: &[f64],
        rest: &[f64],
        symmetric: bool,
    ) -> Result<(), Fault> {
        let Self::Sweep { solver, shift, .. } = self else { return Ok(()) };
        let with = Coefficients { shift, symmetric, ..Coefficients::default() };
        system.factorize_tangent(solver, q, rest, rest, &with)?;
        Ok(())
    }

    /// `K + diag(by)`; false where it is singular, or not definite and that was wanted.
    pub(super) fn factorize(&mut self, system: &System<'_>, by: &[f64], definite: bool) -> bool {
        match self {
            Self::Sweep { .. } => self.sweep(system, by, definite).is_ok(),
            Self::Dense { matrix, factor } => {
                *factor = match definite {
                    true => Definite::of(matrix, by).map(Factor::Definite),
                    false => Some(Factor::General(linear::General::of(matrix, by))),
                };
                factor.is_some()
            }
        }
    }

    fn sweep(&mut self, system: &System<'_>, by: &[f64], definite: bool) -> Result<(), Breakdown> {
        let Self::Sweep { solver, free, shift, rest, .. } = self else { return Ok(()) };
        for (i, by) in free.iter().zip(by) {
            shift[*i] = *by;
        }
        let with = Coefficients { shift, definite, ..Coefficients::default() };
        system.factorize_shifted(solver, rest, &with)
    }

    pub(super) fn solve(&mut self, model: &Model, rhs: &[f64]) -> Vec<f64> {
        match self {
            Self::Sweep { solver, free, full, .. } => {
                full.fill(0.0);
                for (i, value) in free.iter().zip(rhs) {
                    full[*i] = *value;
                }
                solver.solve(model, full);
                free.iter().map(|i| full[*i]).collect()
            }
            Self::Dense { factor: Some(Factor::Definite(factor)), .. } => factor.solve(rhs),
            Self::Dense { factor: Some(Factor::General(factor)), .. } => factor.solve(rhs),
            Self::Dense { factor: None, .. } => vec![f64::NAN; rhs.len()],
        }
    }

    /// A direction in which `K + diag(by)` is negative, or none.
    pub(super) fn negative_direction(&mut self, system: &System<'_>, by: &[f64]) -> Option<Vec<f64>> {
        if let Self::Dense { matrix, .. } = self {
            let n = by.len();
            let shifted = Mat::from_fn(n, n, |i, j| matrix[(i, j)] + if i == j { by[i] } else { 0.0 });
            let eigen = shifted.self_adjoint_eigen(Side::Lower).ok()?;
            return (n > 0 && eigen.S()[0] < 0.0).then(|| (0..n).map(|i| eigen.U()[(i, 0)]).collect());
        }
        let breakdown = self.sweep(system, by, true).err()?;
        let Self::Sweep { solver, free, full, .. } = self else { return None };
        solver.negative_direction(system.model(), breakdown, full);
        Some(free.iter().map(|i| full[*i]).collect())
    }
}
