//! What many rows hold, by sparse matrices.
//!
//! ```text
//! A = G B⁻¹ Gᵀ                    the rows in the metric, sparse where loops are local
//! felt(f) = f − Gᵀ A⁻¹ G B⁻¹ f     the part of a force that does work on the motions               (1)
//! λ = A⁻¹ G B⁻¹ f                  the multipliers that take the rest                              (2)
//! ```
//!
//! For rows that are clearly independent: the smallest singular value of the rows over turns and levers says so, as in
//! [`super::split`], which has the general case by dense matrices.

use crate::sparse::{Gram, SparseRows};
use crate::transfer::tangent::Pull;

/// Vectors of Hutchinson's estimate: its relative deviation is `√(2/8)`.
const PROBES: usize = 8;

/// What rows span that are independent by more than round-off.
#[derive(Debug, Clone)]
pub(in crate::statics) struct RowSpace {
    /// Over the free coordinates, of unit size in the metric.
    rows: SparseRows,
    /// What they pull at.
    pulls: Vec<Pull>,
    gram: Gram,
}

impl RowSpace {
    /// Rows of unit size in the metric; `None` if they are linearly dependent to working precision. The order of `like` is taken
    /// if its pattern is the same.
    pub(super) fn of(rows: SparseRows, pulls: Vec<Pull>, metric: &[f64], like: &Gram) -> Option<Self> {
        let weights: Vec<f64> = metric.iter().map(|b| 1.0 / b).collect();
        Some(Self { gram: Gram::of_like(&rows, &weights, Some(like))?, rows, pulls })
    }

    /// What the rows pull at.
    pub(in crate::statics) fn pulls(&self) -> &[Pull] {
        &self.pulls
    }

    /// `A`.
    pub(super) fn gram(&self) -> &Gram {
        &self.gram
    }

    /// Over the free coordinates.
    pub(in crate::statics) fn rows(&self) -> &SparseRows {
        &self.rows
    }

    /// Eq. (2).
    pub(super) fn multipliers(&self, force: &[f64], metric: &[f64]) -> Vec<f64> {
        let weighted: Vec<f64> = force.iter().zip(metric).map(|(f, b)| f / b).collect();
        let mut multipliers = self.rows.times(&weighted);
        self.gram.solve(&mut multipliers);
        multipliers
    }

    /// Eq. (1), twice: the residual is small compared with what the rows take.
    pub(in crate::statics) fn felt(&self, force: &[f64], metric: &[f64]) -> Vec<f64> {
        let mut left = force.to_vec();
        for _ in 0..2 {
            let multipliers = self.multipliers(&left, metric);
            self.rows.add_transposed(-1.0, &multipliers, &mut left);
        }
        left
    }

    /// How large (1) is of forces whose squares are expected to be these, independently of each other: what rows take is
    /// estimated from vectors of random signs (Hutchinson 1989), and the round-off of the whole force stays.
    pub(in crate::statics) fn felt_size(&self, squares: &[f64], metric: &[f64]) -> Vec<f64> {
        let mut sums = squares.to_vec();
        let mut taken = vec![0.0; squares.len()];
        for probe in 0..PROBES {
            let force: Vec<f64> = squares.iter().enumerate().map(|(i, s)| sign(i, probe) * s.sqrt()).collect();
            let multipliers = self.multipliers(&force, metric);
            taken.fill(0.0);
            self.rows.add_transposed(1.0, &multipliers, &mut taken);
            sums.iter_mut().zip(&taken).for_each(|(sum, x)| *sum += x * x / PROBES as f64);
        }
        sums.into_iter().map(f64::sqrt).collect()
    }
}

/// A random sign, the same every time (splitmix64).
fn sign(i: usize, probe: usize) -> f64 {
    let mut z = ((i * PROBES + probe) as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    if (z ^ (z >> 31)) & 1 == 0 { 1.0 } else { -1.0 }
}
