//! How a run passes singular positions of its loops: change points, where all bars of a linkage lie in one line.
//!
//! Let `c` be the clearance, the sine of the smallest angle between a row and those before it: 0 in the singular position
//! itself. The motion goes on smoothly there, the numbers do not:
//!
//! - A state that is off the loops by `e` gets accelerations that are off by `e / c²`, and stages of a method are off by
//!   more than their steps' errors. So where `c` is small ([`NEAR`]) accelerations are taken from the settled state: that
//!   is the same system on the loops, and as smooth beside them as the motion itself.
//! - A settled state is off by `ε / c`, its accelerations by `ε / c²`, ε the rounding. So where `c` is smaller still
//!   ([`WITHIN`]) they are interpolated between states before and beyond,
//!
//! ```text
//! a(q, v) ≈ Σ w_k a(q_k, v_k),    q_k = settled(q ⊞ k τ v),  v_k = settled(v),    k = ±1 … ±4
//! ```
//!
//!   the polynomial of degree 7 through eight points along the motion, at its middle. τ is such that all of them are clear.
//! - A step that ends within [`TOUCHING`] is not settled: the rounding would come back amplified, and the next one is.

use crate::dynamics::{Fault, Settled, System};
use crate::model::Model;

/// Nearer than this part of the widest clearance met is near.
pub(super) const NEAR: f64 = 0.4;
/// Nearer than this part, accelerations are interpolated: there `ε / c²` is about 1e-12.
const WITHIN: f64 = 0.01;
/// Nearer than this part, nothing is settled.
const TOUCHING: f64 = 1e-4;
/// Weights of the points at ±1, ±2, ±3, ±4.
const WEIGHTS: [f64; 4] = [0.8, -0.4, 4.0 / 35.0, -1.0 / 70.0];
/// The farthest point is not farther along the motion (rad, or the scene's length).
const FARTHEST: f64 = 0.4;
/// What comes back to within this part of where it was put has not moved along: a drive holds it.
const HELD: f64 = 0.1;

/// Where a run stands with respect to singular positions, and memory to look around.
pub(super) struct Passage {
    /// Clearance at the end of the last step.
    clearance: f64,
    /// The widest one met.
    widest: f64,
    /// Sizes of the velocity coordinates: 1 rad, the scene's length.
    sizes: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    step: Vec<f64>,
    acceleration: Vec<f64>,
    multipliers: Vec<f64>,
}

/// What a look finds.
struct Seen {
    clearance: f64,
    /// How far the settled state is from where the motion is now, in parts of how far along it was put.
    moved: f64,
}

impl Passage {
    /// Looks how clear the start is and the positions around it, along the motion.
    pub(super) fn new(model: &Model, system: &mut System, sizes: Vec<f64>) -> Self {
        let mut passage = Self {
            clearance: 0.0,
            widest: f64::MIN_POSITIVE,
            sizes,
            position: model.start_position.clone(),
            velocity: model.start_velocity.clone(),
            step: vec![0.0; model.velocity_count()],
            acceleration: vec![0.0; model.velocity_count()],
            multipliers: vec![0.0; system.constraint_rank()],
        };
        passage.start(system, 0.0, &model.start_position, &model.start_velocity);
        passage
    }

    /// Looks anew from a state: the rows are others than before.
    pub(super) fn start(&mut self, system: &mut System, time: f64, q: &[f64], v: &[f64]) {
        self.multipliers.resize(system.constraint_rank(), 0.0);
        self.clearance = self.look(system, time, (q, v), 0.0).map_or(0.0, |seen| seen.clearance);
        self.widest = self.clearance.max(f64::MIN_POSITIVE);
        let fastest = self.fastest(v);
        for along in [-0.2, -0.05, 0.05, 0.2] {
            let there = if fastest > 0.0 { self.look(system, time, (q, v), along / fastest) } else { None };
            self.widest = self.widest.max(there.map_or(0.0, |seen| seen.clearance));
        }
    }

    /// Whether the last step ended near a singular position.
    pub(super) fn is_near(&self) -> bool {
        self.clearance < NEAR * self.widest
    }

    /// Rows with a smaller clearance do not hold the tangent of an implicit stage.
    pub(super) fn weak(&self) -> f64 {
        NEAR * self.widest
    }

    /// `a ← q̈` near a singular position.
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`](crate::dynamics::Evaluated::accelerations).
    pub(super) fn accelerations(
        &mut self,
        system: &mut System,
        time: f64,
        q: &[f64],
        v: &[f64],
        a: &mut [f64],
    ) -> Result<(), Fault> {
        let here = self.look(system, time, (q, v), 0.0);
        let within = here.as_ref().is_some_and(|seen| seen.clearance < WITHIN * self.widest);
        if within && self.interpolate(system, time, q, v, a) {
            return Ok(());
        }
        if within || here.is_none() {
            return system.at(time, q, v).accelerations(a).map(|_| ());
        }
        self.look(system, time, (q, v), 0.0);
        system.at(time, &self.position, &self.velocity).accelerations(a).map(|_| ())
    }

    /// The interpolation; false if the points around are not clear.
    fn interpolate(&mut self, system: &mut System, time: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
        let fastest = self.fastest(v);
        // The nearest points first: how far one has to go depends on how fast the clearance grows.
        let mut along = 2.0 * WITHIN * self.widest;
        let clear = WITHIN * self.widest;
        while along * WEIGHTS.len() as f64 <= FARTHEST {
            let sides = [-1.0, 1.0].map(|sign| self.look(system, time, (q, v), sign * along / fastest));
            if sides.iter().all(|side| side.as_ref().is_some_and(|seen| seen.clearance >= clear)) {
                return self.sum(system, time, (q, v), along / fastest, a);
            }
            // The dead centre of a drive is passed by no motion: at this time there is none.
            if sides.iter().flatten().all(|seen| seen.moved < HELD) {
                return false;
            }
            along *= 2.0;
        }
        false
    }

    /// The sum; that of the multipliers is left in the system, to go with it.
    fn sum(&mut self, system: &mut System, time: f64, (q, v): (&[f64], &[f64]), tau: f64, a: &mut [f64]) -> bool {
        a.fill(0.0);
        self.multipliers.fill(0.0);
        for (k, weight) in WEIGHTS.iter().enumerate() {
            for sign in [-1.0, 1.0] {
                let clear = self.look(system, time, (q, v), sign * (k + 1) as f64 * tau).is_some();
                let Self { position, velocity, acceleration, multipliers, .. } = self;
                if !clear {
                    return false;
                }
                let Ok(mass) = system.at(time, position, velocity).into_accelerations(acceleration) else {
                    return false;
                };
                mass.add_multipliers(*weight, multipliers);
                a.iter_mut().zip(&*acceleration).for_each(|(a, there)| *a += weight * there);
            }
        }
        system.set_multipliers(&self.multipliers);
        true
    }

    /// Settles the state that lies `along` (s) further on the motion into the scratch state; `None` if it cannot be settled.
    fn look(&mut self, system: &mut System, time: f64, (q, v): (&[f64], &[f64]), along: f64) -> Option<Seen> {
        let Self { position, velocity, step, .. } = self;
        position.copy_from_slice(q);
        velocity.copy_from_slice(v);
        if along != 0.0 {
            step.iter_mut().zip(v).for_each(|(step, v)| *step = along * v);
            System::displace(system.model(), position, step);
        }
        let away = |position: &[f64]| {
            position.iter().zip(q).fold(0.0_f64, |most, (there, here)| most.max((there - here).abs()))
        };
        let put = away(position);
        let settled = system.settle(time, position, velocity).ok()?;
        let moved = if put > 0.0 { away(position) / put } else { 0.0 };
        Some(Seen { clearance: settled.clearance, moved })
    }

    /// The fastest coordinate (1/s).
    fn fastest(&self, v: &[f64]) -> f64 {
        v.iter().zip(&self.sizes).fold(0.0, |m, (v, size)| m.max(v.abs() / size))
    }

    /// Settles a state, unless it touches a singular position.
    ///
    /// # Errors
    /// As [`System::settle`].
    pub(super) fn settle(
        &mut self,
        system: &mut System,
        time: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<Settled, Fault> {
        let Self { position, velocity, .. } = self;
        position.copy_from_slice(q);
        velocity.copy_from_slice(v);
        let settled = system.settle(time, position, velocity)?;
        if settled.clearance < TOUCHING * self.widest {
            return Ok(Settled { moved: false, gap: settled.gap_before, ..settled });
        }
        q.copy_from_slice(position);
        v.copy_from_slice(velocity);
        Ok(settled)
    }

    /// Takes note of the end of a step.
    pub(super) fn advance(&mut self, settled: &Settled) {
        self.clearance = settled.clearance;
        self.widest = self.widest.max(settled.clearance);
    }
}
