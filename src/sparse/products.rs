//! The products of each two sparse rows: which there are is found once for rows of one pattern.

use super::Pattern;
use super::rows::SparseRows;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// Rows with more than this part of their entries are multiplied as dense ones: what ways up a long chain share.
const DENSE: f64 = 0.25;

/// Where the entries of `G W Gᵀ` stand, for rows `G` of one pattern.
#[derive(Debug)]
pub(super) struct Products {
    /// The pattern of the rows: where each begins, and its columns.
    row_starts: Vec<usize>,
    row_columns: Vec<usize>,
    /// Whether they are multiplied as dense ones; else where each of their columns begins, and of its entries the row and the
    /// place among the values.
    is_dense: bool,
    column_starts: Vec<usize>,
    of_columns: Vec<(usize, usize)>,
    /// The upper triangle of the products: where each column begins, and its rows, ascending. Every diagonal entry is there.
    pub(super) starts: Vec<usize>,
    pub(super) columns: Vec<usize>,
}

impl Products {
    /// Of rows over so many columns.
    pub(super) fn of(rows: &SparseRows, columns: usize) -> Self {
        let m = rows.len();
        let mut new = Self {
            row_starts: rows.starts.clone(),
            row_columns: rows.columns.clone(),
            is_dense: rows.values.len() as f64 > DENSE * m as f64 * columns as f64,
            column_starts: vec![0; columns + 1],
            of_columns: Vec::new(),
            starts: vec![0],
            columns: Vec::new(),
        };
        if new.is_dense {
            new.starts = (0..=m).map(|row| row * (row + 1) / 2).collect();
            new.columns = (0..m).flat_map(|row| 0..=row).collect();
            return new;
        }
        new.find_columns(m);
        let mut seen = vec![usize::MAX; m];
        for row in 0..m {
            let first = new.columns.len();
            new.columns.push(row);
            seen[row] = row;
            for column in &new.row_columns[new.row_starts[row]..new.row_starts[row + 1]] {
                let own = &new.of_columns[new.column_starts[*column]..new.column_starts[column + 1]];
                for (other, _) in own.iter().take_while(|(other, _)| *other <= row) {
                    if std::mem::replace(&mut seen[*other], row) != row {
                        new.columns.push(*other);
                    }
                }
            }
            new.columns[first..].sort_unstable();
            new.starts.push(new.columns.len());
        }
        new
    }

    /// The rows of each column, ascending.
    fn find_columns(&mut self, m: usize) {
        self.row_columns.iter().for_each(|column| self.column_starts[column + 1] += 1);
        (1..self.column_starts.len()).for_each(|j| self.column_starts[j] += self.column_starts[j - 1]);
        let mut next = self.column_starts.clone();
        self.of_columns = vec![(0, 0); self.row_columns.len()];
        for row in 0..m {
            for place in self.row_starts[row]..self.row_starts[row + 1] {
                let at = &mut next[self.row_columns[place]];
                self.of_columns[*at] = (row, place);
                *at += 1;
            }
        }
    }

    /// How many rows there are.
    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether these rows have the pattern that this was made for.
    pub(super) fn are_of(&self, rows: &SparseRows) -> bool {
        self.row_starts == rows.starts && self.row_columns == rows.columns
    }

    /// Whether the products of other rows stand where these do.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        std::ptr::eq(self, other) || (self.starts == other.starts && self.columns == other.columns)
    }

    pub(super) fn pattern(&self) -> Pattern<'_> {
        (&self.starts, &self.columns)
    }

    /// The upper triangle of `G W Gᵀ` with weights `W` of the columns.
    pub(super) fn values(&self, rows: &SparseRows, weights: &[f64]) -> Vec<f64> {
        if self.is_dense {
            return dense(rows, weights);
        }
        let mut values = Vec::with_capacity(self.columns.len());
        let mut sums = vec![0.0; self.len()];
        for row in 0..self.len() {
            let pattern = &self.columns[self.starts[row]..self.starts[row + 1]];
            pattern.iter().for_each(|other| sums[*other] = 0.0);
            for (column, value) in rows.row(row) {
                let own = &self.of_columns[self.column_starts[column]..self.column_starts[column + 1]];
                let weighted = weights[column] * value;
                for (other, place) in own.iter().take_while(|(other, _)| *other <= row) {
                    sums[*other] += weighted * rows.values[*place];
                }
            }
            values.extend(pattern.iter().map(|other| sums[*other]));
        }
        values
    }
}

/// The upper triangle of `G W Gᵀ` with weights `W` of the columns: where each column begins, its rows, ascending, and the
/// entries. Every diagonal entry is there.
pub(crate) fn products(rows: &SparseRows, weights: &[f64]) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    let products = Products::of(rows, weights.len());
    let values = products.values(rows, weights);
    (products.starts, products.columns, values)
}

/// [`Products::values`] of rows that have most of their entries.
fn dense(rows: &SparseRows, weights: &[f64]) -> Vec<f64> {
    let (m, n) = (rows.len(), weights.len());
    // By columns: each row stands in one.
    let mut transposed = Mat::<f64>::zeros(n, m);
    (0..m).for_each(|row| rows.row(row).for_each(|(column, value)| transposed[(column, row)] = value));
    let weighted = Mat::from_fn(n, m, |column, row| weights[column] * transposed[(column, row)]);
    let mut whole = Mat::<f64>::zeros(m, m);
    matmul(whole.as_mut(), Accum::Replace, transposed.transpose(), weighted.as_ref(), 1.0, Par::Seq);
    (0..m).flat_map(|row| (0..=row).map(move |other| (other, row))).map(|at| whole[at]).collect()
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
