//! Sparse rows over the velocity coordinates, and the products of each two of them.

use super::Pattern;
use super::cholesky::Cholesky;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// Rows with more than this part of their entries are multiplied as dense ones: what ways up a long chain share.
const DENSE: f64 = 0.25;
/// Inverse iterations for the smallest singular value.
const ITERATIONS: usize = 12;

/// Rows of loops, drives and gears over the velocity coordinates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SparseRows {
    /// Where each row begins, and where the last one ends.
    pub starts: Vec<usize>,
    /// Velocity coordinates of the entries, of each row ascending.
    pub columns: Vec<usize>,
    /// Entries.
    pub values: Vec<f64>,
}

impl SparseRows {
    /// From the entries of each row: velocity coordinate and value. Those of the same coordinate are added.
    pub fn of(rows: Vec<Vec<(usize, f64)>>) -> Self {
        let mut sum = Self { starts: vec![0], ..Self::default() };
        for mut row in rows {
            row.sort_by_key(|(column, _)| *column);
            for (column, value) in row {
                match sum.columns[sum.starts[sum.starts.len() - 1]..].last() == Some(&column) {
                    true => *sum.values.last_mut().expect("an entry before") += value,
                    false => {
                        sum.columns.push(column);
                        sum.values.push(value);
                    }
                }
            }
            sum.starts.push(sum.columns.len());
        }
        sum
    }

    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The entries of one row: velocity coordinate and value.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> {
        let entries = self.starts[row]..self.starts[row + 1];
        self.columns[entries.clone()].iter().copied().zip(self.values[entries].iter().copied())
    }

    /// `G x`.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        (0..self.len()).map(|row| self.row(row).map(|(column, value)| value * x[column]).sum()).collect()
    }

    /// `y += s Gᵀ x`.
    pub fn add_transposed(&self, s: f64, x: &[f64], y: &mut [f64]) {
        for (row, x) in x.iter().enumerate() {
            self.row(row).for_each(|(column, value)| y[column] += s * value * x);
        }
    }

    /// The rows with other entries: `value(row, column, entry)`.
    pub fn map(&self, value: impl Fn(usize, usize, f64) -> f64) -> Self {
        let mut new = self.clone();
        for row in 0..self.len() {
            for at in self.starts[row]..self.starts[row + 1] {
                new.values[at] = value(row, self.columns[at], self.values[at]);
            }
        }
        new
    }
}

/// `A = G W Gᵀ` with weights `W` of the coordinates, factorized.
#[derive(Debug, Clone)]
pub struct Gram {
    starts: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
    cholesky: Cholesky,
}

impl Gram {
    /// Of rows and the weight of each column; `None` if the rows are linearly dependent to working precision.
    pub fn of(rows: &SparseRows, weights: &[f64]) -> Option<Self> {
        Self::damped(rows, weights, 0.0, None)
    }

    /// As [`Gram::of`], with the order of another Gram matrix if that has the same pattern.
    pub(crate) fn of_like(rows: &SparseRows, weights: &[f64], like: Option<&Self>) -> Option<Self> {
        Self::damped(rows, weights, 0.0, like)
    }

    /// The Gram matrix with `damping` times its largest diagonal entry added to the diagonal, in the order of another Gram matrix if
    /// that has the same pattern; `None` if it is singular to working precision.
    pub(crate) fn damped(rows: &SparseRows, weights: &[f64], damping: f64, like: Option<&Self>) -> Option<Self> {
        let (starts, columns, mut values) = products(rows, weights);
        let diagonal = || starts[1..].iter().map(|next| next - 1);
        let largest = diagonal().map(|at| values[at]).fold(0.0, f64::max);
        diagonal().for_each(|at| values[at] += damping * largest);
        let same = like.filter(|like| like.starts == starts && like.columns == columns);
        let mut cholesky = match same {
            Some(like) => like.cholesky.of_same_order(),
            None => Cholesky::new((&starts, &columns)),
        };
        cholesky.llt((&starts, &columns), &values).then_some(())?;
        Some(Self { starts, columns, values, cholesky })
    }

    /// `x ← A⁻¹ x`, refined once.
    pub fn solve(&self, x: &mut [f64]) {
        let (rhs, mut residual) = (x.to_vec(), vec![0.0; x.len()]);
        let mut scratch = self.cholesky.another_scratch();
        self.cholesky.solve_in(&mut scratch, x);
        super::times(self.pattern(), &self.values, x, &mut residual);
        residual.iter_mut().zip(&rhs).for_each(|(r, b)| *r = b - *r);
        self.cholesky.solve_in(&mut scratch, &mut residual);
        x.iter_mut().zip(&residual).for_each(|(x, dx)| *x += dx);
    }

    fn pattern(&self) -> Pattern<'_> {
        (&self.starts, &self.columns)
    }

    /// The smallest singular value of `G W^½`, by inverse iteration: right to a few percent, and never below the true one.
    pub fn smallest_singular_value(&self) -> f64 {
        let mut scratch = self.cholesky.another_scratch();
        let golden = 0.618_033_988_749_894_9;
        let mut x: Vec<f64> = (0..self.starts.len() - 1).map(|i| 0.5 + ((i + 1) as f64 * golden).fract()).collect();
        let mut size = 0.0;
        for _ in 0..ITERATIONS {
            let norm = x.iter().map(|x| x * x).sum::<f64>().sqrt();
            x.iter_mut().for_each(|x| *x /= norm);
            self.cholesky.solve_in(&mut scratch, &mut x);
            size = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        }
        (1.0 / size).sqrt()
    }
}

/// The upper triangle of `G W Gᵀ` with weights `W` of the columns: where each column begins, its rows, ascending, and the
/// entries. Every diagonal entry is there.
pub(crate) fn products(rows: &SparseRows, weights: &[f64]) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    if rows.values.len() as f64 > DENSE * rows.len() as f64 * weights.len() as f64 {
        return dense_products(rows, weights);
    }
    let mut of_column: Vec<Vec<(usize, f64)>> = vec![Vec::new(); weights.len()];
    for row in 0..rows.len() {
        rows.row(row).for_each(|(column, value)| of_column[column].push((row, value)));
    }
    let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    let mut sums = vec![0.0; rows.len()];
    let mut seen = vec![usize::MAX; rows.len()];
    for row in 0..rows.len() {
        let first = columns.len();
        columns.push(row);
        (seen[row], sums[row]) = (row, 0.0);
        for (column, value) in rows.row(row) {
            for (other, with) in of_column[column].iter().take_while(|(other, _)| *other <= row) {
                if seen[*other] != row {
                    (seen[*other], sums[*other]) = (row, 0.0);
                    columns.push(*other);
                }
                sums[*other] += weights[column] * value * with;
            }
        }
        columns[first..].sort_unstable();
        values.extend(columns[first..].iter().map(|other| sums[*other]));
        starts.push(columns.len());
    }
    (starts, columns, values)
}

/// [`products`] of rows that have most of their entries.
fn dense_products(rows: &SparseRows, weights: &[f64]) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    let (m, n) = (rows.len(), weights.len());
    // By columns: each row stands in one.
    let mut transposed = Mat::<f64>::zeros(n, m);
    (0..m).for_each(|row| rows.row(row).for_each(|(column, value)| transposed[(column, row)] = value));
    let weighted = Mat::from_fn(n, m, |column, row| weights[column] * transposed[(column, row)]);
    let mut whole = Mat::<f64>::zeros(m, m);
    matmul(whole.as_mut(), Accum::Replace, transposed.transpose(), weighted.as_ref(), 1.0, Par::Seq);
    let starts = (0..=m).map(|row| row * (row + 1) / 2).collect();
    let columns = (0..m).flat_map(|row| 0..=row).collect();
    let values = (0..m).flat_map(|row| (0..=row).map(move |other| (other, row)));
    (starts, columns, values.map(|at| whole[at]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows with all of their entries, and those among as many columns without any, have the same products.
    #[test]
    fn dense_rows_have_the_products_of_sparse_ones() {
        let entry =
            |row: usize, column: usize| ((3 * row + 7 * column + 1) as f64 * 0.618_033_988_749_894_9).fract() - 0.5;
        let rows: Vec<Vec<(usize, f64)>> =
            (0..9).map(|row| (0..13).map(|column| (column, entry(row, column))).collect()).collect();
        let rows = SparseRows::of(rows);
        let weights: Vec<f64> = (0..13).map(|column| 1.0 + column as f64).collect();
        // Columns that are in no row make the same rows sparse.
        let many: Vec<f64> = weights.iter().copied().chain(vec![1.0; 100]).collect();
        let (dense, sparse) = (products(&rows, &weights), products(&rows, &many));
        assert_eq!((&dense.0, &dense.1), (&sparse.0, &sparse.1));
        // Sums of 13 products below 4 in another order.
        assert!(dense.2.iter().zip(&sparse.2).all(|(a, b)| (a - b).abs() < 1e-13), "{:?} {:?}", dense.2, sparse.2);
    }
}
