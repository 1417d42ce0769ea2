//! Rows beside a sweep: `K + D` on the motions that rows `C` leave, without a matrix of the size of the scene.
//!
//! ```text
//! [ K + D   C ] [ x ]   [ f ]       (K + D) x₀ = f,   (K + D) Y = C,   S = Cᵀ Y                          (1)
//! [ Cᵀ      0 ] [ ν ] = [ 0 ]       x = x₀ − Y S⁻¹ Cᵀ x₀
//!
//! n₋(Zᵀ (K + D) Z) = n₋(K + D) − n₋(S)       Z: a basis of the motions, Cᵀ Z = 0                         (2)
//! ```
//!
//! (2) counts the negative directions of the bordered matrix twice: by the elimination of `x` (Haynsworth), and by that of
//! the rows, each of which makes one positive and one negative.
//!
//! **Braces.** Without its rows a scene may move freely, as a beam does whose root only a loop holds: `K + D` is singular, and (1) has no
//! digits. Then as many coordinates as there are rows, those that the rows hold most firmly (QR with column pivoting, Businger & Golub
//! 1965), are braced by springs, and further rows `E` take out again what these push:
//!
//! ```text
//! [ K + D + EEᵀ   C   E ] [ x ]   [ f ]
//! [ Cᵀ            0   0 ] [ ν ] = [ 0 ]       S = (C E)ᵀ Y − (0, 1),   n₋(Zᵀ (K + D) Z) = n₋(K + D + EEᵀ) + |E| − n₋(S)
//! [ Eᵀ            0   1 ] [ u ]   [ 0 ]
//! ```

use super::split::Across;
use crate::dynamics::{Coefficients, System, TangentSolver};
use crate::model::Model;
use crate::sparse::SparseRows;
use faer::{Mat, Side};

/// `K + D` is singular but for round-off if its solutions are so many times those along the rows: as many digits are lost.
const LOST: f64 = 1e4;

/// The rows, and what (1) needs of one factorization.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Rows {
    /// `C`, one list over the coordinates per row; then `E`.
    rows: Vec<Vec<f64>>,
    /// How many are those of braces.
    braces: usize,
    /// `Y`.
    responses: Vec<Vec<f64>>,
    /// `S = V diag(w) Vᵀ`.
    values: Vec<f64>,
    vectors: Mat<f64>,
}

impl Rows {
    /// `rows` are of comparable size and independent; none at all are allowed.
    pub(in crate::statics) fn new(rows: Vec<Vec<f64>>) -> Self {
        Self { rows, braces: 0, responses: Vec::new(), values: Vec::new(), vectors: Mat::new() }
    }

    pub(in crate::statics) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// How many of them are none of braces.
    fn held(&self) -> usize {
        self.rows.len() - self.braces
    }

    /// Takes these coordinates as braced, by the roots of their springs.
    fn brace(&mut self, braces: &[(usize, f64)]) {
        self.rows.truncate(self.held());
        let n = self.rows.first().map_or(0, Vec::len);
        self.rows.extend(braces.iter().map(|(at, root)| {
            let mut row = vec![0.0; n];
            row[*at] = *root;
            row
        }));
        self.braces = braces.len();
    }

    /// The coordinates that the rows hold most firmly, as many as there are rows, over units of them.
    fn most_held(&self, unit: &[f64]) -> Vec<usize> {
        let m = self.held();
        let mut columns: Vec<Vec<f64>> =
            unit.iter().enumerate().map(|(j, unit)| self.rows[..m].iter().map(|row| row[j] / unit).collect()).collect();
        let mut chosen = Vec::with_capacity(m);
        for _ in 0..m {
            let sizes = columns.iter().map(|column| dot(column, column)).enumerate();
            let (at, size) = sizes.fold((0, 0.0), |most, next| if next.1 > most.1 { next } else { most });
            if !(size > 0.0) {
                break;
            }
            let pivot = std::mem::replace(&mut columns[at], vec![0.0; m]);
            for column in &mut columns {
                let part = dot(&pivot, column) / size;
                column.iter_mut().zip(&pivot).for_each(|(x, p)| *x -= part * p);
            }
            chosen.push(at);
        }
        chosen
    }

    /// After a factorization of `K + D`; false if the motions make it singular.
    pub(in crate::statics) fn factorize(&mut self, solve: &mut dyn FnMut(&[f64]) -> Vec<f64>) -> bool {
        if self.rows.is_empty() {
            return true;
        }
        self.responses = self.rows.iter().map(|row| solve(row)).collect();
        let m = self.rows.len();
        let own = |i: usize, j: usize| if i == j && i >= self.held() { 1.0 } else { 0.0 };
        let entry = |i: usize, j: usize| dot(&self.rows[i], &self.responses[j]) - own(i, j);
        let whole = Mat::from_fn(m, m, entry);
        let small = Mat::from_fn(m, m, |i, j| 0.5 * (whole[(i, j)] + whole[(j, i)]));
        let Ok(eigen) = small.self_adjoint_eigen(Side::Lower) else { return false };
        self.values = (0..m).map(|k| eigen.S()[k]).collect();
        self.vectors = eigen.U().to_owned();
        self.values.iter().all(|w| w.is_finite() && *w != 0.0)
    }

    /// `n₋(S)`.
    pub(in crate::statics) fn negatives(&self) -> usize {
        self.values.iter().filter(|w| **w < 0.0).count()
    }

    /// From a solution of `K + D` to that of (1). Twice: the residual across the rows vanishes however large `Y` is.
    pub(in crate::statics) fn correct(&self, x: &mut [f64]) {
        let mut multipliers = vec![0.0; self.rows.len()];
        for _ in 0..2 {
            let mut along: Vec<f64> = self.rows.iter().map(|row| dot(row, x)).collect();
            along.iter_mut().zip(&multipliers).skip(self.held()).for_each(|(along, u)| *along += u);
            for (k, value) in self.values.iter().enumerate() {
                let part: f64 = along.iter().enumerate().map(|(i, a)| self.vectors[(i, k)] * a).sum::<f64>() / value;
                for (i, response) in self.responses.iter().enumerate() {
                    let by = part * self.vectors[(i, k)];
                    multipliers[i] += by;
                    x.iter_mut().zip(response).for_each(|(x, y)| *x -= by * y);
                }
            }
        }
    }
}

/// The stiffness along closed positions, by sweeps.
pub(in crate::statics) struct Bordered {
    solver: Box<TangentSolver>,
    free: Vec<usize>,
    /// Infinite for locked coordinates.
    shift: Vec<f64>,
    rest: Vec<f64>,
    full: Vec<f64>,
    rows: Rows,
    /// Springs of braces for all free coordinates, should these be needed: empty for none.
    springs: Vec<f64>,
    /// Whether they were once.
    is_braced: bool,
}

impl Bordered {
    /// Room for a model whose `free` coordinates may move.
    pub(in crate::statics) fn new(model: &Model, free: &[usize]) -> Self {
        let n = model.velocity_count();
        let mut shift = vec![f64::INFINITY; n];
        free.iter().for_each(|i| shift[*i] = 0.0);
        let solver = Box::new(TangentSolver::new(model));
        let (free, rest, full) = (free.to_vec(), vec![0.0; n], vec![0.0; n]);
        Self { solver, free, shift, rest, full, rows: Rows::new(Vec::new()), springs: Vec::new(), is_braced: false }
    }

    /// Whether the tangent is a sparse matrix, which is factorized without the system.
    pub(in crate::statics) fn is_sparse(&self) -> bool {
        self.solver.is_written()
    }

    /// Whether solutions take half their digits, where each of them costs.
    pub(in crate::statics) fn be_rough(&mut self, rough: bool) {
        self.solver.be_rough(rough);
    }

    pub(in crate::statics) fn into_solver(self) -> Box<TangentSolver> {
        self.solver
    }

    /// Lets only these coordinates move.
    pub(in crate::statics) fn hold_all_but(&mut self, moving: &[usize]) {
        self.shift.fill(f64::INFINITY);
        moving.iter().for_each(|i| self.shift[*i] = 0.0);
        self.free = moving.to_vec();
    }

    /// Gathers what the sweep needs at `q`; the multipliers are in the system. Braces have `springs`, one for each free coordinate.
    pub(in crate::statics) fn look(
        &mut self,
        system: &mut System,
        q: &[f64],
        (rows, springs): (Across, Vec<f64>),
    ) -> Result<(), crate::dynamics::Fault> {
        let with = Coefficients { symmetric: true, ..Coefficients::default() };
        system.at(0.0, q, &self.rest).gather_tangent(&mut self.solver, &self.rest, &with)?;
        self.rows = hold(&mut self.solver, &self.free, rows);
        self.springs = springs;
        if self.is_braced {
            self.brace();
        }
        Ok(())
    }

    /// Braces what the rows hold; false if there are none, or no springs.
    fn brace(&mut self) -> bool {
        if self.rows.is_empty() || self.springs.len() != self.free.len() || self.springs.iter().any(|k| !(*k > 0.0)) {
            return false;
        }
        let roots: Vec<f64> = self.springs.iter().map(|k| k.sqrt()).collect();
        let braces: Vec<_> = self.rows.most_held(&roots).into_iter().map(|at| (at, roots[at])).collect();
        self.rows.brace(&braces);
        self.is_braced = true;
        true
    }

    /// Whether solutions with the last factorization are small differences of large ones.
    fn cancels(&mut self) -> bool {
        if self.rows.is_empty() || self.springs.is_empty() {
            return false;
        }
        let some = |(i, k): (usize, &f64)| k.sqrt() * (0.5 + (i as f64 * 1.618_033_988_75).fract());
        let force: Vec<f64> = self.springs.iter().enumerate().map(some).collect();
        let Self { solver, free, full, rows, springs, .. } = self;
        let mut x = solved(solver, free, full, &force);
        let energy = |x: &[f64]| x.iter().zip(springs.iter()).map(|(x, k)| k * x * x).sum::<f64>();
        let before = energy(&x);
        rows.correct(&mut x);
        !(before <= LOST * LOST * energy(&x))
    }

    /// `K + diag(by)`; false if it is singular, or not definite along the rows and that is wanted.
    pub(in crate::statics) fn factorize(&mut self, system: &System, by: &[f64], definite: bool) -> bool {
        let regular = self.factorize_all(system, by, definite);
        if !self.rows.is_empty() && self.rows.braces == 0 && (!regular || self.cancels()) && self.brace() {
            return self.factorize_all(system, by, definite) && self.is_wanted(definite);
        }
        regular && self.is_wanted(definite)
    }

    /// Whether what was factorized is definite along the rows, if it has to be.
    fn is_wanted(&self, definite: bool) -> bool {
        let whole = self.rows.is_empty() && !self.solver.is_bordered();
        !definite || whole || self.negatives() == Some(0)
    }

    fn factorize_all(&mut self, system: &System, by: &[f64], definite: bool) -> bool {
        for (i, by) in self.free.iter().zip(by) {
            self.shift[*i] = *by;
        }
        for row in &self.rows.rows[self.rows.held()..] {
            self.free.iter().zip(row).for_each(|(i, root)| self.shift[*i] += root * root);
        }
        // Beside rows and a border the sweep alone need not be definite.
        let whole = self.rows.is_empty() && !self.solver.is_bordered();
        let with = Coefficients { shift: &self.shift, definite: definite && whole, ..Coefficients::default() };
        let factorized = system.factorize_shifted(&mut self.solver, &self.rest, &with);
        self.free.iter().for_each(|i| self.shift[*i] = 0.0);
        let Self { solver, free, full, rows, .. } = self;
        factorized.is_ok() && rows.factorize(&mut |rhs| solved(solver, free, full, rhs))
    }

    /// Negative directions along the rows of what was factorized last; `None` if they could not be counted.
    pub(in crate::statics) fn negatives(&self) -> Option<usize> {
        Some((self.solver.negatives()? + self.rows.braces).saturating_sub(self.rows.negatives()))
    }

    /// (1) with the last factorization.
    pub(in crate::statics) fn solve(&mut self, rhs: &[f64]) -> Vec<f64> {
        let Self { solver, free, full, rows, .. } = self;
        let mut x = solved(solver, free, full, rhs);
        rows.correct(&mut x);
        x
    }

    /// Where `K + diag(by)` is negative along the rows, a direction with a bit of everything to look for that from; else none.
    pub(in crate::statics) fn negative_direction(&mut self, system: &System, by: &[f64]) -> Option<Vec<f64>> {
        // Of a sparse matrix it takes less to see that it is definite than to count.
        if self.is_sparse() && self.factorize(system, by, true) {
            return None;
        }
        let some = self.factorize(system, by, false) && self.negatives()? > 0;
        some.then(|| (0..by.len()).map(|i| 0.5 + (i as f64 * 1.618_033_988_75).fract()).collect())
    }
}

/// Gives sparse rows to the tangent; the others are what borders it.
pub(in crate::statics) fn hold(solver: &mut TangentSolver, free: &[usize], rows: Across) -> Rows {
    match rows {
        Across::Full(rows) => {
            solver.set_rows(&SparseRows::default(), &[]);
            Rows::new(rows)
        }
        Across::Sparse(held) => {
            let mut rows: SparseRows = held.rows().clone();
            rows.columns.iter_mut().for_each(|column| *column = free[*column]);
            solver.set_rows(&rows, held.pulls());
            Rows::new(Vec::new())
        }
    }
}

/// `rhs` in free coordinates through the sweep.
pub(in crate::statics) fn solved(
    solver: &mut TangentSolver,
    free: &[usize],
    full: &mut [f64],
    rhs: &[f64],
) -> Vec<f64> {
    full.fill(0.0);
    for (i, value) in free.iter().zip(rhs) {
        full[*i] = *value;
    }
    solver.solve(full);
    free.iter().map(|i| full[*i]).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
