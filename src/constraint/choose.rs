//! Linearly independent rows, chosen by a sparse Cholesky factorization of their products with pivoting.
//!
//! ```text
//! A = Ĝ Ĝᵀ,   aᵢⱼ ← aᵢⱼ − aᵢₚ aₚⱼ / aₚₚ     for all rows i, j that are not chosen, after row p was
//! ```
//!
//! With rows of unit size a pivot is the squared sine of the angle between a row and those chosen before it. The largest comes
//! first. Of many rows that would fill the matrix: there any pivot that is large enough does, the one with the fewest entries
//! first (threshold pivoting and minimum degree, Duff, Erisman & Reid, *Direct Methods for Sparse Matrices*, 7). If the
//! smallest singular value of all rows is far above what is linearly dependent, each of these sines is, too, and nothing has to
//! be chosen.

use crate::sparse::{Gram, SparseRows, products};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A row is linearly dependent if the squared sine of its angle to the others is below this: axes that are parallel to five
/// digits are meant to be parallel.
pub(super) const DEPENDENT: f64 = 1e-10;
/// Rows are linearly independent without a choice if the estimate of their smallest singular value, which may be too large by
/// half, is above this: three times the least sine.
const CLEAR: f64 = 3e-5;
/// So many rows are many, and a pivot of them is large enough above this.
const MANY: usize = 200;
const LARGE_ENOUGH: f64 = 1e-3;
/// An entry below this changes a pivot by its square over another pivot at most, a part in 10⁶ of what is linearly dependent:
/// it is nothing.
const NOTHING: f64 = 1e-13;
/// Pivots within this part of each other are equal: round-off must not choose among rows.
const EQUAL: f64 = 1e-9;

/// Which of these rows of unit size are linearly independent; the smallest classes are chosen first, of equal rows the first.
pub(super) fn independent(rows: &SparseRows, classes: &[usize], columns: usize) -> Vec<bool> {
    let ones = vec![1.0; columns];
    if Gram::of(rows, &ones).is_some_and(|gram| gram.smallest_singular_value() > CLEAR) {
        return vec![true; rows.len()];
    }
    let mut remaining = Remaining::of(rows, &ones);
    let mut kept = vec![false; rows.len()];
    let mut candidates: BinaryHeap<_> =
        (0..rows.len()).filter(|row| remaining.is_open(*row)).map(|row| remaining.order(row, classes)).collect();
    while let Some(candidate) = candidates.pop() {
        let row = candidate.2.0;
        // What has changed since it was put there comes again.
        if remaining.is_open(row) && candidate == remaining.order(row, classes) {
            kept[row] = true;
            for (other, _) in remaining.eliminate(row) {
                if remaining.is_open(other) {
                    candidates.push(remaining.order(other, classes));
                }
            }
        }
    }
    kept
}

/// The Schur complement of the products of rows when chosen ones have been eliminated.
struct Remaining {
    pivots: Vec<f64>,
    /// The entries beside the diagonal, by rows, ascending.
    beside: Vec<Vec<(usize, f64)>>,
}

impl Remaining {
    fn of(rows: &SparseRows, weights: &[f64]) -> Self {
        let (starts, others, values) = products(rows, weights);
        let mut all = Self { pivots: vec![0.0; rows.len()], beside: vec![Vec::new(); rows.len()] };
        for row in 0..rows.len() {
            let diagonal = starts[row + 1] - 1;
            all.pivots[row] = values[diagonal];
            // Rows come in ascending order: so do the mirror images.
            for at in starts[row]..diagonal {
                all.beside[row].push((others[at], values[at]));
                all.beside[others[at]].push((row, values[at]));
            }
        }
        all
    }

    /// Whether a row may still be chosen.
    fn is_open(&self, row: usize) -> bool {
        self.pivots[row] > DEPENDENT
    }

    /// What is chosen before what: the larger.
    fn order(&self, row: usize, classes: &[usize]) -> (Reverse<usize>, (bool, i64), Reverse<usize>) {
        let is_any = self.pivots.len() > MANY && self.pivots[row] > LARGE_ENOUGH;
        let size =
            if is_any { -(self.beside[row].len() as i64) } else { (self.pivots[row].ln() / EQUAL).round() as i64 };
        (Reverse(classes[row]), (is_any, size), Reverse(row))
    }

    /// Eliminates a row; gives its entries before, beside which pivots and entries have changed.
    fn eliminate(&mut self, row: usize) -> Vec<(usize, f64)> {
        let (pivot, mine) = (std::mem::take(&mut self.pivots[row]), std::mem::take(&mut self.beside[row]));
        for (other, value) in &mine {
            if self.is_open(*other) {
                self.pivots[*other] -= value * value / pivot;
            }
            if !self.is_open(*other) {
                self.beside[*other] = Vec::new();
            }
        }
        let is_open = |pivots: &[f64], other: usize| pivots[other] > DEPENDENT;
        let Self { pivots, beside } = self;
        for (other, value) in mine.iter().filter(|(other, _)| is_open(pivots, *other)) {
            let factor = value / pivot;
            let gone = |at: usize| at == *other || !is_open(pivots, at);
            let old = std::mem::take(&mut beside[*other]);
            let mut new = Vec::with_capacity(old.len() + mine.len());
            let (mut old, mut mine) = (old.iter().peekable(), mine.iter().peekable());
            loop {
                let next = match (old.peek(), mine.peek()) {
                    (Some((a, x)), Some((b, y))) if a == b => {
                        old.next();
                        mine.next();
                        (*a, x - factor * y)
                    }
                    (Some((a, _)), Some((b, y))) if b < a => {
                        mine.next();
                        (*b, -factor * y)
                    }
                    (Some((a, x)), _) => {
                        old.next();
                        (*a, *x)
                    }
                    (None, Some((b, y))) => {
                        mine.next();
                        (*b, -factor * y)
                    }
                    (None, None) => break,
                };
                if !gone(next.0) && next.1.abs() > NOTHING {
                    new.push(next);
                }
            }
            beside[*other] = new;
        }
        mine
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    struct Random(u64);

    impl Random {
        fn below(&mut self, n: usize) -> usize {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 33) as usize % n
        }

        fn number(&mut self) -> f64 {
            self.below(2001) as f64 / 1000.0 - 1.0
        }
    }

    /// Sparse rows of unit size, some of them sums of two others.
    fn rows(random: &mut Random) -> (SparseRows, usize) {
        let columns = 4 + random.below(40);
        let mut rows: Vec<Vec<(usize, f64)>> = Vec::new();
        for _ in 0..2 + random.below(60) {
            let row = match rows.len() > 1 && random.below(3) == 0 {
                true => [random.below(rows.len()), random.below(rows.len())].map(|of| rows[of].clone()).concat(),
                false => (0..1 + random.below(4)).map(|_| (random.below(columns), random.number())).collect(),
            };
            let merged = SparseRows::of(vec![row]);
            let size = merged.values.iter().map(|x| x * x).sum::<f64>().sqrt();
            if size > 0.01 {
                rows.push(merged.row(0).map(|(column, value)| (column, value / size)).collect());
            }
        }
        (SparseRows::of(rows), columns)
    }

    fn dense(rows: &SparseRows, columns: usize, kept: &[bool]) -> DMatrix<f64> {
        let mut dense = DMatrix::<f64>::zeros(rows.len(), columns);
        let entries = (0..rows.len()).filter(|row| kept[*row]).flat_map(|i| rows.row(i).map(move |(j, x)| (i, j, x)));
        entries.for_each(|(i, j, x)| dense[(i, j)] = x);
        dense
    }

    fn values(rows: &SparseRows, columns: usize) -> impl Iterator<Item = f64> {
        dense(rows, columns, &vec![true; rows.len()]).singular_values().as_slice().to_vec().into_iter()
    }

    fn rank(rows: &SparseRows, columns: usize, kept: &[bool]) -> usize {
        dense(rows, columns, kept).rank(1e-5)
    }

    /// As many are chosen as the singular values say, and those are linearly independent; of two classes as many of the first
    /// as are independent by themselves.
    #[test]
    fn as_many_as_the_rank_are_chosen() {
        let (mut redundant, mut clear) = (0, 0);
        for seed in 0..400 {
            let mut random = Random(seed);
            let (rows, columns) = rows(&mut random);
            // Neither one nor the other.
            if values(&rows, columns).any(|value| (1e-7..1e-3).contains(&value)) {
                continue;
            }
            clear += 1;
            let classes: Vec<usize> = (0..rows.len()).map(|_| random.below(2)).collect();
            let kept = independent(&rows, &classes, columns);
            let count = kept.iter().filter(|kept| **kept).count();
            assert_eq!(count, rank(&rows, columns, &vec![true; rows.len()]), "seed {seed}");
            assert_eq!(count, rank(&rows, columns, &kept), "seed {seed}");
            let first: Vec<bool> = classes.iter().map(|class| *class == 0).collect();
            let of_first = (0..rows.len()).filter(|row| kept[*row] && first[*row]).count();
            assert_eq!(of_first, rank(&rows, columns, &first), "seed {seed}");
            redundant += usize::from(count < rows.len());
        }
        assert!(clear > 300 && redundant > 100, "{clear} {redundant}");
    }

    /// A chain of loops, each of two rows that share hinges with the loops beside it and one row that follows from them: the
    /// entries that elimination comes to grow with the number of rows.
    #[test]
    fn a_chain_of_rows_stays_sparse() {
        let entries = |loops: usize| {
            let mut random = Random(loops as u64);
            let mut all = Vec::new();
            for at in 0..loops {
                let mut unit = || {
                    let row = [random.number(), random.number(), 2.0 + random.number()];
                    let size = row.iter().map(|x| x * x).sum::<f64>().sqrt();
                    row.map(|x| x / size)
                };
                let (one, other) = (unit(), unit());
                let size = (0..3).map(|k| (one[k] - other[k]).powi(2)).sum::<f64>().sqrt();
                let third = [0, 1, 2].map(|k| (one[k] - other[k]) / size);
                all.extend([one, other, third].map(|row| (0..3).map(|k| (2 * at + k, row[k])).collect()));
            }
            let rows = SparseRows::of(all);
            let classes = vec![0; rows.len()];
            let kept = independent(&rows, &classes, 2 * loops + 1);
            assert_eq!(kept.iter().filter(|kept| **kept).count(), 2 * loops);
            assert!(kept.chunks(3).all(|one| one.iter().filter(|kept| **kept).count() == 2));
            let mut remaining = Remaining::of(&rows, &vec![1.0; 2 * loops + 1]);
            let mut come_to = 0;
            while let Some(row) =
                (0..rows.len()).filter(|row| remaining.is_open(*row)).max_by_key(|row| remaining.order(*row, &classes))
            {
                come_to += remaining.eliminate(row).len();
            }
            come_to as f64 / loops as f64
        };
        let [short, long] = [100, 1000].map(entries);
        assert!(long < 1.1 * short && long < 20.0, "{short} entries a loop, then {long}");
    }
}
