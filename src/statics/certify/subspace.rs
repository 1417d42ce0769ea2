//! The lowest modes of a large system: Lanczos' method with the O(n) tangent, from two vectors at once (Parlett, *The
//! Symmetric Eigenvalue Problem*, 13).
//!
//! ```text
//! Y = (K + sM)⁻¹ M X_j,   orthogonal in M to all before and normalized: the next X;   T = Xᵀ M (K + sM)⁻¹ M X
//! T u = θ u:   λ = 1/θ − s,   x = X u,   and what of (K + sM)⁻¹ M x is outside the space is known from T
//! ```
//!
//! `s ≥ 0` is the smallest shift of a coarse ladder with K + sM positive definite: zero at a stable equilibrium. Every
//! vector is made orthogonal to all others, so nothing comes twice. A space that grows from two vectors may miss the third
//! of equal modes: the negative pivots of `K − μM` count the modes below μ (Sylvester), and where some are missing, another
//! vector is let in. Rows that are held border `K + sM` (see `bordered`): then all vectors, and what is counted, are of the
//! motions that they leave.

use crate::dynamics::{Coefficients, Fault, MassAction, System, TangentSolver};
use crate::round_off::KRYLOV_EIGENVALUE;
use crate::statics::problem::bordered::{Rows, hold, solved};
use crate::statics::problem::sizes::{NEUTRAL, comparable};
use crate::statics::problem::{Across, Looked};
use faer::{Mat, Side};
use std::sync::Arc;

/// Modes that are wanted beside those of zero stiffness, and of these.
const WANTED: usize = 8;
/// Shifts that are tried beside zero-stiffness motions, and the size of a space that should have shown one.
const SHIFTS: usize = 6;
const HOPELESS: usize = 64;
/// The space grows from so many vectors, to this size at most.
const STARTS: usize = 2;
const MOST_VECTORS: usize = 240;
/// A mode is found where the part of its image outside the space is below this: eigenvalues are then right to its square.
const OUTSIDE: f64 = 1e-8;
/// An image of which less is new is within the space.
const NEW: f64 = 1e-12;
/// How closely above the last wanted mode modes are counted.
const ABOVE: f64 = 1e-6;
/// A matrix that is singular is shifted by so many times as much.
const AGAIN: [f64; 3] = [1.0, 1.0 + 1e-8, 1.0 + 1e-7];
/// The eigenvalues of T are looked at again after so many vectors.
const BETWEEN: usize = 4;

/// What sweeps alone can tell.
pub(in crate::statics) struct Lowest {
    pub unstable: usize,
    pub neutral: usize,
    /// How many of the neutral motions are among the modes.
    pub neutral_modes: usize,
    /// Eigenvalues of `K x = λ M x`, ascending, and their vectors in free coordinates: those that run away, some of those
    /// of zero stiffness, the lowest of all others.
    pub modes: Vec<(f64, Vec<f64>)>,
    /// Momentum `M x` of each.
    pub momenta: Vec<Vec<f64>>,
}

/// Modes and how many of them have zero stiffness, as in [`Lowest`].
#[derive(Default)]
struct Modes {
    neutral: usize,
    modes: Vec<(f64, Vec<f64>)>,
    momenta: Vec<Vec<f64>>,
}

struct Sweeps<'s> {
    system: &'s mut System,
    solver: Box<TangentSolver>,
    /// `c₂` of a tangent that is written down in the solver.
    gathered: Option<f64>,
    q: &'s [f64],
    rest: Vec<f64>,
    shift: Vec<f64>,
    free: &'s [usize],
    full: Vec<f64>,
    product: Vec<f64>,
    mass: MassAction,
    rows: Rows,
    /// Whether rows hold something, those or the tangent's own.
    is_held: bool,
}

/// Counts and lowest modes at `q` across `rows`, with the multipliers that are in the system.
pub(in crate::statics) fn lowest(
    system: &mut System,
    q: &[f64],
    free: &[usize],
    magnitude: &[f64],
    rows: Across,
    looked: Option<Looked>,
) -> Result<Lowest, Fault> {
    let model = &Arc::clone(system.model());
    let n = model.velocity_count();
    let mut shift = vec![f64::INFINITY; n];
    free.iter().for_each(|i| shift[*i] = 0.0);
    let here = looked.as_ref().is_some_and(|looked| looked.here);
    let mut solver = looked.map_or_else(|| Box::new(TangentSolver::new(model)), |looked| looked.solver);
    let held = match &rows {
        Across::Full(rows) => rows.len(),
        Across::Sparse(held) => held.rows().len(),
    };
    if held >= free.len() {
        // Nothing moves.
        return Ok(Lowest { unstable: 0, neutral: 0, neutral_modes: 0, modes: Vec::new(), momenta: Vec::new() });
    }
    let is_held = held > 0;
    let rows = hold(&mut solver, free, rows);
    let (zero, mass) = (vec![0.0; n], MassAction::new(model));
    let (rest, full) = (zero.clone(), zero.clone());
    let gathered = here.then_some(0.0);
    system.at(0.0, q, &rest);
    let mut sweeps =
        Sweeps { system, solver, gathered, q, rest, shift, free, full, product: zero, mass, rows, is_held };
    let magnitude = &comparable(magnitude);
    let (unstable, neutral) = match sweeps.is_clearly_stable(magnitude)? {
        true => (0, 0),
        false => {
            let unstable = sweeps.negative(magnitude, NEUTRAL)?;
            (unstable, sweeps.negative(magnitude, -NEUTRAL)?.saturating_sub(unstable))
        }
    };
    let found = sweeps.iterate(magnitude, neutral)?.unwrap_or_default();
    let Modes { neutral: neutral_modes, modes, momenta } = found;
    Ok(Lowest { unstable, neutral, neutral_modes, modes, momenta })
}

impl Sweeps<'_> {
    /// Whether the stiffness is definite by more than what counts as zero: then nothing has to be counted.
    fn is_clearly_stable(&mut self, magnitude: &[f64]) -> Result<bool, Fault> {
        if !self.is_whole() {
            return Ok(false);
        }
        for (i, size) in self.free.iter().zip(magnitude) {
            self.shift[*i] = -NEUTRAL * size;
        }
        let definite = self.factorize(0.0);
        self.free.iter().for_each(|i| self.shift[*i] = 0.0);
        definite
    }

    /// Whether the pivots of the tangent alone say if all is definite: beside rows and forces that reach far they do not.
    fn is_whole(&self) -> bool {
        self.rows.is_empty() && !self.solver.is_bordered()
    }

    /// Factorizes `K + c₂ M + diag(shift)`; false if that is singular, or not definite and that is wanted.
    fn factorize_shifted(&mut self, c2: f64, definite: bool) -> Result<bool, Fault> {
        let with = Coefficients { c2, shift: &self.shift, symmetric: true, definite, ..Coefficients::default() };
        if self.gathered != Some(c2) {
            self.system.at(0.0, self.q, &self.rest).gather_tangent(&mut self.solver, &self.rest, &with)?;
            // Another tangent is not written down: what it needs is in the system, which moves on.
            self.gathered = self.solver.is_written().then_some(c2);
        }
        Ok(self.system.factorize_shifted(&mut self.solver, &self.rest, &with).is_ok())
    }

    /// Negative eigenvalues of `K + part · diag(magnitude)`.
    fn negative(&mut self, magnitude: &[f64], part: f64) -> Result<usize, Fault> {
        for times in AGAIN {
            for (i, size) in self.free.iter().zip(magnitude) {
                self.shift[*i] = times * part * size;
            }
            let negative = self.negatives_with(0.0);
            for i in self.free {
                self.shift[*i] = 0.0;
            }
            if let Some(negative) = negative? {
                return Ok(negative);
            }
        }
        Err(Fault::Undecided { part })
    }

    /// Negative directions of `K + c₂ M + diag(shift)`; `None` if that is singular.
    fn negatives_with(&mut self, c2: f64) -> Result<Option<usize>, Fault> {
        let regular = self.factorize_shifted(c2, false)? && self.border();
        let negatives = self.solver.negatives().filter(|_| regular);
        Ok(negatives.map(|negatives| negatives.saturating_sub(self.rows.negatives())))
    }

    /// The rows after a factorization of the sweep; false if they make it singular.
    fn border(&mut self) -> bool {
        let Self { solver, free, full, rows, .. } = self;
        rows.factorize(&mut |rhs| solved(solver, free, full, rhs))
    }

    /// Factorizes `K + sM`; false if it is not definite.
    fn factorize(&mut self, s: f64) -> Result<bool, Fault> {
        let definite = self.is_whole();
        let regular = self.factorize_shifted(s, definite)?;
        Ok(regular && (definite || (self.border() && self.solver.negatives() == Some(self.rows.negatives()))))
    }

    fn solve(&mut self, rhs: &[f64]) -> Vec<f64> {
        let Self { solver, free, full, rows, .. } = self;
        let mut x = solved(solver, free, full, rhs);
        rows.correct(&mut x);
        x
    }

    fn mass_times(&mut self, x: &[f64]) -> Vec<f64> {
        self.full.fill(0.0);
        for (i, value) in self.free.iter().zip(x) {
            self.full[*i] = *value;
        }
        // Whatever is evaluated here is evaluated at `q`.
        self.system.mass_times(&mut self.mass, &self.full, &mut self.product);
        self.free.iter().map(|i| self.product[*i]).collect()
    }

    /// The modes, with a shift that lets them be told from `neutral` motions; none if none does.
    fn iterate(&mut self, magnitude: &[f64], neutral: usize) -> Result<Option<Modes>, Fault> {
        let unit = 1.0 / self.system.model().time_scale().powi(2);
        // Neutral motions make K itself singular: a shift well below the wanted eigenvalues takes care of them.
        let mut s = if neutral > 0 { 1e-3 * unit } else { 0.0 };
        for _ in 0..if neutral > 0 { SHIFTS } else { 1 } {
            while !self.factorize(s)? {
                if s > 1e30 * unit {
                    return Ok(None);
                }
                s = if s == 0.0 { 1e-3 * unit } else { 4.0 * s };
            }
            let found = self.with_shift(s, magnitude, neutral)?;
            if found.is_some() {
                return Ok(found);
            }
            s *= 64.0;
        }
        Ok(None)
    }

    /// The lowest modes with one shift; `None` if round-off of the stiffness is too large for it.
    fn with_shift(&mut self, s: f64, magnitude: &[f64], neutral: usize) -> Result<Option<Modes>, Fault> {
        let mut space = Space::new(self.free.len());
        (0..STARTS).for_each(|_| self.let_in(&mut space));
        let mut next_look = 2 * WANTED;
        loop {
            let grown = self.grow(&mut space) || {
                self.let_in(&mut space);
                self.grow(&mut space)
            };
            if grown && space.columns.len() < next_look {
                continue;
            }
            let full = !grown || space.columns.len() >= MOST_VECTORS;
            next_look = space.columns.len() + BETWEEN;
            let Some((found, known)) = space.modes(WANTED + neutral) else { return Ok(None) };
            if known == 0 && neutral > 0 && (full || space.columns.len() >= HOPELESS) {
                return Ok(None);
            }
            let value = |theta: f64| 1.0 / theta - s;
            let costs_nothing = |(theta, u): &(f64, Vec<f64>)| {
                let size = |x: &[f64]| x.iter().zip(magnitude).map(|(x, n)| n * x * x).sum::<f64>();
                neutral > 0 && value(*theta).abs() <= NEUTRAL * size(&combined(&space.vectors, u))
            };
            let (mut picked, mut idle, mut others) = (Vec::new(), 0, 0);
            for mode in &found[..known] {
                if others == WANTED {
                    break;
                }
                let neutral = costs_nothing(mode);
                *if neutral { &mut idle } else { &mut others } += 1;
                if !neutral || idle <= WANTED {
                    picked.push(mode);
                }
            }
            if !full && others < WANTED {
                continue;
            }
            if let Some(last) = picked.last().map(|mode| value(mode.0)).filter(|_| !full) {
                let limit = last + ABOVE * (last.abs() + s);
                let there = self.below(limit)?;
                // Of zero-stiffness motions a few will do.
                let below = found.iter().filter(|(theta, _)| value(*theta) <= limit).count();
                if there > below + if limit > 0.0 { neutral.saturating_sub(idle) } else { 0 } {
                    if !self.factorize(s)? {
                        return Ok(None);
                    }
                    self.let_in(&mut space);
                    continue;
                }
            }
            return Ok(Some(Modes {
                neutral: idle.min(WANTED),
                modes: picked.iter().map(|(theta, u)| (value(*theta), combined(&space.vectors, u))).collect(),
                momenta: picked.iter().map(|(_, u)| combined(&space.momenta, u)).collect(),
            }));
        }
    }

    /// Modes below `limit`: the negative pivots of `K − limit M`.
    fn below(&mut self, limit: f64) -> Result<usize, Fault> {
        for times in AGAIN {
            if let Some(count) = self.negatives_with(-times * limit)? {
                return Ok(count);
            }
        }
        Err(Fault::Undecided { part: limit })
    }

    /// Another vector with a bit of everything.
    fn let_in(&mut self, space: &mut Space) {
        let mut vector = start(self.free.len(), space.starts);
        space.starts += 1;
        if self.is_held {
            let momentum = self.mass_times(&vector);
            vector = self.solve(&momentum);
        }
        self.add(space, vector);
    }

    /// The image of the next vector; false if there is none.
    fn grow(&mut self, space: &mut Space) -> bool {
        let Some(momentum) = space.momenta.get(space.columns.len()) else { return false };
        let image = self.solve(momentum);
        let column = self.add(space, image);
        space.columns.push(column);
        true
    }

    /// Makes a vector orthogonal to the space, and part of it where something is new. Returns its parts along all vectors.
    fn add(&mut self, space: &mut Space, mut vector: Vec<f64>) -> Vec<f64> {
        let mut parts = vec![0.0; space.vectors.len()];
        // Twice is enough (Kahan).
        for _ in 0..2 {
            for ((part, before), momentum) in parts.iter_mut().zip(&space.vectors).zip(&space.momenta) {
                let along = dot(momentum, &vector);
                vector.iter_mut().zip(before).for_each(|(x, y)| *x -= along * y);
                *part += along;
            }
        }
        let mut momentum = self.mass_times(&vector);
        let size = dot(&vector, &momentum).max(0.0).sqrt();
        let whole = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
        if size > NEW * whole {
            vector.iter_mut().chain(&mut momentum).for_each(|x| *x /= size);
            space.vectors.push(vector);
            space.momenta.push(momentum);
            parts.push(size);
        }
        parts
    }
}

/// Eigenvalues θ of T, descending, with their vectors, and how many of the first are found.
type Found = (Vec<(f64, Vec<f64>)>, usize);

/// The space of Lanczos' method.
struct Space {
    /// Orthonormal in M, and M times them.
    vectors: Vec<Vec<f64>>,
    momenta: Vec<Vec<f64>>,
    /// Columns of T: parts of the images of the first vectors along all.
    columns: Vec<Vec<f64>>,
    /// Vectors that were let in.
    starts: usize,
}

impl Space {
    fn new(size: usize) -> Self {
        let room = || Vec::with_capacity(MOST_VECTORS.min(size));
        Self { vectors: room(), momenta: room(), columns: room(), starts: 0 }
    }

    /// Eigenvalues and vectors of T, of which as many are looked at as asked for; none if it is not finite.
    fn modes(&self, looked_at: usize) -> Option<Found> {
        let m = self.columns.len();
        let entry = |i: usize, j: usize| self.columns[j].get(i).copied().unwrap_or(0.0);
        let eigen =
            Mat::from_fn(m, m, |i, j| 0.5 * (entry(i, j) + entry(j, i))).self_adjoint_eigen(Side::Lower).ok()?;
        let found: Vec<(f64, Vec<f64>)> =
            (0..m).rev().map(|k| (eigen.S()[k], (0..m).map(|i| eigen.U()[(i, k)]).collect())).collect();
        let is_known = |(theta, u): &(f64, Vec<f64>)| {
            let row = |i: usize| (0..m).map(|j| entry(i, j) * u[j]).sum::<f64>();
            let outside = (m..self.vectors.len()).map(|i| row(i).powi(2)).sum::<f64>().sqrt();
            outside <= OUTSIDE * theta + KRYLOV_EIGENVALUE.of(found[0].0)
        };
        let known = found.iter().take(looked_at).take_while(|mode| is_known(mode)).count();
        found.iter().all(|(theta, _)| theta.is_finite()).then_some((found, known))
    }
}

/// Low-discrepancy numbers, the same every time.
fn start(n: usize, j: usize) -> Vec<f64> {
    let golden = 0.618_033_988_749_894_9;
    (0..n).map(|i| ((i * (j + 1) + j * j) as f64 * golden + 0.5 / (j + 1) as f64).fract() - 0.5).collect()
}

/// `a · b` in eight sums side by side: a single one would wait for itself at every number.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a, b) = (a.chunks_exact(sums.len()), b.chunks_exact(sums.len()));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for i in 0..sums.len() {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// `Σ u_j x_j`
fn combined(vectors: &[Vec<f64>], u: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; vectors[0].len()];
    for (vector, part) in vectors.iter().zip(u) {
        sum.iter_mut().zip(vector).for_each(|(sum, x)| *sum += part * x);
    }
    sum
}
