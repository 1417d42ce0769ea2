//! The one place that knows the conic solver. Nothing that it says of itself is believed: callers recompute.

use super::Cone;
#[cfg(feature = "friction")]
use clarabel::algebra::CscMatrix;
#[cfg(feature = "friction")]
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
#[cfg(feature = "friction")]
use nalgebra::{DMatrix, RowDVector};

/// `min ½ xᵀ diag(p) x + q·x` with `A x = right` in the first rows and `right − A x` in cones in the others.
#[cfg_attr(not(feature = "friction"), allow(dead_code))]
pub(super) struct Program {
    pub(super) quadratic: Vec<f64>,
    pub(super) linear: Vec<f64>,
    /// Columns of `A`: (row, entry).
    pub(super) columns: Vec<Vec<(usize, f64)>>,
    pub(super) right: Vec<f64>,
    /// Number of equations.
    pub(super) equations: usize,
    /// Cones of the other rows: `true` for a second-order cone, `false` for numbers ≥ 0.
    pub(super) cones: Vec<(bool, usize)>,
}

/// Where it ended: `x`, and the multipliers of all rows.
pub(super) struct Answer {
    pub(super) x: Vec<f64>,
    pub(super) multipliers: Vec<f64>,
}

/// Whether this build has the solver.
pub(super) const BUILT: bool = cfg!(feature = "friction");

/// Accuracy that is asked for: what is reached depends on how degenerate the program is, and is measured by callers.
#[cfg(feature = "friction")]
const ASKED: f64 = 1e-12;

/// Parts of rows of length 1 below this are those of the rows before them.
#[cfg(feature = "friction")]
const DEPENDENT: f64 = 1e-12;
/// Products that finding dependent equations may take: a fraction of a second.
#[cfg(feature = "friction")]
const MOST_PRODUCTS: f64 = 1e8;

impl Program {
    /// Nothing in a build without the solver.
    #[cfg(not(feature = "friction"))]
    pub(super) fn solve(&self) -> Option<Answer> {
        None
    }

    /// An interior point's answer; `None` if it is not finite or the program has no shape that the solver takes.
    #[cfg(feature = "friction")]
    pub(super) fn solve(&self) -> Option<Answer> {
        match self.independent() {
            Some(kept) => self.of_equations(&kept),
            None => self.solved(),
        }
    }

    #[cfg(feature = "friction")]
    fn solved(&self) -> Option<Answer> {
        let n = self.linear.len();
        let quadratic = diagonal(&self.quadratic);
        let matrix = by_columns(&self.columns, self.right.len());
        let mut cones = vec![SupportedConeT::ZeroConeT(self.equations)];
        cones.extend(self.cones.iter().map(|(second_order, size)| match second_order {
            true => SupportedConeT::SecondOrderConeT(*size),
            false => SupportedConeT::NonnegativeConeT(*size),
        }));
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            tol_gap_abs: ASKED,
            tol_gap_rel: ASKED,
            tol_feas: ASKED,
            ..DefaultSettings::default()
        };
        let mut solver = DefaultSolver::new(&quadratic, &self.linear, &matrix, &self.right, &cones, settings).ok()?;
        solver.solve();
        let (x, multipliers) = (solver.solution.x.clone(), solver.solution.z.clone());
        let finite = x.len() == n && x.iter().chain(&multipliers).all(|number| number.is_finite());
        finite.then_some(Answer { x, multipliers })
    }

    /// Equations that the others follow from, where there are more of them than unknowns: between those an interior point takes rounding for a
    /// contradiction.
    #[cfg(feature = "friction")]
    fn independent(&self) -> Option<Vec<usize>> {
        let (rows, n) = (self.equations, self.columns.len());
        if rows <= n || n == 0 || (rows * n * n) as f64 > MOST_PRODUCTS {
            return None;
        }
        let mut transposed = DMatrix::<f64>::zeros(n, rows);
        for (j, column) in self.columns.iter().enumerate() {
            column.iter().filter(|(row, _)| *row < rows).for_each(|(row, entry)| transposed[(j, *row)] += entry);
        }
        transposed.column_iter_mut().for_each(|mut row| {
            row.try_normalize_mut(0.0);
        });
        let mut order = RowDVector::from_fn(rows, |_, row| row);
        let factors = transposed.col_piv_qr();
        factors.p().permute_columns(&mut order);
        let r = factors.r();
        let rank = (0..n).take_while(|i| r[(*i, *i)].abs() > DEPENDENT).count();
        let mut kept: Vec<usize> = order.iter().take(rank).copied().collect();
        kept.sort_unstable();
        Some(kept)
    }

    /// The answer to the program with these of its equations; the multipliers of the others are zero.
    #[cfg(feature = "friction")]
    fn of_equations(&self, kept: &[usize]) -> Option<Answer> {
        let mut place = vec![None; self.right.len()];
        let behind = self.equations..self.right.len();
        let rows: Vec<usize> = kept.iter().copied().chain(behind).collect();
        rows.iter().enumerate().for_each(|(new, old)| place[*old] = Some(new));
        let of = |column: &Vec<(usize, f64)>| {
            column.iter().filter_map(|(row, entry)| place[*row].map(|row| (row, *entry))).collect::<Vec<_>>()
        };
        let program = Self {
            quadratic: self.quadratic.clone(),
            linear: self.linear.clone(),
            columns: self.columns.iter().map(of).collect(),
            right: rows.iter().map(|row| self.right[*row]).collect(),
            equations: kept.len(),
            cones: self.cones.clone(),
        };
        let Answer { x, multipliers: few } = program.solved()?;
        let mut multipliers = vec![0.0; self.right.len()];
        rows.iter().zip(few).for_each(|(row, multiplier)| multipliers[*row] = multiplier);
        Some(Answer { x, multipliers })
    }
}

#[cfg(feature = "friction")]
fn diagonal(entries: &[f64]) -> CscMatrix<f64> {
    let columns: Vec<Vec<(usize, f64)>> = entries
        .iter()
        .enumerate()
        .map(|(i, entry)| if *entry == 0.0 { Vec::new() } else { vec![(i, *entry)] })
        .collect();
    by_columns(&columns, entries.len())
}

/// Compressed columns; entries of a column in ascending rows.
#[cfg(feature = "friction")]
fn by_columns(columns: &[Vec<(usize, f64)>], rows: usize) -> CscMatrix<f64> {
    let (mut starts, mut indices, mut entries) = (vec![0], Vec::new(), Vec::new());
    for column in columns {
        let mut column = column.clone();
        column.sort_by_key(|(row, _)| *row);
        indices.extend(column.iter().map(|(row, _)| *row));
        entries.extend(column.iter().map(|(_, entry)| *entry));
        starts.push(indices.len());
    }
    CscMatrix::new(rows, columns.len(), starts, indices, entries)
}

impl Cone {
    /// Rows that it has in a program: how many, and whether they are a second-order cone.
    pub(super) fn rows(&self) -> Option<(bool, usize)> {
        match self {
            Self::Free => None,
            Self::Ball { bound, .. } if bound.is_infinite() => None,
            Self::Ray => Some((false, 1)),
            Self::Coulomb { friction } if friction.is_infinite() => Some((false, 1)),
            Self::Coulomb { .. } => Some((true, 3)),
            Self::Ball { size, .. } => Some((true, size + 1)),
        }
    }
}
