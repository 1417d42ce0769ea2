//! How many columns of supports are linearly independent.

use crate::sparse::{Cholesky, SparseRows, products};

/// Singular values below this part of the largest entry are zero: its square is a hundred times the rounding of `G Gᵀ`.
const ZERO: f64 = 1e-7;

/// The rank of `G`, given by its rows, with so many columns: `G Gᵀ − σ² 1` has as many negative pivots as `G` has singular values below σ
/// (Sylvester's law of inertia).
pub(super) fn rank(rows: &SparseRows, columns: usize) -> usize {
    let (starts, indices, values) = products(rows, &vec![1.0; columns]);
    let diagonal = || starts[1..].iter().map(|next| next - 1);
    let largest = diagonal().map(|at| values[at]).fold(0.0, f64::max);
    if largest == 0.0 {
        return 0;
    }
    let mut cholesky = Cholesky::new((&starts, &indices));
    // A shift that meets an eigenvalue has a zero pivot: a larger one does not.
    let mut shift = largest * ZERO * ZERO;
    loop {
        let mut shifted = values.clone();
        diagonal().for_each(|at| shifted[at] -= shift);
        if let Some(negatives) = cholesky.ldlt((&starts, &indices), &shifted) {
            return rows.len() - negatives;
        }
        shift *= 2.0;
    }
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
}
