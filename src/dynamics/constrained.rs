//! A system with loops, drives and gears: multipliers with the accelerations, and states kept closed.

use super::{Evaluated, Factorized, Fault, System};
use crate::constraint::{Constraints, HeldRow, Largest, LoopReaction, Rate, RowSelection};
use crate::model::Model;
use crate::motion::variation::LinkVariation;
use crate::motion::{Motion, displace};
use crate::round_off::CLOSED;
use crate::sparse::SparseRows;
use crate::spatial::Wrench;
use crate::transfer::embedded;
use crate::transfer::reduce::Load;
use crate::transfer::tangent::Pull;
use faer::Mat;

/// Rounds of a projection: the gap of an accepted step is small, two rounds are the rule.
const MOST_ROUNDS: usize = 12;
/// A wider gap at the start means that the model has not been assembled.
const ROUGH: f64 = 1e-6;
/// A gap that may be left where rows are left out as redundant: this part of their component's reach.
const OPEN: f64 = 1e-9;

/// The rows of a model and scratch memory to push with them.
#[derive(Debug, Clone)]
pub(super) struct Constrained {
    pub(super) rows: Constraints,
    /// Of the model, beside what a run holds.
    selection: RowSelection,
    /// All rows of the selection, none left out, once reactions are shared among linearly dependent rows.
    every_row: Option<Box<Constraints>>,
    /// Widest gap of redundant rows at the start, in parts of the reach: what numbers with few digits leave open.
    left_open: f64,
    loads: Vec<Wrench>,
    tau: Vec<f64>,
    pub(super) step: Vec<f64>,
    /// What was before a round of a projection.
    before: Vec<f64>,
    /// What the last multipliers apply to named bodies, for reactions of welds.
    on_bodies: Vec<Wrench>,
}

/// What settling a state on the loops did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settled {
    /// Whether the state changed.
    pub moved: bool,
    /// Widest gap before (m; rad times the reach of the mechanism).
    pub gap_before: f64,
    /// Widest gap left.
    pub gap: f64,
    /// How far the mechanism is from a singular position, where rows are linearly dependent that are not elsewhere: the sine
    /// of the smallest angle between a row and those before it, in the metric of the inertia. 1 without rows.
    pub clearance: f64,
}

impl Settled {
    /// What there is to say of a system without loops.
    const FREE: Self = Self { moved: false, gap_before: 0.0, gap: 0.0, clearance: 1.0 };
}

impl Constrained {
    /// Room for the rows of a selection, with what they leave open at a position.
    pub(super) fn new(model: &Model, selection: &RowSelection, mut rows: Constraints, q: &[f64]) -> Box<Self> {
        let mut given = Motion::new(model);
        given.update(model, q, &model.start_velocity);
        rows.place(model, &given, q, true);
        let left_open = rows.largest(&given, Rate::Gap, true).relative;
        let n = model.velocity_count();
        Box::new(Self {
            rows,
            selection: selection.clone(),
            every_row: None,
            left_open: if left_open <= ROUGH { left_open } else { 0.0 },
            loads: vec![Wrench::ZERO; model.links.len()],
            tau: vec![0.0; n],
            step: vec![0.0; n],
            before: vec![0.0; model.position_count().max(n)],
            on_bodies: vec![Wrench::ZERO; if model.loops.is_empty() { 0 } else { model.bodies.len() }],
        })
    }

    pub(super) fn on_body(&self, body: usize) -> Wrench {
        self.on_bodies.get(body).copied().unwrap_or(Wrench::ZERO)
    }
}

impl System {
    /// The rows of loops, drives and gears, with the multipliers of the last accelerations; `None` without any.
    pub fn constraints(&self) -> Option<&Constraints> {
        self.constraints.as_ref().map(|constrained| &constrained.rows)
    }

    /// `step ← M⁻¹ Gᵀ λ` with the last multipliers.
    pub(super) fn push(&mut self) {
        let Some(constrained) = &mut self.constraints else { return };
        let Constrained { rows, loads, tau, step, .. } = &mut **constrained;
        loads.fill(Wrench::ZERO);
        tau.fill(0.0);
        rows.add_loads(loads, tau);
        let load = Load { applied: loads, tau };
        self.reduction.solve(&self.model, &self.motion, &load, step);
    }

    /// How the wrenches of one loop vary with its links at fixed multipliers.
    pub(super) fn vary_loop(&self, index: usize, by: &[LinkVariation]) -> [Wrench; 2] {
        let rows = self.constraints.as_ref().map(|constrained| &constrained.rows);
        rows.map_or([Wrench::ZERO; 2], |rows| rows.vary_loop(index, &self.motion, by))
    }

    /// Adds how what `apply_multipliers` applied varies with the links at fixed multipliers.
    pub(super) fn vary_multipliers(&self, motion_by: &[LinkVariation], applied: &mut [Wrench]) {
        if let Some(constrained) = &self.constraints {
            constrained.rows.add_variation(&self.motion, motion_by, applied);
        }
    }

    /// Number of rows that are left out as linearly dependent on others.
    pub fn left_out_rows(&self) -> usize {
        self.constraints.as_ref().map_or(0, |constrained| constrained.rows.left_out())
    }

    /// Number of self-stresses after [`Evaluated::share_multipliers`]: multipliers that balance each other.
    pub fn self_stresses(&self) -> usize {
        self.constraints.as_ref().map_or(0, |constrained| constrained.rows.self_stresses())
    }

    /// The loops, drives and gears that the `j`-th self-stress strains, by name.
    pub fn stressed(&self, j: usize) -> Vec<String> {
        self.constraints.as_ref().map_or(Vec::new(), |constrained| constrained.rows.stressed(j))
    }

    /// Adds self-stresses, one number for each (N or N m at the row left out), to the multipliers of
    /// [`Evaluated::share_multipliers`].
    pub fn add_self_stress(&mut self, alpha: &[f64]) {
        if let Some(constrained) = &mut self.constraints {
            constrained.rows.add_self_stress(alpha);
        }
    }

    /// The root of the sum of squares of all multipliers, moments divided by the lever of their mechanism (N).
    pub fn multiplier_size(&self) -> f64 {
        self.constraints.as_ref().map_or(0.0, |constrained| constrained.rows.multiplier_size())
    }

    /// Units in which the independent rows, and the velocity coordinates that stand in them, are of one size (m, or 1 for
    /// turns; 0 for a coordinate in no row).
    pub fn row_units(&self) -> (Vec<f64>, Vec<f64>) {
        let none = || (Vec::new(), vec![0.0; self.model.velocity_count()]);
        self.constraints.as_ref().map_or_else(none, |constrained| constrained.rows.units(&self.model))
    }

    /// Number of independent rows of loops, gears and drives.
    pub fn constraint_rank(&self) -> usize {
        self.constraints.as_ref().map_or(0, |constrained| constrained.rows.rank())
    }

    /// Takes multipliers, one per row of [`Evaluated::constraint_matrix`], for residuals and linearizations that follow.
    pub fn set_multipliers(&mut self, multipliers: &[f64]) {
        if let Some(constrained) = &mut self.constraints {
            constrained.rows.set_multipliers(multipliers);
        }
    }

    /// What holds a coordinate or a ball given to [`Evaluated::hold`], by its first velocity coordinate, at the last accelerations
    /// (N or N m); empty if it has no row.
    pub fn held_force(&self, velocity: usize) -> &[f64] {
        self.constraints.as_ref().map_or(&[], |tied| tied.rows.held_force(velocity))
    }

    /// Brings a state at a time (s) onto the loops, drives and gears: positions, then velocities, each the nearest in the metric of
    /// the inertia. A state that is closed to round-off comes back bit for bit.
    ///
    /// # Errors
    /// The loop that cannot be closed from here, a singular hinge, or a number that is not finite.
    pub fn settle(&mut self, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<Settled, Fault> {
        if self.constraints.is_none() {
            return Ok(Settled::FREE);
        }
        self.set_time(time);
        self.motion.update(&self.model, q, v);
        let gap_before = self.place_gap(q).absolute;
        if let Some(constrained) = &mut self.constraints {
            constrained.tau.fill(0.0);
            let Constrained { rows, tau, .. } = &mut **constrained;
            if let Err(singular) = self.reduction.prepare(&self.model, &self.motion, tau) {
                return Err(self.singular(&singular, q, v));
            }
            rows.factorize(&self.model, &self.motion, &self.reduction, 0.0);
        }
        let moved = self.settle_position(q, v);
        let moved = self.settle_velocity(q, v) || moved;
        let gap = self.place_gap(q);
        let Some(constrained) = &self.constraints else { return Ok(Settled::FREE) };
        if !(gap.relative <= OPEN + 2.0 * constrained.left_open) {
            if let Some(fault) = self.not_finite_formula() {
                return Err(fault);
            }
            let left = gap.relative;
            let widest = constrained.rows.widest(&self.motion);
            let solved = constrained.rows.largest(&self.motion, Rate::Gap, false).relative;
            // Those solved for may be closed while one left out is not.
            return Err(match solved < 0.1 * left {
                true => Fault::Independent(widest),
                false => Fault::Open(widest),
            });
        }
        let clearance = constrained.rows.clearance();
        Ok(Settled { moved, gap_before, gap: gap.absolute, clearance })
    }

    /// Places all rows where the motion is; the widest gap.
    fn place_gap(&mut self, q: &[f64]) -> Largest {
        let Some(constrained) = &mut self.constraints else { return Largest::default() };
        constrained.rows.place(&self.model, &self.motion, q, true);
        constrained.rows.largest(&self.motion, Rate::Gap, true)
    }

    /// Rounds of eq. (3) of [`crate::constraint`] with one factorization, while they help.
    fn settle_position(&mut self, q: &mut [f64], v: &[f64]) -> bool {
        let mut moved = false;
        let Some(constrained) = &self.constraints else { return false };
        // Near a singular position a small gap stands for a large distance.
        let enough = CLOSED.of(constrained.rows.clearance().powi(2));
        let mut gap = constrained.rows.largest(&self.motion, Rate::Gap, false).relative;
        for _ in 0..MOST_ROUNDS {
            if gap <= enough {
                break;
            }
            let Some(constrained) = &mut self.constraints else { break };
            constrained.rows.solve(&self.motion, Rate::Gap);
            self.push();
            let Some(constrained) = &mut self.constraints else { break };
            constrained.before[..q.len()].copy_from_slice(q);
            displace(&self.model, q, &constrained.step);
            self.motion.update(&self.model, q, v);
            constrained.rows.place(&self.model, &self.motion, q, false);
            let now = constrained.rows.largest(&self.motion, Rate::Gap, false).relative;
            if !(now < 0.5 * gap) {
                q.copy_from_slice(&constrained.before[..q.len()]);
                self.motion.update(&self.model, q, v);
                constrained.rows.place(&self.model, &self.motion, q, false);
                break;
            }
            moved = true;
            gap = now;
        }
        moved
    }

    /// Rounds of eq. (4) of [`crate::constraint`], while they help.
    fn settle_velocity(&mut self, q: &[f64], v: &mut [f64]) -> bool {
        let mut moved = false;
        let mut left = f64::INFINITY;
        for _ in 0..MOST_ROUNDS {
            let Some(constrained) = &mut self.constraints else { break };
            let now = constrained.rows.largest(&self.motion, Rate::Speed(v), false).relative;
            let size = v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let enough = CLOSED.of(size) * constrained.rows.clearance().powi(2);
            if !(now < 0.5 * left) || now <= enough {
                break;
            }
            left = now;
            constrained.rows.solve(&self.motion, Rate::Speed(v));
            self.push();
            let Some(constrained) = &self.constraints else { break };
            v.iter_mut().zip(&constrained.step).for_each(|(v, step)| *v += step);
            self.motion.update(&self.model, q, v);
            moved = true;
        }
        moved
    }
}

impl Evaluated<'_> {
    /// From the accelerations `a` of the free tree to those that the rows allow.
    pub(super) fn constrain(&mut self, a: &mut [f64]) {
        let Some(constrained) = &mut self.system.constraints else { return };
        let rows = &mut constrained.rows;
        rows.place(&self.system.model, &self.system.motion, self.q, false);
        rows.factorize(&self.system.model, &self.system.motion, &self.system.reduction, 0.0);
        rows.solve(&self.system.motion, Rate::Acceleration(self.system.reduction.links(), a));
        self.system.push();
        let Some(constrained) = &self.system.constraints else { return };
        a.iter_mut().zip(&constrained.step).for_each(|(a, step)| *a += step);
    }

    /// As [`Evaluated::constrain`], by what eliminates each multiplier where its loop closes; false if all rows together are the better
    /// way.
    pub(super) fn constrain_by_loops(&mut self, a: &mut [f64]) -> bool {
        let System { model, motion, reduction, constraints, .. } = &mut *self.system;
        let Some(constrained) = constraints else { return true };
        let rows = &mut constrained.rows;
        if !rows.is_filled() {
            return false;
        }
        rows.place(model, motion, self.q, false);
        let pulls = rows.pulls();
        if embedded::operations(model, &pulls).is_none_or(|operations| operations > rows.operations()) {
            return false;
        }
        let mut rates = vec![0.0; rows.rank()];
        rows.rates(motion, Rate::Acceleration(reduction.links(), a), &mut rates);
        rates.iter_mut().for_each(|rate| *rate = -*rate);
        let Some(multipliers) = embedded::multipliers(model, motion, &pulls, &rates) else { return false };
        rows.set_multipliers(&multipliers);
        self.system.push();
        let Some(constrained) = &self.system.constraints else { return true };
        a.iter_mut().zip(&constrained.step).for_each(|(a, step)| *a += step);
        true
    }

    /// Adds what the last multipliers push to the wrenches and hinge forces of a force balance.
    pub(super) fn apply_multipliers(&mut self) {
        let Some(constrained) = &mut self.system.constraints else { return };
        constrained.rows.place(&self.system.model, &self.system.motion, self.q, constrained.rows.is_shared());
        constrained.rows.add_loads(&mut self.system.applied, &mut self.system.tau);
        if !constrained.on_bodies.is_empty() {
            constrained.on_bodies.fill(Wrench::ZERO);
            constrained.rows.add_to_bodies(&mut constrained.on_bodies);
        }
    }

    /// `G`: one row per independent row of loops, gears and drives, one column per
    /// velocity.
    pub fn constraint_matrix(&mut self) -> Mat<f64> {
        let n = self.system.model.velocity_count();
        let Some(constrained) = &mut self.system.constraints else { return Mat::zeros(0, n) };
        constrained.rows.place(&self.system.model, &self.system.motion, self.q, false);
        let mut matrix = Mat::zeros(constrained.rows.rank(), n);
        constrained
            .rows
            .gradient(&self.system.model, &self.system.motion, |row, column, entry| matrix[(row, column)] += entry);
        matrix
    }

    /// The gradients of the independent rows as sparse rows, without the hinges that both ends of a loop stand on: these carry
    /// nothing of it.
    pub fn constraint_rows(&mut self) -> SparseRows {
        let Some(constrained) = &mut self.system.constraints else { return SparseRows::default() };
        constrained.rows.place(&self.system.model, &self.system.motion, self.q, false);
        constrained.rows.sparse_rows(&self.system.model, &self.system.motion)
    }

    /// [`Evaluated::constraint_rows`], and what each of them pulls at.
    pub fn constraint_rows_and_pulls(&mut self) -> (SparseRows, Vec<Pull>) {
        let rows = self.constraint_rows();
        (rows, self.system.constraints.as_ref().map_or_else(Vec::new, |constrained| constrained.rows.pulls()))
    }

    /// Of all multipliers that balance a state as the last ones do, takes the smallest for residuals, reactions and loops
    /// that follow: where rows are redundant there are many. Loops, drives and gears are placed there.
    ///
    /// # Errors
    /// A singular hinge.
    pub fn share_multipliers(&mut self) -> Result<(), Fault> {
        let Some(constrained) = &mut self.system.constraints else { return Ok(()) };
        constrained.tau.fill(0.0);
        let Constrained { rows, selection, every_row, tau, .. } = &mut **constrained;
        if let Err(singular) = self.system.reduction.prepare(&self.system.model, &self.system.motion, tau) {
            return Err(self.system.singular(&singular, self.q, self.v));
        }
        let all = every_row.get_or_insert_with(|| Box::new(Constraints::every_row(&self.system.model, selection)));
        rows.share(all, &self.system.model, &self.system.motion, &self.system.reduction, self.q);
        rows.place(&self.system.model, &self.system.motion, self.q, true);
        Ok(())
    }

    /// Marks the rows of [`Evaluated::constraint_matrix`] with which something else bears, after [`Evaluated::share_multipliers`].
    pub(crate) fn share_with_others(&mut self, shares: &[bool]) {
        if let Some(constrained) = &mut self.system.constraints {
            constrained.rows.share_with_others(shares);
        }
    }

    /// What the loops pass, after [`Evaluated::share_multipliers`]; empty without loops.
    pub fn loop_reactions(&self) -> Vec<LoopReaction> {
        let rows = self.system.constraints.as_ref().map(|constrained| &constrained.rows);
        rows.map_or(Vec::new(), |rows| rows.loop_reactions(&self.system.model, &self.system.motion))
    }

    /// `G` by rows, as [`Evaluated::constraint_matrix`], into memory that was made before.
    pub fn constraint_gradient(&mut self, out: &mut [f64]) {
        let n = self.system.model.velocity_count();
        out.fill(0.0);
        let Some(constrained) = &mut self.system.constraints else { return };
        constrained.rows.place(&self.system.model, &self.system.motion, self.q, false);
        constrained
            .rows
            .gradient(&self.system.model, &self.system.motion, |row, column, entry| out[row * n + column] += entry);
    }

    /// `G a + bias` of the independent rows for accelerations `a`: zero where they agree with the rows.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn constraint_rates(&mut self, a: &[f64], rates: &mut [f64]) -> Result<(), Fault> {
        self.balance(a)?;
        let System { motion, balance, constraints, .. } = &mut *self.system;
        if let Some(constrained) = constraints {
            constrained.rows.rates(motion, Rate::Acceleration(&balance.accelerations, a), rates);
        }
        Ok(())
    }

    /// Holds coordinates and balls from now on, each where and at the rate that it is told, as rows like those of loops,
    /// drives and gears; those held before are let go. Says which of them the others leave free to be held. Nothing is
    /// done without loops, drives or gears.
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`].
    pub fn hold(&mut self, held: &[HeldRow]) -> Result<Vec<bool>, Fault> {
        let mut a = std::mem::take(&mut self.system.scratch);
        let evaluated = self.accelerations(&mut a).map(|_| ());
        self.system.scratch = a;
        evaluated?;
        let System { constraints, model, motion, .. } = &mut *self.system;
        Ok(constraints.as_mut().map_or(Vec::new(), |tied| tied.rows.hold(model, motion, self.q, held)))
    }

    /// Power that drives put in (W).
    pub(super) fn drive_power(&mut self) -> f64 {
        let mut a = std::mem::take(&mut self.system.scratch);
        let evaluated = self.accelerations(&mut a).is_ok();
        self.system.scratch = a;
        match &self.system.constraints {
            Some(constrained) if evaluated => constrained.rows.power(&self.system.model, &self.system.scratch),
            _ => f64::NAN,
        }
    }

    /// The widest gap of loops, drives and gears (m; rad times the reach of the mechanism); 0 without any.
    pub fn gap(&mut self) -> f64 {
        self.system.place_gap(self.q).absolute
    }

    /// Adds to squares of force terms those of what the last multipliers push each velocity coordinate with (N², N² m²);
    /// positions as in the last call of [`Evaluated::constraint_matrix`].
    pub fn add_multiplier_squares(&self, squares: &mut [f64]) {
        if let Some(constrained) = &self.system.constraints {
            constrained.rows.add_squares(&self.system.model, &self.system.motion, squares);
        }
    }
}

impl Factorized<'_> {
    /// Adds the multipliers, one per row of [`Evaluated::constraint_matrix`], times a weight.
    pub fn add_multipliers(&self, weight: f64, sum: &mut [f64]) {
        if let Some(constrained) = &self.system.constraints {
            constrained.rows.add_multipliers(weight, sum);
        }
    }

    /// Marks the rows whose clearance is not above a limit, and takes their multipliers as zero for what follows.
    pub fn drop_weak_multipliers(&mut self, limit: f64, weak: &mut [bool]) {
        if let Some(constrained) = &mut self.system.constraints {
            constrained.rows.drop_weak(limit, weak);
        }
    }

    /// [`Factorized::answer_impulse`], and the work of drives in the impulse (J): theirs times their speed.
    pub fn answer_impulse_with_work(&mut self, impulse: &[f64], change: &mut [f64]) -> f64 {
        self.answer_impulse(impulse, change);
        let constrained = self.system.constraints.as_ref();
        constrained.map_or(0.0, |constrained| constrained.rows.power(&self.system.model, change))
    }
}
