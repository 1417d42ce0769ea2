//! The sparse tangent, factorized with a fill-reducing order (approximate minimum degree).
//!
//! | matrix | factorization | negative eigenvalues |
//! |---|---|---|
//! | symmetric, wanted definite | L Lᵀ | none, or it breaks down |
//! | symmetric | L D Lᵀ without pivoting | negative pivots, if a refinement contracts |
//! | the same with rows | equilibrated and regularized, eq. (1) | negative pivots less rows, if a refinement contracts |
//! | symmetric, of which L D Lᵀ lost its digits | L U with pivoting; dense L B Lᵀ for the count | of the blocks B |
//! | any other | L U with pivoting | not asked for |
//!
//! ```text
//! [ K  Gᵀ ] [ x ]   [ f ]
//! [ G  0  ] [ λ ] = [ 0 ],     n₋(whole) = m + n₋(K on G x = 0)                                      (1)
//! ```
//!
//! (1) is equilibrated (Ruiz), factorized with −τ on the diagonal of its m rows, and refined against the matrix with zeros there.
//!
//! Without pivoting L D Lᵀ is the exact factorization of a matrix `A₁` near the `A₀` that was meant. If their inertias
//! differ, `A₀ + t (A₁ − A₀)` is singular at a `t` within (0, 1) and `1 − A₁⁻¹ A₀` has the eigenvalue `1/(1 − t)`
//! above 1: refinement then diverges. A refinement that contracts so says that the count holds. One direction alone in which it diverges is a
//! small part of a vector at first: rounds are made until less is left than that part would have become.

use super::twists::{ByTwists, Said};
use crate::model::Model;
use crate::motion::Motion;
use crate::sparse::{Cholesky, General, SparseRows, times};
use crate::spatial::Wrench;
use crate::transfer::balance::Balance;
use crate::transfer::tangent::{Applied, At, Pair, Pull, TangentMatrix};
use faer::{Mat, Side};
use nalgebra::Matrix3;
use std::cell::OnceCell;

/// A refinement contracts by this at least, or the count of negative pivots does not hold.
const CONTRACTS: f64 = 0.1;
/// A random vector has less than this part of its usual share of a direction in one of a thousand cases.
const HIDDEN: f64 = 1e-3;
/// Rounds after which a refinement that contracts has left nothing that could be hidden.
const ROUNDS: usize = 12;
/// A solution this near to the exact one needs no refinement.
const EXACT: f64 = 1e-13;
/// Mirror images that differ by less than this part of their diagonals are the same but for round-off.
const MIRRORED: f64 = 1e-12;
/// Negative eigenvalues of a matrix of up to so many unknowns can be counted by its dense factorization, for every step of a search...
const MOST_DENSE: usize = 3000;
/// ... and of so many for a certificate.
const MOST_AT_LAST: usize = 5000;
/// `τ` of eq. (1), tried in this order. It is a compliance of the rows that adds up along chains of loops, where it has to be
/// smaller; entries grow by `1/τ`, and where bodies are light it has to be larger.
const REGULARIZED: [f64; 3] = [1e-9, 1e-11, 1e-7];
/// A matrix with fewer entries than this in a column is that of a shallow tree, which has nothing to gain from twists.
const SHALLOW: usize = 16;
/// Twists may take this part of the operations that hinge coordinates take: they are refined; and beside rows this multiple of them.
const DEEPER: f64 = 0.5;
const SAFER: f64 = 4.0;
/// Sweeps of the equilibration: each halves the logarithm of how far the largest entry of a row is from one.
const SWEEPS: usize = 5;

/// The tangent of a model as a sparse matrix, with rows or without, and its factorization.
#[derive(Debug, Clone)]
pub(super) struct Sparse {
    matrix: TangentMatrix,
    /// For each pair of links what the one feels when the other moves.
    felt: Vec<Applied>,
    /// Whether the matrix is symmetric.
    symmetric: bool,
    /// The pattern with the rows, and its entries with the shift; of an unsymmetric one those above the diagonal.
    starts: Vec<usize>,
    indices: Vec<usize>,
    upper: Vec<f64>,
    /// Entries below the diagonal of an unsymmetric matrix with rows.
    lower: Vec<f64>,
    held: Vec<bool>,
    rows: SparseRows,
    /// With rows: what unknowns are divided by, and the equilibrated entries.
    scales: Vec<f64>,
    scaled: Vec<f64>,
    tau: f64,
    cholesky: Cholesky,
    general: Option<Box<General>>,
    by_pivoting: bool,
    /// `None` if they have not been counted, or could not be.
    negatives: Option<usize>,
    /// What a dense factorization has counted where they were asked for; empty before that.
    at_last: OnceCell<Option<usize>>,
    /// Refinements that a solution takes; half of them if half the digits do.
    refinements: usize,
    is_rough: bool,
    /// The links' motions as unknowns, where that is the better matrix; where the tangent is that it was assembled at, and whether
    /// the other matrix has been written down there.
    twists: Option<Box<ByTwists>>,
    place: Option<Box<Place>>,
    is_written: bool,
    by_twists: bool,
    /// Whether twists have been thought of for these rows.
    is_chosen: bool,
    pairs: Vec<Pair>,
    pulls: Vec<Pull>,
    rhs: Vec<f64>,
    x: Vec<f64>,
    residual: Vec<f64>,
}

/// A place with what a tangent there needs, while the system moves on.
#[derive(Debug, Clone)]
struct Place {
    motion: Motion,
    balance: Balance,
    hinge: Vec<f64>,
    c2: f64,
    diagonal: Vec<f64>,
    applied: Vec<(usize, Applied)>,
    wrenches: Vec<Wrench>,
    ball_springs: Vec<(usize, Matrix3<f64>)>,
}

impl Place {
    fn of(at: &At<'_>) -> Self {
        Self {
            motion: at.motion.clone(),
            balance: at.balance.clone(),
            hinge: at.hinge.to_vec(),
            c2: at.c2,
            diagonal: at.diagonal.to_vec(),
            applied: at.applied.to_vec(),
            wrenches: at.wrenches.to_vec(),
            ball_springs: at.ball_springs.to_vec(),
        }
    }

    fn at(&self) -> At<'_> {
        let Self { motion, balance, hinge, c2, diagonal, applied, wrenches, ball_springs } = self;
        At { motion, balance, hinge, c1: 0.0, c2: *c2, diagonal, applied, wrenches, coupled: &[], ball_springs }
    }
}

impl Sparse {
    /// Room for a model whose elements couple these pairs of links.
    pub(super) fn new(model: &Model, pairs: &[Pair]) -> Self {
        let (matrix, n) = (TangentMatrix::new(model, pairs), model.velocity_count());
        let (starts, indices) = matrix.pattern();
        let (starts, indices) = (starts.to_vec(), indices.to_vec());
        let zeros = || vec![0.0; n];
        Self {
            felt: vec![Applied::default(); pairs.len()],
            symmetric: true,
            upper: vec![0.0; indices.len()],
            lower: Vec::new(),
            held: vec![false; n],
            rows: SparseRows::default(),
            scales: Vec::new(),
            scaled: Vec::new(),
            tau: 0.0,
            cholesky: Cholesky::new((&starts, &indices)),
            general: None,
            by_pivoting: false,
            negatives: None,
            at_last: OnceCell::new(),
            refinements: 0,
            is_rough: false,
            twists: None,
            place: None,
            is_written: true,
            by_twists: false,
            is_chosen: false,
            pairs: pairs.to_vec(),
            pulls: Vec::new(),
            rhs: zeros(),
            x: zeros(),
            residual: zeros(),
            starts,
            indices,
            matrix,
        }
    }

    /// Takes the links' motions as unknowns if that is the better matrix: without rows the one with fewer operations, with rows, which
    /// may be nearly dependent, also one with a few times as many.
    fn choose_twists(&mut self, model: &Model) {
        self.is_chosen = true;
        let is_known = self.pulls.len() == self.rows.len();
        if !is_known || self.indices.len() < SHALLOW * (self.starts.len() - 1) {
            return;
        }
        let twists = ByTwists::new(model, &self.pairs, &self.rows, &self.pulls);
        let most = self.cholesky.operations() * if self.pulls.is_empty() { DEEPER } else { SAFER };
        self.twists = (twists.operations() <= most).then(|| Box::new(twists));
    }

    /// No link feels another.
    pub(super) fn clear_felt(&mut self) {
        self.felt.fill(Applied::default());
    }

    /// What the first link of a pair feels when the second moves.
    pub(super) fn felt(&mut self, pair: usize) -> &mut Applied {
        &mut self.felt[pair]
    }

    /// Holds what these rows hold from the next factorization on.
    pub(super) fn set_rows(&mut self, rows: &SparseRows, pulls: &[Pull]) {
        let same = self.rows.starts == rows.starts && self.rows.columns == rows.columns;
        self.rows.clone_from(rows);
        self.pulls = pulls.to_vec();
        if same {
            if let Some(twists) = &mut self.twists {
                twists.set_rows(rows, pulls);
            }
            return;
        }
        let n = self.held.len();
        let entries = self.matrix.upper().len();
        self.starts.truncate(n + 1);
        self.indices.truncate(entries);
        for row in 0..rows.len() {
            self.indices.extend(rows.row(row).map(|(column, _)| column));
            self.indices.push(n + row);
            self.starts.push(self.indices.len());
        }
        self.upper.resize(self.indices.len(), 0.0);
        self.lower.resize(if rows.is_empty() { 0 } else { self.indices.len() }, 0.0);
        self.cholesky = Cholesky::new((&self.starts, &self.indices));
        self.general = None;
        let whole = n + rows.len();
        for list in [&mut self.rhs, &mut self.x, &mut self.residual] {
            list.resize(whole, 0.0);
        }
        self.scales = vec![1.0; if rows.is_empty() { 0 } else { whole }];
        self.scaled = vec![0.0; if rows.is_empty() { 0 } else { self.indices.len() }];
        (self.twists, self.is_chosen) = (None, false);
    }

    /// Writes the tangent down, its symmetric part alone if that is wanted; `at.diagonal` is finite.
    pub(super) fn assemble(&mut self, model: &Model, at: &At<'_>, symmetric: bool) {
        let is_still = at.motion.still && at.c1 == 0.0 && at.hinge.iter().all(|a| *a == 0.0);
        if symmetric && is_still && !self.is_chosen {
            self.choose_twists(model);
        }
        if let Some(twists) = self.twists.as_mut().filter(|_| symmetric && is_still) {
            twists.assemble(model, at, &self.felt);
            self.place = Some(Box::new(Place::of(at)));
            (self.is_written, self.symmetric) = (false, true);
            return;
        }
        (self.place, self.is_written) = (None, true);
        self.matrix.assemble(model, at, &self.felt, symmetric);
        self.symmetric = symmetric || self.is_mirrored();
    }

    /// Writes down in hinge coordinates what twists were assembled for.
    fn write_down(&mut self, model: &Model) {
        if let Some(place) = self.place.as_ref().filter(|_| !self.is_written) {
            self.matrix.assemble(model, &place.at(), &self.felt, true);
            self.is_written = true;
        }
    }

    /// What the links' motions say of the place with a shift; nothing where they are not looked at.
    fn factorize_twists(&mut self, shift: &[f64]) -> Said {
        let (Some(twists), Some(place)) = (&mut self.twists, &self.place) else { return Said::Nothing };
        self.held.iter_mut().zip(shift).for_each(|(held, shift)| *held = shift.is_infinite());
        twists.factorize(|j| place.diagonal[j] + shift.get(j).copied().unwrap_or(0.0))
    }

    /// Whether the entries below the diagonal are those above it.
    fn is_mirrored(&self) -> bool {
        let ((starts, rows), upper, lower) = (self.matrix.pattern(), self.matrix.upper(), self.matrix.lower());
        let diagonal = |i: usize| upper[starts[i + 1] - 1].abs();
        (0..starts.len() - 1).all(|j| {
            (starts[j]..starts[j + 1] - 1).all(|at| {
                let size = diagonal(j) + diagonal(rows[at]);
                (upper[at] - lower[at]).abs() <= MIRRORED * size
            })
        })
    }

    /// Factorizes with `shift` added to the diagonal, infinite for a coordinate that is held; empty for nothing. False if
    /// that is singular, or not definite on what the rows leave and that is wanted.
    pub(super) fn factorize(&mut self, model: &Model, shift: &[f64], definite: bool) -> bool {
        (self.negatives, self.refinements, self.by_pivoting, self.by_twists) = (None, 0, false, false);
        self.at_last = OnceCell::new();
        match self.factorize_twists(shift) {
            Said::Definite => {
                (self.negatives, self.by_twists) = (Some(0), true);
                return true;
            }
            // Hinges that give are softer: without a shift, which makes up for it, the other matrix has the word.
            Said::NotDefinite if definite && shift.iter().any(|by| by.is_finite() && *by != 0.0) => return false,
            Said::NotDefinite | Said::Nothing => {}
        }
        self.write_down(model);
        self.fill(shift);
        if !self.symmetric {
            return self.factorize_by_pivoting();
        }
        let pattern = (&*self.starts, &*self.indices);
        if self.rows.is_empty() && definite {
            self.negatives = Some(0);
            return self.cholesky.llt(pattern, &self.upper);
        }
        let count = match self.rows.is_empty() {
            true => self.cholesky.ldlt(pattern, &self.upper).filter(|_| self.contracts()),
            false => self.factorize_regularized(),
        };
        let (rows, is_counted) = (self.rows.len(), count.is_some());
        let count = count.or_else(|| if definite { self.count_densely(MOST_DENSE) } else { None });
        self.negatives = count.and_then(|count| count.checked_sub(rows));
        (is_counted || self.factorize_by_pivoting()) && (!definite || self.negatives == Some(0))
    }

    /// Entries with the shift, and of the rows.
    fn fill(&mut self, shift: &[f64]) {
        let n = self.held.len();
        self.held.iter_mut().zip(shift).for_each(|(held, shift)| *held = shift.is_infinite());
        let entries = self.matrix.upper();
        self.upper[..entries.len()].copy_from_slice(entries);
        for j in 0..n {
            let diagonal = self.starts[j + 1] - 1;
            for at in self.starts[j]..diagonal {
                if self.held[j] || self.held[self.indices[at]] {
                    self.upper[at] = 0.0;
                }
            }
            self.upper[diagonal] = match self.held[j] {
                true => 1.0,
                false => self.upper[diagonal] + shift.get(j).copied().unwrap_or(0.0),
            };
        }
        for row in 0..self.rows.len() {
            let first = self.starts[n + row];
            for (k, (column, value)) in self.rows.row(row).enumerate() {
                self.upper[first + k] = if self.held[column] { 0.0 } else { value };
            }
            self.upper[self.starts[n + row + 1] - 1] = 0.0;
        }
    }

    /// Eq. (1); the number of negative pivots if it is to be trusted.
    fn factorize_regularized(&mut self) -> Option<usize> {
        self.equilibrate();
        let n = self.held.len();
        for tau in REGULARIZED {
            for row in n..self.starts.len() - 1 {
                self.scaled[self.starts[row + 1] - 1] = -tau;
            }
            self.tau = tau;
            let count = self.cholesky.ldlt((&self.starts, &self.indices), &self.scaled);
            if count.is_some() && self.contracts() {
                return count;
            }
        }
        None
    }

    /// Symmetric equilibration: every row's largest entry near one.
    fn equilibrate(&mut self) {
        let Self { starts, indices, upper, scales, scaled, residual: largest, .. } = self;
        scaled.copy_from_slice(upper);
        scales.fill(1.0);
        for _ in 0..SWEEPS {
            largest.fill(0.0);
            for j in 0..scales.len() {
                for at in starts[j]..starts[j + 1] {
                    let size = scaled[at].abs();
                    largest[j] = largest[j].max(size);
                    largest[indices[at]] = largest[indices[at]].max(size);
                }
            }
            largest.iter_mut().for_each(|size| *size = if *size > 0.0 { 1.0 / size.sqrt() } else { 1.0 });
            for j in 0..scales.len() {
                scales[j] *= largest[j];
                (starts[j]..starts[j + 1]).for_each(|at| scaled[at] *= largest[j] * largest[indices[at]]);
            }
        }
    }

    /// Whether refinement with the last L D Lᵀ contracts, and how many steps of it solutions take.
    fn contracts(&mut self) -> bool {
        let golden = 0.618_033_988_749_894_9;
        let n = self.held.len();
        // A solution with a bit of everything in it.
        self.x.iter_mut().enumerate().for_each(|(i, x)| *x = 0.5 + ((i + 1) as f64 * golden).fract());
        // Of linearly dependent rows the multipliers are not determined.
        let size = |x: &[f64]| x[..n].iter().map(|x| x * x).sum::<f64>().sqrt();
        let whole = size(&self.x);
        self.keep_error();
        let contraction = size(&self.x) / whole;
        self.refinements = match contraction {
            exact if exact <= EXACT => 0,
            _ => (EXACT.ln() / contraction.ln()).ceil().clamp(1.0, 12.0) as usize,
        };
        let hidden = HIDDEN / (n as f64).sqrt() * whole;
        let mut rounds = 0;
        while contraction <= CONTRACTS && size(&self.x) > hidden && rounds < ROUNDS {
            self.keep_error();
            rounds += 1;
        }
        contraction <= CONTRACTS && size(&self.x) <= hidden
    }

    /// `x ← x − A₁⁻¹ A₀ x`: what a round of refinement leaves of an error.
    fn keep_error(&mut self) {
        self.multiply();
        self.cholesky.solve(&mut self.residual);
        self.x.iter_mut().zip(&self.residual).for_each(|(x, y)| *x -= y);
    }

    /// `residual ← A x` in the units of the factorization, without what regularizes it.
    fn multiply(&mut self) {
        let Self { starts, indices, upper, scaled, tau, rows, x, residual, held, .. } = self;
        if rows.is_empty() {
            return times((starts, indices), upper, x, residual);
        }
        times((starts, indices), scaled, x, residual);
        let n = held.len();
        residual[n..].iter_mut().zip(&x[n..]).for_each(|(r, x)| *r += *tau * x);
    }

    fn factorize_by_pivoting(&mut self) -> bool {
        self.by_pivoting = true;
        let Self { matrix, general, starts, indices, upper, lower, held, symmetric, .. } = self;
        let lower = match (*symmetric, lower.is_empty()) {
            (true, _) => &*upper,
            (false, true) => matrix.lower(),
            (false, false) => {
                let entries = matrix.lower().len();
                lower[..entries].copy_from_slice(matrix.lower());
                lower[entries..].copy_from_slice(&upper[entries..]);
                &*lower
            }
        };
        let general = general.get_or_insert_with(|| Box::new(General::new((starts, indices))));
        general.factorize((starts, indices), [&*upper, lower], held)
    }

    /// Negative eigenvalues of the symmetric matrix by its dense factorization with pivoting; `None` if it is singular or
    /// too large.
    fn count_densely(&self, most: usize) -> Option<usize> {
        let n = self.x.len();
        if n > most {
            return None;
        }
        let mut dense = Mat::<f64>::zeros(n, n);
        for j in 0..n {
            (self.starts[j]..self.starts[j + 1]).for_each(|at| dense[(j, self.indices[at])] = self.upper[at]);
        }
        let factor = dense.lblt(Side::Lower);
        let (diagonal, beside) = (factor.B_diag(), factor.B_subdiag());
        let (mut i, mut negatives) = (0, 0);
        while i < n {
            let (a, b) = (diagonal[i], beside[i]);
            if b == 0.0 {
                if a == 0.0 || !a.is_finite() {
                    return None;
                }
                negatives += usize::from(a < 0.0);
                i += 1;
            } else {
                // A block of two has one negative eigenvalue, or two or none if its determinant is positive.
                let c = diagonal[i + 1];
                negatives += if a * c - b * b < 0.0 { 1 } else { 2 * usize::from(a < 0.0) };
                i += 2;
            }
        }
        Some(negatives)
    }

    /// `x ← A⁻¹ x`, with rows that of eq. (1); zero for coordinates that are held.
    pub(super) fn solve(&mut self, x: &mut [f64]) {
        self.solve_with_rows(x, &[]);
    }

    /// Whether twists were factorized last.
    pub(super) fn is_by_twists(&self) -> bool {
        self.by_twists
    }

    /// Whether half the digits do.
    pub(super) fn be_rough(&mut self, rough: bool) {
        self.is_rough = rough;
    }

    /// Eq. (1) with `s` in place of the zeros on the right; empty for zeros.
    pub(super) fn solve_with_rows(&mut self, x: &mut [f64], s: &[f64]) {
        let n = x.len();
        x.iter_mut().zip(&self.held).filter(|(_, held)| **held).for_each(|(x, _)| *x = 0.0);
        if let Some(twists) = self.twists.as_mut().filter(|_| self.by_twists) {
            return twists.solve_with_rows(x, s, self.is_rough);
        }
        self.rhs[..n].copy_from_slice(x);
        self.rhs[n..].fill(0.0);
        self.rhs[n..].iter_mut().zip(s).for_each(|(rhs, s)| *rhs = *s);
        if self.by_pivoting {
            let Some(general) = &mut self.general else { return x.fill(f64::NAN) };
            general.solve(&mut self.rhs);
            return x.copy_from_slice(&self.rhs[..n]);
        }
        self.rhs.iter_mut().zip(&self.scales).for_each(|(b, scale)| *b *= scale);
        self.x.copy_from_slice(&self.rhs);
        self.cholesky.solve(&mut self.x);
        for _ in 0..if self.is_rough { self.refinements.div_ceil(2) } else { self.refinements } {
            self.multiply();
            self.residual.iter_mut().zip(&self.rhs).for_each(|(r, b)| *r = b - *r);
            self.cholesky.solve(&mut self.residual);
            self.x.iter_mut().zip(&self.residual).for_each(|(x, dx)| *x += dx);
        }
        self.x.iter_mut().zip(&self.scales).for_each(|(x, scale)| *x *= scale);
        x.copy_from_slice(&self.x[..n]);
    }

    /// Negative eigenvalues of what was factorized last, if that is symmetric: of what the rows leave. `None` if they could not
    /// be counted.
    pub(super) fn negatives(&self) -> Option<usize> {
        let count = || self.count_densely(MOST_AT_LAST)?.checked_sub(self.rows.len());
        self.negatives.or_else(|| if self.symmetric { *self.at_last.get_or_init(count) } else { None })
    }
}
