//! The symmetric tangent with the links' motions as unknowns, factorized and refined ([`Twists`]).
//!
//! ```text
//! [ K  Gᵀ ] [ x ]   [ f ]        x += P⁻¹ (f − K x − Gᵀ λ + gᵀ ρ (s − G x)),   λ += ρ (g δz − (s − G x))          (1)
//! [ G  0  ] [ λ ] = [ s ]
//! ```
//!
//! the method of multipliers (Hestenes 1969) with `P` in place of `K + Gᵀ ρ G`: rows may be linearly dependent. Each round leaves what
//! hinges and rows give, a millionth where few of them are in series. Without rows conjugate gradients with `P` before them
//! (Hestenes & Stiefel 1952) take fewer rounds.

use crate::model::Model;
use crate::round_off::SPARSE_PIVOT;
use crate::sparse::{Cholesky, SparseRows};
use crate::transfer::tangent::{Applied, At, Pair, Pull, Twists};

/// A round leaves at most this part, or hinges give too much for this scene.
const CONTRACTS: f64 = 0.3;
/// Rounds at most.
const ROUNDS: usize = 12;
/// What is left of the step that was taken first: all digits, or what a search needs on its way.
const LEFT: [f64; 2] = [1e-14, 1e-6];
/// What a factorization says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Said {
    Definite,
    NotDefinite,
    /// Another matrix has to say.
    Nothing,
}

/// The factorized matrix.
#[derive(Debug, Clone)]
pub(super) struct ByTwists {
    twists: Twists,
    cholesky: Cholesky,
    rows: SparseRows,
    z: Vec<f64>,
    residual: Vec<f64>,
}

impl ByTwists {
    pub(super) fn new(model: &Model, pairs: &[Pair], rows: &SparseRows, pulls: &[Pull]) -> Self {
        let twists = Twists::new(model, pairs, pulls);
        let cholesky = Cholesky::new(twists.pattern());
        let whole = twists.pattern().0.len() - 1;
        let residual = vec![0.0; model.velocity_count()];
        Self { twists, cholesky, rows: rows.clone(), z: vec![0.0; whole], residual }
    }

    /// Holds what these rows hold, and their pulls.
    pub(super) fn set_rows(&mut self, rows: &SparseRows, pulls: &[Pull]) {
        self.rows.clone_from(rows);
        if !self.twists.set_pulls(pulls) {
            self.cholesky = Cholesky::new(self.twists.pattern());
        }
    }

    /// Operations of a factorization, about.
    pub(super) fn operations(&self) -> f64 {
        self.cholesky.operations()
    }

    pub(super) fn assemble(&mut self, model: &Model, at: &At<'_>, felt: &[Applied]) {
        self.twists.assemble(model, at, felt);
    }

    /// Factorizes with this diagonal, infinite for what is held.
    pub(super) fn factorize(&mut self, diagonal: impl Fn(usize) -> f64) -> Said {
        self.twists.write(&diagonal, 0.0);
        if self.cholesky.llt(self.twists.pattern(), self.twists.values()) {
            return if self.contracts() { Said::Definite } else { Said::Nothing };
        }
        // Stiffer by more than round-off: still not definite?
        self.twists.write(&diagonal, SPARSE_PIVOT.of(1.0));
        match self.cholesky.llt(self.twists.pattern(), self.twists.values()) {
            true => Said::Nothing,
            false => Said::NotDefinite,
        }
    }

    /// Whether rounds of (1) converge, for a force with a bit of everything in it.
    fn contracts(&mut self) -> bool {
        let some = |i: usize| 0.5 + ((i + 1) as f64 * 0.618_033_988_749_894_9).fract();
        let x: Vec<f64> = (0..self.residual.len()).map(some).collect();
        let mut f = vec![0.0; x.len()];
        self.twists.times(&x, &mut f);
        self.solve(&mut f, &[], LEFT[1])
    }

    /// Without rows: conjugate gradients with `P` before them; false if they do not converge.
    fn solve_alone(&mut self, x: &mut [f64], left: f64) -> bool {
        let Self { twists, cholesky, z, residual, .. } = self;
        let n = x.len();
        residual.copy_from_slice(x);
        twists.hold(residual);
        x.fill(0.0);
        let (mut along, mut pushed) = (vec![0.0; n], vec![0.0; n]);
        let (mut first, mut last, mut before) = (0.0_f64, f64::INFINITY, f64::INFINITY);
        for _ in 0..ROUNDS {
            z.fill(0.0);
            z[..n].copy_from_slice(residual);
            cholesky.solve(z);
            last = dot(&z[..n], &z[..n]).sqrt();
            first = first.max(last);
            if last <= left * first {
                x.iter_mut().zip(z.iter()).for_each(|(x, z)| *x += z);
                return true;
            }
            let weight = dot(residual, &z[..n]);
            along.iter_mut().zip(z.iter()).for_each(|(a, z)| *a = z + weight / before * *a);
            before = weight;
            twists.times(&along, &mut pushed);
            let part = weight / dot(&along, &pushed);
            if !(part > 0.0 && part.is_finite()) {
                return false;
            }
            x.iter_mut().zip(&along).for_each(|(x, a)| *x += part * a);
            residual.iter_mut().zip(&pushed).for_each(|(r, k)| *r -= part * k);
        }
        last <= LEFT[1] * first
    }

    /// Eq. (1); false if it does not converge. `s` is empty for zeros.
    fn solve(&mut self, x: &mut [f64], s: &[f64], left: f64) -> bool {
        if self.rows.is_empty() {
            return self.solve_alone(x, left);
        }
        let Self { twists, cholesky, rows, z, residual } = self;
        let n = x.len();
        let force = x.to_vec();
        let mut multipliers = vec![0.0; rows.len()];
        let mut gaps: Vec<f64> = if s.is_empty() { multipliers.clone() } else { s.to_vec() };
        residual.copy_from_slice(&force);
        x.fill(0.0);
        let (mut first, mut last) = (0.0_f64, f64::INFINITY);
        for _ in 0..ROUNDS {
            z.fill(0.0);
            z[..n].copy_from_slice(residual);
            twists.hold(&mut z[..n]);
            twists.push(&gaps, z);
            cholesky.solve(z);
            let size = z[..n].iter().map(|x| x * x).sum::<f64>().sqrt();
            x.iter_mut().zip(z.iter()).for_each(|(x, dx)| *x += dx);
            first = first.max(size);
            if !size.is_finite() || size > CONTRACTS * last {
                return size <= left.max(LEFT[1]) * first;
            }
            if size <= left * first {
                return true;
            }
            last = size;
            for (row, multiplier) in multipliers.iter_mut().enumerate() {
                *multiplier += twists.rho(row) * (twists.opened(row, z) - gaps[row]);
            }
            gaps.iter_mut().zip(rows.times(&z[..n])).for_each(|(gap, closed)| *gap -= closed);
            twists.times(x, residual);
            residual.iter_mut().zip(&force).for_each(|(r, f)| *r = f - *r);
            rows.add_transposed(-1.0, &multipliers, residual);
        }
        last <= LEFT[1] * first
    }

    /// Eq. (1) with the last factorization, to all digits or to half of them.
    pub(super) fn solve_with_rows(&mut self, x: &mut [f64], s: &[f64], is_rough: bool) {
        self.solve(x, s, LEFT[usize::from(is_rough)]);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
