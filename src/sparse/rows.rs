//! Sparse rows over the velocity coordinates.

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
