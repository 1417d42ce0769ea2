//! A model with its forces: accelerations, residuals, their derivatives and energies of a state. The only place where
//! [`applied`] forces and `transfer` meet.

pub mod applied;
mod border;
mod boundaries;
mod constrained;
mod dense;
mod jacobian;
mod linearize;
mod magnitudes;
mod tangent;

pub use constrained::Settled;
pub use dense::{Dense, DenseTangent};
pub use jacobian::AccelerationJacobians;
pub use linearize::Linearization;
pub use magnitudes::Magnitudes;
pub use tangent::{Coefficients, TangentSolver};

use crate::force::Act;
use crate::model::Model;
use crate::model::motor::Push;
use crate::motion::Motion;
use crate::spatial::{Pose, Wrench};
use crate::transfer::balance::Balance;
pub use crate::transfer::mass::MassAction;
use crate::transfer::reduce::{Load, Reduction, Singular};
use crate::transfer::variation::Variation;
pub use applied::Boundary;
use applied::Laws;
use constrained::Constrained;
use nalgebra::Vector3;
use std::sync::Arc;

/// A model and the scratch memory to evaluate it. States come in from outside; nothing of them is kept but the last
/// sweep.
#[derive(Debug, Clone)]
pub struct System {
    model: Arc<Model>,
    /// What pushes, as the model has it or as a run keeps it.
    laws: Laws,
    /// Positions and velocities of the last evaluation.
    motion: Motion,
    reduction: Reduction,
    balance: Balance,
    variation: Variation,
    /// Wrenches of the force elements, one per link.
    applied: Vec<Wrench>,
    /// Hinge forces, and scratch of the same length.
    tau: Vec<f64>,
    scratch: Vec<f64>,
    /// Hinge forces from outside of the model; empty where none can come.
    outside: Vec<f64>,
    /// What motors and curves push with, of the last evaluation, in the order of [`Model::pushed`].
    pushes: Vec<Push>,
    /// The time at which drives and motors are looked at (s).
    time: f64,
    /// Loops, drives and gears, where there are any.
    constraints: Option<Box<Constrained>>,
}

/// Why a system could not be evaluated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// A hinge that nothing with inertia resists.
    #[error(
        "the hinge of `{body}` has no inertia to accelerate in this position: pivot {pivot} (a point mass on its own axis, which needs `inertia`, or a gimbal lock?)"
    )]
    Singular {
        /// Body.
        body: String,
        /// (kg or kg m²)
        pivot: f64,
    },
    /// A loop that opens, or a drive or gear that cannot be followed.
    #[error(
        "{element} cannot be closed: a gap of {gap:.3e} m remains (a position that cannot be reached or where the mechanism is singular)"
    )]
    Open {
        /// Which.
        element: String,
        /// (m; rad times the scene's length)
        gap: f64,
    },
    /// A row that followed from others at the start and no longer does.
    #[error(
        "{element} opens by {gap:.3e} m in a condition that followed from others at the start: the mechanism has fewer ways to move here (axes or points given with few digits, or of a special start?)"
    )]
    Independent {
        /// Which.
        element: String,
        /// (m; rad times the scene's length)
        gap: f64,
    },
    /// Something that knows trees only.
    #[error("`{method}` knows no loops, drives or gears yet")]
    Tied {
        /// Its name.
        method: &'static str,
    },
    /// A formula of a drive or motor without a finite value or derivative.
    #[error("the formula `{text}` of {element} has no finite value or derivative at t = {time} s")]
    Formula {
        /// Which.
        element: String,
        /// The formula, as written.
        text: String,
        /// (s)
        time: f64,
    },
    /// A number that is not finite.
    #[error("{what} of `{element}` is not a finite number")]
    NotFinite {
        /// Which number.
        what: &'static str,
        /// Body or force element.
        element: String,
    },
}

/// Kinetic and potential energy (J).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// Kinetic, armatures included.
    pub kinetic: f64,
    /// Gravity, springs, and loads and motors that have a potential.
    pub potential: f64,
}

/// Powers without a potential (W).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Powers {
    /// Put in by loads and motors.
    pub input: f64,
    /// Taken out by dampers, ≥ 0.
    pub dissipated: f64,
}

impl System {
    /// Scratch memory for a model.
    pub fn new(model: &Arc<Model>) -> Self {
        let n = model.links.len();
        Self {
            model: Arc::clone(model),
            laws: Laws::new(model),
            motion: Motion::new(model),
            reduction: Reduction::new(model),
            balance: Balance::new(model),
            variation: Variation::new(model),
            applied: vec![Wrench::ZERO; n],
            tau: vec![0.0; model.velocity_count()],
            scratch: vec![0.0; model.velocity_count()],
            outside: vec![0.0; if model.stops.is_empty() { 0 } else { model.velocity_count() }],
            pushes: vec![Push::default(); model.pushed().count()],
            time: 0.0,
            constraints: Constrained::new(model),
        }
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Positions and velocities of the last evaluation.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Positions, velocities and forces; no accelerations.
    fn prepare(&mut self, q: &[f64], v: &[f64]) {
        self.motion.update(&self.model, q, v);
        if !self.model.forces.is_empty() || self.constraints.is_some() {
            applied::apply(&self.laws, &self.motion, &mut self.applied);
        }
        applied::hinge::apply(&self.model, q, v, &mut self.tau);
        if !self.pushes.is_empty() {
            applied::motor::pushes(&self.model, &self.laws, self.time, q, v, &mut self.pushes);
            applied::motor::apply(&self.model, &self.pushes, &mut self.tau);
        }
        self.tau.iter_mut().zip(&self.outside).for_each(|(tau, outside)| *tau += outside);
    }

    /// Hinge forces (N, N m) that evaluations take in from now on: what compliant stops push with. Empty for a model
    /// without stops.
    pub fn outside(&mut self) -> &mut [f64] {
        &mut self.outside
    }

    /// `a ← q̈(q, v)`, in O(n).
    ///
    /// # Errors
    /// A singular hinge, or the element whose numbers are not finite.
    pub fn accelerations(&mut self, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Fault> {
        self.prepare(q, v);
        let applied = if self.model.forces.is_empty() { &[] } else { self.applied.as_slice() };
        let load = Load { applied, tau: &self.tau };
        if let Err(singular) = self.reduction.accelerations(&self.model, &self.motion, &load, a) {
            return Err(self.singular(&singular, q, v));
        }
        if self.constraints.is_some() {
            self.constrain(q, a);
        }
        self.check_finite("the acceleration", a, q, v)
    }

    /// `residual ← M(q) a + b(q, v) − τ(q, v)`, in O(n).
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn residual(&mut self, q: &[f64], v: &[f64], a: &[f64], residual: &mut [f64]) -> Result<(), Fault> {
        self.prepare(q, v);
        if self.constraints.is_some() {
            self.apply_multipliers(q);
        }
        self.balance.update(&self.model, &self.motion, &self.applied, &self.tau, a, residual);
        self.check_finite("the force balance", residual, q, v)
    }

    /// `x ← M⁻¹ rhs` with the last factorization of [`System::accelerations`].
    pub fn solve_mass(&mut self, rhs: &[f64], x: &mut [f64]) {
        let load = Load { applied: &[], tau: rhs };
        self.reduction.solve(&self.model, &self.motion, &load, x);
    }

    /// `product ← M x` at the position of the last evaluation, in O(n).
    pub fn mass_times(&self, action: &mut MassAction, x: &[f64], product: &mut [f64]) {
        action.times(&self.model, &self.motion, x, product);
    }

    /// The inertia that each velocity coordinate sees while everything outboard moves freely (kg, kg m²), of the last
    /// factorization.
    pub fn articulated_inertia(&self, out: &mut [f64]) {
        self.reduction.articulated_inertia(&self.model, &self.motion, out);
    }

    /// What the hinge passes to each named body at its root marker, from the last call of [`System::residual`].
    ///
    /// ```
    /// use stillpoint::dynamics::System;
    /// use stillpoint::model::Model;
    /// use stillpoint::model::description::{BodyDescription, Description, HingeDescription};
    ///
    /// // A bob on a string of 2 m that swings through its lowest point at 3 m/s.
    /// let hinge = HingeDescription::revolute([0.0, 1.0, 0.0]);
    /// let bob = BodyDescription::new("bob", hinge).mass(0.5).center([0.0, 0.0, -2.0]);
    /// let model = Model::build(&Description::new("Bob").body(bob)).expect("a sound scene");
    /// let mut system = System::new(&model);
    /// let (q, v) = ([0.0], [3.0 / 2.0]);
    /// let (mut a, mut unbalanced, mut reactions) = ([0.0], [0.0], Vec::new());
    /// system.accelerations(&q, &v, &mut a)?;
    /// system.residual(&q, &v, &a, &mut unbalanced)?;
    /// system.reactions(&mut reactions);
    /// // m g + m v² / l
    /// assert!((reactions[0].force.z - 0.5 * (9.80665 + 9.0 / 2.0)).abs() < 1e-12);
    /// assert!(a[0].abs() < 1e-12 && unbalanced[0].abs() < 1e-12);
    /// # Ok::<(), stillpoint::dynamics::Fault>(())
    /// ```
    pub fn reactions(&self, out: &mut Vec<Wrench>) {
        out.clear();
        out.resize(self.model.bodies.len(), Wrench::ZERO);
        for (index, body) in self.model.bodies.iter().enumerate() {
            if body.link != 0 && self.model.links[body.link].body == index {
                out[index] = self.balance.reactions[body.link];
            }
        }
        self.weld_reactions(out);
    }

    /// A weld carries what its body and all that hangs on it need.
    fn weld_reactions(&self, out: &mut [Wrench]) {
        let welded = |index: usize| {
            let body = &self.model.bodies[index];
            body.link == 0 || self.model.links[body.link].body != index
        };
        if !(0..out.len()).any(welded) {
            return;
        }
        // Children after parents is not promised by the order of names: go by depth.
        let mut depth = vec![0_usize; out.len()];
        for (index, slot) in depth.iter_mut().enumerate() {
            let mut above = self.model.bodies[index].parent;
            while let Some(parent) = above {
                *slot += 1;
                above = self.model.bodies[parent].parent;
            }
        }
        let mut order: Vec<usize> = (0..out.len()).collect();
        order.sort_by_key(|index| std::cmp::Reverse(depth[*index]));
        let mut carried = vec![Wrench::ZERO; out.len()];
        for index in order {
            if welded(index) {
                out[index] = carried[index] + self.body_wrench(index);
            }
            let body = &self.model.bodies[index];
            if let Some(parent) = body.parent {
                let arm = self.root_marker(index) - self.root_marker(parent);
                carried[parent] += out[index].shifted(arm);
            }
        }
    }

    fn root_marker(&self, body: usize) -> Vector3<f64> {
        let body = &self.model.bodies[body];
        let link = &self.motion.links[body.link];
        link.position + link.turn * body.link_from_body.translation.vector
    }

    /// `M a + b − applied` of one named body at its own root marker.
    fn body_wrench(&self, index: usize) -> Wrench {
        let body = &self.model.bodies[index];
        let (link, a) = (&self.motion.links[body.link], &self.balance.accelerations[body.link]);
        let arm = link.turn * body.link_from_body.translation.vector;
        let turn = link.turn * body.link_from_body.rotation.to_rotation_matrix().matrix();
        let (w, dw, c) = (link.angular_velocity, a.angular, turn * body.mass.center);
        let at_center = a.linear + dw.cross(&(arm + c)) + w.cross(&w.cross(&(arm + c)));
        let inertia = turn * body.mass.inertia * turn.transpose();
        let force = body.mass.mass * (at_center - self.model.gravity);
        let moment = c.cross(&force) + inertia * dw + w.cross(&(inertia * w));
        let mut applied = applied::on_body(&self.laws, &self.motion, index);
        if let Some(constrained) = &self.constraints {
            applied += constrained.on_body(index);
        }
        Wrench { force, moment } - applied.shifted(-arm)
    }

    /// Kinetic and potential energy of a state.
    pub fn energies(&mut self, q: &[f64], v: &[f64]) -> Energies {
        self.motion.update(&self.model, q, v);
        let rotors: f64 = self.model.coordinates.iter().zip(v).map(|(c, v)| 0.5 * c.armature * v * v).sum();
        // What drives add to armatures is no inertia of the scene.
        let added = self.model.drives.iter().map(|drive| 0.5 * drive.armature * v[drive.coordinate.velocity].powi(2));
        Energies {
            kinetic: self.motion.kinetic_energy(&self.model) + (rotors - added.sum::<f64>()),
            potential: applied::potential(&self.model, &self.laws, &self.motion, q),
        }
    }

    /// Energies as a search for rest sees them: with the potential of motors at t = 0, whose energy is work in a run.
    pub fn energies_at_rest(&mut self, q: &[f64], v: &[f64]) -> Energies {
        let mut energies = self.energies(q, v);
        energies.potential += applied::motor::potential_at_rest(&self.model, q);
        energies
    }

    /// The motors and what each pushes with at the last evaluation (N or N m).
    pub fn motor_forces(&self) -> impl Iterator<Item = (String, f64)> {
        self.model.motors.iter().zip(&self.pushes).map(|(motor, push)| (motor.name.clone(), push.force))
    }

    /// The same without the names, in the order of the model.
    pub(crate) fn motor_pushes(&self) -> impl Iterator<Item = f64> {
        self.pushes.iter().take(self.model.motors.len()).map(|push| push.force)
    }

    /// The ropes and curves and what each pulls with at the last evaluation (N).
    pub fn pulls(&self) -> impl Iterator<Item = (&str, f64)> {
        let told = self.laws.forces.iter().filter(|force| force.law.pull_name().is_some());
        told.map(|force| (force.name.as_str(), force.law.pull(&self.motion.links)))
    }

    /// Powers of a state that no potential stands for.
    pub fn powers(&mut self, q: &[f64], v: &[f64]) -> Powers {
        let driven = if self.model.drives.is_empty() { 0.0 } else { self.drive_power(q, v) };
        self.motion.update(&self.model, q, v);
        Powers {
            input: applied::input(&self.model, &self.laws, &self.motion, self.time, q, v) + driven,
            dissipated: applied::dissipated(&self.model, &self.laws, &self.motion, v),
        }
    }

    /// Poses of the named bodies' root markers at the last evaluation: `world_from_body`.
    pub fn poses(&self, out: &mut Vec<Pose>) {
        out.clear();
        out.extend(self.model.bodies.iter().map(|body| self.motion.body_pose(body)));
    }

    fn singular(&self, singular: &Singular, q: &[f64], v: &[f64]) -> Fault {
        let body = self.model.bodies[self.model.links[singular.link].body].name.clone();
        if singular.pivot.is_finite() {
            Fault::Singular { body, pivot: singular.pivot }
        } else {
            self.not_finite_state(q, v).unwrap_or(Fault::NotFinite { what: "the position", element: body })
        }
    }

    /// The drive or motor whose formula has no finite value or derivative at this state.
    pub(super) fn not_finite_formula(&self) -> Option<Fault> {
        let fault = |element: String, text: &str| Fault::Formula { element, text: text.to_owned(), time: self.time };
        let drive = self.model.drives.iter().find(|drive| !drive.motion.at(self.time).is_finite());
        if let Some((drive, text)) = drive.and_then(|drive| Some((drive, drive.motion.formula()?))) {
            return Some(fault(format!("drive `{}`", drive.name), text));
        }
        let mut motors = self.model.motors.iter().zip(&self.pushes);
        let (motor, _) = motors.find(|(_, push)| !push.force.is_finite())?;
        Some(fault(format!("motor `{}`", motor.name), motor.formula()?))
    }

    /// Names the cause: a position or velocity that came in, else a formula, else a force element, else the first hinge.
    fn check_finite(&self, what: &'static str, numbers: &[f64], q: &[f64], v: &[f64]) -> Result<(), Fault> {
        let Some(bad) = numbers.iter().position(|x| !x.is_finite()) else { return Ok(()) };
        if let Some(fault) = self.not_finite_state(q, v) {
            return Err(fault);
        }
        if let Some(fault) = self.not_finite_formula() {
            return Err(fault);
        }
        if let Some((force, what)) = applied::not_finite(&self.laws, &self.motion) {
            return Err(Fault::NotFinite { what, element: force.name.clone() });
        }
        Err(Fault::NotFinite { what, element: self.model.owner(bad).to_owned() })
    }

    fn not_finite_state(&self, q: &[f64], v: &[f64]) -> Option<Fault> {
        let bad = |list: &[f64], from: usize, count: usize| list[from..from + count].iter().any(|x| !x.is_finite());
        self.model.bodies.iter().find_map(|body| {
            let (hinge, (positions, velocities)) = (&body.hinge, body.hinge.kind.counts());
            let what = match bad(q, hinge.position, positions) {
                true => "the position",
                false if bad(v, hinge.velocity, velocities) => "the velocity",
                false => return None,
            };
            Some(Fault::NotFinite { what, element: body.name.clone() })
        })
    }

    /// [`crate::motion::displace`].
    pub fn displace(model: &Model, q: &mut [f64], step: &[f64]) {
        crate::motion::displace(model, q, step);
    }
}
