//! A sum of functions of one input each, fitted to a column: what every other input does on its own is taken off before the effect of
//! one input is measured.
//!
//! ```text
//! y ≈ c + Σ f_i(x_i),   y_i = y − Σ_(j ≠ i) f_j(x_j)                                            (1)
//! ```
//!
//! Of independent inputs `E[y_i | x_i]` is `E[y | x_i]` but for a constant, whatever the functions `f_j` are (control variates;
//! Hammersley & Handscomb 1964), and `y_i` scatters less about it. How evenly a plan spreads the other inputs over a class of
//! `x_i`, as chance does or as Sobol points do, then hardly matters.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Polynomials of one input at most: two full waves across the range of an input are met within some per cent.
const MOST_DEGREE: usize = 8;
/// Rows for each number of the fit at least.
const ROWS_FOR_EACH: usize = 10;
/// Numbers of the fit at most: their products are formed for every row that is fitted.
const MOST_NUMBERS: usize = 256;
/// Rows that are fitted at most, nearly: any functions will do, more rows make them little better.
const MOST_FITTED: u64 = 20_000;
/// Part of a variance that is added to each: decides between polynomials that are the same on the few values of a grid.
const RIDGE: f64 = 1e-9;

/// The functions of (1).
#[derive(Debug, Clone)]
pub struct Additive {
    /// Of every input: its least value, the ends of its classes and its largest value, ascending.
    knots: Vec<Vec<f64>>,
    degree: usize,
    /// Every which row is fitted.
    stride: u64,
    seen: u64,
    fitted: u64,
    mean: f64,
    products: DMatrix<f64>,
    with_column: DVector<f64>,
    coefficients: DVector<f64>,
    /// The polynomials at the row at hand, the constant last.
    at: DVector<f64>,
}

impl Additive {
    /// For inputs with these ends of classes and these least and largest values, and a column of so many rows with this mean; `None`
    /// if there are too few rows for so many inputs.
    pub fn new(ends: &[Vec<f64>], ranges: &[(f64, f64)], rows: u64, mean: f64) -> Option<Self> {
        let inputs = ends.len();
        let stride = rows.div_ceil(MOST_FITTED).max(1);
        let numbers = MOST_NUMBERS.min((rows / stride) as usize / ROWS_FOR_EACH);
        let degree = numbers.checked_div(inputs)?.min(MOST_DEGREE);
        let knots = ends.iter().zip(ranges).map(|(ends, (low, high))| {
            let mut knots = [&[*low], ends.as_slice(), &[*high]].concat();
            knots.dedup();
            knots
        });
        let size = degree * inputs + 1;
        (degree > 0).then(|| Self {
            knots: knots.collect(),
            degree,
            stride,
            seen: 0,
            fitted: 0,
            mean,
            products: DMatrix::zeros(size, size),
            with_column: DVector::zeros(size),
            coefficients: DVector::zeros(size),
            at: DVector::zeros(size),
        })
    }

    /// Takes a row: one number for every input, and that of the column last.
    pub fn add(&mut self, row: &[f64]) {
        let (Some(y), seen) = (row.last().map(|y| y - self.mean), self.seen) else { return };
        self.seen += 1;
        if !mixed(seen).is_multiple_of(self.stride) {
            return;
        }
        self.evaluate(row);
        self.fitted += 1;
        self.products.syger(1.0, &self.at, &self.at, 1.0);
        self.with_column.axpy(y, &self.at, 1.0);
    }

    /// Fits the functions to the rows that were taken.
    pub fn fit(&mut self) {
        let ridge = RIDGE * self.fitted as f64;
        let mut products = self.products.clone();
        (0..products.nrows()).for_each(|i| products[(i, i)] += ridge);
        if let Some(factor) = Cholesky::<f64, Dyn>::new(products) {
            self.coefficients = factor.solve(&self.with_column);
        }
    }

    /// How many numbers each function has.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The functions of all inputs at a row.
    pub fn functions(&mut self, row: &[f64], functions: &mut Vec<f64>) {
        self.evaluate(row);
        functions.clear();
        functions.extend((0..self.knots.len()).map(|input| {
            let its = (input * self.degree, self.degree);
            self.at.rows(its.0, its.1).dot(&self.coefficients.rows(its.0, its.1))
        }));
    }

    /// The polynomials at a row: of every input itself, so that a line is met exactly, then of its place among the classes, so that far
    /// values weigh no more than others.
    fn evaluate(&mut self, row: &[f64]) {
        for (input, (x, knots)) in row.iter().zip(&self.knots).enumerate() {
            let (line, place) = places(knots, *x);
            let first = input * self.degree;
            self.at[first] = line;
            // Legendre's recurrence.
            let (mut before, mut legendre) = (1.0, place);
            for degree in 2..=self.degree {
                let n = degree as f64;
                (before, legendre) = (legendre, ((2.0 * n - 1.0) * place * legendre - (n - 1.0) * before) / n);
                self.at[first + degree - 1] = legendre;
            }
        }
        let last = self.at.len() - 1;
        self.at[last] = 1.0;
    }
}

/// A number within its range and among its knots, both from −1 to 1.
fn places(knots: &[f64], x: f64) -> (f64, f64) {
    let (Some(low), Some(high)) = (knots.first(), knots.last()) else { return (0.0, 0.0) };
    if low == high {
        return (0.0, 0.0);
    }
    let above = knots.partition_point(|knot| *knot < x).clamp(1, knots.len() - 1);
    let part = ((x - knots[above - 1]) / (knots[above] - knots[above - 1])).clamp(0.0, 1.0);
    let place = (above as f64 - 1.0 + part) / (knots.len() as f64 - 1.0);
    // Of halves: the range of doubles may be longer than the largest of them.
    let line = (0.5 * x - 0.5 * low) / (0.5 * high - 0.5 * low);
    (2.0 * line - 1.0, 2.0 * place - 1.0)
}

/// Bits that no order of the rows has to do with.
pub(super) fn mixed(row: u64) -> u64 {
    let mut bits = row.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ bits >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Functions of one input each are found but for what polynomials of the place among the classes leave of them.
    #[test]
    fn a_sum_of_functions_is_taken_apart() {
        let rows: Vec<[f64; 3]> = (0..900)
            .map(|i| {
                let (a, b) = (f64::from(i % 30) / 29.0, f64::from(i / 30) / 29.0);
                [a, b, 5.0 + 3.0 * a + (4.0 * b).sin()]
            })
            .collect();
        let ends = vec![(1..15).map(|i| f64::from(i) / 15.0).collect::<Vec<_>>(); 2];
        let mut additive = Additive::new(&ends, &[(0.0, 1.0); 2], 900, 6.0).expect("enough rows");
        rows.iter().for_each(|row| additive.add(row));
        additive.fit();
        let mut functions = Vec::new();
        let mut of = |row: &[f64; 3]| {
            additive.functions(row, &mut functions);
            (functions[0], functions[1])
        };
        let first = of(&rows[0]);
        for row in &rows {
            let (f, g) = of(row);
            assert!((f - first.0 - 3.0 * row[0]).abs() < 1e-5, "{row:?}: {f}");
            assert!((g - first.1 - (4.0 * row[1]).sin()).abs() < 1e-4, "{row:?}: {g}");
        }
        assert!(Additive::new(&ends, &[(0.0, 1.0); 2], 19, 0.0).is_none());
    }
}
