//! Sizes of the terms that a stiffness is the sum of: compared with them it counts, or is round-off.

use crate::round_off::STIFFNESS;
use faer::{Mat, Side};

/// A stiffness below this part of the terms it is the sum of counts as zero.
pub(in crate::statics) const NEUTRAL: f64 = 1e-9;

pub(in crate::statics) fn symmetric(m: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| 0.5 * (m[(i, j)] + m[(j, i)]))
}

/// Sizes of stiffness terms with which coordinates are compared: one without any stiffness, as of a body that floats, or with what rounding of
/// the stiffest makes, is neutral compared with the largest of the others.
pub(in crate::statics) fn comparable(magnitude: &[f64]) -> Vec<f64> {
    let largest = magnitude.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(*x));
    magnitude.iter().map(|x| if *x > STIFFNESS.of(largest) { *x } else { largest }).collect()
}

/// `N^(-1/2) K N^(-1/2)` with the sizes `N` of the stiffness terms.
pub(in crate::statics) fn relative(stiffness: &Mat<f64>, magnitude: &[f64]) -> Mat<f64> {
    // Of each by itself: the product of two sizes may be beyond all numbers.
    let root: Vec<f64> = comparable(magnitude).iter().map(|size| size.sqrt()).collect();
    Mat::from_fn(root.len(), root.len(), |i, j| stiffness[(i, j)] / root[i] / root[j])
}

/// Sizes of the stiffness terms along the columns of `z`, if there is one.
pub(in crate::statics) fn sizes(z: Option<&Mat<f64>>, magnitude: &[f64]) -> Vec<f64> {
    let Some(z) = z else { return magnitude.to_vec() };
    let size = |j: usize| (0..z.nrows()).map(|i| z[(i, j)].powi(2) * magnitude[i]).sum::<f64>();
    (0..z.ncols()).map(size).collect()
}

/// How many directions a stiffness with terms of these sizes is negative along, and along how many it is zero.
pub(in crate::statics) fn count_by_stiffness(stiffness: &Mat<f64>, magnitude: &[f64]) -> (usize, usize) {
    let n = magnitude.len();
    let scaled = relative(stiffness, magnitude);
    let values = scaled.self_adjoint_eigenvalues(Side::Lower).unwrap_or_else(|_| vec![f64::NAN; n]);
    let unstable = values.iter().filter(|x| **x < -NEUTRAL).count();
    let neutral = values.iter().filter(|x| x.abs() <= NEUTRAL || x.is_nan()).count();
    (unstable, neutral)
}
