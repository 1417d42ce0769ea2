//! Gaussian elimination in place, with row pivoting: the library's factorizations ask for memory at every call.

/// Factorizes a square matrix of `order.len()` rows, given row by row; `order` receives the order of its rows in the factorization.
/// False if a pivot is zero or not finite.
#[inline]
pub(crate) fn factorize(entries: &mut [f64], order: &mut [usize]) -> bool {
    let m = order.len();
    order.iter_mut().enumerate().for_each(|(i, row)| *row = i);
    for k in 0..m {
        let size = |i: &usize| entries[order[*i] * m + k].abs();
        let Some(best) = (k..m).max_by(|i, j| size(i).total_cmp(&size(j))) else { return false };
        order.swap(k, best);
        let top = order[k] * m;
        let pivot = entries[top + k];
        if pivot == 0.0 || !pivot.is_finite() {
            return false;
        }
        for i in k + 1..m {
            let row = order[i] * m;
            let factor = entries[row + k] / pivot;
            if factor == 0.0 {
                entries[row + k] = 0.0;
                continue;
            }
            entries[row + k] = factor;
            for j in k + 1..m {
                entries[row + j] -= factor * entries[top + j];
            }
        }
    }
    true
}

/// `x ← A⁻¹ x` after [`factorize`]; `scratch` has as many numbers as `x`.
#[inline]
pub(crate) fn solve(entries: &[f64], order: &[usize], scratch: &mut [f64], x: &mut [f64]) {
    let m = order.len();
    for (i, row) in order.iter().enumerate() {
        let known: f64 = (0..i).map(|j| entries[row * m + j] * scratch[j]).sum();
        scratch[i] = x[*row] - known;
    }
    for i in (0..m).rev() {
        let row = order[i] * m;
        let known: f64 = (i + 1..m).map(|j| entries[row + j] * scratch[j]).sum();
        scratch[i] = (scratch[i] - known) / entries[row + i];
    }
    x.copy_from_slice(scratch);
}
