//! Dynamic relaxation: the baseline that follows a motion until it has come to rest.
//!
//! The tree's own equations without velocity terms and dampers, `v̇ = q̈(q, 0) = M(q)⁻¹ f(q)`, are stepped by the
//! explicit leapfrog
//!
//! ```text
//! v ← v + h q̈(q, 0),     q ← q ⊞ h v
//! ```
//!
//! with kinetic damping (Cundall 1976, Barnes 1999): the motion is undamped until the power `fᵀ v` becomes negative,
//! which is where the kinetic energy has passed its peak; there `q` goes back to the peak, between the last two places,
//! and starts again from rest.
//!
//! Stability rule: `h` is [`SAFETY`] of the limit `2/ω` of the leapfrog, `ω²` being the largest eigenvalue of
//! `−∂q̈/∂q` by power iteration on differences of accelerations, at the start and whenever the motion starts again. A
//! period at the end of which the potential has risen is done again with half the step.
//!
//! With loops, drives and gears the accelerations are those that their rows allow, velocities are kept in agreement with
//! the rows, and positions are closed after every step. Locks are held by rows too.

use crate::dynamics::{Fault, RowSelection, System};
use crate::round_off::ENERGY;
use crate::statics::effort::Iteration;
use crate::statics::problem::place::Place;
use crate::statics::problem::{FAR, Landscape};
use std::sync::Arc;

/// Part of the stability limit that a step takes.
const SAFETY: f64 = 0.85;
/// Time steps of the method on its own.
pub(in crate::statics) const MOST_STEPS: usize = 400_000;
/// Largest change of an angle in one step (rad).
const LARGEST_TURN: f64 = 0.2;
/// Power iterations at the start, and at each new start of the motion.
const FIRST_POWERS: usize = 10;
const POWERS: usize = 2;
/// Angle (or part of the scene's length) over which accelerations are differenced.
const DIFFERENCE: f64 = 1e-6;
/// Inertia added to a locked coordinate, in units of what it sees: it stays where it is.
const HELD: f64 = 1e7;
/// How the relaxation ended.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Outcome {
    pub place: Place,
    /// Time steps.
    pub steps: usize,
    /// Accelerations computed.
    pub accelerations: usize,
    /// Why it gave up.
    pub note: Option<&'static str>,
}

/// Runs from `place` for at most so many time steps; the answer is balanced or where it gave up.
pub(in crate::statics) fn run(
    landscape: &mut Landscape<'_>,
    place: Place,
    most_steps: usize,
    history: &mut Vec<Iteration>,
) -> Result<Outcome, Fault> {
    let system = held(landscape, &place.q)?;
    let mut motion = Motion::new(landscape, system, place)?;
    motion.most_steps = most_steps;
    let note = motion.relax(history)?;
    let Motion { place, steps, accelerations, .. } = motion;
    Ok(Outcome { place, steps, accelerations, note })
}

/// The system with locked coordinates held: in a tree they are too heavy to move, as masses do not change where the forces
/// balance; with loops, drives and gears they have rows, and drives stand or go on at their steady rate.
fn held(landscape: &mut Landscape<'_>, q: &[f64]) -> Result<System, Fault> {
    let model = landscape.model();
    if model.is_constrained() {
        return Ok(System::with_rows(model, &RowSelection::standing(model, q, &landscape.steady), 0.0, q));
    }
    let model = Arc::clone(model);
    let mut inertia = vec![0.0; model.velocity_count()];
    let (rest, mut accelerations) = (inertia.clone(), inertia.clone());
    landscape.system().at(0.0, q, &rest).accelerations(&mut accelerations)?.articulated_inertia(&mut inertia);
    inertia.iter_mut().for_each(|inertia| *inertia *= HELD);
    Ok(System::new(&model.with_heavier_locks(&inertia)))
}

struct Motion<'l, 's> {
    landscape: &'l mut Landscape<'s>,
    system: System,
    place: Place,
    /// Free coordinates that are angles.
    turns: Vec<bool>,
    /// One radian, or one length of the scene, per free coordinate.
    unit: Vec<f64>,
    /// What the power iteration has found so far.
    fastest: Vec<f64>,
    step: f64,
    steps: usize,
    most_steps: usize,
    accelerations: usize,
    /// Velocities about which it moves: those of a steady motion, else zero.
    steady: Vec<f64>,
    rest: Vec<f64>,
    full: Vec<f64>,
}

/// How one motion from rest ended.
enum End {
    /// At the peak of its kinetic energy, there.
    Peak(Vec<f64>),
    /// It never slowed down.
    Fell,
    /// The steps were used up.
    Exhausted,
}

impl<'l, 's> Motion<'l, 's> {
    fn new(landscape: &'l mut Landscape<'s>, system: System, place: Place) -> Result<Self, Fault> {
        let slides = crate::statics::problem::slides(system.model());
        let length = system.model().length_scale();
        let turns: Vec<bool> = landscape.free.iter().map(|i| !slides[*i]).collect();
        let unit: Vec<f64> = turns.iter().map(|turn| if *turn { 1.0 } else { length }).collect();
        // Neighbours in opposite directions, no two alike: nearly every mode takes part, the fastest ones most.
        let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let fastest = unit.iter().enumerate().map(|(i, unit)| sign(i) * unit / (1.0 + 0.1 * (i % 7) as f64)).collect();
        let rest = vec![0.0; system.model().velocity_count()];
        let (full, steady) = (rest.clone(), landscape.steady.clone());
        let (step, steps, most_steps, accelerations) = (f64::INFINITY, 0, MOST_STEPS, 0);
        let known = place.is_balanced();
        let mut motion = Self {
            landscape,
            system,
            place,
            turns,
            unit,
            fastest,
            step,
            steps,
            most_steps,
            accelerations,
            steady,
            rest,
            full,
        };
        if !known {
            motion.step = motion.stable_step(FIRST_POWERS)?;
        }
        Ok(motion)
    }

    /// Motions from rest until balanced; else why not.
    fn relax(&mut self, history: &mut Vec<Iteration>) -> Result<Option<&'static str>, Fault> {
        let mut highest = self.landscape.potential(&self.place.q).abs();
        while !self.place.is_balanced() {
            let before = self.landscape.potential(&self.place.q);
            let q = match self.motion()? {
                End::Peak(q) => q,
                End::Fell => {
                    return Ok(Some("the motion never slows down: there is no equilibrium downhill of the guess"));
                }
                End::Exhausted => return Ok(Some("the motion has not come to rest within the steps that are allowed")),
            };
            let after = self.landscape.potential(&q);
            highest = highest.max(after.abs());
            if self.landscape.conservative && !(after <= before + ENERGY.of(highest)) {
                self.step *= 0.5;
                continue;
            }
            let moved = q.iter().zip(&self.place.q).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            self.place = Place::at(self.landscape, q)?;
            let residual = self.place.residual().0;
            history.push(Iteration { stage: "relaxation", residual, step: moved, shift: 0.0 });
            self.step = self.stable_step(POWERS)?;
        }
        Ok(None)
    }

    /// One motion from rest at `place`.
    fn motion(&mut self) -> Result<End, Fault> {
        let mut q = self.place.q.clone();
        let mut force = if self.system.model().is_constrained() { self.pull(&q)? } else { self.place.force.clone() };
        let mut velocity = vec![0.0; force.len()];
        let (mut travelled, mut part) = (0.0, 0.5);
        while self.steps < self.most_steps && self.landscape.goes_on() {
            self.steps += 1;
            let a = self.acceleration(&q)?;
            for (v, a) in velocity.iter_mut().zip(&a) {
                *v += part * self.step * a;
            }
            part = 1.0;
            self.limit(&mut velocity);
            let by: Vec<f64> = velocity.iter().map(|v| self.step * v).collect();
            let next = self.landscape.moved(&q, &by);
            if next.iter().any(|x| !x.is_finite()) {
                // The loops do not close there: from here again, from rest.
                return Ok(End::Peak(q));
            }
            let pull = self.pull(&next)?;
            self.keep_rows(&next, &mut velocity);
            let power = |force: &[f64]| force.iter().zip(&by).map(|(f, x)| f * x).sum::<f64>();
            let (before, after) = (power(&force), power(&pull));
            if after <= 0.0 {
                let to_peak: Vec<f64> = by.iter().map(|x| x * before / (before - after)).collect();
                let peak = self.landscape.moved(&q, &to_peak);
                return Ok(End::Peak(if peak.iter().all(|x| x.is_finite()) { peak } else { q }));
            }
            travelled += by.iter().zip(&self.unit).map(|(x, unit)| (x / unit).abs()).fold(0.0, f64::max);
            if travelled > FAR {
                return Ok(End::Fell);
            }
            (q, force) = (next, pull);
        }
        Ok(End::Exhausted)
    }

    /// Slows all down where a step would turn a hinge too far.
    fn limit(&self, velocity: &mut [f64]) {
        let fast =
            velocity.iter().zip(&self.turns).filter(|(_, turn)| **turn).map(|(v, _)| v.abs()).fold(0.0, f64::max);
        let most = LARGEST_TURN / self.step;
        if fast > most {
            velocity.iter_mut().for_each(|v| *v *= most / fast);
        }
    }

    /// Forces of the free coordinates, rows and all.
    fn pull(&mut self, q: &[f64]) -> Result<Vec<f64>, Fault> {
        if !self.system.model().is_constrained() {
            return self.landscape.force(q);
        }
        self.acceleration(q)?;
        self.system.at(0.0, q, &self.steady).residual(&self.rest, &mut self.full)?;
        Ok(self.landscape.free.iter().map(|i| -self.full[*i]).collect())
    }

    /// The part of the velocities that agrees with the rows.
    fn keep_rows(&mut self, q: &[f64], velocity: &mut [f64]) {
        if !self.system.model().is_constrained() {
            return;
        }
        self.full.copy_from_slice(&self.steady);
        for (i, v) in self.landscape.free.iter().zip(velocity.iter()) {
            self.full[*i] += v;
        }
        let mut q = q.to_vec();
        if self.system.settle(0.0, &mut q, &mut self.full).is_ok() {
            let moving = self.landscape.free.iter().map(|i| self.full[*i] - self.steady[*i]);
            velocity.iter_mut().zip(moving).for_each(|(v, moving)| *v = moving);
        }
    }

    /// Accelerations of the free coordinates at rest.
    fn acceleration(&mut self, q: &[f64]) -> Result<Vec<f64>, Fault> {
        self.accelerations += 1;
        let tied = self.system.model().is_constrained();
        let mut at = self.system.at(0.0, q, &self.steady);
        let mut mass = at.accelerations(&mut self.full)?;
        if tied {
            return Ok(self.landscape.free.iter().map(|i| self.full[*i]).collect());
        }
        if self.landscape.free.len() < self.rest.len() {
            // The force that a lock holds is not among those that move the others, however heavy it is.
            let mut force = self.rest.clone();
            for (i, value) in self.landscape.free.clone().into_iter().zip(self.landscape.force(q)?) {
                force[i] = value;
            }
            mass.solve_mass(&force, &mut self.full);
        }
        Ok(self.landscape.free.iter().map(|i| self.full[*i]).collect())
    }

    /// The step that the stability rule gives at `place`.
    fn stable_step(&mut self, powers: usize) -> Result<f64, Fault> {
        let q = self.place.q.clone();
        let here = self.acceleration(&q)?;
        let mut largest = 0.0;
        for _ in 0..powers {
            let size = self.fastest.iter().zip(&self.unit).map(|(x, unit)| (x / unit).abs()).fold(0.0, f64::max);
            let by: Vec<f64> = self.fastest.iter().map(|x| DIFFERENCE * x / size).collect();
            let there = self.landscape.moved(&q, &by);
            let change: Vec<f64> = self.acceleration(&there)?.iter().zip(&here).map(|(a, b)| b - a).collect();
            largest = self.landscape.size(&change) / self.landscape.size(&by);
            if !(largest > 0.0) {
                break;
            }
            self.fastest = change;
        }
        let slowest = self.landscape.model().time_scale();
        Ok((SAFETY * 2.0 / largest.sqrt()).min(slowest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::description::{BodyDescription, HingeDescription};
    use crate::model::{Description, Model};

    /// Rods of 0.1 kg and 0.1 m, each bent by a fifth of a radian against the one before.
    fn chain(links: usize) -> Arc<Model> {
        let rod = |index: usize| {
            let hinge = HingeDescription::revolute([0.0, 1.0, 0.0]).position([0.2]);
            let hinge = if index > 0 { hinge.on(&format!("rod{}", index - 1), [0.1, 0.0, 0.0]) } else { hinge };
            let rod = BodyDescription::new(&format!("rod{index}"), hinge);
            rod.mass(0.1).center([0.05, 0.0, 0.0]).inertia([1e-6, 8.4e-5, 8.4e-5])
        };
        let bodies = (0..links).map(rod).collect();
        Model::build(&Description { bodies, ..Description::default() }).expect("a chain")
    }

    #[test]
    fn the_potential_never_rises_from_one_rest_to_the_next() {
        let model = chain(12);
        let mut system = System::new(&model);
        let mut landscape = Landscape::new(&mut system, &model.start_position).expect("a landscape");
        let place = Place::at(&mut landscape, model.start_position.clone()).expect("a place");
        let mut motion = Motion::new(&mut landscape, System::new(&model), place).expect("a motion");
        let mut potential = motion.landscape.potential(&motion.place.q);
        let (first, mut periods) = (potential, 0);
        while !motion.place.is_balanced() {
            let End::Peak(q) = motion.motion().expect("a motion") else { panic!("no peak") };
            motion.place = Place::at(motion.landscape, q).expect("a place");
            let next = motion.landscape.potential(&motion.place.q);
            // Rounding of a sum of twelve weights.
            assert!(next <= potential + 1e-14 * first.abs().max(next.abs()), "{potential} to {next}");
            potential = next;
            periods += 1;
        }
        assert!(periods > 3, "{periods}");
        // All the way down: 12 rods, the centre of the k-th at 0.05 + 0.1 k below the wall.
        let lowest: f64 = (0..12).map(|k| -0.1 * 9.80665 * (0.05 + 0.1 * f64::from(k))).sum();
        assert!((potential - lowest).abs() < 1e-12, "{potential} instead of {lowest}");
    }
}
