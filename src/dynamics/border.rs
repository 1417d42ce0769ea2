//! Force elements between links that are far apart, beside the tangent sweep: a few more right sides and a small dense
//! system (bordering, Woodbury).
//!
//! ```text
//! T x = rhs + W y,   y = A z(x)          T: the tangent without what one end feels when the other moves
//! x = x₀ + X y,      (1 − A Z) y = A z₀   X, Z: responses to unit wrenches at the ends, six of them each
//! ```
//!
//! With `z = Wᵀ x` and the wrenches `y` as unknowns beside `x` the matrix of the whole, `K = T − W A Wᵀ`, has by Sylvester's
//! and Haynsworth's laws as many negative eigenvalues as
//!
//! ```text
//! n₋(K) = n₋(T) + n₋([−A 1; 1 −Z]) − (number of wrenches)
//! ```

use super::dense::Dense;
use crate::model::Model;
use crate::spatial::Wrench;
use crate::transfer::tangent::{Applied, Tangent};
use faer::{Mat, Side};
use nalgebra::Vector3;

/// Unknowns of one element: a wrench at each end.
pub(super) const UNKNOWNS: usize = 12;

/// The far elements of a model, and the small system that joins them to the sweep.
#[derive(Debug, Clone, Default)]
pub(super) struct Border {
    /// Links of both ends, by element.
    pub(super) links: Vec<[usize; 2]>,
    /// What each end feels when the other moves, by element.
    pub(super) felt: Vec<[Applied; 2]>,
    /// `X`, one row of velocities for each unknown.
    responses: Vec<f64>,
    /// `Z`, by columns: shifts and turns of the ends.
    moves: Vec<f64>,
    /// `1 − A Z`.
    small: Dense,
    /// Right side and solution.
    y: Vec<f64>,
}

impl Border {
    /// Room for the elements between the given links.
    pub(super) fn new(model: &Model, links: Vec<[usize; 2]>) -> Self {
        let m = UNKNOWNS * links.len();
        Self {
            felt: vec![<[Applied; 2]>::default(); links.len()],
            links,
            responses: vec![0.0; m * model.velocity_count()],
            moves: vec![0.0; m * m],
            small: Dense::new(m),
            y: vec![0.0; m],
        }
    }

    fn len(&self) -> usize {
        UNKNOWNS * self.links.len()
    }

    /// After a factorization of the sweep: responses to unit wrenches, and the small system. False where it is singular.
    pub(super) fn factorize(&mut self, model: &Model, tangent: &mut Tangent) -> bool {
        let (m, n) = (self.len(), model.velocity_count());
        for column in 0..m {
            let (element, end, axis) = (column / UNKNOWNS, column % UNKNOWNS / 6, column % 6);
            let response = &mut self.responses[column * n..(column + 1) * n];
            response.fill(0.0);
            tangent.solve_loaded(Some((self.links[element][end], unit(axis))), response);
            self.feel(tangent);
            let ends = self.links.iter().flatten();
            for (link, moves) in ends.zip(self.moves[column * m..(column + 1) * m].chunks_exact_mut(6)) {
                let [turn, place, ..] = tangent.variation(*link);
                moves[..3].copy_from_slice(place.as_slice());
                moves[3..].copy_from_slice(turn.as_slice());
            }
            for row in 0..m {
                *self.small.entry(row, column) = f64::from(u8::from(row == column)) - self.y[row];
            }
        }
        self.small.eliminate()
    }

    /// What the elements add to the negative eigenvalues of the sweep's matrix: less where they hold.
    pub(super) fn negatives(&self) -> isize {
        let m = self.len();
        if m == 0 {
            return 0;
        }
        // Unknowns in units in which `Z` has a diagonal of one.
        let unit: Vec<f64> = (0..m).map(|i| self.moves[i * m + i].abs().sqrt()).collect();
        let largest = unit.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(*x));
        let unit = |i: usize| unit[i].max(1e-6 * largest);
        let felt = |i: usize, j: usize| {
            let (element, end, axis) = (i / UNKNOWNS, i % UNKNOWNS / 6, i % 6);
            if j / UNKNOWNS != element || j % UNKNOWNS / 6 == end {
                return 0.0;
            }
            // Shifts are the second block, turns the first.
            let block = &self.felt[element][end][usize::from(j % 6 < 3)];
            let rows = if axis < 3 { block.force } else { block.moment };
            rows[(axis % 3, j % 3)]
        };
        let entry = |i: usize, j: usize| match (i < m, j < m) {
            (true, true) => -0.5 * (felt(i, j) + felt(j, i)) * unit(i) * unit(j),
            (false, false) => {
                let (i, j) = (i - m, j - m);
                -0.5 * (self.moves[i * m + j] + self.moves[j * m + i]) / (unit(i) * unit(j))
            }
            _ => f64::from(u8::from(i.abs_diff(j) == m)),
        };
        let whole = Mat::from_fn(2 * m, 2 * m, entry);
        let values = whole.self_adjoint_eigenvalues(Side::Lower).unwrap_or_default();
        values.iter().filter(|x| **x < 0.0).count() as isize - m as isize
    }

    /// `y ← A z` of the last solution.
    fn feel(&mut self, tangent: &Tangent) {
        for (element, (links, felt)) in self.links.iter().zip(&self.felt).enumerate() {
            for end in 0..2 {
                let wrench = times(&felt[end], tangent.variation(links[1 - end]));
                let at = UNKNOWNS * element + 6 * end;
                self.y[at..at + 3].copy_from_slice(wrench.force.as_slice());
                self.y[at + 3..at + 6].copy_from_slice(wrench.moment.as_slice());
            }
        }
    }

    /// Completes a solution `x₀` of the sweep.
    pub(super) fn complete(&mut self, tangent: &Tangent, x: &mut [f64]) {
        self.feel(tangent);
        self.small.solve(&mut self.y);
        for (y, response) in self.y.iter().zip(self.responses.chunks_exact(x.len().max(1))) {
            x.iter_mut().zip(response).for_each(|(x, response)| *x += y * response);
        }
    }
}

fn unit(axis: usize) -> Wrench {
    match axis {
        0..3 => Wrench { force: Vector3::ith(axis, 1.0), ..Wrench::ZERO },
        _ => Wrench { moment: Vector3::ith(axis - 3, 1.0), ..Wrench::ZERO },
    }
}

/// What an element feels when a link moves.
fn times(felt: &Applied, parts: [Vector3<f64>; 4]) -> Wrench {
    let mut sum = Wrench::ZERO;
    for (block, part) in felt.iter().zip(parts) {
        sum += Wrench { force: block.force * part, moment: block.moment * part };
    }
    sum
}
