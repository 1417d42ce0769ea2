//! Solutions with a factor `L` or `L D Lᵀ` in the order that was chosen for it, for one right side.
//!
//! A supernode is a block of columns with the same rows below them. Its columns lie one after the other, those below the block
//! are gathered once for all of them. A column by itself is a supernode of one.
//!
//! ```text
//! L y = P b:    y_s ← L_ss⁻¹ y_s,   y_below ← y_below − L_bs y_s        supernode s by supernode
//! Lᵀ x = y:     x_s ← L_ss⁻ᵀ (y_s − L_bsᵀ x_below)                      backwards;  with D in between
//! ```

use faer::sparse::linalg::cholesky::{SymbolicCholesky, SymbolicCholeskyRaw};
use std::ops::Range;

/// Memory that solutions work in.
#[derive(Debug, Clone)]
pub(crate) struct Scratch {
    /// The unknowns in the order of the factor.
    x: Vec<f64>,
    /// Unknowns below one supernode.
    below: Vec<f64>,
}

/// One block of columns of a factor.
struct Node<'f> {
    columns: Range<usize>,
    /// Rows below the block.
    rows: &'f [usize],
    /// Column after column: the block, then the rows below it.
    values: &'f [f64],
}

impl Scratch {
    pub(super) fn new(symbolic: &SymbolicCholesky<usize>) -> Self {
        let most = match symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(_) => 0,
            SymbolicCholeskyRaw::Supernodal(nodes) => {
                (0..nodes.n_supernodes()).map(|s| nodes.supernode(s).pattern().len()).max().unwrap_or(0)
            }
        };
        Self { x: vec![0.0; symbolic.nrows()], below: vec![0.0; most] }
    }
}

/// `x ← A⁻¹ x` with the factor of `A`: `L Lᵀ`, or `L D Lᵀ` with `D` on the diagonal of a unit `L`.
pub(super) fn solve(
    symbolic: &SymbolicCholesky<usize>,
    values: &[f64],
    is_llt: bool,
    scratch: &mut Scratch,
    x: &mut [f64],
) {
    let forward = symbolic.perm().map_or(&[][..], |order| order.arrays().0);
    let Scratch { x: ordered, below } = scratch;
    match forward.is_empty() {
        true => ordered.copy_from_slice(x),
        false => ordered.iter_mut().zip(forward).for_each(|(y, at)| *y = x[*at]),
    }
    match symbolic.raw() {
        SymbolicCholeskyRaw::Simplicial(columns) => {
            let (starts, rows) = (columns.col_ptr(), columns.row_idx());
            let of = |j: usize| (&rows[starts[j] + 1..starts[j + 1]], &values[starts[j]..starts[j + 1]]);
            (0..ordered.len()).for_each(|j| down_column(of(j), j, is_llt, ordered));
            (0..ordered.len()).rev().for_each(|j| up_column(of(j), j, is_llt, ordered));
        }
        SymbolicCholeskyRaw::Supernodal(nodes) => {
            let node = |s: usize| Node {
                columns: nodes.supernode_begin()[s]..nodes.supernode_end()[s],
                rows: nodes.supernode(s).pattern(),
                values: &values[nodes.col_ptr_for_val()[s]..nodes.col_ptr_for_val()[s + 1]],
            };
            (0..nodes.n_supernodes()).for_each(|s| node(s).down(is_llt, ordered, below));
            (0..nodes.n_supernodes()).rev().for_each(|s| node(s).up(is_llt, ordered, below));
        }
    }
    match forward.is_empty() {
        true => x.copy_from_slice(ordered),
        false => ordered.iter().zip(forward).for_each(|(y, at)| x[*at] = *y),
    }
}

/// One column of `L y = b`, its diagonal first among the values.
fn down_column((rows, values): (&[usize], &[f64]), j: usize, is_llt: bool, x: &mut [f64]) {
    if is_llt {
        x[j] /= values[0];
    }
    let along = x[j];
    rows.iter().zip(&values[1..]).for_each(|(row, l)| x[*row] -= l * along);
}

/// One column of `D Lᵀ x = y`.
fn up_column((rows, values): (&[usize], &[f64]), j: usize, is_llt: bool, x: &mut [f64]) {
    let sum: f64 = rows.iter().zip(&values[1..]).map(|(row, l)| l * x[*row]).sum();
    x[j] = if is_llt { (x[j] - sum) / values[0] } else { x[j] / values[0] - sum };
}

impl Node<'_> {
    /// Columns of the block and, of each, the diagonal entry, those of the block below it, and those below the block.
    fn each(&self, j: usize) -> (f64, &[f64], &[f64]) {
        let (size, height) = (self.columns.len(), self.columns.len() + self.rows.len());
        let column = &self.values[j * height..(j + 1) * height];
        (column[j], &column[j + 1..size], &column[size..])
    }

    fn down(&self, is_llt: bool, x: &mut [f64], below: &mut [f64]) {
        let below = &mut below[..self.rows.len()];
        below.fill(0.0);
        let own = &mut x[self.columns.clone()];
        for j in 0..own.len() {
            let (diagonal, within, under) = self.each(j);
            if is_llt {
                own[j] /= diagonal;
            }
            let along = own[j];
            own[j + 1..].iter_mut().zip(within).for_each(|(x, l)| *x -= l * along);
            below.iter_mut().zip(under).for_each(|(sum, l)| *sum += l * along);
        }
        self.rows.iter().zip(below).for_each(|(row, sum)| x[*row] -= *sum);
    }

    fn up(&self, is_llt: bool, x: &mut [f64], below: &mut [f64]) {
        let below = &mut below[..self.rows.len()];
        below.iter_mut().zip(self.rows).for_each(|(b, row)| *b = x[*row]);
        let own = &mut x[self.columns.clone()];
        for j in (0..own.len()).rev() {
            let (diagonal, within, under) = self.each(j);
            let sum = dot(under, below) + dot(within, &own[j + 1..]);
            own[j] = if is_llt { (own[j] - sum) / diagonal } else { own[j] / diagonal - sum };
        }
    }
}

/// `a · b` in four sums side by side: a single one would wait for itself at every number.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a, b) = (a.chunks_exact(sums.len()), b.chunks_exact(sums.len()));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        (0..4).for_each(|i| sums[i] += a[i] * b[i]);
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use crate::sparse::{Cholesky, times};

    /// A membrane of `n × m` knots, row by row: 4 on the diagonal, −1 between neighbours, and `shift` added to the diagonal.
    fn membrane(n: usize, m: usize, shift: f64) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
        let (mut starts, mut rows, mut upper) = (vec![0], Vec::new(), Vec::new());
        for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
            let before = [(i > 0).then(|| (i - 1) * m + j), (j > 0).then(|| i * m + j - 1)];
            for other in before.into_iter().flatten() {
                rows.push(other);
                upper.push(-1.0);
            }
            rows.push(i * m + j);
            upper.push(4.0 + shift);
            starts.push(rows.len());
        }
        (starts, rows, upper)
    }

    /// The matrix times the solution is the right side: of columns by themselves (a chain) and of supernodes (a membrane), of a
    /// definite matrix and of one with negative eigenvalues.
    #[test]
    fn solutions_have_their_right_sides() {
        for (n, m, shift) in [(1, 60, 0.0), (25, 25, 0.0), (1, 60, -4.1), (25, 25, -2.03)] {
            let (starts, rows, upper) = membrane(n, m, shift);
            let pattern = (&starts[..], &rows[..]);
            let rhs: Vec<f64> = (0..n * m).map(|i| ((i + 1) as f64 * 0.618_033_988_749_894_9).fract() - 0.5).collect();
            let mut cholesky = Cholesky::new(pattern);
            match shift == 0.0 {
                true => assert!(cholesky.llt(pattern, &upper)),
                false => assert!(cholesky.ldlt(pattern, &upper).is_some_and(|negatives| negatives > 0)),
            }
            let (mut x, mut product) = (rhs.clone(), vec![0.0; n * m]);
            cholesky.solve(&mut x);
            times(pattern, &upper, &x, &mut product);
            let error = product.iter().zip(&rhs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Without pivoting pivots near zero cost digits: four of sixteen where there are negative ones.
            let largest = x.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            assert!(error <= 1e-12 * largest, "{n} x {m}, shift {shift}: {error}");
        }
    }
}
