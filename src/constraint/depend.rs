//! How rows that are left out depend on those solved for.
//!
//! ```text
//! G_d = C G_i,   C = (G_d D G_iᵀ)(G_i D G_iᵀ)⁻¹                                                 (1)
//! ```
//!
//! for every positive definite `D`. In the metric of the inertia (`D = M⁻¹`) the products are at hand; where loops are many and far
//! from the ground they are all full, and so are their factors. In the metric of the coordinates the rows are sparse, and
//! so are products and factors.

use super::{Constraints, Envelope};
use crate::model::Model;
use crate::motion::Motion;
use crate::sparse::{Gram, SparseRows};

/// A loop over so many links is long.
const LONG: usize = 32;
/// `A` is wide if its factorization takes the operations of rows that each reach over so many others.
const WIDE: usize = 64;

/// Rows in units of their weights, and the solution of (1).
pub(super) enum Dependence<'d> {
    /// In the metric of the inertia: the rows solved for, factorized, and the products of all rows.
    Inertia { kept: &'d Constraints, all: &'d Constraints },
    /// In that of the coordinates.
    Coordinates(Box<Sparse>),
}

/// All rows, and the products of those solved for.
pub(super) struct Sparse {
    all: SparseRows,
    kept: SparseRows,
    products: Gram,
    columns: usize,
    /// Of every row, the largest square of those of its element.
    sizes: Vec<f64>,
}

impl Sparse {
    /// `all` have been placed; of them `solved` are kept, by their unknowns. `None` if their products are singular.
    pub(super) fn new(all: &mut Constraints, model: &Model, motion: &Motion, solved: &[usize]) -> Option<Self> {
        let columns = model.velocity_count();
        let length = model.length_scale();
        let mut units = vec![1.0; columns];
        model.lengths().for_each(|velocity| units[velocity] = length);
        let weights: Vec<f64> = all.plan.rows().map(|row| all.weights[row]).collect();
        let rows = all.sparse_rows(model, motion);
        let rows = rows.map(|row, column, entry| weights[row] * entry * units[column]);
        let kept = SparseRows::of(solved.iter().map(|unknown| rows.row(*unknown).collect()).collect());
        let products = Gram::of(&kept, &vec![1.0; columns])?;
        let mut sizes = vec![0.0; weights.len()];
        for group in &all.plan.groups {
            let of_group = group.first..group.first + group.rows.len();
            let largest = of_group.clone().map(|row| square(&rows, row)).fold(0.0, f64::max);
            sizes[of_group].fill(largest);
        }
        Some(Self { all: rows, kept, products, columns, sizes })
    }
}

fn square(rows: &SparseRows, row: usize) -> f64 {
    rows.row(row).map(|(_, entry)| entry * entry).sum()
}

impl Dependence<'_> {
    /// Whether a row, by its unknown among all of them, has no entries in this position.
    pub(super) fn is_nothing(&self, own: usize) -> bool {
        match self {
            Self::Inertia { all, .. } => Envelope::is_nothing(all.matrix.get(own, own), all.sizes[own]),
            Self::Coordinates(sparse) => Envelope::is_nothing(square(&sparse.all, own), sparse.sizes[own]),
        }
    }

    /// A row of C, in units of the weights: of `row`, whose unknown is `own`, by the rows `solved`, whose unknowns are `unknowns`.
    pub(super) fn part(&self, (row, own): (usize, usize), solved: &[usize], unknowns: &[usize]) -> Vec<f64> {
        match self {
            Self::Inertia { kept, all } => {
                let mut part: Vec<f64> = unknowns.iter().map(|other| all.matrix.get(own, *other)).collect();
                kept.matrix.solve(&mut part);
                for (part, other) in part.iter_mut().zip(solved) {
                    *part *= kept.weights[row] / kept.weights[*other];
                }
                part
            }
            Self::Coordinates(sparse) => {
                let mut along = vec![0.0; sparse.columns];
                sparse.all.row(own).for_each(|(column, entry)| along[column] = entry);
                let mut part = sparse.kept.times(&along);
                sparse.products.solve(&mut part);
                part
            }
        }
    }
}

impl Constraints {
    /// Whether the products of rows in the metric of the inertia are better not made: loops are long, or `A` is wide.
    pub(super) fn is_wide(&self) -> bool {
        let longest = self.elements.iter().map(|element| element.branches.iter().map(Vec::len).sum::<usize>());
        longest.max().is_some_and(|longest| longest >= LONG) || self.is_filled()
    }

    /// Whether `A` is wide: of many loops on one tree all meet in it.
    pub(crate) fn is_filled(&self) -> bool {
        self.operations() > self.rank() * WIDE * WIDE
    }

    /// Operations of a factorization of `A`, about.
    pub(crate) fn operations(&self) -> usize {
        self.plan.operations()
    }
}
