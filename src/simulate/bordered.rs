//! The Newton matrix of an implicit stage of a system with loops, drives or gears.
//!
//! The multipliers are eliminated: with `a_c` the accelerations that the rows allow, the residual of a stage is
//! `r = M (a − a_c(t, q, v)) = M a + b − τ − Gᵀ λ(t, q, v)`, an ordinary system in `a` (index reduced, every row at the level of
//! accelerations; positions and velocities are settled after the step). Its derivative along a displacement `x`,
//!
//! ```text
//! N x = c₂ M x + Π (c₁ C + K) x,      Π = 1 − Gᵀ A⁻¹ G M⁻¹
//! ```
//!
//! with `K` at fixed λ, the rows' geometric stiffness in it, and what varies in the rows' own velocity terms. `N x = r` is
//! solved bordered, `g̈ = G a + bias` being the rows' accelerations:
//!
//! ```text
//! [ c₂ M + c₁ C + K                 −Gᵀ ] [ x ]   [ r       ]
//! [ c₂ G + c₁ ∂g̈/∂v + ∂g̈/∂q          0  ] [ ν ] = [ G M⁻¹ r ]
//! ```
//!
//! The rows' derivatives are taken as differences: their error, a part in 10⁷, only costs that part of the convergence.

use crate::dynamics::{Fault, System};
use crate::motion::displace;
use faer::Mat;
use faer::linalg::solvers::{PartialPivLu, Solve};

/// A factorized matrix.
pub(super) struct Bordered {
    factor: PartialPivLu<f64>,
    /// `G M⁻¹`.
    weighted: Mat<f64>,
}

impl Bordered {
    /// Factorizes at a state with accelerations `a`.
    pub(super) fn of(
        system: &mut System<'_>,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        c1: f64,
        c2: f64,
    ) -> Result<Self, Fault> {
        let n = a.len();
        let mut allowed = vec![0.0; n];
        system.accelerations(q, v, &mut allowed)?;
        let rows = system.constraint_matrix(q);
        let m = rows.nrows();
        let mut weighted = Mat::zeros(m, n);
        for i in 0..m {
            let gradient: Vec<f64> = (0..n).map(|j| rows[(i, j)]).collect();
            system.solve_mass(&gradient, &mut allowed);
            (0..n).for_each(|j| weighted[(i, j)] = allowed[j]);
        }
        let rates = rate_derivatives(system, q, v, a, c1, m)?;
        let linear = system.linearize(q, v, a)?;
        let matrix = Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
            (true, true) => linear.stiffness[(i, j)] + c1 * linear.damping[(i, j)] + c2 * linear.mass[(i, j)],
            (true, false) => -rows[(j - n, i)],
            (false, true) => c2 * rows[(i - n, j)] + rates[(i - n, j)],
            (false, false) => 0.0,
        });
        Ok(Self { factor: matrix.partial_piv_lu(), weighted })
    }

    /// `x ← N⁻¹ x`.
    pub(super) fn solve(&self, x: &mut [f64]) {
        let (m, n) = (self.weighted.nrows(), x.len());
        let rate = |i: usize| (0..n).map(|j| self.weighted[(i, j)] * x[j]).sum::<f64>();
        let mut both = Mat::from_fn(n + m, 1, |i, _| if i < n { x[i] } else { rate(i - n) });
        self.factor.solve_in_place(&mut both);
        x.iter_mut().enumerate().for_each(|(i, x)| *x = both[(i, 0)]);
    }
}

/// Size of a difference (rad, m).
const DIFFERENCE: f64 = 1e-7;

/// `c₁ ∂g̈/∂v + ∂g̈/∂q` at fixed accelerations, column by column.
fn rate_derivatives(
    system: &mut System<'_>,
    q: &[f64],
    v: &[f64],
    a: &[f64],
    c1: f64,
    rows: usize,
) -> Result<Mat<f64>, Fault> {
    let n = v.len();
    let (mut base, mut moved) = (vec![0.0; rows], vec![0.0; rows]);
    system.constraint_rates(q, v, a, &mut base)?;
    let mut derivatives = Mat::zeros(rows, n);
    let (mut step, mut near, mut faster) = (vec![0.0; n], q.to_vec(), v.to_vec());
    // One difference for both: the velocity moves with the position as within a stage, but never by more than its size.
    let largest = v.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
    let size = DIFFERENCE * (largest / c1.max(f64::MIN_POSITIVE)).min(1.0);
    for j in 0..n {
        step[j] = size;
        near.copy_from_slice(q);
        displace(system.model(), &mut near, &step);
        step[j] = 0.0;
        faster[j] = v[j] + c1 * size;
        system.constraint_rates(&near, &faster, a, &mut moved)?;
        faster[j] = v[j];
        (0..rows).for_each(|i| derivatives[(i, j)] = (moved[i] - base[i]) / size);
    }
    Ok(derivatives)
}
