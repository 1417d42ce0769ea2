//! The sparse tangent: in hinge coordinates ([`Written`]), or with the links' twists beside them ([`ByTwists`]) where that is the better
//! matrix.

use super::twists::{ByTwists, Said};
use super::written::Written;
use crate::model::Model;
use crate::motion::Motion;
use crate::sparse::SparseRows;
use crate::spatial::Wrench;
use crate::transfer::balance::Balance;
use crate::transfer::tangent::{Applied, At, Pair, Pull, TangentMatrix};
use nalgebra::Matrix3;

/// A matrix with fewer entries than this in a column is that of a shallow tree, which has nothing to gain from twists.
const SHALLOW: usize = 16;
/// Twists may take this part of the operations that hinge coordinates take: they are refined; and beside rows this multiple of them.
const DEEPER: f64 = 0.5;
const SAFER: f64 = 4.0;
/// Operations of a step of writing the matrix in hinge coordinates down.
const PER_STEP: f64 = 60.0;

/// The tangent of a model as a sparse matrix, with rows or without, and its factorization.
#[derive(Debug, Clone)]
pub(super) struct Sparse {
    pairs: Vec<Pair>,
    /// For each pair of links what the one feels when the other moves.
    felt: Vec<Applied>,
    rows: SparseRows,
    pulls: Vec<Pull>,
    held: Vec<bool>,
    /// In hinge coordinates, once that is asked for: where elements reach far it takes the product of their ways to the root.
    written: Option<Box<Written>>,
    /// That matrix without its rows, between two sets of them.
    matrix: Option<Box<TangentMatrix>>,
    /// The links' motions as unknowns, where that is the better matrix; where the tangent is that it was assembled at, and whether
    /// the other matrix has been written down there.
    twists: Option<Box<ByTwists>>,
    place: Option<Box<Place>>,
    is_written: bool,
    by_twists: bool,
    /// Whether twists have been thought of for these rows.
    is_chosen: bool,
    is_rough: bool,
}

/// A place with what a tangent there needs, while the system moves on.
#[derive(Debug, Clone)]
struct Place {
    motion: Motion,
    balance: Balance,
    hinge: Vec<f64>,
    c2: f64,
    diagonal: Vec<f64>,
    applied: Vec<(usize, Applied)>,
    wrenches: Vec<Wrench>,
    ball_springs: Vec<(usize, Matrix3<f64>)>,
}

impl Place {
    fn of(at: &At<'_>) -> Self {
        Self {
            motion: at.motion.clone(),
            balance: at.balance.clone(),
            hinge: at.hinge.to_vec(),
            c2: at.c2,
            diagonal: at.diagonal.to_vec(),
            applied: at.applied.to_vec(),
            wrenches: at.wrenches.to_vec(),
            ball_springs: at.ball_springs.to_vec(),
        }
    }

    fn at(&self) -> At<'_> {
        let Self { motion, balance, hinge, c2, diagonal, applied, wrenches, ball_springs } = self;
        At { motion, balance, hinge, c1: 0.0, c2: *c2, diagonal, applied, wrenches, coupled: &[], ball_springs }
    }
}

impl Sparse {
    /// Room for a model whose elements couple these pairs of links.
    pub(super) fn new(model: &Model, pairs: &[Pair]) -> Self {
        Self {
            pairs: pairs.to_vec(),
            felt: vec![Applied::default(); pairs.len()],
            rows: SparseRows::default(),
            pulls: Vec::new(),
            held: vec![false; model.velocity_count()],
            written: None,
            matrix: None,
            twists: None,
            place: None,
            is_written: true,
            by_twists: false,
            is_chosen: false,
            is_rough: false,
        }
    }

    /// The matrix in hinge coordinates, laid out if that has not been done.
    fn written(&mut self, model: &Model) -> &mut Written {
        let Self { written, matrix, pairs, rows, .. } = self;
        written.get_or_insert_with(|| {
            let matrix = matrix.take().unwrap_or_else(|| Box::new(TangentMatrix::new(model, pairs)));
            Box::new(Written::new(*matrix, rows))
        })
    }

    /// Takes the links' motions as unknowns if that is the better matrix: without rows the one with fewer operations, with rows, which
    /// may be nearly dependent, also one with a few times as many. Where they take less than it takes to write the other one
    /// down, which takes more steps than it has entries, that is not even laid out.
    fn choose_twists(&mut self, model: &Model) {
        self.is_chosen = true;
        let (is_known, shallow) = (self.pulls.len() == self.rows.len(), SHALLOW * self.held.len());
        let steps = TangentMatrix::most_entries(model, &self.pairs);
        if !is_known || steps + self.rows.columns.len() < shallow {
            return;
        }
        let twists = ByTwists::new(model, &self.pairs, &self.rows, &self.pulls);
        let n = self.held.len();
        if steps < n * n || twists.operations() > PER_STEP * steps as f64 {
            let most = if self.pulls.is_empty() { DEEPER } else { SAFER };
            let written = self.written(model);
            if written.entries() < shallow || twists.operations() > most * written.operations() {
                return;
            }
        }
        self.twists = Some(Box::new(twists));
    }

    /// No link feels another.
    pub(super) fn clear_felt(&mut self) {
        self.felt.fill(Applied::default());
    }

    /// What the first link of a pair feels when the second moves.
    pub(super) fn felt(&mut self, pair: usize) -> &mut Applied {
        &mut self.felt[pair]
    }

    /// Holds what these rows hold from the next factorization on.
    pub(super) fn set_rows(&mut self, rows: &SparseRows, pulls: &[Pull]) {
        let same = self.rows.starts == rows.starts && self.rows.columns == rows.columns;
        self.rows.clone_from(rows);
        self.pulls = pulls.to_vec();
        if same {
            self.twists.iter_mut().for_each(|twists| twists.set_rows(rows, pulls));
            self.written.iter_mut().for_each(|written| written.set_rows(rows));
            return;
        }
        self.matrix = self.matrix.take().or_else(|| self.written.take().map(|written| Box::new(written.into_matrix())));
        (self.written, self.twists, self.is_chosen) = (None, None, false);
    }

    /// Writes the tangent down, its symmetric part alone if that is wanted; `at.diagonal` is finite.
    pub(super) fn assemble(&mut self, model: &Model, at: &At<'_>, symmetric: bool) {
        let is_still = at.motion.still && at.c1 == 0.0 && at.hinge.iter().all(|a| *a == 0.0);
        if symmetric && is_still && !self.is_chosen {
            self.choose_twists(model);
        }
        if let Some(twists) = self.twists.as_mut().filter(|_| symmetric && is_still) {
            twists.assemble(model, at, &self.felt);
            (self.place, self.is_written) = (Some(Box::new(Place::of(at))), false);
            return;
        }
        (self.place, self.is_written) = (None, true);
        let felt = std::mem::take(&mut self.felt);
        self.written(model).assemble(model, at, &felt, symmetric);
        self.felt = felt;
    }

    /// Writes down in hinge coordinates what twists were assembled for.
    fn write_down(&mut self, model: &Model) {
        if !self.is_written
            && let Some(place) = self.place.take()
        {
            let felt = std::mem::take(&mut self.felt);
            self.written(model).assemble(model, &place.at(), &felt, true);
            (self.place, self.felt, self.is_written) = (Some(place), felt, true);
        }
    }

    /// What the links' motions say of the place with a shift; nothing where they are not looked at.
    fn factorize_twists(&mut self, shift: &[f64]) -> Said {
        let (Some(twists), Some(place)) = (&mut self.twists, &self.place) else { return Said::Nothing };
        self.held.iter_mut().zip(shift).for_each(|(held, shift)| *held = shift.is_infinite());
        twists.factorize(|j| place.diagonal[j] + shift.get(j).copied().unwrap_or(0.0))
    }

    /// Factorizes with `shift` added to the diagonal, infinite for a coordinate that is held; empty for nothing. False if
    /// that is singular, or not definite on what the rows leave and that is wanted.
    pub(super) fn factorize(&mut self, model: &Model, shift: &[f64], definite: bool) -> bool {
        self.by_twists = false;
        match self.factorize_twists(shift) {
            Said::Definite => {
                self.by_twists = true;
                return true;
            }
            // Hinges that give are softer: without a shift, which makes up for it, the other matrix has the word.
            Said::NotDefinite if definite && shift.iter().any(|by| by.is_finite() && *by != 0.0) => return false,
            Said::NotDefinite | Said::Nothing => {}
        }
        self.write_down(model);
        self.written(model).factorize(shift, definite)
    }

    /// `x ← A⁻¹ x`, with rows that of (1) of [`super::written`]; zero for coordinates that are held.
    pub(super) fn solve(&mut self, x: &mut [f64]) {
        self.solve_with_rows(x, &[]);
    }

    /// Whether twists were factorized last.
    pub(super) fn is_by_twists(&self) -> bool {
        self.by_twists
    }

    /// Whether half the digits do.
    pub(super) fn be_rough(&mut self, rough: bool) {
        self.is_rough = rough;
    }

    /// `x ← A⁻¹ x` with `s` in place of the zeros on the right; empty for zeros.
    pub(super) fn solve_with_rows(&mut self, x: &mut [f64], s: &[f64]) {
        match (&mut self.twists, &mut self.written) {
            (Some(twists), _) if self.by_twists => {
                x.iter_mut().zip(&self.held).filter(|(_, held)| **held).for_each(|(x, _)| *x = 0.0);
                twists.solve_with_rows(x, s, self.is_rough);
            }
            (_, Some(written)) => written.solve_with_rows(x, s, self.is_rough),
            // Nothing has been factorized.
            (_, None) => x.fill(f64::NAN),
        }
    }

    /// Negative eigenvalues of what was factorized last, if that is symmetric: of what the rows leave. `None` if they could not
    /// be counted.
    pub(super) fn negatives(&self) -> Option<usize> {
        if self.by_twists { Some(0) } else { self.written.as_ref()?.negatives() }
    }
}
