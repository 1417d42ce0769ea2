//! Stops of hinge coordinates: what they add to the motion of a system that knows nothing of them.
//!
//! ```text
//! (1)  pushing     τ_i −= side · (k p + d ṗ),  p = side · (q_i − limit);  until it would pull
//! (2)  held        a_i = 0:  a = a₀ + M⁻¹ Hᵀ λ,  (H M⁻¹ Hᵀ) λ = −H a₀;  released when λ would pull
//! (3)  stored      V = ½ k max(0, p)²,  whether it pushes or not
//! (4)  dissipated  P = d ṗ² while it pushes,  P = −k p ṗ > 0 while it does not and p > 0
//! ```
//!
//! By (4) a damped stop that its coordinate leaves faster than it relaxes spends what (3) still holds on its own damper:
//! `k p + d ṗ < 0` there, and so `ṗ < 0`. A coordinate that comes back before `p = 0` meets the rest of it.
//!
//! Which stops push and which hold is the [`Mode`] of a run. It changes at events alone (`instant.rs`): within a step every
//! law is smooth, so that no method has to step over a jump. `M⁻¹` of a unit force is one more right side of the
//! factorization that gave the accelerations. A scene without stops has none of this, and one whose stops are not touched
//! pays a comparison for each.
//!
//! **Beside loops, drives and gears** a stop that holds is a row like theirs. Stops whose rows depend linearly on theirs and
//! on other stops' (the second of two fingers that a gear ties) bear nothing of their own and are not held.

use crate::model::prescribed::Instant;
use crate::model::{Model, Stop, StopLaw};
use std::sync::Arc;

/// Which end of a stop's range: −1 the low one, 1 the high one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Side {
    /// Index into the model's stops.
    pub(super) stop: usize,
    /// −1 or 1.
    pub(super) sign: f64,
}

/// A rigid stop that holds its coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    /// Which.
    pub(super) side: Side,
    /// It lets go when it would have to pull by more than this, the round-off of what presses (N or N m).
    pub(super) slack: f64,
}

/// The discrete state of a run, beside its positions and velocities.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Mode {
    /// Compliant stops that push.
    pub(super) pushing: Vec<Side>,
    /// Rigid stops that hold their coordinates.
    pub(super) held: Vec<Held>,
}

/// The stops of a model and what rests on them.
#[derive(Debug)]
pub(super) struct Stops {
    pub(super) model: Arc<Model>,
    pub(super) mode: Mode,
    /// Whether what is held has rows beside those of loops, drives and gears.
    tied: bool,
    /// `M⁻¹ Hᵀ` of the held coordinates, one after the other.
    columns: Vec<Vec<f64>>,
    /// `H M⁻¹ Hᵀ` and λ.
    matrix: Vec<f64>,
    multipliers: Vec<f64>,
    force: Vec<f64>,
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

impl Stops {
    /// `None` for a model without stops.
    pub(super) fn new(model: &Arc<Model>) -> Option<Self> {
        let n = model.velocity_count();
        let room = model.stops.len();
        (!model.stops.is_empty()).then(|| Self {
            model: Arc::clone(model),
            mode: Mode { pushing: Vec::with_capacity(room), held: Vec::with_capacity(room) },
            tied: model.is_constrained(),
            columns: Vec::new(),
            matrix: Vec::new(),
            multipliers: Vec::new(),
            force: vec![0.0; n],
        })
    }

    /// Holds these from now on, and no others.
    pub(super) fn set_held(&mut self, held: &[Held]) {
        self.mode.held.clear();
        self.mode.held.extend_from_slice(held);
        if !self.tied {
            let (m, n) = (held.len(), self.force.len());
            self.columns.resize_with(m.max(self.columns.len()), || vec![0.0; n]);
            self.matrix.resize(m * m, 0.0);
            self.multipliers.resize(m, 0.0);
        }
    }

    /// (1) of all stops that push.
    pub(super) fn press(&self, q: &[f64], v: &[f64], tau: &mut [f64]) {
        tau.fill(0.0);
        for side in &self.mode.pushing {
            let stop = &self.model.stops[side.stop];
            tau[stop.velocity] -= side.sign * stop.push(side.sign, q, v);
        }
    }

    /// Corrects the free accelerations of a tree by (2); `solve` is `x ← M⁻¹ rhs`.
    pub(super) fn correct(&mut self, a: &mut [f64], solve: &mut dyn FnMut(&[f64], &mut [f64])) {
        if self.mode.held.is_empty() || self.tied {
            return;
        }
        let m = self.mode.held.len();
        for (k, Held { side, .. }) in self.mode.held.iter().enumerate() {
            self.force.fill(0.0);
            self.force[self.model.stops[side.stop].velocity] = 1.0;
            solve(&self.force, &mut self.columns[k]);
        }
        for (row, Held { side, .. }) in self.mode.held.iter().enumerate() {
            let i = self.model.stops[side.stop].velocity;
            self.multipliers[row] = -a[i];
            for k in 0..m {
                self.matrix[row * m + k] = self.columns[k][i];
            }
        }
        solve_positive(&mut self.matrix[..m * m], &mut self.multipliers[..m]);
        for k in 0..m {
            let by = self.multipliers[k];
            a.iter_mut().zip(&self.columns[k]).for_each(|(a, column)| *a += by * column);
        }
        for Held { side, .. } in &self.mode.held {
            a[self.model.stops[side.stop].velocity] = 0.0;
        }
    }

    /// A coordinate on the stop of a side, with this speed.
    pub(super) fn row(&self, side: Side, velocity: f64) -> (usize, Instant) {
        let stop = &self.model.stops[side.stop];
        (stop.velocity, Instant { position: stop.limit(side.sign), velocity, acceleration: 0.0 })
    }

    /// What presses on a held stop of a tree, of the last corrected accelerations; negative if it would have to pull.
    pub(super) fn pressure(&self, held: usize) -> f64 {
        -self.mode.held[held].side.sign * self.multipliers[held]
    }

    /// Takes the rows that are held off the force balance of a tree.
    pub(super) fn balance(&self, residual: &mut [f64]) {
        if !self.tied {
            self.mode.held.iter().for_each(|held| residual[self.model.stops[held.side.stop].velocity] = 0.0);
        }
    }

    /// What the stops add to the diagonal of a tangent: infinite for what they hold in a tree.
    pub(super) fn diagonal(&mut self, c1: f64) -> &[f64] {
        self.force.fill(0.0);
        for side in &self.mode.pushing {
            let stop = &self.model.stops[side.stop];
            if let StopLaw::Compliant { stiffness, damping } = stop.law {
                self.force[stop.velocity] += stiffness + c1 * damping;
            }
        }
        if !self.tied {
            self.mode
                .held
                .iter()
                .for_each(|held| self.force[self.model.stops[held.side.stop].velocity] = f64::INFINITY);
        }
        &self.force
    }

    /// (3) of all stops (J).
    pub(super) fn potential(&self, q: &[f64]) -> f64 {
        self.compliant()
            .map(|(side, [k, _])| 0.5 * k * self.model.stops[side.stop].depth(side.sign, q).max(0.0).powi(2))
            .sum()
    }

    /// (4) of all stops (W).
    pub(super) fn dissipated(&self, q: &[f64], v: &[f64]) -> f64 {
        let of_side = |(side, [k, d]): (Side, [f64; 2])| {
            let stop = &self.model.stops[side.stop];
            let (p, rate) = (stop.depth(side.sign, q), side.sign * v[stop.velocity]);
            if self.mode.pushing.contains(&side) { d * rate * rate } else { -k * p.max(0.0) * rate }
        };
        self.compliant().map(of_side).sum()
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
