//! L Lᵀ and L D Lᵀ of a sparse symmetric matrix, with the order of approximate minimum degree.

use super::triangular::{self, Scratch};
use super::{Pattern, square};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::{Par, Side};
use std::sync::Arc;

/// Supernodes are taken from a third of the operations per entry that the library would wait for: nets have larger ones than
/// chains of loops, whose columns are faster by themselves.
const SUPERNODAL: SupernodalThreshold = SupernodalThreshold(0.3);

/// Memory that a factorization works in.
pub(crate) struct Workspace(StackReq, pub(super) MemBuffer);

impl std::fmt::Debug for Workspace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Workspace").field(&self.0).finish()
    }
}

impl Workspace {
    pub(crate) fn new(size: StackReq) -> Self {
        Self(size, MemBuffer::new(size))
    }
}

impl Clone for Workspace {
    fn clone(&self) -> Self {
        Self::new(self.0)
    }
}

/// L Lᵀ or L D Lᵀ of a symmetric matrix.
#[derive(Debug, Clone)]
pub(crate) struct Cholesky {
    symbolic: Arc<SymbolicCholesky<usize>>,
    values: Vec<f64>,
    workspace: Workspace,
    scratch: Scratch,
    is_llt: bool,
}

impl Cholesky {
    pub(crate) fn new(pattern: Pattern<'_>) -> Self {
        let parameters =
            CholeskySymbolicParams { supernodal_flop_ratio_threshold: SUPERNODAL, ..CholeskySymbolicParams::default() };
        let symbolic = factorize_symbolic_cholesky(square(pattern), Side::Upper, SymmetricOrdering::Amd, parameters)
            .expect("memory for the pattern of the tangent");
        let sizes = [
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
            symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default()),
        ];
        let values = vec![0.0; symbolic.len_val()];
        Self {
            scratch: Scratch::new(&symbolic),
            symbolic: Arc::new(symbolic),
            values,
            workspace: Workspace::new(StackReq::any_of(&sizes)),
            is_llt: false,
        }
    }

    /// Operations of a factorization, about: the square of the entries of the factor over their columns.
    pub(crate) fn operations(&self) -> f64 {
        (self.values.len() as f64).powi(2) / (self.symbolic.nrows().max(1) as f64)
    }

    /// Room for another matrix of the same pattern, whose order is not looked for again.
    pub(super) fn of_same_order(&self) -> Self {
        let (values, scratch) = (vec![0.0; self.values.len()], self.scratch.clone());
        Self { symbolic: Arc::clone(&self.symbolic), values, workspace: self.workspace.clone(), scratch, is_llt: false }
    }

    pub(crate) fn llt(&mut self, pattern: Pattern<'_>, upper: &[f64]) -> bool {
        let (matrix, none) = (SparseColMatRef::new(square(pattern), upper), Default::default());
        let stack = MemStack::new(&mut self.workspace.1);
        self.values.fill(0.0);
        self.is_llt = true;
        self.symbolic
            .factorize_numeric_llt(&mut self.values, matrix, Side::Upper, none, Par::Seq, stack, Default::default())
            .is_ok()
    }

    /// Returns the number of negative pivots; `None` if one is zero or not finite.
    pub(crate) fn ldlt(&mut self, pattern: Pattern<'_>, upper: &[f64]) -> Option<usize> {
        let (matrix, none) = (SparseColMatRef::new(square(pattern), upper), Default::default());
        let stack = MemStack::new(&mut self.workspace.1);
        self.values.fill(0.0);
        self.is_llt = false;
        self.symbolic
            .factorize_numeric_ldlt(&mut self.values, matrix, Side::Upper, none, Par::Seq, stack, Default::default())
            .ok()?;
        let mut negatives = 0;
        let mut regular = true;
        self.pivots(|pivot| {
            regular &= pivot != 0.0 && pivot.is_finite();
            negatives += usize::from(pivot < 0.0);
        });
        regular.then_some(negatives)
    }

    /// D of L D Lᵀ.
    fn pivots(&self, mut each: impl FnMut(f64)) {
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(columns) => {
                columns.col_ptr()[..self.symbolic.nrows()].iter().for_each(|first| each(self.values[*first]));
            }
            SymbolicCholeskyRaw::Supernodal(nodes) => {
                for node in 0..nodes.n_supernodes() {
                    let first = nodes.col_ptr_for_val()[node];
                    let columns = nodes.supernode_end()[node] - nodes.supernode_begin()[node];
                    let rows = (nodes.col_ptr_for_val()[node + 1] - first) / columns.max(1);
                    (0..columns).for_each(|k| each(self.values[first + k * rows + k]));
                }
            }
        }
    }

    /// `x ← A⁻¹ x` with the last factorization, which was `L Lᵀ` or `L D Lᵀ`.
    pub(crate) fn solve(&mut self, x: &mut [f64]) {
        triangular::solve(&self.symbolic, &self.values, self.is_llt, &mut self.scratch, x);
    }

    /// Memory for [`Cholesky::solve_in`].
    pub(crate) fn another_scratch(&self) -> Scratch {
        self.scratch.clone()
    }

    /// Solves in place in memory of [`Cholesky::another_scratch`].
    pub(crate) fn solve_in(&self, scratch: &mut Scratch, x: &mut [f64]) {
        triangular::solve(&self.symbolic, &self.values, self.is_llt, scratch, x);
    }
}
