//! Lagrange's equations of the first kind: the baseline in maximal coordinates.
//!
//! Every link has a pose (six unknowns) and every hinge its constraints `g` with multipliers `λ`; no tree sweep is
//! used. Newton's method on
//!
//! ```text
//! r(x, λ) = [F(x) + Gᵀλ; g(x)] = 0,     [∂(F + Gᵀλ)/∂x − σM   Gᵀ] [δx]   [−F − Gᵀλ]
//!                                       [G                    0 ] [δλ] = [−g      ]
//! ```
//!
//! with the exact tangent: weight, force elements, hinge springs and the geometric stiffness of the constraints. The
//! matrix is equilibrated and factorized by a sparse LU whose ordering is found once.
//!
//! Loops, drives and gears are further rows, those that are independent; where locks or a singular position make them hang
//! on each other after all, a small compliance of these rows decides for the least multipliers. It does not enter the
//! residual. Drives in steady motion add inertia forces.
//!
//! The first multipliers are those of the least unbalanced force; without them the matrix would have no geometric
//! stiffness. Newton (σ = 0) goes by a line search on `½|r|²`, forces measured by the scene's weight and lengths by its
//! size. Where that comes to a stand the search starts again as pseudo-transient continuation: σ holds the links' turn
//! per step to a part of a radian and falls with the residual (Kelley & Keyes 1998), so that it ends as Newton's.

mod balance;
mod constraints;
mod entries;
mod gradient;
mod poses;
mod steady;

use crate::constraint::Rule;
use crate::dynamics::Fault;
use crate::model::{Model, Scalar};
use crate::spatial::Wrench;
use crate::statics::effort::Iteration;
use crate::statics::problem::Landscape;
use crate::statics::problem::place::Place;
use constraints::Constraint;
use entries::{Entries, Pattern};
use poses::Poses;
use std::sync::Arc;

const MOST_NEWTON_STEPS: usize = 60;
const MOST_TRANSIENT_STEPS: usize = 400;
/// Largest turn of a link in one Newton step (rad).
const NEWTON_TURN: f64 = 1.0;
/// Largest turn of a link in one step of the continuation (rad).
const TRANSIENT_TURN: f64 = 0.4;
/// A line search that comes down to this part of its first step has come to a stand.
const SMALLEST_PART: f64 = 1e-3;
/// Below this residual the answer is also looked at as hinge coordinates.
const NEAR: f64 = 1e-6;

/// Compliance of the rows of loops, drives and gears, in units of the scene's length over its forces.
const COMPLIANCE: f64 = 1e-13;

/// How the search ended, with the work in maximal coordinates.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Outcome {
    pub place: Place,
    /// `newton` or `pseudo-transient`.
    pub stage: &'static str,
    /// What each hinge passes to its link at its root marker: constraint forces, springs and motors; by link.
    pub reactions: Vec<Wrench>,
    /// Evaluations of forces and constraints.
    pub force_evaluations: usize,
    /// Factorizations of the matrix.
    pub factorizations: usize,
    /// Why the search gave up.
    pub note: Option<&'static str>,
}

/// Runs from `place`; the answer is balanced or the best that was found.
pub(in crate::statics) fn run(
    landscape: &mut Landscape<'_>,
    place: Place,
    history: &mut Vec<Iteration>,
) -> Result<Outcome, Fault> {
    if !(landscape.model().rods.is_empty() && landscape.model().modals.is_empty()) {
        return Err(Fault::Flexible { method: "lagrange" });
    }
    let mut search = Search::new(landscape, &place);
    let mut stage = "newton";
    let mut found = None;
    if search.balance_at_best().is_some() {
        let start = search.state.clone();
        found = search.newton(history)?;
        if found.is_none() {
            search.state = start;
            stage = "pseudo-transient";
            found = search.transient(history)?;
        }
    }
    let note = match found {
        Some(_) => None,
        None => Some("neither Newton nor the pseudo-transient continuation brings the forces into balance"),
    };
    let reactions = search.reactions();
    let (force_evaluations, factorizations) = (search.evaluations, search.factorizations);
    let place = match found {
        Some(place) => place,
        None => Place::at(landscape, place.q.clone()).unwrap_or(place),
    };
    Ok(Outcome { place, stage, reactions, force_evaluations, factorizations, note })
}

/// Poses, multipliers and the residual of the equations there.
#[derive(Debug, Clone)]
struct State {
    poses: Poses,
    multipliers: Vec<f64>,
    /// `[F + Gᵀλ; g]`
    residual: Vec<f64>,
}

/// A sum of coordinates that a drive or a gear prescribes.
struct Sum {
    row: usize,
    parts: [(Scalar, f64); 2],
    target: f64,
}

struct Search<'l, 's> {
    landscape: &'l mut Landscape<'s>,
    model: Arc<Model>,
    /// Of hinges, then of loops.
    constraints: Vec<Constraint>,
    hinges: usize,
    sums: Vec<Sum>,
    /// Rows of loops, drives and gears, and the compliance of each.
    compliance: Vec<(usize, f64)>,
    /// Coordinates of drives and gears.
    pushed: Vec<bool>,
    spins: bool,
    /// One over the size of each residual: forces, moments, lengths, cosines.
    weights: Vec<f64>,
    /// Pose unknowns; multipliers come after them.
    moving: usize,
    pattern: Option<Pattern>,
    entries: Entries,
    state: State,
    evaluations: usize,
    factorizations: usize,
}

impl<'l, 's> Search<'l, 's> {
    /// At the guess, without multipliers.
    fn new(landscape: &'l mut Landscape<'s>, place: &Place) -> Self {
        let model = &Arc::clone(landscape.model());
        let (mut constraints, first) = constraints::of_model(model, &place.q);
        let hinges = constraints.len();
        let tied = landscape.system().constraints().map_or(Vec::new(), |rows| rows.independent_rows(model));
        constraints.extend(constraints::of_loops(&tied, first));
        let rows = first + tied.len();
        let mut pushed = vec![false; model.velocity_count()];
        let mut sums = Vec::new();
        for (index, row) in tied.iter().enumerate() {
            if let Rule::Motion { parts } = row.rule {
                parts.iter().filter(|part| part.1 != 0.0).for_each(|(scalar, _)| pushed[scalar.velocity] = true);
                sums.push(Sum { row: first + index, parts, target: row.target });
            }
        }
        let moving = 6 * (model.links.len() - 1);
        let poses = Poses::new(model, &place.q);
        let state = State { poses, multipliers: vec![0.0; rows], residual: vec![0.0; moving + rows] };
        let spins = landscape.steady.iter().any(|v| *v != 0.0);
        let inertia = if spins { steady::inertia(model, &state.poses, &landscape.steady) } else { Vec::new() };
        let mut weights = weights(model, &state.poses, (&constraints, &inertia), moving + rows);
        for sum in sums.iter().filter(|sum| sum.parts[0].0.slides) {
            weights[moving + sum.row] = 1.0 / model.length_scale();
        }
        // The weight of a force over that of the gap, squared.
        let compliance = |row: usize| COMPLIANCE * weights[0] / weights[moving + row].powi(2) / model.length_scale();
        let compliance = (first..rows).map(|row| (row, compliance(row))).collect();
        let mut search = Self {
            landscape,
            model: Arc::clone(model),
            weights,
            constraints,
            hinges,
            sums,
            compliance,
            pushed,
            spins,
            moving,
            pattern: None,
            entries: Entries::default(),
            state,
            evaluations: 0,
            factorizations: 0,
        };
        search.evaluate();
        search
    }

    /// Sets the residual of the state.
    fn evaluate(&mut self) {
        self.evaluations += 1;
        let (model, state) = (&*self.model, &mut self.state);
        let mut sum = balance::on_links(model, &state.poses);
        if self.spins {
            let inertia = steady::inertia(model, &state.poses, &self.landscape.steady);
            sum.iter_mut().zip(inertia).for_each(|(sum, inertia)| *sum += inertia);
        }
        let push = push(&self.sums, &state.multipliers, self.pushed.len());
        for (index, own) in balance::hinges(model, &state.poses, &push).iter().enumerate().skip(1) {
            sum[index] += own[0];
            sum[model.links[index].parent] += own[1];
        }
        balance::add_reactions(&self.constraints, &state.poses, &state.multipliers, &mut sum);
        for (index, wrench) in sum.iter().enumerate() {
            entries::place(&mut state.residual, index, &wrench.force, &wrench.moment);
        }
        for constraint in &self.constraints {
            for (i, (gap, _)) in constraint.at(&state.poses.motion).iter().take(constraint.count()).enumerate() {
                state.residual[self.moving + constraint.row + i] = *gap;
            }
        }
        for one in &self.sums {
            let now: f64 = one.parts.iter().map(|(scalar, factor)| factor * state.poses.q[scalar.position]).sum();
            state.residual[self.moving + one.row] = now - one.target;
        }
    }

    /// `½|r|²`, dimensionless.
    fn merit(&self) -> f64 {
        self.state.residual.iter().zip(&self.weights).map(|(r, w)| 0.5 * (r * w).powi(2)).sum()
    }

    /// The multipliers of the least unbalanced force; `None` if the constraints depend on each other.
    fn balance_at_best(&mut self) -> Option<()> {
        self.entries.clear();
        self.entries.add_least_squares(self.model.links.len(), self.model.length_scale());
        self.add_constraints();
        let pattern = Pattern::of(&self.entries, self.weights.len())?;
        self.factorizations += 1;
        let mut rhs: Vec<f64> = self.state.residual.iter().map(|r| -r).collect();
        rhs[self.moving..].fill(0.0);
        let solution = pattern.solve(&self.entries, &rhs)?;
        self.state.multipliers.copy_from_slice(&solution[self.moving..]);
        self.evaluate();
        Some(())
    }

    fn add_constraints(&mut self) {
        for constraint in &self.constraints {
            let at = constraint.at(&self.state.poses.motion);
            for (i, (_, gradient)) in at.iter().take(constraint.count()).enumerate() {
                let row = self.moving + constraint.row + i;
                self.entries.add_constraint(row, gradient, constraint.link, constraint.parent);
            }
        }
        for one in &self.sums {
            for (scalar, factor) in one.parts.iter().filter(|part| part.1 != 0.0) {
                let link = &self.model.links[scalar.link];
                let gradient = balance::coordinate(&self.state.poses, scalar.link, link).times(*factor);
                self.entries.add_constraint(self.moving + one.row, &gradient, scalar.link, link.parent);
            }
        }
        for (row, value) in &self.compliance {
            self.entries.add_diagonal(self.moving + row, *value);
        }
    }

    /// The step of the shifted equations; `None` if they are singular.
    fn direction(&mut self, shift: f64) -> Option<Vec<f64>> {
        self.entries.clear();
        let push = push(&self.sums, &self.state.multipliers, self.pushed.len());
        balance::vary(&self.model, &self.state.poses, (&push, &self.pushed), shift, &mut self.entries);
        if self.spins {
            steady::vary(&self.model, &self.state.poses, &self.landscape.steady, &mut self.entries);
        }
        for constraint in &self.constraints {
            constraint.vary(&self.state.poses.motion, &self.state.multipliers, &mut self.entries);
        }
        self.add_constraints();
        if self.pattern.is_none() {
            self.pattern = Pattern::of(&self.entries, self.weights.len());
        }
        self.factorizations += 1;
        let rhs: Vec<f64> = self.state.residual.iter().map(|r| -r).collect();
        self.pattern.as_ref()?.solve(&self.entries, &rhs)
    }

    /// Largest turn of a link in a step (rad).
    fn turn(&self, step: &[f64]) -> f64 {
        let of_link = |part: &[f64]| part[3..].iter().map(|x| x * x).sum::<f64>().sqrt();
        step[..self.moving].chunks(6).map(of_link).fold(0.0, f64::max)
    }

    /// Goes `scale` of a step from `from`.
    fn go(&mut self, from: &State, step: &[f64], scale: f64) {
        self.state.poses = from.poses.moved(&self.model, step, scale);
        for ((new, old), by) in self.state.multipliers.iter_mut().zip(&from.multipliers).zip(&step[self.moving..]) {
            *new = old + scale * by;
        }
        self.evaluate();
    }

    /// Newton with a line search, until balanced; `None` if it comes to a stand.
    fn newton(&mut self, history: &mut Vec<Iteration>) -> Result<Option<Place>, Fault> {
        for _ in 0..MOST_NEWTON_STEPS {
            if let Some(place) = self.balanced()? {
                return Ok(Some(place));
            }
            let Some(step) = self.direction(0.0) else { return Ok(None) };
            let (from, before) = (self.state.clone(), self.merit());
            let mut scale = (NEWTON_TURN / self.turn(&step)).min(1.0);
            let least = scale * SMALLEST_PART;
            loop {
                self.go(&from, &step, scale);
                if self.merit() <= (1.0 - 1e-4 * scale) * before {
                    break;
                }
                scale *= 0.5;
                if scale < least {
                    return Ok(None);
                }
            }
            self.note("newton", scale * self.turn(&step), 0.0, history);
        }
        self.balanced()
    }

    /// Steps along the way of an overdamped system, ever longer.
    fn transient(&mut self, history: &mut Vec<Iteration>) -> Result<Option<Place>, Fault> {
        let slowest = self.model.time_scale().powi(-2);
        let mut shift = slowest;
        let mut tries = 0;
        while tries < MOST_TRANSIENT_STEPS {
            if let Some(place) = self.balanced()? {
                return Ok(Some(place));
            }
            tries += 1;
            let step = self.direction(shift).filter(|step| self.turn(step) <= TRANSIENT_TURN);
            let Some(step) = step else {
                shift = (4.0 * shift).max(1e-6 * slowest);
                continue;
            };
            let (from, before) = (self.state.clone(), self.merit());
            self.go(&from, &step, 1.0);
            let after = self.merit();
            if !after.is_finite() {
                self.state = from;
                shift *= 10.0;
                continue;
            }
            self.note("pseudo-transient", self.turn(&step), shift, history);
            shift *= (after / before).sqrt().clamp(0.1, 1.0).min(0.5);
        }
        self.balanced()
    }

    fn note(&self, stage: &'static str, step: f64, shift: f64, history: &mut Vec<Iteration>) {
        let residual = self.state.residual.iter().zip(&self.weights).map(|(r, w)| (r * w).abs()).fold(0.0, f64::max);
        history.push(Iteration { stage, residual, step, shift });
    }

    /// The answer in hinge coordinates where that is balanced.
    fn balanced(&mut self) -> Result<Option<Place>, Fault> {
        if !(self.merit() <= NEAR * NEAR) {
            return Ok(None);
        }
        let mut q = self.state.poses.q.clone();
        if !self.landscape.close(&mut q) {
            return Ok(None);
        }
        let place = Place::at(self.landscape, q)?;
        Ok(place.is_balanced().then_some(place))
    }

    /// What each hinge passes to its link, by link.
    fn reactions(&self) -> Vec<Wrench> {
        let (model, state) = (&*self.model, &self.state);
        let hinges = &self.constraints[..self.hinges];
        let constraint = balance::reactions(hinges, &state.poses, &state.multipliers, model.links.len());
        let push = push(&self.sums, &state.multipliers, self.pushed.len());
        let own = balance::hinges(model, &state.poses, &push);
        own.iter().zip(&constraint).map(|(own, constraint)| own[0] + constraint[0]).collect()
    }
}

/// What drives and gears push in every coordinate.
fn push(sums: &[Sum], multipliers: &[f64], count: usize) -> Vec<f64> {
    let mut push = vec![0.0; count];
    for one in sums {
        one.parts.iter().for_each(|(scalar, factor)| push[scalar.velocity] += factor * multipliers[one.row]);
    }
    push
}

/// Forces by everything that pushes at the start, lengths by the scene's.
fn weights(model: &Model, poses: &Poses, (constraints, inertia): (&[Constraint], &[Wrench]), size: usize) -> Vec<f64> {
    let length = model.length_scale();
    let of_wrench = |wrench: &Wrench| wrench.force.norm() + wrench.moment.norm() / length;
    let applied = balance::on_links(model, poses);
    let hinges = balance::hinges(model, poses, &[]);
    let sum: f64 = applied.iter().skip(1).chain(hinges.iter().map(|pair| &pair[0])).chain(inertia).map(of_wrench).sum();
    let force = if sum > 0.0 { sum } else { 1.0 };
    let mut weights = vec![1.0; size];
    let moving = 6 * (model.links.len() - 1);
    for part in weights[..moving].chunks_mut(6) {
        part[..3].fill(1.0 / force);
        part[3..].fill(1.0 / (force * length));
    }
    for constraint in constraints.iter().filter(|constraint| constraint.is_length()) {
        weights[moving + constraint.row..][..constraint.count()].fill(1.0 / length);
    }
    weights
}
