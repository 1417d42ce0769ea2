//! Dense systems, factorized in place.

use super::{Evaluated, Fault};
use crate::element::lu;
use crate::model::Model;
use crate::motion::variation::Direction;

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
pub struct DenseTangent {
    matrix: Dense,
    /// A unit vector, and `c₁` and `c₂` times it.
    unit: [Vec<f64>; 3],
    column: Vec<f64>,
}

impl DenseTangent {
    /// Room for a model.
    pub fn new(model: &Model) -> Self {
        let n = model.velocity_count();
        Self { matrix: Dense::new(n), unit: [(); 3].map(|()| vec![0.0; n]), column: vec![0.0; n] }
    }

    /// `x ← (c₂ M + c₁ C + K)⁻¹ x`.
    pub fn solve(&mut self, x: &mut [f64]) {
        self.matrix.solve(x);
    }
}

impl Evaluated<'_> {
    /// Factorizes the dense tangent with hinge accelerations `a`; `shift` is added to its diagonal, infinite for a
    /// coordinate that is held, empty for nothing. `Ok(false)` where it is singular.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn factorize_dense(
        &mut self,
        dense: &mut DenseTangent,
        a: &[f64],
        [c1, c2]: [f64; 2],
        shift: &[f64],
    ) -> Result<bool, Fault> {
        self.balance(a)?;
        let held = |i: usize| shift.get(i).is_some_and(|shift| shift.is_infinite());
        let DenseTangent { matrix, unit, column } = dense;
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
                for (i, x) in column.iter().enumerate() {
                    let own = if i == j { shift.get(i).copied().unwrap_or(0.0) } else { 0.0 };
                    *matrix.entry(i, j) = match held(i) || held(j) {
                        true => f64::from(u8::from(i == j)),
                        false => x + own,
                    };
                }
            }
        }
        Ok(matrix.eliminate())
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
