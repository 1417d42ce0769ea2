//! Laws of hinge coordinates that are smooth in parts only, stops and dry friction: what they add to the motion of a system that
//! knows nothing of them.
//!
//! ```text
//! (1)  pushing     τ_i −= side · (k p + d ṗ),  p = side · (q_i − limit);  until it would pull
//! (2)  held        a_i = 0:  a = a₀ + M⁻¹ Hᵀ λ,  (H M⁻¹ Hᵀ) λ = −H a₀;  released when λ leaves its range
//! (3)  stored      V = ½ k max(0, p)²,  whether it pushes or not
//! (4)  dissipated  P = d ṗ² while it pushes,  P = −k p ṗ > 0 while it does not and p > 0
//! (5)  sliding     τ −= f_slide u,  u = v / |v|;  P = f_slide |v|
//! ```
//!
//! By (4) a damped stop that its coordinate leaves faster than it relaxes spends what (3) still holds on its own damper:
//! `k p + d ṗ < 0` there, and so `ṗ < 0`. A coordinate that comes back before `p = 0` meets the rest of it.
//!
//! The range of λ in (2): a stop pushes and never pulls, dry friction holds up to its largest force at rest (the norm of the
//! torque, in a spherical hinge), a coordinate that rests on a stop and has friction is held by both. In (5) `v` is one
//! coordinate, whose sign is kept within a step, or the angular velocity of a spherical hinge. Its direction turns at a rate that grows
//! without bound as it comes to rest or lets go: below a speed `v₀` that is a matter of the tolerance
//!
//! ```text
//! (6)  u = v / v₀ + (1 − |v| / v₀) d,   d the direction at the end of the last step
//! ```
//!
//! which is the same as long as the direction stays.
//!
//! Which stops push, what is held and what slides is the [`Phase`] of a run. It changes at events alone (`instant.rs`): within a
//! step every law is smooth, so that no method has to step over a jump. `M⁻¹` of a unit force is one more right side of the
//! factorization that gave the accelerations. A scene without stops and friction has none of this, and one whose stops are not
//! touched pays a comparison for each.
//!
//! **With loops, drives and gears** a coordinate that is held has a row like theirs. Those whose rows depend linearly on
//! theirs and on others (the second of two fingers that a gear ties) bear nothing of their own and are not held.

use crate::dynamics::Held as Row;
use crate::model::contact::HingeFriction;
use crate::model::prescribed::Instant;
use crate::model::{Model, Scalar, Stop, StopLaw};
use nalgebra::Vector3;
use std::sync::Arc;

/// Which end of a stop's range: −1 the low one, 1 the high one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Side {
    /// Index into the model's stops.
    pub(super) stop: usize,
    /// −1 or 1.
    pub(super) sign: f64,
}

/// A coordinate, or the three of a spherical hinge, at rest by what holds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    /// First velocity coordinate, and how many: 1, or 3 of a spherical hinge.
    pub(super) velocity: usize,
    pub(super) count: usize,
    /// The rigid stop that it rests on.
    pub(super) stop: Option<Side>,
    /// The dry friction that acts, by its index in the model.
    pub(super) friction: Option<usize>,
    /// What holds it can push with this along the coordinate; of a spherical hinge the norm counts (N or N m).
    pub(super) range: [f64; 2],
    /// It lets go when it would have to leave its range by more than this, the round-off of what presses (N or N m).
    pub(super) slack: f64,
}

/// What dry friction of a hinge does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rubbing {
    /// It holds what is at rest, as a part of [`Phase::held`] says.
    Sticks,
    /// It opposes motion in this direction, of unit length; a turn or a slide has ±1 as the first component.
    Slides(Vector3<f64>),
    /// Its coordinate rests because others to which it is tied are held: it pushes with this (N or N m).
    Dependent(f64),
}

/// The discrete state of a run, besides its positions and velocities.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Phase {
    /// Compliant stops that push.
    pub(super) pushing: Vec<Side>,
    /// What is at rest.
    pub(super) held: Vec<Held>,
    /// What dry friction does, per hinge coordinate that has it.
    pub(super) rubbing: Vec<Rubbing>,
}

/// The stops and the dry friction of a model, and what they do.
#[derive(Debug)]
pub(super) struct Nonsmooth {
    pub(super) model: Arc<Model>,
    pub(super) phase: Phase,
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
    /// `v₀` of (6) (rad/s); 0 for none.
    pub(super) slow: f64,
}

/// What dry friction opposes: a coordinate, or the angular velocity of a spherical hinge.
pub(super) fn rate_of(friction: &HingeFriction, v: &[f64]) -> Vector3<f64> {
    let mut rate = Vector3::zeros();
    rate.iter_mut().zip(&v[friction.velocity..friction.velocity + friction.count]).for_each(|(to, from)| *to = *from);
    rate
}

impl Stop {
    /// The limit on a side.
    pub(super) fn limit(&self, sign: f64) -> f64 {
        self.range[usize::from(sign > 0.0)]
    }

    /// How far a coordinate is beyond the limit of a side; negative inside.
    pub(super) fn depth(&self, sign: f64, q: &[f64]) -> f64 {
        sign * (q[self.position] - self.limit(sign))
    }

    /// `k p + d ṗ` on a side, whatever its sign; zero for a rigid stop.
    pub(super) fn push(&self, sign: f64, q: &[f64], v: &[f64]) -> f64 {
        match self.law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { stiffness, damping } => {
                stiffness * self.depth(sign, q) + damping * sign * v[self.velocity]
            }
        }
    }

    /// The sides that exist.
    pub(super) fn signs(&self) -> impl Iterator<Item = f64> + use<> {
        let range = self.range;
        [-1.0, 1.0].into_iter().filter(move |sign| range[usize::from(*sign > 0.0)].is_finite())
    }
}

impl Nonsmooth {
    /// `None` for a model without stops and dry friction.
    pub(super) fn new(model: &Arc<Model>) -> Option<Self> {
        let n = model.velocity_count();
        let room = model.stops.len();
        let any = !(model.stops.is_empty() && model.hinge_friction.is_empty());
        let phase = Phase {
            pushing: Vec::with_capacity(room),
            held: Vec::with_capacity(room + model.hinge_friction.len()),
            rubbing: vec![Rubbing::Sticks; model.hinge_friction.len()],
        };
        any.then(|| Self {
            model: Arc::clone(model),
            phase,
            tied: model.is_constrained(),
            columns: Vec::new(),
            matrix: Vec::new(),
            multipliers: Vec::new(),
            coordinates: Vec::new(),
            force: vec![0.0; n],
            slow: 0.0,
        })
    }

    /// Holds these from now on, and no others.
    pub(super) fn set_held(&mut self, held: &[Held]) {
        self.phase.held.clear();
        self.phase.held.extend_from_slice(held);
        if !self.tied {
            self.coordinates.clear();
            self.coordinates.extend(held.iter().flat_map(|held| held.velocity..held.velocity + held.count));
            let (m, n) = (self.coordinates.len(), self.force.len());
            self.columns.resize_with(m.max(self.columns.len()), || vec![0.0; n]);
            self.matrix.resize(m * m, 0.0);
            self.multipliers.resize(m, 0.0);
        }
    }

    /// (1) of all stops that push, and (5).
    pub(super) fn press(&self, q: &[f64], v: &[f64], tau: &mut [f64]) {
        tau.fill(0.0);
        for side in &self.phase.pushing {
            let stop = &self.model.stops[side.stop];
            tau[stop.velocity] -= side.sign * stop.push(side.sign, q, v);
        }
        for (friction, rubbing) in self.model.hinge_friction.iter().zip(&self.phase.rubbing) {
            match *rubbing {
                Rubbing::Sticks => {}
                Rubbing::Dependent(force) => tau[friction.velocity] += force,
                Rubbing::Slides(direction) => {
                    let direction = match friction.count {
                        1 => direction,
                        _ => self.direction(&rate_of(friction, v), &direction),
                    };
                    for k in 0..friction.count {
                        tau[friction.velocity + k] -= friction.friction.slide * direction[k];
                    }
                }
            }
        }
    }

    /// `u` of (5) and (6).
    fn direction(&self, rate: &Vector3<f64>, last: &Vector3<f64>) -> Vector3<f64> {
        let speed = rate.norm();
        match speed < self.slow {
            true => rate / self.slow + (1.0 - speed / self.slow) * last,
            false => rate.try_normalize(f64::MIN_POSITIVE).unwrap_or(*last),
        }
    }

    /// Corrects the free accelerations of a tree by (2); `solve` is `x ← M⁻¹ rhs`.
    pub(super) fn correct(&mut self, a: &mut [f64], solve: &mut dyn FnMut(&[f64], &mut [f64])) {
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
    pub(super) fn rows(&self, held: &[Held], q: &[f64]) -> Vec<Row> {
        let row = |held: &Held| {
            let link = self
                .model
                .links
                .iter()
                .position(|link| held.velocity == link.velocity && link.joint.counts().1 == held.count)?;
            if held.count != 1 {
                return Some(Row::Ball(link));
            }
            let (position, joint) = (self.model.links[link].position, &self.model.links[link].joint);
            let at = held.stop.map_or(q[position], |side| self.model.stops[side.stop].limit(side.sign));
            let coordinate = Scalar { link, position, velocity: held.velocity, slides: joint.is_distance() };
            Some(Row::Coordinate { coordinate, at: Instant { position: at, ..Instant::default() } })
        };
        held.iter().filter_map(row).collect()
    }

    /// A coordinate on the stop of a side, with the speed that it has.
    pub(super) fn row(&self, side: Side, q: &[f64], v: &[f64]) -> Option<Row> {
        let velocity = self.model.stops[side.stop].velocity;
        let held = Held { velocity, count: 1, stop: Some(side), friction: None, range: [0.0; 2], slack: 0.0 };
        let mut row = self.rows(&[held], q).pop()?;
        if let Row::Coordinate { at, .. } = &mut row {
            at.velocity = v[velocity];
        }
        Some(row)
    }

    /// How far the forces of what is held in this place of the list are within their range, of the last corrected accelerations
    /// of a tree; below zero if it has to let go.
    pub(super) fn reserve(&self, held: usize) -> f64 {
        let first: usize = self.phase.held[..held].iter().map(|held| held.count).sum();
        let held = &self.phase.held[held];
        within(held, &self.multipliers[first..first + held.count])
    }

    /// What holds the first coordinate in this place of the list, of the last corrected accelerations of a tree (N or N m).
    pub(super) fn held_force(&self, held: usize) -> f64 {
        let first: usize = self.phase.held[..held].iter().map(|held| held.count).sum();
        self.multipliers[first]
    }

    /// Takes the rows that are held off the force balance of a tree.
    pub(super) fn balance(&self, residual: &mut [f64]) {
        if !self.tied {
            self.coordinates.iter().for_each(|i| residual[*i] = 0.0);
        }
    }

    /// What the stops add to the diagonal of a tangent, and dry friction of spherical hinges, across its direction and along it: a
    /// bound, for Newton's method alone. Infinite for what is held in a tree.
    pub(super) fn diagonal(&mut self, v: &[f64], c1: f64) -> &[f64] {
        self.force.fill(0.0);
        for side in &self.phase.pushing {
            let stop = &self.model.stops[side.stop];
            if let StopLaw::Compliant { stiffness, damping } = stop.law {
                self.force[stop.velocity] += stiffness + c1 * damping;
            }
        }
        for (friction, rubbing) in self.model.hinge_friction.iter().zip(&self.phase.rubbing) {
            if let (Rubbing::Slides(_), 3) = (rubbing, friction.count) {
                let speed = rate_of(friction, v).norm().max(self.slow).max(f64::MIN_POSITIVE.sqrt());
                let range = friction.velocity..friction.velocity + 3;
                self.force[range].iter_mut().for_each(|entry| *entry += c1 * friction.friction.slide / speed);
            }
        }
        if !self.tied {
            self.coordinates.iter().for_each(|i| self.force[*i] = f64::INFINITY);
        }
        &self.force
    }

    /// (3) of all stops (J).
    pub(super) fn potential(&self, q: &[f64]) -> f64 {
        self.compliant()
            .map(|(side, [k, _])| 0.5 * k * self.model.stops[side.stop].depth(side.sign, q).max(0.0).powi(2))
            .sum()
    }

    /// (4) of all stops and (5) of all that slides (W).
    pub(super) fn dissipated(&self, q: &[f64], v: &[f64]) -> f64 {
        let of_friction = |(friction, rubbing): (&HingeFriction, &Rubbing)| match rubbing {
            Rubbing::Slides(_) => friction.friction.slide * rate_of(friction, v).norm(),
            Rubbing::Sticks | Rubbing::Dependent(_) => 0.0,
        };
        let friction: f64 = self.model.hinge_friction.iter().zip(&self.phase.rubbing).map(of_friction).sum();
        let of_side = |(side, [k, d]): (Side, [f64; 2])| {
            let stop = &self.model.stops[side.stop];
            let (p, rate) = (stop.depth(side.sign, q), side.sign * v[stop.velocity]);
            if self.phase.pushing.contains(&side) { d * rate * rate } else { -k * p.max(0.0) * rate }
        };
        friction + self.compliant().map(of_side).sum::<f64>()
    }

    /// The sides of compliant stops, stiffness and damping with them.
    fn compliant(&self) -> impl Iterator<Item = (Side, [f64; 2])> {
        let law = |stop: &Stop| match stop.law {
            StopLaw::Rigid { .. } => None,
            StopLaw::Compliant { stiffness, damping } => Some([stiffness, damping]),
        };
        let stops =
            self.model.stops.iter().enumerate().filter_map(move |(index, stop)| Some((index, stop, law(stop)?)));
        stops.flat_map(|(index, stop, law)| stop.signs().map(move |sign| (Side { stop: index, sign }, law)))
    }
}

/// How far the forces of what is held are within their range; below zero beyond it.
pub(super) fn within(held: &Held, forces: &[f64]) -> f64 {
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
