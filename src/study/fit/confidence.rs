//! How well measurements determine parameters.
//!
//! With the Jacobian `J` of the weighted residuals `r` where their sum of squares is least, `n` measurements and `k` parameters that
//! they determine:
//!
//! ```text
//! (1)  s² = |r|² / (n − k),    C = s² (JᵀJ)⁺,    the standard error of parameter j: √C_jj
//! (2)  x_j ± t √C_jj           t the quantile of Student's distribution with n − k degrees of freedom
//! (3)  J N⁻¹ = U S Vᵀ           N the sizes of the columns; singular values of zero: combinations that change nothing
//! ```
//!
//! The intervals are those of the linear model at the minimum, for errors that are independent and equal after weighting.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A parameter that takes part in a combination that changes nothing by more than this part of it is not determined.
const PART: f64 = 1e-3;

/// What (1) to (3) say.
#[derive(Debug, Clone)]
pub(super) struct Confidence {
    /// `n − k`.
    pub freedom: usize,
    /// `C`; rows and columns of parameters that are not determined, or are held at a bound, are `NaN`.
    pub covariance: DMatrix<f64>,
    /// `t`; `NaN` without degrees of freedom.
    pub quantile: f64,
    /// Indices of parameters that no measurement feels.
    pub unfelt: Vec<usize>,
    /// Combinations of several parameters that change nothing: their indices, and their part in it, the largest ±1.
    pub together: Vec<Vec<(usize, f64)>>,
}

impl Confidence {
    /// Of parameters that are `free`. Singular values below `rank` of the largest count as zero; `level` is the probability of the
    /// intervals, 0 to 1.
    pub(super) fn of(jacobian: &DMatrix<f64>, residuals: &DVector<f64>, free: &[usize], rank: f64, level: f64) -> Self {
        let sizes: Vec<f64> = free.iter().map(|j| jacobian.column(*j).norm()).collect();
        let felt: Vec<usize> = (0..free.len()).filter(|at| sizes[*at] > 0.0).collect();
        let unfelt = (0..free.len()).filter(|at| sizes[*at] == 0.0).map(|at| free[at]).collect();
        let scaled = DMatrix::from_fn(jacobian.nrows().max(felt.len()), felt.len(), |i, at| {
            if i < jacobian.nrows() { jacobian[(i, free[felt[at]])] / sizes[felt[at]] } else { 0.0 }
        });
        let count = jacobian.ncols();
        let mut covariance = DMatrix::from_element(count, count, f64::NAN);
        let (mut together, mut determined) = (Vec::new(), vec![true; felt.len()]);
        let mut kept = 0;
        if !felt.is_empty() {
            let parts = scaled.svd(false, true);
            let largest = parts.singular_values.max();
            let directions = parts.v_t.unwrap_or_default();
            let mut inverse = DMatrix::zeros(felt.len(), felt.len());
            for (k, value) in parts.singular_values.iter().enumerate() {
                let direction = directions.row(k);
                if *value > rank * largest {
                    kept += 1;
                    inverse += direction.transpose() * direction / (value * value);
                    continue;
                }
                let per = |at: usize| direction[at] / sizes[felt[at]];
                let most = (0..felt.len()).map(|at| direction[at].abs()).fold(0.0, f64::max);
                let takes_part: Vec<usize> = (0..felt.len()).filter(|at| direction[*at].abs() > PART * most).collect();
                let first = takes_part.first().map_or(1.0, |at| per(*at));
                together.push(takes_part.iter().map(|at| (free[felt[*at]], per(*at) / first)).collect());
                takes_part.into_iter().for_each(|at| determined[at] = false);
            }
            let freedom = residuals.len().saturating_sub(kept);
            let variance = if freedom > 0 { residuals.norm_squared() / freedom as f64 } else { f64::NAN };
            for (a, i) in felt.iter().enumerate().filter(|(a, _)| determined[*a]) {
                for (b, j) in felt.iter().enumerate().filter(|(b, _)| determined[*b]) {
                    covariance[(free[*i], free[*j])] = variance * inverse[(a, b)] / (sizes[*i] * sizes[*j]);
                }
            }
        }
        let freedom = residuals.len().saturating_sub(kept);
        let student = StudentsT::new(0.0, 1.0, freedom as f64).ok();
        let quantile = student.map_or(f64::NAN, |student| student.inverse_cdf(0.5 + 0.5 * level));
        Self { freedom, covariance, quantile, unfelt, together }
    }

    /// √C_jj; `None` where that is not determined.
    pub(super) fn error(&self, j: usize) -> Option<f64> {
        Some(self.covariance[(j, j)].sqrt()).filter(|error| error.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight line through four points: s² (XᵀX)⁻¹ is known in closed form.
    #[test]
    fn a_line_has_the_errors_of_textbooks() {
        let x = [0.0, 1.0, 2.0, 3.0];
        let jacobian = DMatrix::from_fn(4, 2, |i, j| if j == 0 { 1.0 } else { x[i] });
        let residuals = DVector::from_vec(vec![0.1, -0.1, -0.1, 0.1]);
        let found = Confidence::of(&jacobian, &residuals, &[0, 1], 1e-9, 0.95);
        // s² = 0.04/2, Sxx = 5, mean 1.5.
        let slope = (0.02_f64 / 5.0).sqrt();
        let offset = (0.02_f64 * (0.25 + 1.5 * 1.5 / 5.0)).sqrt();
        assert!((found.error(1).expect("an error") - slope).abs() < 1e-14);
        assert!((found.error(0).expect("an error") - offset).abs() < 1e-14);
        // Student's t for two degrees of freedom, 97.5 %: tables.
        assert!((found.quantile - 4.302_652_73).abs() < 1e-6, "{}", found.quantile);
    }

    #[test]
    fn parameters_that_only_act_together_are_named() {
        // The first two enter as their sum, the fourth not at all.
        let jacobian = DMatrix::from_fn(5, 4, |i, j| [1.0, 1.0, i as f64, 0.0][j]);
        let residuals = DVector::from_element(5, 0.1);
        let found = Confidence::of(&jacobian, &residuals, &[0, 1, 2, 3], 1e-9, 0.95);
        assert_eq!((found.freedom, &found.unfelt[..]), (3, &[3][..]));
        let names: Vec<usize> = found.together[0].iter().map(|(j, _)| *j).collect();
        assert_eq!(names, [0, 1]);
        assert!((found.together[0][1].1 + 1.0).abs() < 1e-12, "{:?}", found.together);
        assert!(found.error(0).is_none() && found.error(2).is_some() && found.error(3).is_none());
    }
}
