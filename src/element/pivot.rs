//! The pivot of a flexible element, m×m with m ≤ 18: factorized in place, no memory asked for.

use super::lu;
use crate::round_off::BLOCK_PIVOT;
use nalgebra::DMatrix;

/// A square matrix by rows, then its factors.
#[derive(Debug, Clone, Default)]
pub struct Pivot {
    entries: Vec<f64>,
    /// Of a symmetric one `1/√Dᵢᵢ`; of a general one the order of its rows.
    scale: Vec<f64>,
    order: Vec<usize>,
    x: Vec<f64>,
}

impl Pivot {
    /// Room for m×m numbers, all zero.
    pub fn new(m: usize) -> Self {
        Self { entries: vec![0.0; m * m], scale: vec![1.0; m], order: (0..m).collect(), x: vec![0.0; m] }
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.order.len()
    }

    /// All entries zero.
    pub fn clear(&mut self) {
        self.entries.fill(0.0);
    }

    /// One entry.
    pub fn entry(&mut self, row: usize, column: usize) -> &mut f64 {
        let m = self.order.len();
        &mut self.entries[row * m + column]
    }

    /// Cholesky factors after scaling by the diagonal, of which the lower triangle is read.
    ///
    /// # Errors
    /// The smallest pivot, if one is not positive beyond round-off.
    pub fn factorize_definite(&mut self) -> Result<(), f64> {
        let m = self.size();
        for i in 0..m {
            let diagonal = self.entries[i * m + i];
            if !(diagonal > 0.0 && diagonal.is_finite()) {
                return Err(diagonal);
            }
            self.scale[i] = 1.0 / diagonal.sqrt();
        }
        for j in 0..m {
            for i in j..m {
                let mut sum = self.entries[i * m + j] * self.scale[i] * self.scale[j];
                for k in 0..j {
                    sum -= self.entries[i * m + k] * self.entries[j * m + k];
                }
                if i == j {
                    if !(sum > BLOCK_PIVOT.of(1.0)) {
                        return Err(sum / (self.scale[j] * self.scale[j]));
                    }
                    self.entries[j * m + j] = sum.sqrt();
                } else {
                    self.entries[i * m + j] = sum / self.entries[j * m + j];
                }
            }
        }
        Ok(())
    }

    /// `x ← L⁻¹ x` after [`Pivot::factorize_definite`], with `D = L Lᵀ`: of m numbers or of m wrenches.
    pub(crate) fn forward<T>(&self, x: &mut [T], add: impl Fn(&mut T, f64, &T), scale: impl Fn(&mut T, f64)) {
        let m = self.size();
        for i in 0..m {
            let (known, from_here) = x.split_at_mut(i);
            scale(&mut from_here[0], self.scale[i]);
            for (k, known) in known.iter().enumerate() {
                add(&mut from_here[0], -self.entries[i * m + k], known);
            }
            scale(&mut from_here[0], 1.0 / self.entries[i * m + i]);
        }
    }

    /// `x ← L⁻ᵀ x`.
    pub(crate) fn backward(&self, x: &mut [f64]) {
        let m = self.size();
        for i in (0..m).rev() {
            let known: f64 = (i + 1..m).map(|k| self.entries[k * m + i] * x[k]).sum();
            x[i] = (x[i] - known) / self.entries[i * m + i];
        }
        x.iter_mut().zip(&self.scale).for_each(|(x, scale)| *x *= scale);
    }

    /// Negative eigenvalues of the symmetric part and, if there is one, the direction of the lowest. For a matrix that is
    /// positive definite no memory is asked for.
    pub fn inertia(&self, scratch: &mut Self) -> (usize, Option<Vec<f64>>) {
        let m = self.size();
        let part = |i: usize, j: usize| 0.5 * (self.entries[i * m + j] + self.entries[j * m + i]);
        for i in 0..m {
            for j in 0..=i {
                scratch.entries[i * m + j] = part(i, j);
            }
        }
        if scratch.factorize_definite().is_ok() {
            return (0, None);
        }
        // The signs are those of the matrix scaled by its diagonal, whose eigenvalues are known to more digits.
        let size: Vec<f64> = (0..m).map(|i| part(i, i).abs().max(f64::MIN_POSITIVE).sqrt()).collect();
        let scaled = DMatrix::from_fn(m, m, |i, j| part(i, j) / size[i] / size[j]);
        if !scaled.iter().all(|x| x.is_finite()) {
            return (0, None);
        }
        let eigen = scaled.symmetric_eigen();
        let negative = eigen.eigenvalues.iter().filter(|x| **x < 0.0).count();
        let lowest = eigen.eigenvalues.imin();
        let direction = (negative > 0).then(|| (0..m).map(|i| eigen.eigenvectors[(i, lowest)] / size[i]).collect());
        (negative, direction)
    }

    /// Gaussian elimination with row pivoting; false if a pivot is zero or not finite.
    pub fn factorize(&mut self) -> bool {
        lu::factorize(&mut self.entries, &mut self.order)
    }

    /// `x ← D⁻¹ x` after [`Pivot::factorize`].
    pub fn solve(&mut self, x: &mut [f64]) {
        lu::solve(&self.entries, &self.order, &mut self.x, x);
    }
}
