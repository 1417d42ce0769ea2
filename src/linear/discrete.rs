//! Inputs held constant over a step: the exponential of the equations.
//!
//! ```text
//! (1)  exp( [A B; 0 0] h ) = [A_d B_d; 0 1]
//! (2)  exp(X) = exp(X / 2^k)^(2^k),   the factor by its Taylor series
//! ```

use super::StateSpace;
use faer::Mat;
use std::f64::consts::LN_10;

/// The norm up to which the series is taken, and its terms: the truncation error, 2⁻¹⁹/19!, is below the rounding of one.
const NORM: f64 = 0.5;
const TERMS: usize = 18;

/// `A_d` and `B_d` by (1) for a step (s); not finite if they grow beyond the largest number.
pub fn hold(a: &Mat<f64>, b: &Mat<f64>, step: f64) -> (Mat<f64>, Mat<f64>) {
    let (n, m) = (a.nrows(), b.ncols());
    let both = Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
        (true, true) => step * a[(i, j)],
        (true, false) => step * b[(i, j - n)],
        _ => 0.0,
    });
    let exponential = exponential(&both).unwrap_or_else(|| Mat::from_fn(n + m, n + m, |_, _| f64::NAN));
    (Mat::from_fn(n, n, |i, j| exponential[(i, j)]), Mat::from_fn(n, m, |i, j| exponential[(i, n + j)]))
}

/// Why there are no equations from step to step.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "over a step of {step} s the equations grow beyond the largest number: {}; take a shorter step",
    grown(*.growth, *.step)
)]
pub struct Overflow {
    /// The step (s).
    pub step: f64,
    /// The eigenvalue with the largest real part, its real and imaginary part (1/s); none if that is not known.
    pub growth: Option<[f64; 2]>,
}

/// What grows over a step.
fn grown(growth: Option<[f64; 2]>, step: f64) -> String {
    match growth {
        Some([re, im]) if re > 0.0 => {
            let value = if im == 0.0 { format!("{re:.6}") } else { format!("{re:.6} ± {:.6}i", im.abs()) };
            format!(
                "their fastest growing eigenvalue is {value} 1/s, and exp({re:.4} · {step}) = 10^{:.0}",
                re * step / LN_10
            )
        }
        _ => "their matrix times the step is too large to be squared".to_owned(),
    }
}

impl StateSpace {
    /// [`hold`] of these equations for a step (s).
    ///
    /// # Errors
    /// [`Overflow`] if a number of them is not finite.
    pub fn hold(&self, step: f64) -> Result<(Mat<f64>, Mat<f64>), Overflow> {
        let (a, b) = hold(&self.a, &self.b, step);
        let is_finite = |m: &Mat<f64>| m.col_iter().all(|column| column.iter().all(|x| x.is_finite()));
        if is_finite(&a) && is_finite(&b) {
            return Ok((a, b));
        }
        let growth = self.eigenvalues().into_iter().max_by(|a, b| a[0].total_cmp(&b[0]));
        Err(Overflow { step, growth })
    }
}

/// (2); `None` of a matrix whose norm is not finite.
fn exponential(x: &Mat<f64>) -> Option<Mat<f64>> {
    let n = x.nrows();
    let norm = (0..n).map(|i| (0..n).map(|j| x[(i, j)].abs()).sum::<f64>()).fold(0.0, f64::max);
    if !norm.is_finite() {
        return None;
    }
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
    Some(sum)
}
