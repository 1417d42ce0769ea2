//! L D Lᵀ with pivoting of a sparse symmetric matrix of any inertia: multifrontal, pivots that are too small are put off to a later front
//! (Duff & Reid 1983).

use super::Pattern;
use feral::{CscMatrix, FactorStatus, Solver};

/// L D Lᵀ of symmetric matrices of one pattern, with pivots of one row or two.
pub(crate) struct Pivoted {
    solver: Solver,
    /// The lower triangle by columns.
    matrix: CscMatrix,
    /// Of each entry of the upper triangle its place in that.
    places: Vec<usize>,
    solution: Vec<f64>,
}

impl std::fmt::Debug for Pivoted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pivoted").field("n", &self.matrix.n).finish_non_exhaustive()
    }
}

/// Another one has to factorize for itself.
impl Clone for Pivoted {
    fn clone(&self) -> Self {
        let (matrix, places, solution) = (self.matrix.clone(), self.places.clone(), self.solution.clone());
        Self { solver: solver(), matrix, places, solution }
    }
}

/// One thread: bits do not depend on how many there are.
fn solver() -> Solver {
    Solver::new().with_parallel(false)
}

impl Pivoted {
    pub(crate) fn new((starts, rows): Pattern<'_>) -> Self {
        let n = starts.len() - 1;
        let mut col_ptr = vec![0; n + 1];
        rows.iter().for_each(|row| col_ptr[row + 1] += 1);
        (0..n).for_each(|j| col_ptr[j + 1] += col_ptr[j]);
        let (mut next, mut row_idx, mut places) = (col_ptr.clone(), vec![0; rows.len()], vec![0; rows.len()]);
        for j in 0..n {
            for at in starts[j]..starts[j + 1] {
                let place = &mut next[rows[at]];
                (row_idx[*place], places[at]) = (j, *place);
                *place += 1;
            }
        }
        let values = vec![0.0; rows.len()];
        Self { solver: solver(), matrix: CscMatrix { n, col_ptr, row_idx, values }, places, solution: vec![0.0; n] }
    }

    /// Factorizes the matrix of this upper triangle. Returns the number of negative eigenvalues; `None` if it is singular to round-off.
    pub(crate) fn factorize(&mut self, upper: &[f64]) -> Option<usize> {
        self.places.iter().zip(upper).for_each(|(place, value)| self.matrix.values[*place] = *value);
        let FactorStatus::Success = self.solver.factor(&self.matrix, None) else { return None };
        self.solver.inertia().filter(|found| found.zero == 0).map(|found| found.negative)
    }

    /// `x ← A⁻¹ x`; not numbers without a factorization.
    pub(crate) fn solve(&mut self, x: &mut [f64]) {
        match self.solver.solve_into(x, &mut self.solution) {
            Ok(()) => x.copy_from_slice(&self.solution),
            Err(_) => x.fill(f64::NAN),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A saddle point whose first pivots are zero, and the same with a row that depends on another.
    #[test]
    fn inertia_and_solution_of_a_matrix_that_needs_pivots() {
        // [0 0 1 0; 0 2 0 1; 1 0 0 1; 0 1 1 -1] by columns of the upper triangle.
        let (starts, rows) = ([0, 1, 2, 4, 7], [0, 1, 0, 2, 1, 2, 3]);
        let upper = [0.0, 2.0, 1.0, 0.0, 1.0, 1.0, -1.0];
        let mut found = Pivoted::new((&starts, &rows));
        assert_eq!(found.factorize(&upper), Some(2));
        let mut x = [3.0, 8.0, 5.0, 1.0];
        found.solve(&mut x);
        // A (1, 2, 3, 4) = (3, 8, 5, 1).
        assert!(x.iter().zip([1.0, 2.0, 3.0, 4.0]).all(|(a, b)| (a - b).abs() < 1e-14), "{x:?}");
        assert_eq!(found.factorize(&[0.0, 2.0, 0.0, 0.0, 1.0, 1.0, -1.0]), None);
    }
}
