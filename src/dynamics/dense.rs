//! Dense systems, factorized in place.

use super::{Evaluated, Fault};
use crate::element::lu;
use crate::model::Model;
use crate::motion::variation::Direction;
use faer::{Mat, Side};

/// A square matrix by rows, and its factorization in place.
#[derive(Debug, Clone, Default)]
pub struct Dense {
    entries: Vec<f64>,
    /// The order of the rows in the factorization.
    order: Vec<usize>,
    swapped: Vec<f64>,
}

impl Dense {
    /// Zeros.
    pub fn new(size: usize) -> Self {
        Self { entries: vec![0.0; size * size], order: (0..size).collect(), swapped: vec![0.0; size] }
    }

    /// One entry.
    pub fn entry(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.entries[row * self.order.len() + column]
    }

    /// Gaussian elimination with row pivoting; false if a pivot is zero or not finite.
    pub fn eliminate(&mut self) -> bool {
        lu::factorize(&mut self.entries, &mut self.order)
    }

    /// `x ← A⁻¹ x` after the elimination.
    pub fn solve(&mut self, x: &mut [f64]) {
        lu::solve(&self.entries, &self.order, &mut self.swapped, x);
    }
}

/// The tangent `c₂ M + c₁ C + K` as a dense matrix.
#[derive(Debug, Clone)]
pub(super) struct DenseTangent {
    /// By rows, without a shift.
    written: Vec<f64>,
    matrix: Dense,
    /// A unit vector, and `c₁` and `c₂` times it.
    unit: [Vec<f64>; 3],
    column: Vec<f64>,
}

impl DenseTangent {
    /// Room for a model.
    pub(super) fn new(model: &Model) -> Self {
        let n = model.velocity_count();
        let unit = [(); 3].map(|()| vec![0.0; n]);
        Self { written: vec![0.0; n * n], matrix: Dense::new(n), unit, column: vec![0.0; n] }
    }

    /// Factorizes what was written last with `shift` added to the diagonal, infinite for a coordinate that is held, empty for
    /// nothing. False if that is singular, or not definite and that is wanted.
    pub(super) fn factorize(&mut self, shift: &[f64], definite: bool) -> bool {
        let n = self.column.len();
        let held = |i: usize| shift.get(i).is_some_and(|shift| shift.is_infinite());
        for i in 0..n {
            for j in 0..n {
                let own = if i == j { shift.get(i).copied().unwrap_or(0.0) } else { 0.0 };
                *self.matrix.entry(i, j) = match held(i) || held(j) {
                    true => f64::from(u8::from(i == j)),
                    false => self.written[i * n + j] + own,
                };
            }
        }
        if definite {
            let matrix = &mut self.matrix;
            let whole = Mat::from_fn(n, n, |i, j| *matrix.entry(i, j));
            if whole.llt(Side::Lower).is_err() {
                return false;
            }
        }
        self.matrix.eliminate()
    }

    /// `x ← (c₂ M + c₁ C + K)⁻¹ x`.
    pub(super) fn solve(&mut self, x: &mut [f64]) {
        self.matrix.solve(x);
    }
}

impl Evaluated<'_> {
    /// Writes the dense tangent down with hinge accelerations `a`, its symmetric part alone if that is wanted.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub(super) fn write_dense(
        &mut self,
        dense: &mut DenseTangent,
        a: &[f64],
        [c1, c2]: [f64; 2],
        symmetric: bool,
    ) -> Result<(), Fault> {
        self.balance(a)?;
        let DenseTangent { written, unit, column, .. } = dense;
        let n = column.len();
        for link in 1..self.system.model.links.len() {
            let (first, (_, count)) =
                (self.system.model.links[link].velocity, self.system.model.links[link].joint.counts());
            for j in first..first + count {
                [1.0, c1, c2].iter().zip(&mut *unit).for_each(|(size, unit)| unit[j] = *size);
                let [position, velocity, acceleration] = &*unit;
                column.fill(0.0);
                let subtree = link..self.system.model.links[link].subtree_end;
                self.column(a, &Direction { position, velocity, acceleration }, subtree, column);
                unit.iter_mut().for_each(|unit| unit[j] = 0.0);
                column.iter().enumerate().for_each(|(i, x)| written[i * n + j] = *x);
            }
        }
        if symmetric {
            for i in 0..n {
                for j in 0..i {
                    let mean = 0.5 * (written[i * n + j] + written[j * n + i]);
                    (written[i * n + j], written[j * n + i]) = (mean, mean);
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows that need another order, solved against what the right side was made from.
    #[test]
    fn solves_what_it_eliminates() {
        let rows = [[0.0, 2.0, 1.0], [1.0, -1.0, 0.5], [4.0, 0.0, -3.0]];
        let x = [1.0, -2.0, 0.5];
        let mut dense = Dense::new(3);
        (0..9).for_each(|k| *dense.entry(k / 3, k % 3) = rows[k / 3][k % 3]);
        let mut rhs = rows.map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>());
        assert!(dense.eliminate());
        dense.solve(&mut rhs);
        assert!(rhs.iter().zip(&x).all(|(found, x)| (found - x).abs() < 1e-15), "{rhs:?}");
        *dense.entry(0, 0) = f64::NAN;
        assert!(!dense.eliminate());
    }
}
