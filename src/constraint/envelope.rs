//! A symmetric positive definite matrix whose rows start where their first neighbour stands: `L D Lᵀ` in place.

use crate::round_off::ROW_PIVOT;

/// A pivot below this part of its row's own entry is round-off: the row is linearly dependent on those before it. So is an
/// entry below the square of this part of the row's size: the row has no entries in this position.
const DEPENDENT: f64 = ROW_PIVOT.of(1.0);

/// The lower half of a symmetric matrix, each row from its first entry to the diagonal.
#[derive(Debug, Clone, Default)]
pub(super) struct Envelope {
    /// First column of every row.
    first: Vec<usize>,
    /// Where every row begins in `entries`, and where the last one ends.
    start: Vec<usize>,
    entries: Vec<f64>,
    /// `1/D`; 0 for a dependent row, whose unknown is then zero.
    inverse: Vec<f64>,
    /// The smallest pivot, relative to the size of its row.
    smallest: f64,
}

impl Envelope {
    /// Of rows that start at these columns; without entries before [`Envelope::clear`].
    pub(super) fn new(first: Vec<usize>) -> Self {
        let mut start = vec![0];
        for (row, first) in first.iter().enumerate() {
            start.push(start[row] + row + 1 - first);
        }
        let n = first.len();
        Self { first, start, entries: Vec::new(), inverse: vec![0.0; n], smallest: 1.0 }
    }

    /// Whether a row of this size has no entries, by its own entry on the diagonal.
    pub(super) fn is_nothing(own: f64, size: f64) -> bool {
        !(own > DEPENDENT * DEPENDENT * size)
    }

    /// Sets all entries to zero.
    pub(super) fn clear(&mut self) {
        self.entries.fill(0.0);
        self.entries.resize(self.start[self.start.len() - 1], 0.0);
    }

    /// The entry of a row at or left of its diagonal.
    #[inline]
    pub(super) fn entry(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.entries[self.start[row] + column - self.first[row]]
    }

    /// The entry of a row and column in any order; zero outside.
    pub(super) fn get(&self, row: usize, column: usize) -> f64 {
        let (row, column) = (row.max(column), row.min(column));
        if column < self.first[row] { 0.0 } else { self.entries[self.start[row] + column - self.first[row]] }
    }

    /// `A = L D Lᵀ`; `sizes` are those of the rows.
    pub(super) fn factorize(&mut self, sizes: &[f64]) {
        self.smallest = 1.0;
        for row in 0..self.first.len() {
            let (first, at) = (self.first[row], self.start[row]);
            for column in first..row {
                let from = first.max(self.first[column]);
                let (mine, other) = (at + from - first, self.start[column] + from - self.first[column]);
                let length = column - from;
                let dot = dot(&self.entries[mine..mine + length], &self.entries[other..other + length]);
                self.entries[at + column - first] -= dot;
            }
            let own = self.entries[at + row - first];
            let mut pivot = own;
            for column in first..row {
                let g = self.entries[at + column - first];
                let l = g * self.inverse[column];
                pivot -= g * l;
                self.entries[at + column - first] = l;
            }
            let dependent = !(pivot > DEPENDENT * own) || Self::is_nothing(own, sizes[row]);
            self.inverse[row] = if dependent { 0.0 } else { 1.0 / pivot };
            self.smallest = self.smallest.min((pivot / sizes[row]).max(0.0));
        }
    }

    /// `x ← A⁻¹ x`.
    pub(super) fn solve(&self, x: &mut [f64]) {
        let n = self.first.len();
        for row in 0..n {
            let (first, at) = (self.first[row], self.start[row]);
            x[row] -= dot(&self.entries[at..at + row - first], &x[first..row]);
        }
        for (x, inverse) in x.iter_mut().zip(&self.inverse) {
            *x *= inverse;
        }
        for row in (0..n).rev() {
            let (first, at, value) = (self.first[row], self.start[row], x[row]);
            for (x, l) in x[first..row].iter_mut().zip(&self.entries[at..]) {
                *x -= l * value;
            }
        }
    }

    /// The pivot of one row relative to a size; 0 for a dependent row.
    pub(super) fn pivot(&self, row: usize, size: f64) -> f64 {
        if self.inverse[row] == 0.0 { 0.0 } else { 1.0 / (self.inverse[row] * size) }
    }

    /// The smallest pivot of the last factorization relative to the size of its row: how near the rows are to hanging
    /// on each other.
    pub(super) fn smallest_pivot(&self) -> f64 {
        self.smallest
    }
}

#[inline]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix with an arrow's envelope, solved against what it was made from.
    #[test]
    fn solves_what_it_factorizes() {
        let first = vec![0, 0, 2, 1, 0];
        let mut matrix = Envelope::new(first.clone());
        matrix.clear();
        let value = |i: usize, j: usize| if i == j { 4.0 + i as f64 } else { 1.0 / (1.0 + (i + 2 * j) as f64) };
        for row in 0..5 {
            for column in first[row]..=row {
                *matrix.entry(row, column) = value(row, column);
            }
        }
        let x = [1.0, -2.0, 0.5, 3.0, -1.0];
        let mut product: Vec<f64> = (0..5).map(|i| (0..5).map(|j| matrix.get(i, j) * x[j]).sum()).collect();
        matrix.factorize(&[4.0; 5]);
        matrix.solve(&mut product);
        for (found, x) in product.iter().zip(x) {
            assert!((found - x).abs() < 1e-14, "{product:?}");
        }
    }

    /// Of two equal rows the second is dropped, and a right side that fits both is met by the first.
    #[test]
    fn a_dependent_row_is_dropped() {
        let mut matrix = Envelope::new(vec![0, 0]);
        matrix.clear();
        for (row, column) in [(0, 0), (1, 0), (1, 1)] {
            *matrix.entry(row, column) = 2.0;
        }
        matrix.factorize(&[2.0; 2]);
        let mut x = [3.0, 3.0];
        matrix.solve(&mut x);
        assert_eq!(x, [1.5, 0.0]);
    }
}
