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

use crate::dynamics::{Coefficients, Dense, DenseTangent, Fault, System, TangentSolver};
use crate::integrate::Point;
use crate::motion::displace;

/// A factorized matrix. Valid until the next factorization, whatever the system evaluates in between.
pub(super) struct Bordered {
    tree: Tree,
    /// `G`, by rows.
    gradient: Vec<f64>,
    /// `G M⁻¹`, by rows.
    weighted: Vec<f64>,
    /// `Yᵀ`, by rows.
    responses: Vec<f64>,
    /// `B Y`.
    small: Dense,
    /// Rows that are left out.
    weak: Vec<bool>,
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

/// The tangent of the tree.
enum Tree {
    Sweep(Box<TangentSolver>),
    Dense(DenseTangent),
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

impl Bordered {
    /// Room for a system.
    pub(super) fn new(system: &System) -> Self {
        let model = system.model();
        let (m, n) = (system.constraint_rank(), model.velocity_count());
        let tree = match TangentSolver::is_for_dense(model) {
            true => Tree::Dense(DenseTangent::new(model)),
            false => Tree::Sweep(Box::new(TangentSolver::new(model))),
        };
        let at = At { q: model.start_position.clone(), v: vec![0.0; n], a: vec![0.0; n], ..At::default() };
        Self {
            tree,
            gradient: vec![0.0; m * n],
            weighted: vec![0.0; m * n],
            responses: vec![0.0; m * n],
            small: Dense::new(m),
            weak: vec![false; m],
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
    pub(super) fn factorize(
        &mut self,
        system: &mut System,
        at: Point<'_>,
        [c1, c2]: [f64; 2],
        shift: &[f64],
        weak: f64,
    ) -> Result<bool, Fault> {
        let (n, m) = (at.a.len(), self.weak.len());
        (self.at.time, self.at.c1, self.at.c2) = (at.time, c1, c2);
        self.at.q.copy_from_slice(at.q);
        self.at.v.copy_from_slice(at.v);
        self.at.a.copy_from_slice(at.a);
        let mut here = system.at(at.time, at.q, at.v);
        here.constraint_gradient(&mut self.gradient);
        let mut mass = here.accelerations(&mut self.x)?;
        for (row, weighted) in self.gradient.chunks_exact(n).zip(self.weighted.chunks_exact_mut(n)) {
            mass.solve_mass(row, weighted);
        }
        here.drop_weak_multipliers(weak, &mut self.weak);
        let regular = match &mut self.tree {
            Tree::Sweep(solver) => {
                let with = Coefficients { c1, c2, shift, ..Coefficients::default() };
                here.factorize_tangent(solver, at.a, &with)?
            }
            Tree::Dense(dense) => here.factorize_dense(dense, at.a, [c1, c2], shift)?,
        };
        if !regular {
            return Ok(false);
        }
        here.constraint_rates(at.a, &mut self.base)?;
        self.responses.copy_from_slice(&self.gradient);
        for row in 0..m {
            self.tree.solve(&mut self.responses[row * n..(row + 1) * n]);
            self.x.copy_from_slice(&self.responses[row * n..(row + 1) * n]);
            self.rates_along(system)?;
            for i in 0..m {
                *self.small.entry(i, row) = match self.weak[i] || self.weak[row] {
                    true => f64::from(u8::from(i == row)),
                    false => self.rates[i],
                };
            }
        }
        Ok(self.small.eliminate())
    }

    /// `rates ← B x`.
    fn rates_along(&mut self, system: &mut System) -> Result<(), Fault> {
        let Self { at, x, position, velocity, rates, base, gradient, .. } = self;
        let largest = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if largest == 0.0 {
            rates.fill(0.0);
            return Ok(());
        }
        // One difference for both: the velocity moves with the position as within a stage, but never by more than its
        // size.
        let fastest = at.v.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
        let size = DIFFERENCE * (fastest / at.c1.max(f64::MIN_POSITIVE)).min(1.0) / largest;
        position.copy_from_slice(&at.q);
        velocity.iter_mut().zip(&*x).for_each(|(step, x)| *step = size * x);
        displace(system.model(), position, velocity);
        velocity.iter_mut().zip(&at.v).for_each(|(step, v)| *step = v + at.c1 * *step);
        system.at(at.time, position, velocity).constraint_rates(&at.a, rates)?;
        for (i, row) in gradient.chunks_exact(x.len()).enumerate() {
            let by_acceleration: f64 = row.iter().zip(&*x).map(|(g, x)| g * x).sum();
            rates[i] = (rates[i] - base[i]) / size + at.c2 * by_acceleration;
        }
        Ok(())
    }

    /// `rhs ← N⁻¹ rhs`; not numbers where the rows cannot be evaluated.
    pub(super) fn solve(&mut self, system: &mut System, rhs: &mut [f64]) {
        let n = rhs.len();
        for (nu, row) in self.nu.iter_mut().zip(self.weighted.chunks_exact(n)) {
            *nu = row.iter().zip(&*rhs).map(|(g, r)| g * r).sum();
        }
        self.tree.solve(rhs);
        self.x.copy_from_slice(rhs);
        if self.rates_along(system).is_err() {
            return rhs.fill(f64::NAN);
        }
        for ((nu, rate), weak) in self.nu.iter_mut().zip(&self.rates).zip(&self.weak) {
            *nu = if *weak { 0.0 } else { *nu - rate };
        }
        self.small.solve(&mut self.nu);
        for (nu, response) in self.nu.iter().zip(self.responses.chunks_exact(n)) {
            rhs.iter_mut().zip(response).for_each(|(x, response)| *x += nu * response);
        }
    }
}

impl Tree {
    fn solve(&mut self, x: &mut [f64]) {
        match self {
            Self::Sweep(solver) => solver.solve(x),
            Self::Dense(dense) => dense.solve(x),
        }
    }
}
