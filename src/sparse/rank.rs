//! How many rows of a matrix are linearly independent, and what they leave free.

use super::{Cholesky, SparseRows, products};
use faer::{Mat, Side};

/// Singular values below this part of the largest entry are zero: its square is a hundred times the rounding of `G Gᵀ`.
const ZERO: f64 = 1e-7;
/// Matrices up to this size, and those of which more than this part is free, are taken apart as dense ones.
const SMALL: usize = 64;
const MUCH: f64 = 0.25;
/// Steps of inverse iteration: each takes what is not free by the part `σ₀² / σ²`, of which the first is 1e-14 of the largest.
const STEPS: usize = 6;

/// `G Gᵀ` of rows with so many columns, and the shift below which its eigenvalues are zero; `None` if all of them are.
struct Products {
    starts: Vec<usize>,
    indices: Vec<usize>,
    values: Vec<f64>,
    shift: f64,
    cholesky: Cholesky,
}

impl Products {
    fn new(rows: &SparseRows, columns: usize) -> Option<Self> {
        let (starts, indices, values) = products(rows, &vec![1.0; columns]);
        let largest = starts[1..].iter().map(|next| values[next - 1]).fold(0.0, f64::max);
        let cholesky = Cholesky::new((&starts, &indices));
        (largest > 0.0).then_some(Self { starts, indices, values, shift: largest * ZERO * ZERO, cholesky })
    }

    fn shifted(&self, by: f64) -> Vec<f64> {
        let mut shifted = self.values.clone();
        self.starts[1..].iter().for_each(|next| shifted[next - 1] += by);
        shifted
    }

    /// How many eigenvalues are zero: `G Gᵀ − σ² 1` has as many negative pivots as `G` has singular values below σ (Sylvester's law
    /// of inertia).
    fn zeros(&mut self) -> usize {
        // A shift that meets an eigenvalue has a zero pivot: a larger one does not.
        loop {
            let shifted = self.shifted(-self.shift);
            if let Some(negatives) = self.cholesky.ldlt((&self.starts, &self.indices), &shifted) {
                return negatives;
            }
            self.shift *= 2.0;
        }
    }
}

/// The rank of `G`, given by its rows, with so many columns.
pub(crate) fn rank(rows: &SparseRows, columns: usize) -> usize {
    Products::new(rows, columns).map_or(0, |mut products| rows.len() - products.zeros())
}

/// An orthonormal basis of what the columns of `G`, given by its rows, leave free: `Gᵀ Z = 0`, in as many columns as there are.
pub(crate) fn kernel(rows: &SparseRows, columns: usize) -> Mat<f64> {
    let n = rows.len();
    let Some(mut products) = Products::new(rows, columns) else { return Mat::identity(n, n) };
    let free = products.zeros();
    if free == 0 {
        return Mat::zeros(n, 0);
    }
    if n <= SMALL || free as f64 > MUCH * n as f64 {
        let mut whole = Mat::<f64>::zeros(n, n);
        for column in 0..n {
            for at in products.starts[column]..products.starts[column + 1] {
                let row = products.indices[at];
                (whole[(row, column)], whole[(column, row)]) = (products.values[at], products.values[at]);
            }
        }
        let Ok(eigen) = whole.self_adjoint_eigen(Side::Lower) else { return Mat::zeros(n, 0) };
        // Eigenvalues ascend.
        return eigen.U().subcols(0, free).to_owned();
    }
    smallest(&mut products, free)
}

/// The space of the eigenvectors of the smallest eigenvalues: inverse iteration on all of them at once (Parlett, "The symmetric
/// eigenvalue problem", 1998, 14.1).
fn smallest(products: &mut Products, count: usize) -> Mat<f64> {
    let n = products.starts.len() - 1;
    let golden = 0.618_033_988_749_894_9;
    let mut basis = Mat::from_fn(n, count, |i, k| (((i + 1) * (2 * k + 1)) as f64 * golden).fract() - 0.5);
    let shifted = products.shifted(products.shift);
    if !products.cholesky.llt((&products.starts, &products.indices), &shifted) {
        return Mat::zeros(n, 0);
    }
    for _ in 0..STEPS {
        basis = basis.qr().compute_thin_Q();
        for k in 0..count {
            products.cholesky.solve(basis.col_as_slice_mut(k));
        }
    }
    basis.qr().compute_thin_Q()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random sparse rows with known dependencies: as many as `nalgebra` counts singular values.
    #[test]
    fn rank_is_what_singular_values_say() {
        let mut seed = 0x2545_f491_4f6c_dd1d_u64;
        let mut next = || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for case in 0..200 {
            let (count, columns, free) = (1 + case % 9, 1 + (case / 3) % 11, 1 + case % 5);
            let base: Vec<Vec<f64>> =
                (0..free.min(count)).map(|_| (0..columns).map(|_| next() - 0.5).collect()).collect();
            let dense: Vec<Vec<f64>> = (0..count)
                .map(|_| {
                    let weights: Vec<f64> = base.iter().map(|_| next() - 0.5).collect();
                    (0..columns).map(|k| weights.iter().zip(&base).map(|(w, row)| w * row[k]).sum()).collect()
                })
                .collect();
            let rows = SparseRows::of(dense.iter().map(|row| row.iter().copied().enumerate().collect()).collect());
            let matrix = nalgebra::DMatrix::from_fn(count, columns, |i, k| dense[i][k]);
            let values = matrix.svd(false, false).singular_values;
            let expected = values.iter().filter(|value| **value > 1e-9 * values.max()).count();
            assert_eq!(rank(&rows, columns), expected, "case {case}: {values:?}");
        }
    }

    /// A chain of springs in space, of which some are cut: dense and sparse answers span the same space, which no column feels.
    #[test]
    fn what_is_free_is_felt_by_no_column() {
        for (count, cut) in [(5, 2), (40, 3), (300, 1), (300, 7), (300, 0)] {
            // Columns pull neighbours together; the first hangs on the ground, and every cut frees what follows.
            let step = count / (cut + 1);
            let mut rows = vec![Vec::new(); count];
            for k in (0..count).filter(|k| cut == 0 || k % step != step - 1 || *k == 0) {
                rows[k].push((k, 1.0 + 0.1 * (k % 3) as f64));
                if k > 0 {
                    rows[k - 1].push((k, -1.0 - 0.1 * (k % 3) as f64));
                }
            }
            let rows = SparseRows::of(rows);
            let free = kernel(&rows, count);
            assert_eq!(free.ncols(), count - rank(&rows, count));
            assert_eq!(free.ncols() > 0, cut > 0);
            for k in 0..free.ncols() {
                let motion: Vec<f64> = (0..count).map(|i| free[(i, k)]).collect();
                let mut felt = vec![0.0; count];
                rows.add_transposed(1.0, &motion, &mut felt);
                assert!(felt.iter().all(|rate| rate.abs() < 1e-12), "{count} {cut}: {felt:?}");
                let dot = |j: usize| (0..count).map(|i| free[(i, j)] * motion[i]).sum::<f64>();
                (0..=k).for_each(|j| assert!((dot(j) - f64::from(u8::from(j == k))).abs() < 1e-12));
            }
        }
    }
}
