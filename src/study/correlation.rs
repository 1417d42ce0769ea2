//! Correlated numbers, by a Gaussian copula.
//!
//! Independent probabilities `u` become normal numbers, these correlated ones by the Cholesky factor of the matrix, and
//! probabilities again:
//!
//! ```text
//! z = L Φ⁻¹(u),   u′ = Φ(z),   L Lᵀ = R                                                         (1)
//! ```
//!
//! `R` is the correlation of the normal numbers `z`: exactly that of numbers with normal distributions, nearly that of others.
//! The distribution of each number by itself stays as it is.

use super::distribution::{BELOW_ONE, standard_normal, standard_normal_below};
use crate::model::problem::{counted, significant};
use crate::round_off::WRITTEN;
use nalgebra::DMatrix;

/// Correlated dimensions and the factor of their matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct Correlation {
    /// Dimensions that the matrix speaks of, in its order.
    dimensions: Vec<usize>,
    factor: DMatrix<f64>,
    matrix: DMatrix<f64>,
}

impl Correlation {
    /// Reads a matrix: a line with the addresses, and a line of numbers for each, separated by commas; the lines may begin
    /// with their address, and the first line with a comma then. Addresses that are not there stay independent. `addresses`
    /// are those of the plan.
    ///
    /// # Errors
    /// If it names another address, is not symmetric, or is no correlation matrix: not positive definite.
    pub fn parse(text: &str, addresses: &[&str]) -> Result<Self, String> {
        let lines: Vec<Vec<&str>> = text
            .lines()
            .filter(|line| !line.trim().is_empty() && !line.starts_with('#'))
            .map(|line| line.split(',').map(|cell| cell.trim().trim_matches('"')).collect())
            .collect();
        let Some((head, rows)) = lines.split_first() else { return Err("it is empty".to_owned()) };
        let named = head.first().is_some_and(|first| first.is_empty());
        let names = &head[usize::from(named)..];
        let n = names.len();
        let place = |name: &&str| {
            let found = addresses.iter().position(|address| address == name);
            found.ok_or_else(|| format!("`{name}` is not varied: the plan varies {}", addresses.join(", ")))
        };
        let dimensions = names.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        if let Some((index, name)) = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
            return Err(format!("`{name}` is there twice (column {})", index + 1));
        }
        if rows.len() != n {
            return Err(format!(
                "{} {} of numbers, not {}",
                counted(n, "address needs", "addresses need"),
                counted(n, "line", "lines"),
                rows.len()
            ));
        }
        let mut matrix = DMatrix::zeros(n, n);
        for (i, row) in rows.iter().enumerate() {
            if named && row[0] != names[i] {
                return Err(format!("line {} begins with `{}`, not with `{}`", i + 2, row[0], names[i]));
            }
            let cells = &row[usize::from(named)..];
            if cells.len() != n {
                return Err(format!(
                    "the line of `{}` has {}, not {n}",
                    names[i],
                    counted(cells.len(), "number", "numbers")
                ));
            }
            for (j, cell) in cells.iter().enumerate() {
                let number: f64 = cell.parse().map_err(|_| format!("`{cell}` is not a number"))?;
                if !number.is_finite() {
                    let of = format!("line {}, `{}` and `{}`", i + 2, names[i], names[j]);
                    return Err(format!("{of}: {number} is no correlation, allowed: finite numbers from −1 to 1"));
                }
                matrix[(i, j)] = number;
            }
        }
        Self::new(dimensions, matrix, names)
    }

    fn new(dimensions: Vec<usize>, matrix: DMatrix<f64>, names: &[&str]) -> Result<Self, String> {
        for (i, name) in names.iter().enumerate() {
            for j in 0..=i {
                let (here, there) = (matrix[(i, j)], matrix[(j, i)]);
                if !WRITTEN.hides(here - there, 1.0) {
                    return Err(format!("it is not symmetric: {here} and {there} for `{name}` and `{}`", names[j]));
                }
            }
            if !WRITTEN.hides(matrix[(i, i)] - 1.0, 1.0) {
                return Err(format!("`{name}` is correlated with itself by {}, and 1 is right", matrix[(i, i)]));
            }
        }
        let factor = matrix.clone().cholesky().map(|factor| factor.l()).ok_or_else(|| {
            let least = matrix.symmetric_eigenvalues().min();
            format!(
                "it is not positive definite (its least eigenvalue is {}): no numbers are correlated like this; \
                 smaller correlations are possible",
                significant(least, 4)
            )
        })?;
        Ok(Self { dimensions, factor, matrix })
    }

    /// Equation (1), for the dimensions of the matrix.
    pub fn apply(&self, u: &mut [f64]) {
        let normal: Vec<f64> = self.dimensions.iter().map(|d| standard_normal(u[*d])).collect();
        for (i, d) in self.dimensions.iter().enumerate() {
            let z: f64 = (0..=i).map(|j| self.factor[(i, j)] * normal[j]).sum();
            u[*d] = standard_normal_below(z).clamp(f64::MIN_POSITIVE, BELOW_ONE);
        }
    }

    /// The matrix with the dimensions of its rows, as it enters the hash of a plan.
    pub fn text(&self) -> String {
        format!("{:?} {:?}", self.dimensions, self.matrix.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::{Sampler, Sampling};
    use super::*;

    const ADDRESSES: [&str; 3] = ["a.mass", "b.mass", "c.length"];

    #[test]
    fn normal_numbers_have_the_correlation_that_was_asked_for() {
        let text = "c.length, a.mass\n1, -0.8\n-0.8, 1\n";
        let correlation = Correlation::parse(text, &ADDRESSES).expect("a matrix");
        let n = 20_000;
        let sampler = Sampler::new((Sampling::Random, 3, n), 3, Some(correlation)).expect("few numbers");
        let rows: Vec<Vec<f64>> =
            (0..n).map(|i| sampler.probabilities(i).into_iter().map(standard_normal).collect()).collect();
        let r = |a: usize, b: usize| rows.iter().map(|row| row[a] * row[b]).sum::<f64>() / n as f64;
        // The standard deviation of such a mean is at most √2/√n = 0.01.
        for (a, b, exact) in [(0, 2, -0.8), (0, 1, 0.0), (1, 2, 0.0), (0, 0, 1.0), (2, 2, 1.0)] {
            assert!((r(a, b) - exact).abs() < 0.05, "{a}, {b}: {}", r(a, b));
        }
    }

    #[test]
    fn what_is_no_correlation_matrix_is_refused_with_the_reason() {
        for (text, word) in [
            ("", "it is empty"),
            ("a.mass,d.mass\n1,0\n0,1\n", "`d.mass` is not varied"),
            ("a.mass,a.mass\n1,0\n0,1\n", "twice"),
            ("a.mass,b.mass\n1,0\n", "2 lines"),
            ("a.mass,b.mass\n1,0\n0,1,0\n", "3 numbers"),
            ("a.mass,b.mass\n1,0.5\n0.4,1\n", "not symmetric"),
            ("a.mass,b.mass\n2,0\n0,1\n", "with itself"),
            ("a.mass,b.mass\n1,nan\nnan,1\n", "line 2, `a.mass` and `b.mass`: NaN is no correlation"),
            ("a.mass,b.mass\n1,0\n-inf,1\n", "line 3, `b.mass` and `a.mass`: -inf is no correlation"),
            ("a.mass,b.mass\n1,1\n1,1\n", "not positive definite"),
            ("a.mass,b.mass,c.length\n1,0.9,-0.9\n0.9,1,0.9\n-0.9,0.9,1\n", "not positive definite"),
            (",a.mass,b.mass\nb.mass,1,0\na.mass,0,1\n", "begins with `b.mass`"),
            ("a.mass,b.mass\n1,x\nx,1\n", "`x` is not a number"),
        ] {
            let error = Correlation::parse(text, &ADDRESSES).expect_err(text);
            assert!(error.contains(word), "{text}: {error}");
        }
        let named = Correlation::parse(",b.mass,c.length\nb.mass,1,0.2\nc.length,0.2,1\n", &ADDRESSES);
        assert_eq!(named, Correlation::parse("\"b.mass\",c.length\n1,0.2\n0.2,1", &ADDRESSES));
    }
}
