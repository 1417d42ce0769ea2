//! What a column of a study says: moments, quantiles, and how much of it each input explains.
//!
//! **Regression.** With inputs and output scaled to mean 0 and variance 1, `R` the correlations of the inputs, `r` those of each
//! input with the output:
//!
//! ```text
//! β = R⁻¹ r,    R² = βᵀ r                                                                       (1)
//! s_j² = (1 − R²) (R⁻¹)_jj / (n − k − 1)                                                        (2)
//! ```
//!
//! β are the standardized regression coefficients, and β ± t s their confidence intervals with a quantile `t` of Student's
//! distribution with n − k − 1 degrees of freedom. The sum of β² is R² if the inputs are independent: β² is the part of the
//! variance that an input explains. Of correlated inputs none has such a part of its own: two may cancel each other, and β² of both be
//! above 1. A small R² says that the output is not linear in the inputs.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Count, means and products of deviations of several columns, row by row (Welford 1962).
#[derive(Debug, Clone)]
pub struct Moments {
    /// Rows.
    pub count: u64,
    mean: Vec<f64>,
    /// Σ (x_i − mean_i)(x_j − mean_j), j ≤ i.
    products: Vec<f64>,
    /// Smallest and largest of every column.
    pub ends: Vec<(f64, f64)>,
}

impl Moments {
    /// Of so many columns.
    pub fn new(columns: usize) -> Self {
        let ends = vec![(f64::INFINITY, f64::NEG_INFINITY); columns];
        Self { count: 0, mean: vec![0.0; columns], products: vec![0.0; columns * (columns + 1) / 2], ends }
    }

    /// Takes a row: one number for every column.
    pub fn add(&mut self, row: &[f64]) {
        self.count += 1;
        let part = 1.0 / self.count as f64;
        let mut at = 0;
        for i in 0..row.len() {
            let before = row[i] - self.mean[i];
            self.mean[i] += part * before;
            // Deviations from the means before and after: columns j ≤ i have the new mean already.
            for j in 0..=i {
                self.products[at] += before * (row[j] - self.mean[j]);
                at += 1;
            }
            self.ends[i] = (self.ends[i].0.min(row[i]), self.ends[i].1.max(row[i]));
        }
    }

    /// The mean of a column.
    pub fn mean(&self, i: usize) -> f64 {
        self.mean[i]
    }

    /// The standard deviation of a column, that of a sample.
    pub fn deviation(&self, i: usize) -> f64 {
        let freedom = self.count.saturating_sub(1).max(1) as f64;
        (self.product(i, i) / freedom).sqrt()
    }

    /// Whether a column differs from row to row by more than rounding.
    pub fn varies(&self, i: usize) -> bool {
        let (low, high) = self.ends[i];
        high - low > 16.0 * f64::EPSILON * low.abs().max(high.abs())
    }

    /// The correlation of two columns that vary.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        self.product(i, j) / (self.product(i, i) * self.product(j, j)).sqrt()
    }

    fn product(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.max(j), i.min(j));
        self.products[i * (i + 1) / 2 + j]
    }
}

/// What an input does to an output.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Effect {
    /// Which input.
    pub input: usize,
    /// Standardized regression coefficient: standard deviations of the output for one of the input.
    pub coefficient: f64,
    /// Half of the confidence interval of the coefficient.
    pub confidence: f64,
    /// Correlation with the output.
    pub correlation: f64,
}

/// Equations (1) and (2).
#[derive(Debug, Clone, PartialEq)]
pub struct Regression {
    /// The inputs that vary, the largest coefficient first.
    pub effects: Vec<Effect>,
    /// R²: the part of the variance that is explained.
    pub explained: f64,
    /// The two inputs that are correlated most, and by how much, if that is more than chance: no input has a part of the variance then.
    pub correlated: Option<(usize, usize, f64)>,
}

/// The confidence of intervals.
pub const CONFIDENCE: f64 = 0.95;
/// Correlations of inputs below this leave β² as good as what it is for independent ones.
const SMALL: f64 = 0.1;
/// Correlations are more than chance from so many of their standard deviations on: with many pairs of inputs two or three are common.
const CHANCE: f64 = 4.0;
/// A part of the variance that is larger than the whole by this factor is none, however few rows say so.
const WHOLE: f64 = 1.1;

impl Regression {
    /// Of the last column on those before. `None` if too few rows or none that vary say something, or if the inputs are
    /// linearly dependent.
    pub fn new(moments: &Moments) -> Option<Self> {
        Self::beside(moments, 0)
    }

    /// As [`new`](Self::new), of columns for which so many more numbers were fitted to the rows before.
    pub fn beside(moments: &Moments, more: usize) -> Option<Self> {
        let output = moments.mean.len() - 1;
        let inputs: Vec<usize> = (0..output).filter(|i| moments.varies(*i)).collect();
        let k = inputs.len();
        let freedom = moments.count as f64 - (k + more) as f64 - 1.0;
        if k == 0 || freedom < 1.0 || !moments.varies(output) {
            return None;
        }
        let of_inputs = DMatrix::from_fn(k, k, |i, j| moments.correlation(inputs[i], inputs[j]));
        let closest = closest_pair(&of_inputs);
        let with_output = DVector::from_fn(k, |i, _| moments.correlation(inputs[i], output));
        let inverse = of_inputs.cholesky()?.inverse();
        let coefficients = &inverse * &with_output;
        let explained = coefficients.dot(&with_output).clamp(0.0, 1.0);
        let t = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.5 + 0.5 * CONFIDENCE);
        let mut effects: Vec<Effect> = (0..k)
            .map(|i| Effect {
                input: inputs[i],
                coefficient: coefficients[i],
                confidence: t * ((1.0 - explained) * inverse[(i, i)] / freedom).sqrt(),
                correlation: with_output[i],
            })
            .collect();
        effects.sort_by(|a, b| b.coefficient.abs().total_cmp(&a.coefficient.abs()));
        let is_too_much = effects.iter().any(|effect| effect.coefficient.powi(2) > WHOLE * explained);
        let correlated = closest
            .filter(|(.., r)| r.abs() > SMALL && (is_too_much || is_more_than_chance(*r, moments.count as f64)))
            .map(|(i, j, r)| (inputs[i], inputs[j], r));
        Some(Self { effects, explained, correlated })
    }
}

/// The pair that is correlated most, and by how much.
fn closest_pair(correlations: &DMatrix<f64>) -> Option<(usize, usize, f64)> {
    let pairs = (0..correlations.nrows()).flat_map(|j| (0..j).map(move |i| (i, j, correlations[(i, j)])));
    pairs.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))
}

/// Whether a correlation in so many rows is more than chance makes of independent columns: `artanh r` of these has a standard deviation of
/// 1/√(n − 3) (Fisher 1921).
fn is_more_than_chance(r: f64, rows: f64) -> bool {
    rows > 3.0 && r.abs().min(1.0).atanh() > CHANCE / (rows - 3.0).sqrt()
}

/// Bits that one pass of [`quantiles`] settles.
const DIGIT: u32 = 16;

/// Hands all numbers to what it is given.
pub type Each<'e, E> = &'e mut dyn FnMut(&mut dyn FnMut(f64)) -> Result<(), E>;

/// Exact quantiles of numbers that are read several times and never kept: the order of doubles is that of their bits, and each
/// of four passes counts one digit of those that begin like the answer (radix selection). For a part p of n numbers it is
/// the smallest that is not below p n of them. `each` hands over all numbers, every time the same.
///
/// # Errors
/// The errors of `each`.
pub fn quantiles<E>(parts: &[f64], count: u64, each: Each<'_, E>) -> Result<Vec<f64>, E> {
    // Beginning of the answer, and how many numbers are below among those that begin so.
    let rank = |part: &f64| ((part * count as f64).ceil() as u64).clamp(1, count.max(1)) - 1;
    let mut found: Vec<(u64, u64)> = parts.iter().map(|part| (0, rank(part))).collect();
    for pass in 1..=u64::BITS / DIGIT {
        let shift = u64::BITS - pass * DIGIT;
        let begins = |key: u64| if pass == 1 { 0 } else { key >> (shift + DIGIT) };
        let mut begun: Vec<u64> = found.iter().map(|(key, _)| *key).collect();
        begun.dedup();
        let mut counts = vec![vec![0_u64; 1 << DIGIT]; begun.len()];
        each(&mut |number| {
            let key = ordered(number);
            if let Ok(at) = begun.binary_search(&begins(key)) {
                counts[at][(key >> shift) as usize & ((1 << DIGIT) - 1)] += 1;
            }
        })?;
        for (key, below) in &mut found {
            let Ok(at) = begun.binary_search(key) else { continue };
            let mut digit = 0;
            while digit + 1 < 1 << DIGIT && *below >= counts[at][digit] {
                *below -= counts[at][digit];
                digit += 1;
            }
            *key = *key << DIGIT | digit as u64;
        }
    }
    Ok(found.into_iter().map(|(key, _)| number(key)).collect())
}

/// Bits in the order of the numbers.
fn ordered(number: f64) -> u64 {
    let bits = number.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

/// The number with these ordered bits.
fn number(key: u64) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that repeat nothing, from a linear congruence.
    fn random(n: usize) -> Vec<f64> {
        let mut state = 12345_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..n).map(|_| next()).collect()
    }

    #[test]
    fn quantiles_are_those_of_the_sorted_numbers() {
        for n in [1, 2, 3, 10, 1001] {
            for scale in [1.0, -1e300, 1e-310, 0.0] {
                let mut numbers: Vec<f64> = random(n).into_iter().map(|x| x * scale).collect();
                let parts = [0.0, 0.05, 0.5, 0.5, 0.95, 1.0];
                let found = quantiles::<()>(&parts, n as u64, &mut |take| {
                    numbers.iter().for_each(|x| take(*x));
                    Ok(())
                });
                numbers.sort_by(f64::total_cmp);
                let exact = parts.map(|p| numbers[((p * n as f64).ceil() as usize).clamp(1, n) - 1]);
                assert_eq!(found, Ok(exact.to_vec()), "{n} numbers");
            }
        }
    }

    /// y = 3 a − 2 b + noise: coefficients, R² and intervals against their exact values.
    #[test]
    fn coefficients_are_those_of_the_model_that_made_the_numbers() {
        let n = 4000;
        let x = random(3 * n);
        let mut moments = Moments::new(4);
        for row in x.chunks(3) {
            moments.add(&[row[0], row[1], 7.0, 3.0 * row[0] - 2.0 * row[1] + row[2] + 1e6]);
        }
        let found = Regression::new(&moments).expect("enough rows");
        assert_eq!(found.effects.iter().map(|effect| effect.input).collect::<Vec<_>>(), [0, 1]);
        let size = 14_f64.sqrt();
        for (effect, exact) in found.effects.iter().zip([3.0 / size, -2.0 / size]) {
            // Standard error: √((1 − R²)/n) = 0.0042, and that of the deviations, 0.7 % of the coefficient.
            assert!((effect.coefficient - exact).abs() < 5.0 * 0.008, "{effect:?}");
            assert!((effect.confidence / (1.96 * (1.0 / 14.0 / n as f64).sqrt()) - 1.0).abs() < 0.1, "{effect:?}");
        }
        assert!((found.explained - 13.0 / 14.0).abs() < 0.01, "{}", found.explained);
        assert!((moments.mean(3) - 1e6).abs() < 0.1 && (moments.deviation(3) - (14.0_f64 / 12.0).sqrt()).abs() < 0.05);
        assert_eq!((moments.mean(2), moments.deviation(2), moments.varies(2)), (7.0, 0.0, false));
    }

    /// y = a + b of inputs with correlation r: β² of each is 1 / (2 + 2 r), above 1 for r < −1/2. Chance alone correlates nothing.
    #[test]
    fn correlated_inputs_are_told_and_chance_is_not() {
        for (n, r, is_told) in
            [(2000, -0.9_f64, true), (2000, 0.3, true), (2000, 0.0, false), (60, 0.0, false), (12, -0.95, true)]
        {
            let mut moments = Moments::new(3);
            for row in random(2 * n).chunks(2) {
                let b = r * row[0] + (1.0 - r * r).sqrt() * row[1];
                moments.add(&[row[0], b, row[0] + b]);
            }
            let found = Regression::new(&moments).expect("enough rows");
            let pair = found.correlated.map(|(i, j, _)| (i, j));
            assert_eq!(pair, is_told.then_some((0, 1)), "{n} {r} {found:?}");
        }
    }

    #[test]
    fn what_says_nothing_has_no_regression() {
        let of = |rows: &[[f64; 3]]| {
            let mut moments = Moments::new(3);
            rows.iter().for_each(|row| moments.add(row));
            Regression::new(&moments)
        };
        assert_eq!(of(&[[1.0, 2.0, 3.0], [2.0, 1.0, 5.0]]), None, "two rows");
        assert_eq!(of(&[[1.0, 2.0, 3.0]; 9]), None, "nothing varies");
        let dependent: Vec<[f64; 3]> = random(20).into_iter().map(|x| [x, 2.0 * x, x * x]).collect();
        assert!(of(&dependent).is_none_or(|found| found.effects[0].confidence > 1.0), "linearly dependent inputs");
    }
}
