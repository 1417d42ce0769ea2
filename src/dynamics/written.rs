//! The sparse tangent in hinge coordinates, written down and factorized with a fill-reducing order (approximate minimum degree).
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

use crate::model::Model;
use crate::sparse::{Cholesky, General, SparseRows, times};
use crate::transfer::tangent::{Applied, At, TangentMatrix};
use faer::{Mat, Side};
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
/// Sweeps of the equilibration: each halves the logarithm of how far the largest entry of a row is from one.
const SWEEPS: usize = 5;

/// The tangent of a model in hinge coordinates, with rows or without, and its factorization.
#[derive(Debug, Clone)]
pub(super) struct Written {
    matrix: TangentMatrix,
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
    rhs: Vec<f64>,
    x: Vec<f64>,
    residual: Vec<f64>,
}

impl Written {
    /// Room for a matrix with these rows.
    pub(super) fn new(matrix: TangentMatrix, rows: &SparseRows) -> Self {
        let (starts, indices) = matrix.pattern();
        let (mut starts, mut indices) = (starts.to_vec(), indices.to_vec());
        let n = starts.len() - 1;
        for row in 0..rows.len() {
            indices.extend(rows.row(row).map(|(column, _)| column));
            indices.push(n + row);
            starts.push(indices.len());
        }
        let whole = n + rows.len();
        let beside_rows = |count: usize| if rows.is_empty() { 0 } else { count };
        let zeros = || vec![0.0; whole];
        Self {
            symmetric: true,
            upper: vec![0.0; indices.len()],
            lower: vec![0.0; beside_rows(indices.len())],
            held: vec![false; n],
            rows: rows.clone(),
            scales: vec![1.0; beside_rows(whole)],
            scaled: vec![0.0; beside_rows(indices.len())],
            tau: 0.0,
            cholesky: Cholesky::new((&starts, &indices)),
            general: None,
            by_pivoting: false,
            negatives: None,
            at_last: OnceCell::new(),
            refinements: 0,
            rhs: zeros(),
            x: zeros(),
            residual: zeros(),
            starts,
            indices,
            matrix,
        }
    }

    /// The matrix without its rows.
    pub(super) fn into_matrix(self) -> TangentMatrix {
        self.matrix
    }

    /// Takes other rows of the same pattern.
    pub(super) fn set_rows(&mut self, rows: &SparseRows) {
        self.rows.clone_from(rows);
    }

    /// Entries, with those of the rows.
    pub(super) fn entries(&self) -> usize {
        self.indices.len()
    }

    /// Operations of a factorization, about.
    pub(super) fn operations(&self) -> f64 {
        self.cholesky.operations()
    }

    /// Writes the tangent down, its symmetric part alone if that is wanted; `at.diagonal` is finite.
    pub(super) fn assemble(&mut self, model: &Model, at: &At<'_>, felt: &[Applied], symmetric: bool) {
        self.matrix.assemble(model, at, felt, symmetric);
        self.symmetric = symmetric || self.is_mirrored();
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
    pub(super) fn factorize(&mut self, shift: &[f64], definite: bool) -> bool {
        (self.negatives, self.refinements, self.by_pivoting) = (None, 0, false);
        self.at_last = OnceCell::new();
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

    /// Eq. (1) with `s` in place of the zeros on the right, empty for zeros; to half of the digits if that is rough.
    pub(super) fn solve_with_rows(&mut self, x: &mut [f64], s: &[f64], is_rough: bool) {
        let n = x.len();
        x.iter_mut().zip(&self.held).filter(|(_, held)| **held).for_each(|(x, _)| *x = 0.0);
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
        for _ in 0..if is_rough { self.refinements.div_ceil(2) } else { self.refinements } {
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
