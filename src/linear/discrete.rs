//! Inputs held constant over a step: the exponential of the equations.
//!
//! ```text
//! (1)  exp( [A B; 0 0] h ) = [A_d B_d; 0 1]
//! (2)  exp(X) = exp(X / 2^k)^(2^k),   the factor by its Taylor series
//! ```

use faer::Mat;

/// The norm up to which the series is taken, and its terms: the truncation error, 2⁻¹⁹/19!, is below the rounding of one.
const NORM: f64 = 0.5;
const TERMS: usize = 18;

/// `A_d` and `B_d` by (1) for a step (s).
pub fn hold(a: &Mat<f64>, b: &Mat<f64>, step: f64) -> (Mat<f64>, Mat<f64>) {
    let (n, m) = (a.nrows(), b.ncols());
    let both = Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
        (true, true) => step * a[(i, j)],
        (true, false) => step * b[(i, j - n)],
        _ => 0.0,
    });
    let exponential = exponential(&both);
    (Mat::from_fn(n, n, |i, j| exponential[(i, j)]), Mat::from_fn(n, m, |i, j| exponential[(i, n + j)]))
}

/// (2)
fn exponential(x: &Mat<f64>) -> Mat<f64> {
    let n = x.nrows();
    let norm = (0..n).map(|i| (0..n).map(|j| x[(i, j)].abs()).sum::<f64>()).fold(0.0, f64::max);
    let halvings = if norm > NORM { (norm / NORM).log2().ceil() as i32 } else { 0 };
    let small = Mat::from_fn(n, n, |i, j| x[(i, j)] * 0.5_f64.powi(halvings));
    let mut term: Mat<f64> = Mat::identity(n, n);
    let mut sum = term.clone();
    for k in 1..=TERMS {
        term = &term * &small;
        term = Mat::from_fn(n, n, |i, j| term[(i, j)] / k as f64);
        sum = &sum + &term;
    }
    for _ in 0..halvings {
        sum = &sum * &sum;
    }
    sum
}
