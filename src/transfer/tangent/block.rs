//! The block of a flexible element's own coordinates in the tangent: `D` of `rod` and `modal`, and its inverse.

use crate::element::pivot::Pivot;
use crate::spatial::quad::Quad;

/// `D`, eliminated.
#[derive(Debug, Clone)]
pub(super) struct FlexBlock {
    /// `D`, then its factors.
    pub(super) pivot: Pivot,
    /// `D⁻¹`, row by row.
    inverse: Vec<f64>,
    /// Where `D` is negative, the direction in which it is so most.
    pub(super) lowest: Vec<f64>,
    scratch: Pivot,
    unit: Vec<f64>,
}

impl FlexBlock {
    /// Of so many coordinates.
    pub(super) fn new(m: usize) -> Self {
        Self {
            pivot: Pivot::new(m),
            inverse: vec![0.0; m * m],
            lowest: vec![0.0; m],
            scratch: Pivot::new(m),
            unit: vec![0.0; m],
        }
    }

    /// Adds the diagonal of the shift, infinite for what is held, and inverts: rows and columns of what is held are zero. Gives the
    /// number of negative eigenvalues of `D`, `None` if it is singular.
    pub(super) fn invert(&mut self, diagonal: &[f64]) -> Option<usize> {
        let m = diagonal.len();
        let held = |i: usize| diagonal[i].is_infinite();
        for i in 0..m {
            for j in 0..m {
                if held(i) || held(j) {
                    *self.pivot.entry(i, j) = if i == j { 1.0 } else { 0.0 };
                }
            }
            if !held(i) {
                *self.pivot.entry(i, i) += diagonal[i];
            }
        }
        let (negative, lowest) = self.pivot.inertia(&mut self.scratch);
        if let Some(lowest) = lowest {
            self.lowest.copy_from_slice(&lowest);
        }
        if !self.pivot.factorize() {
            return None;
        }
        for j in 0..m {
            self.unit.fill(0.0);
            self.unit[j] = if held(j) { 0.0 } else { 1.0 };
            self.pivot.solve(&mut self.unit);
            (0..m).for_each(|i| self.inverse[i * m + j] = self.unit[i]);
        }
        Some(negative)
    }

    /// Column `j` of `N D⁻¹`.
    pub(super) fn solved_column(&self, columns: &[(Quad, Quad)], j: usize) -> (Quad, Quad) {
        let m = columns.len();
        let mut sum = (Quad::default(), Quad::default());
        for (i, (force, moment)) in columns.iter().enumerate() {
            let by = Quad::all(self.inverse[i * m + j]);
            sum = (by.times_add(*force, sum.0), by.times_add(*moment, sum.1));
        }
        sum
    }

    /// `x += D⁻¹ e_j f`.
    pub(super) fn add_solution(&self, x: &mut [f64], j: usize, felt: f64) {
        let m = self.lowest.len();
        (0..m).for_each(|i| x[i] += self.inverse[i * m + j] * felt);
    }
}
