//! The lowest modes of a part of a body by iteration in a subspace: `K⁻¹ M` on a block of vectors, Rayleigh and Ritz in between
//! (Bathe and Wilson, 1972). Massless freedoms are allowed.

use super::{Flaw, Symmetric};
use crate::sparse::Cholesky;
use nalgebra::{DMatrix, SymmetricEigen};

/// Displacements of all freedoms for a unit of each coordinate.
pub(super) struct Basis {
    pub(super) columns: Vec<Vec<f64>>,
}

/// Rounds, at most: a block of twice the modes gains a factor of some tens in each.
const MOST_ROUNDS: usize = 200;

/// Changes of the eigenvalues against themselves between two rounds at which they are taken: the error of the modes is the root of
/// that.
const SETTLED: f64 = 1e-13;

/// Changes below this part that fall no more will not: the stiffness is known to its round-off only.
const STALLED: f64 = 1e-9;

/// The lowest `count` modes of `K x = ω² M x`, by columns; `factors` are those of `K`.
///
/// # Errors
/// Fewer modes than wanted have mass, or the iteration did not settle.
pub(super) fn lowest(
    stiffness: &Symmetric,
    mass: &Symmetric,
    factors: &mut Cholesky,
    count: usize,
) -> Result<Vec<Vec<f64>>, Flaw> {
    let n = stiffness.len();
    if count == 0 {
        return Ok(Vec::new());
    }
    let block = n.min((2 * count).max(count + 8));
    let mut vectors: Vec<Vec<f64>> = (0..block).map(|k| start(n, k)).collect();
    let mut before = vec![f64::INFINITY; count.min(block)];
    let mut last = f64::INFINITY;
    for _ in 0..MOST_ROUNDS {
        for x in &mut vectors {
            *x = mass.times(x);
            factors.solve(x);
        }
        let flexible = ritz(stiffness, mass, &mut vectors);
        if flexible.len() < count {
            let message = format!("{} modes with all interfaces held have mass, {count} are wanted", flexible.len());
            return Err(Flaw::new(message).help("ask for fewer `modes`"));
        }
        let change = |(now, before): (&f64, &f64)| ((now - before) / now).abs();
        let worst = flexible.iter().zip(&before).map(change).fold(0.0, f64::max);
        // Eigenvalues settle no further than their round-off, which is that of the stiffness against its least.
        let floor = worst < STALLED && worst > 0.5 * last;
        if worst < SETTLED || floor || vectors.len() == n {
            vectors.truncate(count);
            vectors.iter_mut().for_each(|x| straighten(x));
            return Ok(vectors);
        }
        before = flexible[..count].to_vec();
        last = worst;
    }
    Err(Flaw::new(format!("{count} modes of the body did not settle in {MOST_ROUNDS} rounds"))
        .help("ask for fewer `modes`"))
}

/// Numbers in −1 … 1 that depend on nothing but their place (the finalizer of splitmix64).
fn start(n: usize, k: usize) -> Vec<f64> {
    let number = |i: usize| {
        let mut z = 0x9E37_79B9_7F4A_7C15_u64.wrapping_mul((k * n + i + 1) as u64);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..n).map(number).collect()
}

/// Replaces the vectors by the Ritz vectors in ascending order of their frequencies, which are returned squared.
fn ritz(stiffness: &Symmetric, mass: &Symmetric, vectors: &mut Vec<Vec<f64>>) -> Vec<f64> {
    let block = vectors.len();
    // An orthonormal basis first, twice: the vectors are nearly parallel to the lowest modes.
    for _ in 0..2 {
        for i in 0..block {
            let (done, from_here) = vectors.split_at_mut(i);
            let x = &mut from_here[0];
            let given = dot(x, x).sqrt();
            for other in done {
                let along = dot(x, other);
                x.iter_mut().zip(&*other).for_each(|(x, y)| *x -= along * y);
            }
            let length = dot(x, x).sqrt();
            let scale = if length > 1e-12 * given { 1.0 / length } else { 0.0 };
            x.iter_mut().for_each(|x| *x *= scale);
        }
    }
    vectors.retain(|x| x.iter().any(|x| *x != 0.0));
    let block = vectors.len();
    let form = |matrix: &Symmetric| {
        let images: Vec<Vec<f64>> = vectors.iter().map(|x| matrix.times(x)).collect();
        let full = DMatrix::from_fn(block, block, |i, j| dot(&vectors[i], &images[j]));
        0.5 * (&full + full.transpose())
    };
    let (k, m) = (form(stiffness), form(mass));
    let Some(factor) = k.cholesky() else { return Vec::new() };
    let left = |matrix: &DMatrix<f64>| factor.l().solve_lower_triangular(matrix).unwrap_or_else(|| matrix.clone());
    let inner = left(&left(&m).transpose());
    let eigen = SymmetricEigen::new(0.5 * (&inner + inner.transpose()));
    let mut order: Vec<usize> = (0..block).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let largest = eigen.eigenvalues.max();
    let shapes = factor.l().transpose().solve_upper_triangular(&eigen.eigenvectors);
    let Some(shapes) = shapes else { return Vec::new() };
    let combined = order.iter().map(|mode| {
        let mut sum = vec![0.0; vectors[0].len()];
        for (i, x) in vectors.iter().enumerate() {
            sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += shapes[(i, *mode)] * x);
        }
        sum
    });
    let combined: Vec<Vec<f64>> = combined.collect();
    *vectors = combined;
    let with_mass = order.iter().map(|mode| eigen.eigenvalues[*mode]).filter(|value| *value > 1e-14 * largest);
    with_mass.map(|value| 1.0 / value).collect()
}

/// The entry of the largest size is positive.
fn straighten(x: &mut [f64]) {
    let largest = x.iter().fold(0.0_f64, |most, x| if x.abs() > most.abs() * (1.0 + 1e-9) { *x } else { most });
    if largest < 0.0 {
        x.iter_mut().for_each(|x| *x = -*x);
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
