//! What follows from one place: a time, positions and velocities.
//!
//! [`System::at`] places a system; what depends on the place is asked of the [`Evaluated`] that it gives, and what depends on
//! more than the place of a borrow that proves that it has been computed: [`Factorized`] of the mass matrix, [`Balanced`] of the
//! force balance. None of them outlives the place, so that nothing can be read of another one.

use super::applied;
use super::{Energies, Fault, Powers, System};
use crate::constraint::{LoopReaction, Rate};
use crate::force::{Act, Force};
use crate::model::motor::Push;
use crate::motion::Motion;
use crate::spatial::link::LinkAcceleration;
use crate::spatial::{Pose, Wrench};
use crate::transfer::mass::MassAction;
use crate::transfer::reduce::Load;

/// A system at one time, position and velocity.
#[derive(Debug)]
pub struct Evaluated<'a> {
    pub(super) system: &'a mut System,
    pub(super) q: &'a [f64],
    pub(super) v: &'a [f64],
}

/// The mass matrix `M(q)` of the tree, factorized.
#[derive(Debug)]
pub struct Factorized<'a> {
    pub(super) system: &'a mut System,
    pub(super) q: &'a [f64],
    pub(super) v: &'a [f64],
}

/// The force balance at one place with given hinge accelerations.
#[derive(Debug)]
pub struct Balanced<'a> {
    pub(super) system: &'a System,
    pub(super) q: &'a [f64],
    pub(super) v: &'a [f64],
}

impl<'a> Evaluated<'a> {
    /// [`Evaluated::accelerations`] for those who go on with the factorization alone.
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`].
    pub(crate) fn into_accelerations(mut self, a: &mut [f64]) -> Result<Factorized<'a>, Fault> {
        self.accelerations(a)?;
        Ok(Factorized { system: self.system, q: self.q, v: self.v })
    }
}

impl Evaluated<'_> {
    /// The system.
    pub fn system(&self) -> &System {
        self.system
    }

    /// Where every link is and how fast it moves.
    pub fn motion(&self) -> &Motion {
        &self.system.motion
    }

    /// Wrenches of the force elements and hinge forces.
    fn gather(&mut self) {
        let System { model, laws, motion, applied, tau, pressed, pressed_hinges, pushes, time, constraints, .. } =
            &mut *self.system;
        if !model.forces.is_empty() || constraints.is_some() || !pressed.is_empty() {
            applied::apply(laws, motion, applied);
        }
        applied.iter_mut().zip(pressed).for_each(|(applied, pressed)| *applied += *pressed);
        applied::hinge::apply(model, self.q, self.v, tau);
        if !pushes.is_empty() {
            applied::motor::pushes(model, laws, *time, self.q, self.v, pushes);
            applied::motor::apply(model, pushes, tau);
        }
        laws.phase.apply(model, self.q, self.v, tau);
        tau.iter_mut().zip(pressed_hinges).for_each(|(tau, pressed)| *tau += *pressed);
    }

    /// `a ← q̈(t, q, v)`, in O(n); with the factorization that gave it.
    ///
    /// # Errors
    /// A singular hinge, or the element whose numbers are not finite.
    pub fn accelerations(&mut self, a: &mut [f64]) -> Result<Factorized<'_>, Fault> {
        self.of_tree(a)?;
        if self.system.constraints.is_some() {
            self.constrain(a);
            self.system.check_finite("the acceleration", a, self.q, self.v)?;
        }
        Ok(Factorized { system: self.system, q: self.q, v: self.v })
    }

    /// [`Evaluated::accelerations`] for those who need no factorization: where many loops of one tree are short, in a time proportional
    /// to its size.
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`].
    pub fn accelerations_alone(&mut self, a: &mut [f64]) -> Result<(), Fault> {
        self.of_tree(a)?;
        if self.system.constraints.is_some() {
            if !self.constrain_by_loops(a) {
                self.constrain(a);
            }
            self.system.check_finite("the acceleration", a, self.q, self.v)?;
        }
        Ok(())
    }

    /// The inertia that each velocity coordinate sees while everything outboard moves freely (kg, kg m²), whatever loops, drives and
    /// gears hold.
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`].
    pub fn articulated_inertia(&mut self, out: &mut [f64]) -> Result<(), Fault> {
        self.of_tree(out)?;
        self.system.reduction.articulated_inertia(&self.system.model, &self.system.motion, out);
        Ok(())
    }

    /// The accelerations without loops, drives and gears.
    fn of_tree(&mut self, a: &mut [f64]) -> Result<(), Fault> {
        self.gather();
        let System { model, motion, reduction, applied, tau, pressed, .. } = &mut *self.system;
        let applied = if model.forces.is_empty() && pressed.is_empty() { &[] } else { applied.as_slice() };
        if let Err(singular) = reduction.accelerations(model, motion, &Load { applied, tau }, a) {
            return Err(self.system.singular(&singular, self.q, self.v));
        }
        self.system.check_finite("the acceleration", a, self.q, self.v)
    }

    /// The factorization that [`Evaluated::accelerations`] has left; for what has asked for them at this place.
    pub(super) fn factorized(&mut self) -> Factorized<'_> {
        Factorized { system: self.system, q: self.q, v: self.v }
    }

    /// `residual ← M(q) a + b(q, v) − τ(t, q, v)` with the multipliers that are in the system, in O(n).
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn residual(&mut self, a: &[f64], residual: &mut [f64]) -> Result<Balanced<'_>, Fault> {
        self.gather();
        if self.system.constraints.is_some() {
            self.apply_multipliers();
        }
        let System { model, motion, balance, applied, tau, .. } = &mut *self.system;
        balance.update(model, motion, applied, tau, a, residual);
        self.system.check_finite("the force balance", residual, self.q, self.v)?;
        Ok(Balanced { system: self.system, q: self.q, v: self.v })
    }

    /// The residual for what needs the balance alone: reactions, tangents.
    pub(super) fn balance(&mut self, a: &[f64]) -> Result<(), Fault> {
        let mut residual = std::mem::take(&mut self.system.scratch);
        let evaluated = self.residual(a, &mut residual).map(|_| ());
        self.system.scratch = residual;
        evaluated
    }

    /// `product ← M x`, in O(n).
    pub fn mass_times(&self, action: &mut MassAction, x: &[f64], product: &mut [f64]) {
        self.system.mass_times(action, x, product);
    }

    /// Kinetic and potential energy.
    pub fn energies(&self) -> Energies {
        let v = self.v;
        let rotors: f64 = self.system.model.coordinates.iter().zip(v).map(|(c, v)| 0.5 * c.armature * v * v).sum();
        // What drives add to armatures is no inertia of the scene.
        let added =
            self.system.model.drives.iter().map(|drive| 0.5 * drive.armature * v[drive.coordinate.velocity].powi(2));
        Energies {
            kinetic: self.system.motion.kinetic_energy(&self.system.model) + (rotors - added.sum::<f64>()),
            potential: applied::potential(&self.system.model, &self.system.laws, &self.system.motion, self.q),
        }
    }

    /// Energies as a search for rest sees them: with the potential of motors and of loads over time as they are, whose energy is work in a run.
    pub fn energies_at_rest(&self) -> Energies {
        let mut energies = self.energies();
        let System { laws, motion, .. } = &*self.system;
        energies.potential += laws.forces.iter().map(|force| force.law.potential_at_rest(&motion.links)).sum::<f64>();
        energies.potential += applied::motor::potential_at_rest(&self.system.model, self.q);
        energies
    }

    /// The motors and what each pushes with (N or N m).
    pub fn motor_forces(&mut self) -> impl Iterator<Item = (&str, f64)> {
        let System { model, laws, time, pushes, .. } = &mut *self.system;
        applied::motor::pushes(model, laws, *time, self.q, self.v, pushes);
        model.motors.iter().zip(pushes).map(|(motor, push)| (motor.name.as_str(), push.force))
    }

    /// The ropes and curves and what each pulls with (N).
    pub fn pulls(&self) -> impl Iterator<Item = (&str, f64)> {
        let told = self.system.laws.forces.iter().filter(|force| force.law.pull_name().is_some());
        told.map(|force| (force.name.as_str(), force.law.pull(&self.system.motion.links)))
    }

    /// Powers that no potential stands for.
    pub fn powers(&mut self) -> Powers {
        let driven = if self.system.model.drives.is_empty() { 0.0 } else { self.drive_power() };
        self.system.powers(self.q, self.v, driven)
    }

    /// Poses of the named bodies' root markers: `world_from_body`.
    pub fn poses(&self, out: &mut Vec<Pose>) {
        out.clear();
        out.extend(self.system.model.bodies.iter().map(|body| self.system.motion.body_pose(body)));
    }
}

impl System {
    /// Powers at the place where the system is, with what drives put in (W).
    fn powers(&self, q: &[f64], v: &[f64], driven: f64) -> Powers {
        let Self { model, laws, motion, time, .. } = self;
        Powers {
            input: applied::input(model, laws, motion, *time, q, v) + driven - model.burnt(*time, &motion.links),
            dissipated: applied::dissipated(model, laws, motion, v),
        }
    }
}

impl Balanced<'_> {
    /// Powers that no potential stands for, drives pushing with the multipliers of the balance; its hinge accelerations.
    pub fn powers(&self, accelerations: &[f64]) -> Powers {
        let model = &self.system.model;
        let pushes = self.system.constraints().into_iter().flat_map(|rows| rows.drive_pushes(model, accelerations));
        let driven = model.drives.iter().zip(pushes).map(|(drive, push)| push * self.v[drive.coordinate.velocity]);
        self.system.powers(self.q, self.v, driven.sum())
    }

    /// The system.
    pub fn system(&self) -> &System {
        self.system
    }

    /// The time (s).
    pub fn time(&self) -> f64 {
        self.system.time
    }

    /// Hinge coordinates.
    pub fn position(&self) -> &[f64] {
        self.q
    }

    /// Hinge velocities.
    pub fn velocity(&self) -> &[f64] {
        self.v
    }

    /// Where every link is and how fast it moves.
    pub fn motion(&self) -> &Motion {
        &self.system.motion
    }

    /// Accelerations of the links' root markers, for the hinge accelerations of the balance.
    pub fn link_accelerations(&self) -> &[LinkAcceleration] {
        &self.system.balance.accelerations
    }

    /// What motors and curves push with, in the order of [`Model::pushed`](crate::model::Model::pushed).
    pub fn pushes(&self) -> &[Push] {
        &self.system.pushes
    }

    /// The force elements, as a run keeps them.
    pub fn forces(&self) -> &[Force] {
        &self.system.laws.forces
    }

    /// What the loops pass, with the multipliers of the balance; empty without loops.
    pub fn loop_reactions(&self) -> Vec<LoopReaction> {
        let rows = self.system.constraints();
        rows.map_or(Vec::new(), |rows| rows.loop_reactions(&self.system.model, &self.system.motion))
    }
}

impl Factorized<'_> {
    /// The system.
    pub fn system(&self) -> &System {
        self.system
    }

    /// Where every link is and how fast it moves.
    pub fn motion(&self) -> &Motion {
        &self.system.motion
    }

    /// Adds to what contacts push a link with, at its root marker, in evaluations to come.
    pub(crate) fn press(&mut self, link: usize, wrench: Wrench) {
        self.system.pressed[link] += wrench;
    }

    /// Adds a force in a velocity coordinate (N or N m) to what contacts push with.
    pub(crate) fn press_hinge(&mut self, velocity: usize, force: f64) {
        self.system.pressed_hinges[velocity] += force;
    }

    /// `x ← M⁻¹ rhs`.
    pub fn solve_mass(&mut self, rhs: &[f64], x: &mut [f64]) {
        let System { model, motion, reduction, .. } = &mut *self.system;
        reduction.solve(model, motion, &Load { applied: &[], tau: rhs }, x);
    }

    /// The inertia that each velocity coordinate sees while everything outboard moves freely (kg, kg m²).
    pub fn articulated_inertia(&self, out: &mut [f64]) {
        self.system.reduction.articulated_inertia(&self.system.model, &self.system.motion, out);
    }

    /// `change ← (M⁻¹ − M⁻¹ Gᵀ A⁻¹ G M⁻¹) impulse`: how velocities answer an impulse with loops, drives and gears.
    pub fn answer_impulse(&mut self, impulse: &[f64], change: &mut [f64]) {
        self.solve_mass(impulse, change);
        let System { model, motion, constraints, .. } = &mut *self.system;
        let Some(constrained) = constraints else { return };
        motion.update(model, self.q, change);
        constrained.rows.solve(motion, Rate::Change(change));
        motion.update(model, self.q, self.v);
        self.system.push();
        if let Some(constrained) = &self.system.constraints {
            change.iter_mut().zip(&constrained.step).for_each(|(change, step)| *change += step);
        }
    }
}
