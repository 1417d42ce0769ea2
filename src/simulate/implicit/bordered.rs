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
//! [ T    −Gᵀ ] [ x ]   [ r       ]      T = c₂ M + c₁ C + K              the tangent of the tree, by its sweep
//! [ B     0  ] [ ν ] = [ G M⁻¹ r ]      B = c₂ G + c₁ ∂g̈/∂v + ∂g̈/∂q
//!
//! x = x₀ + Y ν,   T x₀ = r,   T Y = Gᵀ,   (B Y) ν = G M⁻¹ r − B x₀
//! ```
//!
//! so one factorization costs a solution of the tree's tangent for each row. `∂g̈` is only needed along single directions:
//! it is taken as a difference there, whose error, a part in 10⁷, only costs that part of the convergence.
//!
//! Near a singular position linearly dependent rows are left out of the border (not of the residual).
//!
//! **Many rows** beside a tangent that is a sparse matrix are rows of that matrix, with `c₂ G` in place of `B`:
//!
//! ```text
//! [ T     −Gᵀ ] [ x ]   [ r ]
//! [ c₂ G   0  ] [ ν ] = [ s ]        s = G M⁻¹ r,  then  s ← s − B x for a correction of x, twice
//! ```
//!
//! `B` differs from `c₂ G` by parts of the size of a step's turn, `h ω`: after two corrections the error is its cube.

use crate::dynamics::{Coefficients, Dense, Fault, System, TangentSolver};
use crate::integrate::Point;
use crate::motion::displace;
use crate::sparse::SparseRows;

/// A factorized matrix. Valid until the next factorization, whatever the system evaluates in between.
pub(in crate::simulate) struct Bordered {
    tree: TangentSolver,
    /// `None` while the rows are those of a sparse matrix.
    border: Option<Border>,
    /// `c₂ G` where the rows are those of a sparse matrix.
    sparse: Option<SparseRows>,
    /// Rows that are left out, and the clearance below which they are.
    weak: Vec<bool>,
    clearance: f64,
    /// Where the matrix belongs to.
    at: At,
    /// `g̈` there.
    base: Vec<f64>,
    /// Scratch: a displaced state, its `g̈`, a solution.
    position: Vec<f64>,
    velocity: Vec<f64>,
    rates: Vec<f64>,
    nu: Vec<f64>,
    x: Vec<f64>,
}

/// A border of dense rows.
struct Border {
    /// `G`, by rows.
    gradient: Vec<f64>,
    /// `G M⁻¹`, by rows.
    weighted: Vec<f64>,
    /// `Yᵀ`, by rows.
    responses: Vec<f64>,
    /// `B Y`.
    small: Dense,
}

impl Border {
    fn new(m: usize, n: usize) -> Self {
        let zeros = || vec![0.0; m * n];
        Self { gradient: zeros(), weighted: zeros(), responses: zeros(), small: Dense::new(m) }
    }
}

#[derive(Default)]
struct At {
    time: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    c1: f64,
    c2: f64,
}

/// Size of a difference (rad, m).
const DIFFERENCE: f64 = 1e-7;
/// Corrections of a solution by a sparse matrix for what `c₂ G` leaves of `B`.
const CORRECTIONS: usize = 2;

impl Bordered {
    /// Room for a system.
    pub(in crate::simulate) fn new(system: &System) -> Self {
        let model = system.model();
        let (m, n) = (system.constraint_rank(), model.velocity_count());
        let is_sparse = TangentSolver::is_sparse(model);
        let at = At { q: model.start_position.clone(), v: vec![0.0; n], a: vec![0.0; n], ..At::default() };
        Self {
            tree: TangentSolver::new(model),
            border: (!is_sparse).then(|| Border::new(m, n)),
            sparse: is_sparse.then(SparseRows::default),
            weak: vec![false; m],
            clearance: 0.0,
            position: at.q.clone(),
            velocity: vec![0.0; n],
            at,
            base: vec![0.0; m],
            rates: vec![0.0; m],
            nu: vec![0.0; m],
            x: vec![0.0; n],
        }
    }

    /// Factorizes at a point, `shift` added to the diagonal of the tree's tangent; rows with a clearance below `weak` are
    /// left out. `Ok(false)` where it is singular.
    pub(in crate::simulate) fn factorize(
        &mut self,
        system: &mut System,
        at: Point<'_>,
        [c1, c2]: [f64; 2],
        shift: &[f64],
        weak: f64,
    ) -> Result<bool, Fault> {
        (self.at.time, self.at.c1, self.at.c2, self.clearance) = (at.time, c1, c2, weak);
        self.at.q.copy_from_slice(at.q);
        self.at.v.copy_from_slice(at.v);
        self.at.a.copy_from_slice(at.a);
        if self.sparse.is_some() {
            let mut here = system.at(at.time, at.q, at.v);
            here.accelerations(&mut self.x)?.drop_weak_multipliers(weak, &mut self.weak);
            if !self.weak.contains(&true) {
                self.border = None;
                return self.factorize_with_rows(system, shift);
            }
            self.tree.set_rows(&SparseRows::default(), &[]);
            self.sparse = Some(SparseRows::default());
        }
        self.factorize_bordered(system, shift)
    }

    /// With the rows in the sparse matrix.
    fn factorize_with_rows(&mut self, system: &mut System, shift: &[f64]) -> Result<bool, Fault> {
        let At { time, q, v, a, c1, c2 } = &self.at;
        let with = Coefficients { c1: *c1, c2: *c2, shift, ..Coefficients::default() };
        let mut here = system.at(*time, q, v);
        let rows = here.constraint_rows().map(|_, _, entry| c2 * entry);
        self.tree.set_rows(&rows, &[]);
        self.sparse = Some(rows);
        let regular = here.factorize_tangent(&mut self.tree, a, &with)?;
        here.constraint_rates(a, &mut self.base)?;
        Ok(regular)
    }

    /// With a border.
    fn factorize_bordered(&mut self, system: &mut System, shift: &[f64]) -> Result<bool, Fault> {
        let (n, m) = (self.x.len(), self.weak.len());
        let mut border = self.border.take().unwrap_or_else(|| Border::new(m, n));
        let At { time, q, v, a, c1, c2 } = &self.at;
        let with = Coefficients { c1: *c1, c2: *c2, shift, ..Coefficients::default() };
        let mut here = system.at(*time, q, v);
        here.constraint_gradient(&mut border.gradient);
        let mut mass = here.accelerations(&mut self.x)?;
        for (row, weighted) in border.gradient.chunks_exact(n).zip(border.weighted.chunks_exact_mut(n)) {
            mass.solve_mass(row, weighted);
        }
        mass.drop_weak_multipliers(self.clearance, &mut self.weak);
        let regular = here.factorize_tangent(&mut self.tree, a, &with)?;
        here.constraint_rates(a, &mut self.base)?;
        border.responses.copy_from_slice(&border.gradient);
        for row in (0..m).take_while(|_| regular) {
            self.tree.solve(&mut border.responses[row * n..(row + 1) * n]);
            self.x.copy_from_slice(&border.responses[row * n..(row + 1) * n]);
            self.rates_along(system, Some(&border.gradient))?;
            for i in 0..m {
                *border.small.entry(i, row) = match self.weak[i] || self.weak[row] {
                    true => f64::from(u8::from(i == row)),
                    false => self.rates[i],
                };
            }
        }
        let regular = regular && border.small.eliminate();
        self.border = Some(border);
        Ok(regular)
    }

    /// `rates ← B x`, with `G` by rows; without it `c₂ G` is that of the sparse matrix.
    fn rates_along(&mut self, system: &mut System, gradient: Option<&[f64]>) -> Result<(), Fault> {
        let Self { at, x, position, velocity, rates, base, sparse, .. } = self;
        let largest = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if largest == 0.0 {
            rates.fill(0.0);
            return Ok(());
        }
        // One difference for both: the velocity moves with the position as within a stage, but never by more than its
        // size. Along x of size 1: the quotient of the size and an x that has almost underflowed is infinite.
        let fastest = at.v.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
        let size = DIFFERENCE * (fastest / at.c1.max(f64::MIN_POSITIVE)).min(1.0);
        position.copy_from_slice(&at.q);
        velocity.iter_mut().zip(&*x).for_each(|(step, x)| *step = size * (x / largest));
        displace(system.model(), position, velocity);
        velocity.iter_mut().zip(&at.v).for_each(|(step, v)| *step = v + at.c1 * *step);
        system.at(at.time, position, velocity).constraint_rates(&at.a, rates)?;
        for (i, rate) in rates.iter_mut().enumerate() {
            let by_acceleration: f64 = match (gradient, &*sparse) {
                (Some(gradient), _) => {
                    let row = &gradient[i * x.len()..(i + 1) * x.len()];
                    at.c2 * row.iter().zip(&*x).map(|(g, x)| g * x).sum::<f64>()
                }
                (None, Some(rows)) => along(rows, i, x),
                (None, None) => 0.0,
            };
            *rate = (*rate - base[i]) / size * largest + by_acceleration;
        }
        Ok(())
    }

    /// `rhs ← N⁻¹ rhs`; not numbers where the rows cannot be evaluated.
    pub(in crate::simulate) fn solve(&mut self, system: &mut System, rhs: &mut [f64]) {
        let mut border = self.border.take();
        let solved = match &mut border {
            Some(border) => self.solve_bordered(system, border, rhs),
            None => self.solve_with_rows(system, rhs),
        };
        self.border = border;
        if solved.is_err() {
            rhs.fill(f64::NAN);
        }
    }

    fn solve_bordered(&mut self, system: &mut System, border: &mut Border, rhs: &mut [f64]) -> Result<(), Fault> {
        let n = rhs.len();
        for (nu, row) in self.nu.iter_mut().zip(border.weighted.chunks_exact(n)) {
            *nu = row.iter().zip(&*rhs).map(|(g, r)| g * r).sum();
        }
        self.tree.solve(rhs);
        self.x.copy_from_slice(rhs);
        self.rates_along(system, Some(&border.gradient))?;
        for ((nu, rate), weak) in self.nu.iter_mut().zip(&self.rates).zip(&self.weak) {
            *nu = if *weak { 0.0 } else { *nu - rate };
        }
        border.small.solve(&mut self.nu);
        for (nu, response) in self.nu.iter().zip(border.responses.chunks_exact(n)) {
            rhs.iter_mut().zip(response).for_each(|(x, response)| *x += nu * response);
        }
        Ok(())
    }

    fn solve_with_rows(&mut self, system: &mut System, rhs: &mut [f64]) -> Result<(), Fault> {
        let Some(rows) = &self.sparse else { return Ok(()) };
        // s = c₂⁻¹ (c₂ G) M⁻¹ r
        let mut here = system.at(self.at.time, &self.at.q, &self.at.v);
        here.accelerations(&mut self.x)?.solve_mass(rhs, &mut self.x);
        self.nu.iter_mut().enumerate().for_each(|(i, nu)| *nu = along(rows, i, &self.x) / self.at.c2);
        self.x.copy_from_slice(rhs);
        self.tree.solve_with_rows(&mut self.x, &self.nu);
        rhs.copy_from_slice(&self.x);
        for _ in 0..CORRECTIONS {
            self.rates_along(system, None)?;
            self.nu.iter_mut().zip(&self.rates).for_each(|(nu, rate)| *nu -= rate);
            self.x.fill(0.0);
            self.tree.solve_with_rows(&mut self.x, &self.nu);
            rhs.iter_mut().zip(&self.x).for_each(|(x, more)| *x += more);
        }
        Ok(())
    }
}

/// One row times a list.
fn along(rows: &SparseRows, row: usize, x: &[f64]) -> f64 {
    rows.row(row).map(|(column, value)| value * x[column]).sum()
}
