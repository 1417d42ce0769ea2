//! L U with pivoting of a sparse matrix.

use super::cholesky::Workspace;
use super::{Pattern, square};
use faer::dyn_stack::{MemStack, StackReq};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::lu::{LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::{Conj, MatMut, Par};
use std::sync::Arc;

/// L U of any matrix with a symmetric pattern.
#[derive(Debug, Clone)]
pub(crate) struct General {
    symbolic: Arc<SymbolicLu<usize>>,
    numeric: NumericLu<usize, f64>,
    /// The whole pattern by columns, and of each entry its place in the upper triangle and whether it is below it.
    starts: Vec<usize>,
    rows: Vec<usize>,
    places: Vec<(usize, bool)>,
    values: Vec<f64>,
    workspace: Workspace,
}

impl General {
    pub(crate) fn new((starts, rows): Pattern<'_>) -> Self {
        let n = starts.len() - 1;
        let mut columns: Vec<Vec<(usize, (usize, bool))>> = vec![Vec::new(); n];
        for j in 0..n {
            for at in starts[j]..starts[j + 1] {
                columns[j].push((rows[at], (at, false)));
                if rows[at] != j {
                    columns[rows[at]].push((j, (at, true)));
                }
            }
        }
        let mut whole = vec![0];
        for column in &mut columns {
            column.sort_unstable();
            whole.push(whole[whole.len() - 1] + column.len());
        }
        let (rows, places): (Vec<usize>, Vec<(usize, bool)>) = columns.into_iter().flatten().unzip();
        let symbolic = factorize_symbolic_lu(square((&whole, &rows)), LuSymbolicParams::default())
            .expect("memory for the pattern of the tangent");
        let sizes = [
            symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default()),
            symbolic.solve_in_place_scratch::<f64>(1, Par::Seq),
        ];
        let (numeric, values) = (NumericLu::new(), vec![0.0; rows.len()]);
        let (symbolic, workspace) = (Arc::new(symbolic), Workspace::new(StackReq::any_of(&sizes)));
        Self { symbolic, numeric, starts: whole, rows, places, values, workspace }
    }

    /// `[upper, lower]` by the places of the upper triangle; rows and columns that are held are those of the identity.
    pub(crate) fn factorize(&mut self, (_, rows): Pattern<'_>, [upper, lower]: [&[f64]; 2], held: &[bool]) -> bool {
        // Rows beside the coordinates are not held.
        let is_held = |i: usize| held.get(i).copied().unwrap_or(false);
        for j in 0..self.starts.len() - 1 {
            for at in self.starts[j]..self.starts[j + 1] {
                let (place, below) = self.places[at];
                self.values[at] = match below {
                    true if is_held(j) || is_held(self.rows[at]) => 0.0,
                    true => lower[place],
                    false => upper[place],
                };
                debug_assert!(below || rows[place] == self.rows[at]);
            }
        }
        let matrix = SparseColMatRef::new(square((&self.starts, &self.rows)), &self.values);
        let stack = MemStack::new(&mut self.workspace.1);
        self.symbolic.factorize_numeric_lu(&mut self.numeric, matrix, Par::Seq, stack, Default::default()).is_ok()
    }

    /// `x ← A⁻¹ x`.
    pub(crate) fn solve(&mut self, x: &mut [f64]) {
        let n = x.len();
        let (x, stack) = (MatMut::from_column_major_slice_mut(x, n, 1), MemStack::new(&mut self.workspace.1));
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_in_place_with_conj(Conj::No, x, Par::Seq, stack);
    }
}
