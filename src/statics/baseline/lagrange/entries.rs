//! The entries of the sparse matrix, and its solution: equilibrated, LU with pivoting, one step of refinement.

use super::gradient::{Gradient, Part};
use crate::spatial::Wrench;
use faer::Mat;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat};
use nalgebra::{Matrix3, Vector3};

/// Passes of equilibration: each halves the logarithm of the remaining ratios.
const PASSES: usize = 4;

/// First index of a part of a link; the ground has none.
fn index((link, part): (usize, Part)) -> Option<usize> {
    (link > 0).then(|| 6 * (link - 1) + if part == Part::Place { 0 } else { 3 })
}

/// Entries in the order in which they were added; entries at the same place add up. The order must be the same each
/// time: the pattern is analysed once.
#[derive(Debug, Default)]
pub(super) struct Entries {
    pairs: Vec<Pair<usize, usize>>,
    values: Vec<f64>,
}

impl Entries {
    pub(super) fn clear(&mut self) {
        self.pairs.clear();
        self.values.clear();
    }

    fn push(&mut self, row: usize, col: usize, value: f64) {
        self.pairs.push(Pair::new(row, col));
        self.values.push(value);
    }

    /// A 3×3 block between parts of links.
    pub(super) fn add(&mut self, row: (usize, Part), col: (usize, Part), block: &Matrix3<f64>) {
        let (Some(row), Some(col)) = (index(row), index(col)) else { return };
        for j in 0..3 {
            for i in 0..3 {
                self.push(row + i, col + j, block[(i, j)]);
            }
        }
    }

    /// What a wrench does to the column `col` of one coordinate of a link.
    pub(super) fn add_wrench(&mut self, link: usize, col: (usize, Part), axis: usize, wrench: &Wrench) {
        let (Some(row), Some(col)) = (index((link, Part::Place)), index(col)) else { return };
        for i in 0..3 {
            self.push(row + i, col + axis, wrench.force[i]);
            self.push(row + 3 + i, col + axis, wrench.moment[i]);
        }
    }

    /// `size g gᵀ` for the gradient of one coordinate.
    pub(super) fn add_outer(&mut self, gradient: &Gradient, link: usize, parent: usize, size: f64) {
        let blocks = gradient.blocks(link, parent);
        for (row_link, row_part, row) in &blocks {
            for (col_link, col_part, col) in &blocks {
                self.add((*row_link, *row_part), (*col_link, *col_part), &(size * row * col.transpose()));
            }
        }
    }

    /// A constraint's row, and the same as a column.
    pub(super) fn add_constraint(&mut self, row: usize, gradient: &Gradient, link: usize, parent: usize) {
        for (link, part, vector) in gradient.blocks(link, parent) {
            let Some(first) = index((link, part)) else { continue };
            for i in 0..3 {
                self.push(row, first + i, vector[i]);
                self.push(first + i, row, vector[i]);
            }
        }
    }

    /// One entry on the diagonal.
    pub(super) fn add_diagonal(&mut self, row: usize, value: f64) {
        self.push(row, row, value);
    }

    /// `−weight` on the diagonal of every part: the balance in the sense of least squares.
    pub(super) fn add_least_squares(&mut self, links: usize, length: f64) {
        for link in 1..links {
            self.add((link, Part::Place), (link, Part::Place), &-Matrix3::identity());
            self.add((link, Part::Turn), (link, Part::Turn), &(-length * length * Matrix3::identity()));
        }
    }
}

/// The analysed pattern.
pub(super) struct Pattern {
    symbolic: SymbolicSparseColMat<usize>,
    order: Argsort<usize>,
    factor: SymbolicLu<usize>,
    size: usize,
}

impl Pattern {
    /// Analyses the pattern of `entries`; `None` if the matrix is too large to address.
    pub(super) fn of(entries: &Entries, size: usize) -> Option<Self> {
        let (symbolic, order) = SymbolicSparseColMat::try_new_from_indices(size, size, &entries.pairs).ok()?;
        let factor = SymbolicLu::try_new(symbolic.as_ref()).ok()?;
        Some(Self { symbolic, order, factor, size })
    }

    /// The solution of one system; `None` if the matrix is singular.
    pub(super) fn solve(&self, entries: &Entries, rhs: &[f64]) -> Option<Vec<f64>> {
        let (rows, cols) = equilibration(entries, self.size);
        let scaled: Vec<f64> =
            entries.pairs.iter().zip(&entries.values).map(|(at, value)| value * rows[at.row] * cols[at.col]).collect();
        let matrix = SparseColMat::new_from_argsort(self.symbolic.clone(), &self.order, &scaled).ok()?;
        let factor = Lu::try_new_with_symbolic(self.factor.clone(), matrix.as_ref()).ok()?;
        let b = Mat::from_fn(self.size, 1, |i, _| rows[i] * rhs[i]);
        let mut x = factor.solve(&b);
        let left = &b - &matrix * &x;
        x += factor.solve(&left);
        let x: Vec<f64> = (0..self.size).map(|i| cols[i] * x[(i, 0)]).collect();
        x.iter().all(|x| x.is_finite()).then_some(x)
    }
}

/// Factors of rows and columns that bring the largest entry of each near one (Ruiz 2001).
fn equilibration(entries: &Entries, size: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut rows, mut cols) = (vec![1.0; size], vec![1.0; size]);
    for _ in 0..PASSES {
        let (mut row_largest, mut col_largest) = (vec![0.0_f64; size], vec![0.0_f64; size]);
        for (at, value) in entries.pairs.iter().zip(&entries.values) {
            let value = (value * rows[at.row] * cols[at.col]).abs();
            row_largest[at.row] = row_largest[at.row].max(value);
            col_largest[at.col] = col_largest[at.col].max(value);
        }
        let shrink = |factors: &mut [f64], largest: &[f64]| {
            for (factor, largest) in factors.iter_mut().zip(largest) {
                if *largest > 0.0 {
                    *factor /= largest.sqrt();
                }
            }
        };
        shrink(&mut rows, &row_largest);
        shrink(&mut cols, &col_largest);
    }
    (rows, cols)
}

/// A wrench as it stands in the right side.
pub(super) fn place(list: &mut [f64], link: usize, force: &Vector3<f64>, moment: &Vector3<f64>) {
    if let Some(first) = index((link, Part::Place)) {
        list[first..first + 3].copy_from_slice(force.as_slice());
        list[first + 3..first + 6].copy_from_slice(moment.as_slice());
    }
}
