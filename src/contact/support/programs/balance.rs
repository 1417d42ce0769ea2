//! The balance of forces that an interior point method has found to its own accuracy, taken to rounding.

use super::{BALANCED, Scaled};
use crate::round_off::SINGULAR_VALUE;
use crate::sparse::{Gram, SparseRows};

/// What is added to the diagonal of `G Gᵀ`, in parts of its largest entry: rows that depend on others leave it singular to rounding. Each
/// refinement takes the part `σ² / (σ² + this)` of what is missing along a singular value σ away.
const DAMPING: f64 = 1e-13;
/// Refinements with one factorization.
const REFINEMENTS: usize = 12;

impl Scaled<'_> {
    /// Takes away what the balance of forces lacks, by the least change of them: `δf = −Gᵀ (G Gᵀ)⁻¹ (G f + w)`, refined as long as that
    /// halves what is missing (Björck, "Numerical methods for least squares problems", 1996, 2.9).
    pub(super) fn polish(&self, forces: &mut [f64]) {
        let mut entries = vec![Vec::new(); self.load.len()];
        for (at, column) in self.columns.iter().enumerate() {
            column.iter().for_each(|(row, entry)| entries[*row].push((at, *entry)));
        }
        let rows = SparseRows::of(entries);
        let mut missing = self.unbalanced(forces);
        if let Some(gram) = Gram::damped(&rows, &vec![1.0; forces.len()], DAMPING, None) {
            for _ in 0..REFINEMENTS {
                let mut multipliers = self.rest(forces);
                gram.solve(&mut multipliers);
                let mut trial = forces.to_vec();
                rows.add_transposed(-1.0, &multipliers, &mut trial);
                let left = self.unbalanced(&trial);
                if !(left < 0.5 * missing) {
                    break;
                }
                forces.copy_from_slice(&trial);
                missing = left;
            }
        }
        if !(missing <= BALANCED) {
            self.nearest(forces);
        }
    }

    /// Polishes by conjugate gradients on the normal equations, which also find what is nearest to a balance of loads that no support feels
    /// (Björck, 7.4: CGLS).
    fn nearest(&self, forces: &mut [f64]) {
        let mut rest: Vec<f64> = self.rest(forces).iter().map(|rest| -rest).collect();
        let mut gradient = self.rates(&rest);
        let mut direction = gradient.clone();
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let size = self.columns.iter().flatten().fold(0.0, |sum: f64, (_, entry)| sum.hypot(*entry));
        let mut steep = square(&gradient);
        for _ in 0..2 * self.load.len() {
            let mut along = vec![0.0; self.load.len()];
            for (column, d) in self.columns.iter().zip(&direction) {
                column.iter().for_each(|(row, entry)| along[*row] += entry * d);
            }
            let curve = square(&along);
            // The gradient vanishes where no forces do better: of loads that no support feels nothing else is left.
            let vanished = SINGULAR_VALUE.hides(steep.sqrt(), size * square(&rest).sqrt());
            if !(curve > 0.0) || vanished || square(&rest) < 1e-32 * self.load.len() as f64 {
                break;
            }
            let step = steep / curve;
            forces.iter_mut().zip(&direction).for_each(|(f, d)| *f += step * d);
            rest.iter_mut().zip(&along).for_each(|(rest, along)| *rest -= step * along);
            gradient = self.rates(&rest);
            let next = square(&gradient);
            direction.iter_mut().zip(&gradient).for_each(|(d, g)| *d = g + next / steep * *d);
            steep = next;
        }
    }
}
