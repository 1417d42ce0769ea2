//! Sparse matrices: symmetric ones by their upper triangles, factorized in the order of approximate minimum degree, and sparse
//! rows with the products of each two of them. Knows no mechanics.

mod cholesky;
mod general;
mod gram;
mod products;
mod rank;
mod rows;
mod triangular;

pub(crate) use cholesky::Cholesky;
pub(crate) use general::General;
pub use gram::Gram;
pub(crate) use products::products;
pub(crate) use rank::{kernel, rank};
pub use rows::SparseRows;

use faer::sparse::SymbolicSparseColMatRef;

/// Where each column of an upper triangle begins, and its rows, ascending; every diagonal entry is there.
pub(crate) type Pattern<'a> = (&'a [usize], &'a [usize]);

/// `y ← A x` for a symmetric matrix, from its upper triangle.
pub(crate) fn times((starts, rows): Pattern<'_>, upper: &[f64], x: &[f64], y: &mut [f64]) {
    y.fill(0.0);
    for j in 0..x.len() {
        let diagonal = starts[j + 1] - 1;
        let mut sum = upper[diagonal] * x[j];
        for at in starts[j]..diagonal {
            y[rows[at]] += upper[at] * x[j];
            sum += upper[at] * x[rows[at]];
        }
        y[j] += sum;
    }
}

fn square<'a>((starts, rows): Pattern<'a>) -> SymbolicSparseColMatRef<'a, usize> {
    let n = starts.len() - 1;
    SymbolicSparseColMatRef::new_checked(n, n, starts, None, rows)
}
