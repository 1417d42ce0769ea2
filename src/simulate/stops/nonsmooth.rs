//! What stops and dry friction of hinges hold at rest, and the energy of stops.
//!
//! ```text
//! (1)  held        a_i = 0:  a = a₀ + M⁻¹ Hᵀ λ,  (H M⁻¹ Hᵀ) λ = −H a₀;  released when λ leaves its range
//! (2)  stored      V = ½ k max(0, d)²,  d the depth beyond a limit, whether the stop pushes or not
//! (3)  dissipated  P = c ḋ² while it pushes,  P = −k d ḋ > 0 while it does not and d > 0
//! ```
//!
//! By (3) a damped stop that its coordinate leaves faster than it relaxes spends what (2) still holds on its own damper:
//! `k d + c ḋ < 0` there, and so `ḋ < 0`. A coordinate that comes back before `d = 0` meets the rest of it.
//!
//! The range of λ in (1): a stop pushes and never pulls, dry friction holds up to its largest force at rest (the norm of the
//! torque, in a spherical hinge), a coordinate that rests on a stop and has friction is held by both.
//!
//! What is held is a part of the discrete state of a run, beside the [`Phase`] of its system, which has what pushes and slides. Both
//! change at events alone (`instant.rs`): within a step every law is smooth, so that no method has to step over a jump. `M⁻¹` of
//! a unit force is one more right side of the factorization that gave the accelerations. A scene without stops and friction
//! has none of this, and one whose stops are not touched pays a comparison for each.
//!
//! **With loops, drives and gears** a coordinate that is held has a row like theirs. Those whose rows depend linearly on
//! theirs and on others (the second of two fingers that a gear ties) bear nothing of their own and are not held.

use crate::dynamics::HeldRow;
use crate::dynamics::applied::{Phase, Rubbing, rate_of};
use crate::model::prescribed::Instant;
use crate::model::stop::sides;
use crate::model::{Model, Scalar, StopLaw, StopSide};
use std::sync::Arc;

/// A coordinate, or the three of a spherical hinge, at rest by what holds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::simulate) struct Holding {
    /// First velocity coordinate, and how many: 1, or 3 of a spherical hinge.
    pub(in crate::simulate) velocity: usize,
    pub(in crate::simulate) count: usize,
    /// The rigid stop that it rests on.
    pub(in crate::simulate) stop: Option<StopSide>,
    /// The dry friction that acts, by its index in the model.
    pub(in crate::simulate) friction: Option<usize>,
    /// What holds it can push with this along the coordinate; of a spherical hinge the norm counts (N or N m).
    pub(in crate::simulate) range: [f64; 2],
    /// It lets go when it would have to leave its range by more than this, the round-off of what presses (N or N m).
    pub(in crate::simulate) slack: f64,
}

/// The stops and the dry friction of a model, and what they do.
#[derive(Debug)]
pub(in crate::simulate) struct Nonsmooth {
    pub(in crate::simulate) model: Arc<Model>,
    /// What is at rest.
    pub(in crate::simulate) held: Vec<Holding>,
    /// Whether what is held has rows beside those of loops, drives and gears.
    tied: bool,
    /// `M⁻¹ Hᵀ` of the held coordinates, one after the other.
    columns: Vec<Vec<f64>>,
    /// `H M⁻¹ Hᵀ` and λ.
    matrix: Vec<f64>,
    multipliers: Vec<f64>,
    /// The held coordinates, in the order of the multipliers.
    coordinates: Vec<usize>,
    force: Vec<f64>,
}

impl Nonsmooth {
    /// `None` for a model without stops and dry friction.
    pub(in crate::simulate) fn new(model: &Arc<Model>) -> Option<Self> {
        let n = model.velocity_count();
        let any = !(model.stops.is_empty() && model.hinge_friction.is_empty());
        any.then(|| Self {
            model: Arc::clone(model),
            held: Vec::with_capacity(model.stops.len() + model.hinge_friction.len()),
            tied: model.is_constrained(),
            columns: Vec::new(),
            matrix: Vec::new(),
            multipliers: Vec::new(),
            coordinates: Vec::new(),
            force: vec![0.0; n],
        })
    }

    /// Holds these from now on, and no others.
    pub(in crate::simulate) fn set_held(&mut self, held: &[Holding]) {
        self.held.clear();
        self.held.extend_from_slice(held);
        if !self.tied {
            self.coordinates.clear();
            self.coordinates.extend(held.iter().flat_map(|held| held.velocity..held.velocity + held.count));
            let (m, n) = (self.coordinates.len(), self.force.len());
            self.columns.resize_with(m.max(self.columns.len()), || vec![0.0; n]);
            self.matrix.resize(m * m, 0.0);
            self.multipliers.resize(m, 0.0);
        }
    }

    /// Corrects the free accelerations of a tree by (1); `solve` is `x ← M⁻¹ rhs`.
    pub(in crate::simulate) fn correct(&mut self, a: &mut [f64], solve: &mut dyn FnMut(&[f64], &mut [f64])) {
        if self.coordinates.is_empty() || self.tied {
            return;
        }
        let m = self.coordinates.len();
        for (column, i) in self.columns.iter_mut().zip(&self.coordinates) {
            self.force.fill(0.0);
            self.force[*i] = 1.0;
            solve(&self.force, column);
        }
        for (row, i) in self.coordinates.iter().enumerate() {
            self.multipliers[row] = -a[*i];
            for k in 0..m {
                self.matrix[row * m + k] = self.columns[k][*i];
            }
        }
        solve_positive(&mut self.matrix[..m * m], &mut self.multipliers[..m]);
        for k in 0..m {
            let by = self.multipliers[k];
            a.iter_mut().zip(&self.columns[k]).for_each(|(a, column)| *a += by * column);
        }
        self.coordinates.iter().for_each(|i| a[*i] = 0.0);
    }

    /// What is held from now on, as rows with those of loops, drives and gears: stops at their limits, the rest where it is.
    pub(in crate::simulate) fn rows(&self, held: &[Holding], q: &[f64]) -> Vec<HeldRow> {
        let row = |held: &Holding| {
            let link = self
                .model
                .links
                .iter()
                .position(|link| held.velocity == link.velocity && link.joint.counts().1 == held.count)?;
            if held.count != 1 {
                return Some(HeldRow::Ball(link));
            }
            let (position, joint) = (self.model.links[link].position, &self.model.links[link].joint);
            let at = held.stop.map_or(q[position], |side| self.model.stops[side.stop].limit(side.at));
            let coordinate = Scalar { link, position, velocity: held.velocity, slides: joint.is_distance() };
            Some(HeldRow::Coordinate { coordinate, at: Instant { position: at, ..Instant::default() } })
        };
        held.iter().filter_map(row).collect()
    }

    /// A coordinate on the stop of a side, with the speed that it has.
    pub(in crate::simulate) fn row(&self, side: StopSide, q: &[f64], v: &[f64]) -> Option<HeldRow> {
        let velocity = self.model.stops[side.stop].velocity;
        let held = Holding { velocity, count: 1, stop: Some(side), friction: None, range: [0.0; 2], slack: 0.0 };
        let mut row = self.rows(&[held], q).pop()?;
        if let HeldRow::Coordinate { at, .. } = &mut row {
            at.velocity = v[velocity];
        }
        Some(row)
    }

    /// How far the forces of what is held in this place of the list are within their range, of the last corrected accelerations
    /// of a tree; below zero if it has to let go.
    pub(in crate::simulate) fn reserve(&self, held: usize) -> f64 {
        let first: usize = self.held[..held].iter().map(|held| held.count).sum();
        let held = &self.held[held];
        within(held, &self.multipliers[first..first + held.count])
    }

    /// What holds the first coordinate in this place of the list, of the last corrected accelerations of a tree (N or N m).
    pub(in crate::simulate) fn held_force(&self, held: usize) -> f64 {
        let first: usize = self.held[..held].iter().map(|held| held.count).sum();
        self.multipliers[first]
    }

    /// Takes the rows that are held off the force balance of a tree.
    pub(in crate::simulate) fn balance(&self, residual: &mut [f64]) {
        if !self.tied {
            self.coordinates.iter().for_each(|i| residual[*i] = 0.0);
        }
    }

    /// What the stops add to the diagonal of a tangent, and dry friction of spherical hinges, across its direction and along it: a
    /// bound, for Newton's method alone. Infinite for what is held in a tree.
    pub(in crate::simulate) fn diagonal(&mut self, phase: &Phase, v: &[f64], c1: f64) -> &[f64] {
        self.force.fill(0.0);
        for side in &phase.pushing {
            let stop = &self.model.stops[side.stop];
            if let StopLaw::Compliant { stiffness, damping } = stop.law {
                self.force[stop.velocity] += stiffness + c1 * damping;
            }
        }
        for (friction, rubbing) in self.model.hinge_friction.iter().zip(&phase.rubbing) {
            if let (Rubbing::Slides(_), 3) = (rubbing, friction.count) {
                let speed = rate_of(friction, v).norm().max(phase.slow).max(f64::MIN_POSITIVE.sqrt());
                let range = friction.velocity..friction.velocity + 3;
                self.force[range].iter_mut().for_each(|entry| *entry += c1 * friction.friction.slide / speed);
            }
        }
        if !self.tied {
            self.coordinates.iter().for_each(|i| self.force[*i] = f64::INFINITY);
        }
        &self.force
    }

    /// (2) of all stops (J).
    pub(in crate::simulate) fn potential(&self, q: &[f64]) -> f64 {
        sides(&self.model.stops).map(|side| self.model.stops[side.stop].potential(side.at, q)).sum()
    }

    /// Where a compliant stop is run into between two states, what its damper pushes with at once (N or N m), by velocity coordinate.
    pub(in crate::simulate) fn run_into(&self, from: [&[f64]; 2], to: [&[f64]; 2]) -> Vec<(usize, f64)> {
        let of_side = |side: StopSide| {
            let stop = &self.model.stops[side.stop];
            let StopLaw::Compliant { damping, .. } = stop.law else { return None };
            let pushes = |[q, v]: [&[f64]; 2]| stop.depth(side.at, q) > 0.0 && stop.push(side.at, q, v) > 0.0;
            (!pushes(from) && pushes(to)).then(|| (stop.velocity, damping * from[1][stop.velocity].abs()))
        };
        sides(&self.model.stops).filter_map(of_side).collect()
    }

    /// (3) of all stops and what friction takes out of all that slides (W).
    pub(in crate::simulate) fn dissipated(&self, phase: &Phase, q: &[f64], v: &[f64]) -> f64 {
        let of_side = |side: StopSide| {
            let stop = &self.model.stops[side.stop];
            let StopLaw::Compliant { stiffness: k, damping: d } = stop.law else { return 0.0 };
            let (p, rate) = (stop.depth(side.at, q), side.at.sign() * v[stop.velocity]);
            if phase.pushes(side) { d * rate * rate } else { -k * p.max(0.0) * rate }
        };
        phase.rubbed(&self.model, v) + sides(&self.model.stops).map(of_side).sum::<f64>()
    }
}

/// How far the forces of what is held are within their range; below zero beyond it.
pub(in crate::simulate) fn within(held: &Holding, forces: &[f64]) -> f64 {
    let [low, high] = held.range;
    match forces {
        [force] => (force - low).min(high - force),
        _ => high - forces.iter().map(|force| force * force).sum::<f64>().sqrt(),
    }
}

/// `x ← A⁻¹ x` for a small positive definite matrix, by rows; `A` is lost.
fn solve_positive(a: &mut [f64], x: &mut [f64]) {
    let n = x.len();
    for k in 0..n {
        for i in k + 1..n {
            let factor = a[i * n + k] / a[k * n + k];
            for j in k..n {
                a[i * n + j] -= factor * a[k * n + j];
            }
            x[i] -= factor * x[k];
        }
    }
    for k in (0..n).rev() {
        for j in k + 1..n {
            x[k] -= a[k * n + j] * x[j];
        }
        x[k] /= a[k * n + k];
    }
}
