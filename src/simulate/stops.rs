//! Stops of hinge coordinates: what they add to the motion of a system that knows nothing of them.
//!
//! ```text
//! (1)  pushing     τ_i −= side · (k p + d ṗ),  p = side · (q_i − limit);  until it would pull
//! (2)  held        a_i = 0:  a = a₀ + M⁻¹ Hᵀ λ,  (H M⁻¹ Hᵀ) λ = −H a₀;  released where λ would pull
//! (3)  impact      v⁺ = v⁻ + M⁻¹ Hᵀ λ  such that  v_i⁺ = −e v_i⁻
//! ```
//!
//! Which stops push and which hold changes at events alone (`events.rs`): within a step every law is smooth, so that no
//! method has to step over a jump. `M⁻¹` of a unit force is one more right side of the factorization that gave the accelerations. A scene without stops
//! has none of this, and one whose stops are not touched pays a comparison for each.
//!
//! **Beside loops, drives and gears** what a stop holds is a row like theirs, while it is held; (3) is then the projection
//! of velocities, with the speed that comes back as what this row asks for. A stop whose row hangs on theirs and on the
//! stops before it (the second of two fingers that a gear ties) rests with them and bears nothing of its own.

use crate::model::prescribed::Instant;
use crate::model::{Model, Stop, StopLaw};

/// Which end of a stop's range: −1 the low one, 1 the high one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Side {
    /// Index into the model's stops.
    pub(super) stop: usize,
    /// −1 or 1.
    pub(super) sign: f64,
}

/// The stops of a model and what rests on them.
#[derive(Debug)]
pub(super) struct Stops<'m> {
    pub(super) stops: &'m [Stop],
    /// Compliant stops that push.
    pub(super) pushing: Vec<Side>,
    /// Rigid stops that hold their coordinate.
    pub(super) held: Vec<Side>,
    /// Beside loops, drives and gears: which of them have a row of their own. `None` in a tree.
    pub(super) counts: Option<Vec<bool>>,
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

impl<'m> Stops<'m> {
    /// `None` for a model without stops.
    pub(super) fn new(model: &'m Model) -> Option<Self> {
        let n = model.velocity_count();
        (!model.stops.is_empty()).then(|| Self {
            stops: &model.stops,
            pushing: Vec::with_capacity(model.stops.len()),
            held: Vec::with_capacity(model.stops.len()),
            counts: model.is_constrained().then(Vec::new),
            columns: vec![vec![0.0; n]; model.stops.len()],
            matrix: vec![0.0; model.stops.len() * model.stops.len()],
            multipliers: vec![0.0; model.stops.len()],
            force: vec![0.0; n],
        })
    }

    /// (1) of all stops that push.
    pub(super) fn press(&self, q: &[f64], v: &[f64], tau: &mut [f64]) {
        tau.fill(0.0);
        for side in &self.pushing {
            let stop = &self.stops[side.stop];
            tau[stop.velocity] -= side.sign * stop.push(side.sign, q, v);
        }
    }

    /// Corrects the free accelerations of a tree by (2); `solve` is `x ← M⁻¹ rhs`.
    pub(super) fn correct(&mut self, a: &mut [f64], solve: &mut dyn FnMut(&[f64], &mut [f64])) {
        if !self.held.is_empty() && self.counts.is_none() {
            self.hold(a, -1.0, solve);
        }
    }

    /// The coordinates that are held, and where.
    pub(super) fn rows(&self) -> Vec<(usize, Instant)> {
        self.held.iter().map(|side| self.row(*side, 0.0)).collect()
    }

    /// A coordinate on the stop of a side, with this speed.
    pub(super) fn row(&self, side: Side, velocity: f64) -> (usize, Instant) {
        let stop = &self.stops[side.stop];
        (stop.velocity, Instant { position: stop.limit(side.sign), velocity, acceleration: 0.0 })
    }

    /// `x += M⁻¹ Hᵀ λ` such that the held components of `x` are `1 + factor` of what they were; λ is kept.
    fn hold(&mut self, x: &mut [f64], factor: f64, solve: &mut dyn FnMut(&[f64], &mut [f64])) {
        let m = self.held.len();
        for (k, side) in self.held.iter().enumerate() {
            self.force.fill(0.0);
            self.force[self.stops[side.stop].velocity] = 1.0;
            solve(&self.force, &mut self.columns[k]);
        }
        for (row, side) in self.held.iter().enumerate() {
            let i = self.stops[side.stop].velocity;
            self.multipliers[row] = factor * x[i];
            for k in 0..m {
                self.matrix[row * m + k] = self.columns[k][i];
            }
        }
        solve_positive(&mut self.matrix[..m * m], &mut self.multipliers[..m]);
        for k in 0..m {
            let by = self.multipliers[k];
            x.iter_mut().zip(&self.columns[k]).for_each(|(x, column)| *x += by * column);
        }
        if factor == -1.0 {
            for side in &self.held {
                x[self.stops[side.stop].velocity] = 0.0;
            }
        }
    }

    /// (3): the velocities after coordinates hit the stop of a side, held ones staying put. The restitution is 0 for a
    /// coordinate that comes to rest.
    pub(super) fn strike(
        &mut self,
        side: Side,
        restitution: f64,
        v: &mut [f64],
        solve: &mut dyn FnMut(&[f64], &mut [f64]),
    ) {
        let after = -restitution * v[self.stops[side.stop].velocity];
        self.held.push(side);
        self.hold(v, -1.0, solve);
        let m = self.held.len();
        if restitution > 0.0 {
            // The same with what comes back, the held ones still.
            for (row, held) in self.held.iter().enumerate() {
                let i = self.stops[held.stop].velocity;
                self.multipliers[row] = if row + 1 == m { after } else { 0.0 };
                for k in 0..m {
                    self.matrix[row * m + k] = self.columns[k][i];
                }
            }
            solve_positive(&mut self.matrix[..m * m], &mut self.multipliers[..m]);
            for k in 0..m {
                let by = self.multipliers[k];
                v.iter_mut().zip(&self.columns[k]).for_each(|(v, column)| *v += by * column);
            }
        }
        self.held.pop();
    }

    /// What presses on a held stop, of the last corrected accelerations; negative where it would have to pull.
    pub(super) fn pressure(&self, held: usize) -> f64 {
        -self.held[held].sign * self.multipliers[held]
    }

    /// Takes the rows that are held off the force balance of a tree.
    pub(super) fn balance(&self, residual: &mut [f64]) {
        if self.counts.is_none() {
            self.held.iter().for_each(|side| residual[self.stops[side.stop].velocity] = 0.0);
        }
    }

    /// What the stops add to the diagonal of a tangent: infinite where they hold a tree.
    pub(super) fn diagonal(&mut self, c1: f64) -> &[f64] {
        self.force.fill(0.0);
        for side in &self.pushing {
            let stop = &self.stops[side.stop];
            if let StopLaw::Compliant { stiffness, damping } = stop.law {
                self.force[stop.velocity] += stiffness + c1 * damping;
            }
        }
        if self.counts.is_none() {
            self.held.iter().for_each(|side| self.force[self.stops[side.stop].velocity] = f64::INFINITY);
        }
        &self.force
    }

    /// Energy in the springs of stops that push (J).
    pub(super) fn potential(&self, q: &[f64]) -> f64 {
        let of_side = |side: &Side| match self.stops[side.stop].law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { stiffness, .. } => 0.5 * stiffness * self.stops[side.stop].depth(side.sign, q).powi(2),
        };
        self.pushing.iter().map(of_side).sum()
    }

    /// Power that the dampers of stops that push take out (W).
    pub(super) fn dissipated(&self, v: &[f64]) -> f64 {
        let of_side = |side: &Side| match self.stops[side.stop].law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { damping, .. } => damping * v[self.stops[side.stop].velocity].powi(2),
        };
        self.pushing.iter().map(of_side).sum()
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
