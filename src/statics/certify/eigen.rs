//! Eigenvalues and eigenvectors of a matrix without symmetry.
//!
//! Small ones, which a study solves by the million, from the real Schur form `A = Q T Qᵀ` (Golub & Van Loan, §7.4 to 7.6): `T` is triangular
//! but for blocks of two rows, one for each complex pair, and the eigenvector of λ is `Q x` with
//!
//! ```text
//! (T − λ) x = 0,   x = (…, x_k, 0, …, 0) for λ of the block that ends in row k                   (1)
//! ```
//!
//! by substitution from row k upwards: twelve rows, of six coordinates, take 131 000 instructions for it where faer takes 335 000. Large ones
//! are faer's, which works in blocks.

use faer::{Mat, c64};
use nalgebra::{DMatrix, Schur};

/// Rows up to which the Schur form is computed row by row.
const SMALL: usize = 24;
/// Sweeps of the QR iteration for each row: two or three are usual.
const SWEEPS: usize = 60;
/// Divisors are at least this part of the matrix: equal eigenvalues give vectors that are as good as equal.
const LEAST: f64 = f64::EPSILON;
/// Vectors that grow beyond this by such divisors are scaled: their squares have to stay finite.
const LARGE: f64 = 1e100;

/// Eigenvalues with their vectors, every pair of complex ones by both; `None` if the iteration does not end.
pub(super) fn pairs(matrix: &Mat<f64>) -> Option<Vec<(c64, Vec<c64>)>> {
    let n = matrix.nrows();
    if n <= SMALL
        && let Some(found) = small(matrix)
    {
        return Some(found);
    }
    let eigen = matrix.eigen().ok()?;
    Some((0..n).map(|i| (eigen.S()[i], (0..n).map(|row| eigen.U()[(row, i)]).collect())).collect())
}

fn small(matrix: &Mat<f64>) -> Option<Vec<(c64, Vec<c64>)>> {
    let n = matrix.nrows();
    // Squares neither overflow nor vanish; a power of two, so that no bit changes.
    let size = matrix.norm_max();
    if !size.is_finite() {
        return None;
    }
    let unit = if size > 0.0 { size.log2().floor().exp2() } else { 1.0 };
    let copy = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] / unit);
    let (q, t) = Schur::try_new(copy, f64::EPSILON, SWEEPS * n.max(1))?.unpack();
    let mut found = Vec::with_capacity(n);
    let mut k = 0;
    while k < n {
        let is_pair = k + 1 < n && t[(k + 1, k)] != 0.0;
        let last = k + usize::from(is_pair);
        for root in block(&t, k, last) {
            let x = substituted(&t, root, last);
            let vector: Vec<c64> = (0..n).map(|row| (0..=last).map(|j| x[j] * q[(row, j)]).sum()).collect();
            found.push((root * unit, vector));
        }
        k = last + 1;
    }
    found.iter().all(|(root, _)| root.re.is_finite() && root.im.is_finite()).then_some(found)
}

/// Eigenvalues of the block of rows `k` to `last`.
fn block(t: &DMatrix<f64>, k: usize, last: usize) -> Vec<c64> {
    if k == last {
        return vec![c64::new(t[(k, k)], 0.0)];
    }
    let (a, b, c, d) = (t[(k, k)], t[(k, last)], t[(last, k)], t[(last, last)]);
    let (middle, half) = (0.5 * (a + d), 0.5 * (a - d));
    let square = half * half + b * c;
    let root = square.abs().sqrt();
    if square < 0.0 {
        return vec![c64::new(middle, root), c64::new(middle, -root)];
    }
    // Two real ones that the iteration left in one block: the larger, and the other from the determinant.
    let larger = middle + root.copysign(middle);
    let smaller = if larger == 0.0 { 0.0 } else { (a * d - b * c) / larger };
    vec![c64::new(larger, 0.0), c64::new(smaller, 0.0)]
}

/// (1) for an eigenvalue of the block that ends in row `last`.
fn substituted(t: &DMatrix<f64>, root: c64, last: usize) -> Vec<c64> {
    let mut x = vec![c64::new(0.0, 0.0); last + 1];
    x[last] = c64::new(1.0, 0.0);
    let mut row = last as isize - 1;
    if last > 0 && t[(last, last - 1)] != 0.0 {
        // Either row of the block says the same; the larger entries say it best.
        let (above, below) = (t[(last - 1, last)], t[(last, last - 1)]);
        x[last - 1] = if above.abs() > below.abs() {
            -c64::new(above, 0.0) / clear(c64::new(t[(last - 1, last - 1)], 0.0) - root)
        } else {
            -(c64::new(t[(last, last)], 0.0) - root) / c64::new(below, 0.0)
        };
        row -= 1;
    }
    while row >= 0 {
        let i = row as usize;
        let known = |i: usize, from: usize, x: &[c64]| (from..=last).map(|j| x[j] * t[(i, j)]).sum::<c64>();
        if i > 0 && t[(i, i - 1)] != 0.0 {
            let rows = [
                [c64::new(t[(i - 1, i - 1)], 0.0) - root, c64::new(t[(i - 1, i)], 0.0)],
                [c64::new(t[(i, i - 1)], 0.0), c64::new(t[(i, i)], 0.0) - root],
            ];
            [x[i - 1], x[i]] = solved(rows, [-known(i - 1, i + 1, &x), -known(i, i + 1, &x)]);
            row -= 2;
        } else {
            x[i] = -known(i, i + 1, &x) / clear(c64::new(t[(i, i)], 0.0) - root);
            row -= 1;
        }
        let largest = x.iter().map(size).fold(0.0, f64::max);
        if largest > LARGE {
            x.iter_mut().for_each(|z| *z /= largest);
        }
    }
    x
}

fn size(z: &c64) -> f64 {
    z.re.hypot(z.im)
}

/// A divisor that is no smaller than [`LEAST`].
fn clear(z: c64) -> c64 {
    if size(&z) < LEAST { c64::new(LEAST, 0.0) } else { z }
}

/// Two equations, by elimination with the largest pivots: where they depend on each other the residual stays small, and the solution is
/// along what they leave free.
fn solved(rows: [[c64; 2]; 2], rhs: [c64; 2]) -> [c64; 2] {
    let largest = (0..4).max_by(|a, b| size(&rows[a / 2][a % 2]).total_cmp(&size(&rows[b / 2][b % 2]))).unwrap_or(0);
    let (i, j) = (largest / 2, largest % 2);
    let pivot = clear(rows[i][j]);
    let part = rows[1 - i][j] / pivot;
    let other = (rhs[1 - i] - part * rhs[i]) / clear(rows[1 - i][1 - j] - part * rows[i][1 - j]);
    let own = (rhs[i] - rows[i][1 - j] * other) / pivot;
    if j == 0 { [own, other] } else { [other, own] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(n: usize, state: &mut u64) -> Mat<f64> {
        let mut next = || {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        Mat::from_fn(n, n, |_, _| next())
    }

    /// Every pair solves its equation, and their sum is the trace: random matrices, defective ones, and ones with equal values.
    #[test]
    fn pairs_solve_their_equation() {
        let mut state = 7;
        let mut cases: Vec<Mat<f64>> = (1..=SMALL).flat_map(|n| [(); 6].map(|()| random(n, &mut state))).collect();
        cases.push(Mat::zeros(5, 5));
        cases.push(Mat::identity(4, 4));
        cases.push(Mat::from_fn(6, 6, |i, j| if i == j { 2.0 } else { f64::from(u8::from(i + 1 == j)) }));
        cases.push(Mat::from_fn(4, 4, |i, j| {
            [[0., 0., 1., 0.], [0., 0., 0., 1.], [-9., 0., 0., 0.], [0., -9., 0., 0.]][i][j]
        }));
        for a in &cases {
            let n = a.nrows();
            let found = small(a).expect("an end");
            assert_eq!(found.len(), n);
            let size = a.norm_max().max(1.0) * n as f64;
            for (root, x) in &found {
                let largest = x.iter().map(|z| z.re.hypot(z.im)).fold(0.0, f64::max);
                assert!(largest > 0.0 && largest.is_finite());
                for i in 0..n {
                    let left = (0..n).map(|j| x[j] * a[(i, j)]).sum::<c64>() - *root * x[i];
                    assert!(left.re.hypot(left.im) < 1e-13 * size * largest, "{n}: {left:?} of {root:?}");
                }
            }
            let trace: f64 = (0..n).map(|i| a[(i, i)]).sum();
            let sum: c64 = found.iter().map(|(root, _)| *root).sum();
            assert!((sum.re - trace).abs() < 1e-13 * size && sum.im.abs() < 1e-13 * size, "{sum:?} for {trace}");
        }
    }

    /// The values are faer's.
    #[test]
    fn values_are_those_of_the_large_ones() {
        let mut state = 11;
        for n in 1..=SMALL {
            let a = random(n, &mut state);
            let mut other = a.eigenvalues().expect("an end");
            for (root, _) in small(&a).expect("an end") {
                let near = |z: &c64| (z.re - root.re).hypot(z.im - root.im);
                let at =
                    (0..other.len()).min_by(|i, j| near(&other[*i]).total_cmp(&near(&other[*j]))).expect("one left");
                // Eigenvalues of a random matrix of this size are some 10⁵ times as uncertain as its entries at worst.
                assert!(near(&other[at]) < 1e-9, "{n}: {root:?} and {:?}", other[at]);
                other.swap_remove(at);
            }
        }
    }
}
