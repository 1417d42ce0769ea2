//! Force elements between links that are far apart, in addition to the tangent sweep: a few more right sides and a small dense
//! system (bordering, Woodbury).
//!
//! ```text
//! T x = rhs + W y,   y = A z(x)          T: the tangent without what one link feels when another moves
//! x = x₀ + X y,      (1 − A Z) y = A z₀   X, Z: responses to unit wrenches on the links, six of them each
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
use std::ops::Range;

/// Unknowns for each link that a far element acts on: a wrench.
pub(super) const PER_LINK: usize = 6;

/// The far elements of a model, and the small system that joins them to the sweep.
#[derive(Debug, Clone, Default)]
pub(super) struct Border {
    /// The links that far elements act on, one element after the other.
    links: Vec<usize>,
    /// Which of them belong to the element that acts on each.
    together: Vec<Range<usize>>,
    /// Where each element begins among them.
    first: Vec<usize>,
    /// What each link feels when another of the same element moves: for each link a row of all links.
    felt: Vec<Vec<Applied>>,
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
    /// Room for elements that act on the given links.
    pub(super) fn new(model: &Model, elements: &[Vec<usize>]) -> Self {
        let links: Vec<usize> = elements.iter().flatten().copied().collect();
        let (mut together, mut felt, mut first) = (Vec::new(), Vec::new(), Vec::new());
        for element in elements {
            let range = together.len()..together.len() + element.len();
            first.push(range.start);
            for _ in element {
                together.push(range.clone());
                felt.push(vec![Applied::default(); range.len()]);
            }
        }
        let m = PER_LINK * links.len();
        Self {
            links,
            together,
            first,
            felt,
            responses: vec![0.0; m * model.velocity_count()],
            moves: vec![0.0; m * m],
            small: Dense::new(m),
            y: vec![0.0; m],
        }
    }

    /// Whether there are no far elements.
    pub(super) fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    /// No link feels another.
    pub(super) fn clear_felt(&mut self) {
        self.felt.iter_mut().for_each(|row| row.fill(Applied::default()));
    }

    /// What one link of an element feels when another moves.
    pub(super) fn felt(&mut self, element: usize, feels: usize, moves: usize) -> &mut Applied {
        &mut self.felt[self.first[element] + feels][moves]
    }

    fn len(&self) -> usize {
        PER_LINK * self.links.len()
    }

    /// After a factorization of the sweep: responses to unit wrenches, and the small system. False if it is singular.
    pub(super) fn factorize(&mut self, model: &Model, tangent: &mut Tangent) -> bool {
        let (m, n) = (self.len(), model.velocity_count());
        for column in 0..m {
            let (place, axis) = (column / PER_LINK, column % PER_LINK);
            let response = &mut self.responses[column * n..(column + 1) * n];
            response.fill(0.0);
            tangent.solve_loaded(Some((self.links[place], unit(axis))), response);
            self.feel(tangent);
            for (link, moves) in self.links.iter().zip(self.moves[column * m..(column + 1) * m].chunks_exact_mut(6)) {
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
            let (feels, moves, axis) = (i / PER_LINK, j / PER_LINK, i % PER_LINK);
            if feels == moves || !self.together[feels].contains(&moves) {
                return 0.0;
            }
            // Shifts are the second block, turns the first.
            let block = &self.felt[feels][moves - self.together[feels].start][usize::from(j % PER_LINK < 3)];
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
        let wrenches = self.y.chunks_exact_mut(PER_LINK).zip(self.together.iter().zip(&self.felt));
        for (place, (wrench, (together, felt))) in wrenches.enumerate() {
            let mut sum = Wrench::ZERO;
            for (other, felt) in together.clone().zip(felt).filter(|(other, _)| *other != place) {
                sum += times(felt, tangent.variation(self.links[other]));
            }
            wrench[..3].copy_from_slice(sum.force.as_slice());
            wrench[3..].copy_from_slice(sum.moment.as_slice());
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
