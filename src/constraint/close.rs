//! Closing gaps: positions and velocities brought onto the rows by steps in the metric of the inertia.
//!
//! ```text
//! q ← q − M⁻¹ Gᵀ (A + μ D)⁻¹ g
//! ```
//!
//! is the step of Levenberg and Marquardt for `½ |g|²`: the damping μ makes it short where the gaps are wide and the rows
//! linearly dependent, and goes away as they close. All rows take part; none has to be independent.
//!
//! In that metric the lightest bodies move first. The tip of a long chain that is drawn straight would whip about by
//! itself; [`Metric::Coordinates`] puts the unit matrix in place of `M⁻¹` and bends the chain as a whole. Short ways back
//! onto the rows of long chains are taken like that: the tip would need a hundred steps. So are all ways of many loops of one
//! tree: all of them meet in `A`, but few share hinges.

use super::component::between_ends;
use super::rows::Owner;
use super::{Constraints, Largest, Rate, RowSelection};
use crate::model::Model;
use crate::model::problem::rounded;
use crate::motion::{Motion, displace};
use crate::round_off::CLOSED;
use crate::sparse::{Gram, SparseRows};
use crate::spatial::Wrench;
use crate::transfer::Reduction;
use crate::transfer::reduce::{Load, Singular};
use nalgebra::DVector;

/// A gap that counts as closed where rows with few digits are redundant.
const LEFT_OPEN: f64 = 1e-6;
const FIRST_DAMPING: f64 = 1e-3;
const LEAST_DAMPING: f64 = 1e-11;
const MOST_DAMPING: f64 = 1e6;
const MOST_STEPS: usize = 300;
/// A step that leaves less than this part of a gap is followed by another one with the same matrix (the simplified Newton method).
const SAME_MATRIX: f64 = 0.1;
/// A short way back in the metric of the inertia takes a handful of steps. With more of them a light body that cannot close the
/// gap by itself swings to and fro while a heavy one hardly moves: all coordinates are bent then.
const SHORT_WAY: usize = 30;
/// A beam that is bent by so much goes as far as a hinge that turns by 1 rad.
const BENDS: f64 = 0.05;
/// Largest turn (rad), and part of the scene's length, of one step within a loop.
const LONGEST_STEP: f64 = 0.3;

/// The widest gap that is left.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenGap {
    /// Its element: ``loop `coupler-ground` ``.
    pub element: String,
    /// Gap (m; rad times the reach of the mechanism).
    pub gap: f64,
    /// Gap of an angle (rad); `None` for distances.
    pub angle: Option<f64>,
}

impl OpenGap {
    /// The gap with its unit.
    pub fn words(&self) -> String {
        self.angle.map_or_else(|| format!("{} m", rounded(self.gap)), |angle| format!("{} rad", rounded(angle)))
    }
}

impl Constraints {
    /// Where the widest gap of the last placement of all rows is.
    pub(crate) fn widest(&self, motion: &Motion) -> OpenGap {
        let Largest { absolute: gap, row, .. } = self.largest(motion, Rate::Gap, true);
        self.open_gap(row, gap)
    }

    /// Where the gap of the last placement of all rows is that is widest beside a length (m), or 1 rad.
    pub(crate) fn widest_beside(&self, motion: &Motion, length: f64) -> OpenGap {
        let mut widest = (0.0, None, 0.0);
        for element in &self.elements {
            for row in element.rows.clone() {
                let gap = self.rate(row, element.links(), motion, Rate::Gap).abs();
                let part = if self.rules[row].turns() { gap } else { gap / length };
                // A gap that is not a number is the widest of all.
                if !(part <= widest.0) {
                    widest = (part, Some(row), gap);
                }
            }
        }
        let (_, row, gap) = widest;
        self.open_gap(row, gap)
    }

    /// The gap of a row in its own unit; `gap` as a length (m).
    fn open_gap(&self, row: Option<usize>, gap: f64) -> OpenGap {
        let element = row.and_then(|row| self.element_of(row)).map_or(String::new(), |element| element.name.clone());
        let angle = row.and_then(|row| self.rules[row].angle(self.placed[row].gap));
        OpenGap { element, gap, angle }
    }
}

/// Closes positions of a model whose locked coordinates stay where they are given.
pub(crate) struct Closer {
    all: Closing,
    /// With the rows alone that are independent at the start, where products of all of them are made: once there is a gap to close.
    independent: Option<Closing>,
}

impl Closer {
    pub(crate) fn new(model: &Model) -> Self {
        Self { all: Closing::new(model, &RowSelection::locks(model), 0.0), independent: None }
    }

    /// The rows that are independent at the start, if these alone are to be closed.
    fn independent(&mut self, model: &Model) -> Option<&mut Closing> {
        let known = model.independent_rows.as_ref().filter(|_| self.all.nearby() == Metric::Coordinates)?;
        Some(self.independent.get_or_insert_with(|| {
            let mut fewer = Closing::new(model, &RowSelection::locks(model), 0.0);
            // Rows of locks come after those of the model.
            fewer.rows.keep(|row| known.get(row).copied().unwrap_or(true));
            fewer
        }))
    }

    /// Closes `q`; false if a gap is left, or the tree is singular.
    pub(crate) fn close(&mut self, model: &Model, q: &mut [f64]) -> bool {
        let before = self.all.gap(model, q);
        if before <= CLOSED.of(1.0) {
            return true;
        }
        let given = q.to_vec();
        if let Some(independent) = self.independent(model) {
            // Beyond a singular position, or with data of few digits, the others have their say.
            match independent.close_within(model, q, Metric::Coordinates, MOST_STEPS) {
                Ok((gap, _)) if gap <= CLOSED.of(1.0) => return true,
                Ok((gap, _)) if gap < before => {}
                _ => q.copy_from_slice(&given),
            }
        }
        let metric = self.all.nearby();
        let most = if metric == Metric::Inertia { SHORT_WAY } else { MOST_STEPS };
        let mut closed = self.all.close_within(model, q, metric, most);
        if matches!(closed, Ok((_, true))) && metric == Metric::Inertia {
            q.copy_from_slice(&given);
            closed = self.all.close_within(model, q, Metric::Coordinates, MOST_STEPS);
        }
        matches!(closed, Ok((gap, _)) if gap <= LEFT_OPEN)
    }
}

/// What makes a step short.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Metric {
    /// Little kinetic energy.
    Inertia,
    /// Little change of the hinge coordinates (rad; m as part of the scene's length). Sparse where loops are local.
    Coordinates,
}

/// A model's rows, and the tree they push on.
pub(super) struct Closing {
    pub(super) rows: Constraints,
    pub(super) motion: Motion,
    pub(super) reduction: Reduction,
    loads: Vec<Wrench>,
    tau: Vec<f64>,
    step: Vec<f64>,
    rest: Vec<f64>,
    /// Of [`Closing::bend`]: its order is used again.
    gram: Option<Gram>,
    /// Of every velocity coordinate, what is as far as a turn by 1 rad of a hinge: the scene's length for a slide.
    units: Vec<f64>,
    /// Whether something between the ends of loops bends.
    bends: bool,
    /// Of every velocity coordinate, its longest step (m or rad): infinite outside of loops, for drives and gears are linear.
    longest: Vec<f64>,
}

impl Closing {
    pub(super) fn new(model: &Model, selection: &RowSelection, time: f64) -> Self {
        let n = model.velocity_count();
        let mut rows = Constraints::every_row(model, selection);
        rows.set_time(time);
        let length = model.length_scale();
        let mut units = vec![1.0; n];
        model.lengths().for_each(|velocity| units[velocity] = length);
        let mut longest = vec![f64::INFINITY; n];
        let loops = rows.elements.iter().filter(|element| matches!(element.owner, Owner::Loop(_)));
        let bends = loops.clone().flat_map(|of| between_ends(model, of)).any(|link| model.links[link].joint.is_flex());
        for link in loops.flat_map(|element| between_ends(model, element)).map(|link| &model.links[link]) {
            for i in link.velocity..link.velocity + link.joint.counts().1 {
                longest[i] = LONGEST_STEP * units[i];
            }
        }
        // Hinges close a gap before beams do: these have to be bent.
        let flexible = model.links.iter().filter(|link| link.joint.is_flex());
        for i in flexible.flat_map(|link| link.velocity..link.velocity + link.joint.counts().1) {
            units[i] *= BENDS;
        }
        Self {
            longest,
            bends,
            gram: None,
            rows,
            motion: Motion::new(model),
            reduction: Reduction::new(model),
            units,
            loads: vec![Wrench::ZERO; model.links.len()],
            tau: vec![0.0; n],
            step: vec![0.0; n],
            rest: vec![0.0; n],
        }
    }

    /// The widest gap of all rows at a position (parts of the component's reach; rad).
    pub(super) fn gap(&mut self, model: &Model, q: &[f64]) -> f64 {
        self.motion.update(model, q, &self.rest);
        self.rows.place(model, &self.motion, q, true);
        self.rows.largest(&self.motion, Rate::Gap, true).relative
    }

    /// The metric for a short way back onto the rows.
    pub(super) fn nearby(&self) -> Metric {
        match self.rows.is_wide() {
            true => Metric::Coordinates,
            false => Metric::Inertia,
        }
    }

    /// The metric in which a guess is brought onto the rows.
    pub(super) fn of_guess(&self) -> Metric {
        match self.rows.is_filled() || self.bends {
            true => Metric::Coordinates,
            false => Metric::Inertia,
        }
    }

    /// Where the widest gap of the last placement is.
    pub(super) fn widest(&self) -> OpenGap {
        self.rows.widest(&self.motion)
    }

    /// Where the gap of the last placement is that is widest beside a length (m), or 1 rad.
    pub(super) fn widest_beside(&self, length: f64) -> OpenGap {
        self.rows.widest_beside(&self.motion, length)
    }

    /// Closes the gaps from `q`, to round-off where that is possible; gives the widest gap left.
    pub(super) fn close(&mut self, model: &Model, q: &mut [f64], metric: Metric) -> Result<f64, Singular> {
        self.close_within(model, q, metric, MOST_STEPS).map(|(gap, _)| gap)
    }

    /// Closes the gaps in at most `most` steps; gives the widest gap and whether all steps were used.
    fn close_within(
        &mut self,
        model: &Model,
        q: &mut [f64],
        metric: Metric,
        most: usize,
    ) -> Result<(f64, bool), Singular> {
        let mut gap = self.gap(model, q);
        // Damping that falls with the gap converges quadratically, also where rows are redundant (Yamashita & Fukushima).
        let damped = |damping: f64, gap: f64| damping.min(gap).max(LEAST_DAMPING);
        let mut damping = damped(FIRST_DAMPING, gap);
        let mut size = self.squares();
        let mut trial = q.to_vec();
        let (mut exhausted, mut keeps) = (true, false);
        for _ in 0..most {
            if gap <= CLOSED.of(1.0) {
                exhausted = false;
                break;
            }
            self.gap(model, q);
            match metric {
                Metric::Inertia => {
                    self.reduction.prepare(model, &self.motion, &self.rest)?;
                    self.rows.factorize(model, &self.motion, &self.reduction, damping);
                    self.push(model, Rate::Gap);
                }
                Metric::Coordinates => self.bend(model, damping, keeps),
            }
            self.shorten();
            trial.copy_from_slice(q);
            displace(model, &mut trial, &self.step);
            let (wider, new_size) = (self.gap(model, &trial), self.squares());
            if new_size < size {
                // The residual is round-off once it no longer halves with almost no damping.
                let stalled = damping <= LEAST_DAMPING && new_size > 0.25 * size;
                keeps = new_size < SAME_MATRIX * SAME_MATRIX * size;
                (gap, size) = (wider, new_size);
                q.copy_from_slice(&trial);
                damping = damped(0.1 * damping, gap);
                if stalled && gap < 1e-12 {
                    exhausted = false;
                    break;
                }
            } else if std::mem::replace(&mut keeps, false) {
                // The matrix of another place does not do any more.
            } else {
                damping *= 10.0;
                if damping > MOST_DAMPING || gap < 1e-13 {
                    exhausted = false;
                    break;
                }
            }
        }
        Ok((self.gap(model, q), exhausted))
    }

    /// Closes velocities at a closed position; gives the largest rate left of the rows solved for (parts of the component's
    /// reach, or radians, per second).
    pub(super) fn close_rates(&mut self, model: &Model, q: &[f64], v: &mut [f64]) -> Result<f64, Singular> {
        self.motion.update(model, q, v);
        self.rows.place(model, &self.motion, q, true);
        self.reduction.prepare(model, &self.motion, &self.rest)?;
        let mut left = self.rows.largest(&self.motion, Rate::Speed(v), false).relative;
        // At rest there is nothing to take away.
        if left == 0.0 {
            return Ok(left);
        }
        self.rows.factorize(model, &self.motion, &self.reduction, LEAST_DAMPING);
        // Damping by 1e-11 leaves that part of a rate: two rounds bring it to round-off.
        for _ in 0..4 {
            self.push(model, Rate::Speed(v));
            let before = v.to_vec();
            v.iter_mut().zip(&self.step).for_each(|(v, step)| *v += step);
            self.motion.update(model, q, v);
            let now = self.rows.largest(&self.motion, Rate::Speed(v), false).relative;
            if now >= left {
                v.copy_from_slice(&before);
                self.motion.update(model, q, v);
                break;
            }
            left = now;
        }
        Ok(left)
    }

    /// The rates of the rows solved for at a closed position, and the largest over its component's reach (rad/s).
    pub(super) fn speeds(&mut self, model: &Model, q: &[f64], v: &[f64]) -> (DVector<f64>, f64) {
        self.motion.update(model, q, v);
        self.rows.place(model, &self.motion, q, true);
        let mut rates = DVector::zeros(self.rows.rank());
        self.rows.rates(&self.motion, Rate::Speed(v), rates.as_mut_slice());
        (rates, self.rows.largest(&self.motion, Rate::Speed(v), false).relative)
    }

    /// The entries of `G` for the rows solved for, as placed last: `put(row, velocity, entry)`.
    pub(super) fn gradient(&mut self, model: &Model, put: impl FnMut(usize, usize, f64)) {
        self.rows.gradient(model, &self.motion, put);
    }

    /// `step ← M⁻¹ Gᵀ λ` with the multipliers that take a rate away.
    fn push(&mut self, model: &Model, rate: Rate<'_>) {
        self.rows.solve(&self.motion, rate);
        self.loads.fill(Wrench::ZERO);
        self.tau.fill(0.0);
        self.rows.add_loads(&mut self.loads, &mut self.tau);
        let load = Load { applied: &self.loads, tau: &self.tau };
        self.reduction.solve(model, &self.motion, &load, &mut self.step);
    }

    /// `step ← −Bᵀ (B Bᵀ + μ)⁻¹ g`, the rows `B` taken in equal units of coordinates and gaps; `B Bᵀ` the last one if it `keeps`.
    fn bend(&mut self, model: &Model, damping: f64, keeps: bool) {
        let (weights, rows) = self.equal_rows(model);
        let mut gaps = vec![0.0; self.rows.rank()];
        self.rows.rates(&self.motion, Rate::Gap, &mut gaps);
        gaps.iter_mut().zip(&weights).for_each(|(gap, weight)| *gap *= -weight);
        self.step.fill(0.0);
        // Rows that are all nothing give no step.
        if !keeps {
            self.gram = Gram::damped(&rows, &vec![1.0; self.step.len()], damping, self.gram.as_ref());
        }
        let Some(gram) = &self.gram else { return };
        gram.solve(&mut gaps);
        rows.add_transposed(1.0, &gaps, &mut self.step);
        self.step.iter_mut().zip(&self.units).for_each(|(step, unit)| *step *= unit);
    }

    /// Takes off a step (m or rad) what opens the rows to first order at the position placed last, in the metric of the
    /// coordinates: the way back onto the rows from its end is short.
    pub(super) fn keep_closed(&mut self, model: &Model, step: &mut [f64]) {
        let (_, rows) = self.equal_rows(model);
        let mut along: Vec<f64> = step.iter().zip(&self.units).map(|(step, unit)| step / unit).collect();
        let mut opens = rows.times(&along);
        // Damped, for rows may be linearly dependent.
        let Some(gram) = Gram::damped(&rows, &vec![1.0; along.len()], LEAST_DAMPING, self.gram.as_ref()) else {
            return;
        };
        gram.solve(&mut opens);
        rows.add_transposed(-1.0, &opens, &mut along);
        step.iter_mut().zip(&along).zip(&self.units).for_each(|((step, along), unit)| *step = along * unit);
    }

    /// The rows as placed last in equal units of coordinates and gaps, and what each was multiplied by.
    fn equal_rows(&mut self, model: &Model) -> (Vec<f64>, SparseRows) {
        let weights: Vec<f64> = self.rows.plan.rows().map(|row| self.rows.relative(row, 1.0)).collect();
        let rows = self.rows.sparse_rows(model, &self.motion);
        let rows = rows.map(|row, column, entry| weights[row] * entry * self.units[column]);
        (weights, rows)
    }

    fn shorten(&mut self) {
        let times = self.step.iter().zip(&self.longest).map(|(step, longest)| step.abs() / longest).fold(0.0, f64::max);
        if times > 1.0 {
            self.step.iter_mut().for_each(|step| *step /= times);
        }
    }

    fn squares(&self) -> f64 {
        (0..self.rows.placed.len()).map(|row| self.rows.relative_gap(row).powi(2)).sum()
    }
}
