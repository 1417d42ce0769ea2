//! What is simulated: immutable, validated, no numbers that change in time.
//!
//! A [`Description`] is what a person writes; [`Model::build`] checks it and compiles it into a tree of *links*. A link
//! is one elementary hinge (turn, slide, screw or ball) and the rigid body outboard of it; a hinge with several coordinates
//! becomes several links, all but the last without mass. Welded bodies have no link of their own: they are part of the
//! link that carries them. Link 0 is the ground.

pub mod address;
pub mod beam;
mod build;
pub mod burn;
mod check;
pub mod contact;
pub mod controller;
mod couple;
pub mod couplings;
mod describe;
pub mod description;
pub mod guided;
mod halves;
mod hinge_curve;
mod link;
pub mod modal;
pub mod motor;
pub mod output;
pub mod parameter;
mod point_mass;
pub mod prescribed;
pub mod problem;
pub mod shape;
pub mod stage;
pub mod stop;
pub mod structure;
mod tree;
mod variant;
pub mod watch;

pub use crate::force::{End, Force};
pub use crate::hinge::Joint;
pub use beam::{Beam, BeamElement};
pub use burn::Burn;
pub use contact::{ContactRule, HingeFriction};
pub use controller::Controller;
pub use couple::{Drive, Gear, Loop, Scalar};
pub use description::Description;
pub use guided::CurveEnd;
pub use halves::Halves;
pub use hinge_curve::{CurveOver, HingeCurve};
pub use link::Link;
pub use modal::ModalBody;
pub use motor::Motor;
pub use output::{Output, Quantity};
pub use parameter::Parameter;
pub use problem::{Element, Problem};
pub use stop::{Side, Stop, StopLaw, StopSide};
pub use watch::{Event, Watched};

use crate::element::Rod;
use crate::force::Act;
use crate::pages::Pages;
use crate::spatial::Pose;
use description::{HingeKind, MassProperties};
use nalgebra::Vector3;
use shape::Shape;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A checked and compiled scene.
#[derive(Debug, Clone)]
pub struct Model {
    /// One line for people.
    pub title: String,
    /// Gravitational acceleration, inertial axes (m/s²).
    pub gravity: Vector3<f64>,
    /// The named bodies, in the order of the description.
    pub bodies: Vec<Body>,
    /// The tree: link 0 is the ground, parents stand before children, and every subtree is contiguous.
    pub links: Pages<Link>,
    /// The flexible elements, and the curves that bodies are guided along.
    pub rods: Vec<Rod>,
    /// The ends of those curves.
    pub curve_ends: Vec<CurveEnd>,
    /// Bodies whose mass burns away.
    pub burns: Vec<Burn>,
    /// The beams that they belong to.
    pub beams: Vec<Beam>,
    /// The modal bodies.
    pub modals: Vec<ModalBody>,
    /// Where the tree falls into two halves, in large ones.
    pub halves: Option<Halves>,
    /// What acts in each velocity coordinate.
    pub coordinates: Vec<Coordinate>,
    /// Springs, bushings and loads.
    pub forces: Arc<[Force]>,
    /// What closes kinematic loops.
    pub loops: Vec<Loop>,
    /// Coordinates with a given motion.
    pub drives: Vec<Drive>,
    /// Coordinates in a fixed ratio.
    pub gears: Vec<Gear>,
    /// Forces in coordinates that follow a law.
    pub motors: Vec<Motor>,
    /// Indices of the motors of type `input`.
    pub inputs: Vec<usize>,
    /// What sets them at the instants of a period.
    pub controllers: Vec<Controller>,
    /// Springs and dampers by tables in coordinates.
    pub curves: Arc<[HingeCurve]>,
    /// Which rows of loops, drives and gears are independent of the others, where that has been decided (by
    /// `constraint::assemble`).
    pub independent_rows: Option<Vec<bool>>,
    /// Stops of hinge coordinates.
    pub stops: Vec<Stop>,
    /// Hinges with dry friction.
    pub hinge_friction: Vec<HingeFriction>,
    /// What may touch what; nothing else does.
    pub contacts: Vec<ContactRule>,
    /// What a run takes note of.
    pub events: Vec<Event>,
    /// Numbers that are asked of it.
    pub outputs: Vec<Output>,
    /// The whole scene of one with changes of structure, of which this is the first; `None` without.
    pub stages: Option<Arc<Description>>,
    /// Start or guess: hinge coordinates, `position_count` numbers.
    pub start_position: Vec<f64>,
    /// Start velocities, `velocity_count` numbers.
    pub start_velocity: Vec<f64>,
}

/// A named body.
#[derive(Debug, Clone)]
pub struct Body {
    /// Name.
    pub name: String,
    /// Index of the parent body, `None` for the ground.
    pub parent: Option<usize>,
    /// The link that it is (part of); 0 where it is welded to the ground.
    pub link: usize,
    /// Where its root marker stands on that link.
    pub link_from_body: Pose,
    /// Whether it is the tip of an element of a beam.
    pub is_element: bool,
    /// Whether no description names it: the tip of an element, or where a beam begins that is welded to the body on its hinge.
    pub is_inner: bool,
    /// Mass, centre and inertia, body axes.
    pub mass: MassProperties,
    /// Named points, body axes.
    pub markers: Vec<(String, Vector3<f64>)>,
    /// For pictures.
    pub shapes: Vec<Shape>,
    /// Its hinge.
    pub hinge: Hinge,
}

impl Body {
    /// The longest of the distances that it is described by: to its markers and its centre, its radius of gyration, and from
    /// its parent's root marker to its hinge (m).
    pub fn extent(&self) -> f64 {
        let gyration = if self.mass.mass > 0.0 { (self.mass.inertia.trace() / self.mass.mass).sqrt() } else { 0.0 };
        let markers = self.markers.iter().map(|(_, at)| at.norm());
        let hinge = self.hinge.parent_from_hinge.translation.vector.norm();
        markers.chain([self.mass.center.norm(), gyration, hinge]).fold(0.0, f64::max)
    }
}

/// Where a hinge's coordinates stand, and where it sits.
#[derive(Debug, Clone)]
pub struct Hinge {
    /// Kind; axes as given.
    pub kind: HingeKind,
    /// Hinge frame on the parent body: `parent_from_hinge`.
    pub parent_from_hinge: Pose,
    /// First index into the position vector; `kind.counts().0` numbers.
    pub position: usize,
    /// First index into the velocity vector; `kind.counts().1` numbers.
    pub velocity: usize,
    /// Held during statics.
    pub lock: bool,
}

/// What acts in one velocity coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Coordinate {
    /// Index of the body whose hinge it belongs to.
    pub body: usize,
    /// Spring stiffness (N/m, N m/rad).
    pub stiffness: f64,
    /// Damping (N s/m, N m s/rad).
    pub damping: f64,
    /// Where the spring is relaxed (turns and slides; a ball keeps its rest orientation in its joint).
    pub rest: f64,
    /// Added inertia (kg, kg m²).
    pub armature: f64,
    /// Constant motor force (N, N m).
    pub force: f64,
    /// Held during statics.
    pub lock: bool,
}

impl Model {
    /// Checks a description and compiles it.
    ///
    /// # Errors
    /// Every problem that was found, each with the element and the field it belongs to.
    pub fn build(description: &Description) -> Result<Arc<Self>, Vec<Problem>> {
        let model = Self::build_loosely(description)?;
        let problems = match model.stages {
            None => point_mass::problems(description, &model),
            Some(_) => structure::each(description, |scene| {
                let model = build::build(scene)?;
                Ok(point_mass::problems(scene, &model))
            })?,
        };
        match problems {
            problems if problems.is_empty() => Ok(model),
            problems => Err(problems),
        }
    }

    /// Builds without the check for point masses that turn about themselves: an axis that could not be read may stand in for
    /// another.
    pub(crate) fn build_loosely(description: &Description) -> Result<Arc<Self>, Vec<Problem>> {
        if description.stages.is_empty() {
            return build::build(description).map(Arc::new);
        }
        structure::build(description, build::build).map(Arc::new)
    }

    /// The model that starts in a state; what follows from the given positions stays.
    pub(crate) fn starting_in(self: Arc<Self>, position: &[f64], velocity: &[f64]) -> Arc<Self> {
        let mut model = Arc::unwrap_or_clone(self);
        model.start_position.copy_from_slice(position);
        model.start_velocity.copy_from_slice(velocity);
        Arc::new(model)
    }

    /// The model as it is before its first stage, which does not come.
    pub fn before_stages(self: &Arc<Self>) -> Arc<Self> {
        match &self.stages {
            None => Arc::clone(self),
            Some(_) => Arc::new(Self { stages: None, ..Self::clone(self) }),
        }
    }

    /// Number of hinge coordinates.
    pub fn position_count(&self) -> usize {
        self.start_position.len()
    }

    /// Positions with every hinge where its coordinates are zero, turns of three axes at none.
    pub fn unmoved_position(&self) -> Vec<f64> {
        let mut position = vec![0.0; self.position_count()];
        for link in &self.links {
            let (positions, velocities) = link.joint.counts();
            // The real part of a quaternion, which stands last.
            if positions > velocities {
                position[link.position + positions - 4] = 1.0;
            }
        }
        position
    }

    /// Number of hinge velocities: the degrees of freedom of the tree.
    pub fn velocity_count(&self) -> usize {
        self.start_velocity.len()
    }

    /// Whether loops, drives or gears tie coordinates together.
    pub fn is_constrained(&self) -> bool {
        !(self.loops.is_empty() && self.drives.is_empty() && self.gears.is_empty())
    }

    /// Degrees of freedom that loops, gears and drives leave, once it is decided which of their rows are independent.
    pub fn degrees_of_freedom(&self) -> usize {
        let rank = self.independent_rows.as_ref().map_or(0, |rows| rows.iter().filter(|row| **row).count());
        self.velocity_count() - rank
    }

    /// The coordinates that something pushes alone: of each motor, then of each curve.
    pub fn pushed(&self) -> impl Iterator<Item = Scalar> {
        self.motors.iter().map(|motor| motor.coordinate).chain(self.curves.iter().map(|curve| curve.coordinate))
    }

    /// The force elements whose pull is told, and what it is called.
    pub fn pulls(&self) -> impl Iterator<Item = (&Force, &'static str)> {
        self.forces.iter().filter_map(|force| Some((force, force.law.pull_name()?)))
    }

    /// The force elements that have events of their own, by their index.
    pub fn switching(&self) -> impl Iterator<Item = usize> {
        let forces = self.forces.iter().enumerate();
        forces.filter(|(_, force)| force.law.switches().is_some()).map(|(index, _)| index)
    }

    /// Whether laws change within the reach of a motion, where steps end: ropes, tables with kinks, and formulas that switch.
    pub fn has_boundaries(&self) -> bool {
        self.motors.iter().any(|motor| !motor.pieces().is_empty())
            || self.forces.iter().any(|force| force.law.boundaries().iter().any(Option::is_some))
            || self.curves.iter().any(|curve| curve.table.kinks().iter().any(Option::is_some))
    }

    /// Index of a body by name.
    pub fn body(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|body| body.name == name)
    }

    /// The name of the body whose hinge a velocity coordinate belongs to.
    pub fn owner(&self, velocity: usize) -> &str {
        &self.bodies[self.coordinates[velocity].body].name
    }

    /// What every motor pushes with at t = 0, by its name (N or N m).
    pub fn motor_forces(&self, q: &[f64], v: &[f64]) -> Vec<(String, f64)> {
        let force = |motor: &Motor| {
            let at = motor.coordinate;
            (motor.name.clone(), motor.at(0.0, q[at.position], v[at.velocity]).force)
        };
        self.motors.iter().map(force).collect()
    }

    /// Velocity coordinates that are lengths: of slides, and of flexible elements that stretch or shear.
    pub fn lengths(&self) -> impl Iterator<Item = usize> + '_ {
        self.links.iter().flat_map(move |link| {
            let is_length = move |k: &usize| match link.joint.rod() {
                Some(rod) => self.rods[rod].strain_of(*k) < 3,
                None => match link.joint.modal() {
                    Some(modal) => self.modals[modal].modal.is_length(*k),
                    None => link.joint.is_slide(),
                },
            };
            (0..link.joint.counts().1).filter(is_length).map(|k| link.velocity + k)
        })
    }

    /// What a force along a velocity coordinate is measured in: `N` along slides, `N m` about axes.
    pub fn force_unit(&self, velocity: usize) -> &'static str {
        if self.lengths().any(|length| length == velocity) { "N" } else { "N m" }
    }

    /// What the coordinate of a velocity is measured in: `m` along slides, `rad` about axes.
    pub fn coordinate_unit(&self, velocity: usize) -> &'static str {
        if self.lengths().any(|length| length == velocity) { "m" } else { "rad" }
    }

    /// What an output's number is measured in, by its place among the numbers of all outputs; `1` if it is a pure number.
    pub fn output_unit(&self, number: usize) -> &str {
        self.outputs.iter().flat_map(|output| &output.units).nth(number).map_or("1", String::as_str)
    }

    /// The shortest time in which a compliant stop turns what it carries around, but for a factor of π (s); infinite without such stops.
    pub fn shortest_push(&self) -> f64 {
        let stiffness = |stop: &Stop| match stop.law {
            StopLaw::Compliant { stiffness, .. } => Some((stop.velocity, stiffness)),
            StopLaw::Rigid { .. } => None,
        };
        let mut pushes = self.stops.iter().filter_map(stiffness).peekable();
        if pushes.peek().is_none() {
            return f64::INFINITY;
        }
        // Of every link with all that it carries.
        let own = |link: &Link| [link.mass, self.bodies[link.body].extent()];
        let mut carried = vec![[0.0, 0.0]];
        carried.extend(self.links.iter().skip(1).map(own));
        for at in (1..self.links.len()).rev() {
            let ([mass, extent], parent) = (carried[at], &mut carried[self.links[at].parent]);
            *parent = [parent[0] + mass, parent[1].max(extent)];
        }
        let scalar = self.links.iter().zip(carried).skip(1).filter(|(link, _)| link.joint.is_scalar());
        let inertia: BTreeMap<usize, f64> = scalar
            .map(|(link, [mass, extent])| {
                (link.velocity, if link.joint.is_slide() { mass } else { mass * extent * extent })
            })
            .collect();
        let times = pushes.filter_map(|(velocity, stiffness)| Some((inertia.get(&velocity)? / stiffness).sqrt()));
        times.filter(|time| *time > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// The velocity coordinate of this [`label`](Self::label).
    pub fn labelled(&self, label: &str) -> Option<usize> {
        (0..self.velocity_count()).find(|velocity| self.label(*velocity) == label)
    }

    /// A velocity coordinate for people: the body's name, and which coordinate where its hinge has several.
    pub fn label(&self, velocity: usize) -> String {
        let body = &self.bodies[self.coordinates[velocity].body];
        let names = body.hinge.kind.velocities();
        match names.len() {
            0 if self.modal_of(velocity).is_some() => {
                let name = self.modal_of(velocity).map_or("", |(_, name)| name);
                format!("`{}` ({name})", body.name)
            }
            // Of a flexible element.
            0 | 1 => format!("`{}`", body.name),
            _ => format!("`{}` ({})", body.name, names[velocity - body.hinge.velocity].0),
        }
    }

    /// The modal body that a velocity coordinate belongs to, and what the body calls it.
    pub fn modal_of(&self, velocity: usize) -> Option<(&ModalBody, &str)> {
        let first = |modal: &ModalBody| self.links[modal.link].velocity;
        let of = |modal: &&ModalBody| (first(modal)..first(modal) + modal.modal.count()).contains(&velocity);
        let modal = self.modals.iter().find(of)?;
        Some((modal, &modal.modal.coordinates[velocity - first(modal)].0))
    }

    /// Total mass of what moves and what is welded to the ground (kg).
    pub fn total_mass(&self) -> f64 {
        let inner = |rod: &Rod| rod.slices[1..rod.steps()].iter().map(|slice| slice.mass).sum::<f64>();
        self.bodies.iter().map(|body| body.mass.mass).sum::<f64>()
            + self.rods.iter().map(inner).sum::<f64>()
            + self.modals.iter().map(|modal| modal.modal.mass).sum::<f64>()
    }

    /// The times at which a load or a mass begins to follow another rule (s).
    pub fn table_times(&self) -> impl Iterator<Item = f64> + '_ {
        let loads = self.forces.iter().flat_map(|force| force.law.times());
        loads.chain(self.burns.iter().flat_map(|burn| &burn.timeline.times)).copied()
    }

    /// Whether every load has a potential: no mass that burns away, no loads over time, no follower loads, no torques fixed in space, no motors about balls or by
    /// formulas of their coordinate.
    pub fn is_conservative(&self) -> bool {
        self.burns.is_empty()
            && self.forces.iter().all(|force| force.law.has_potential())
            && self.is_conservative_at_rest()
    }

    /// [`Model::is_conservative`] at any one time, for statics: what changes over time stands still then.
    pub fn is_conservative_at_rest(&self) -> bool {
        self.forces.iter().all(|force| force.law.has_potential_at_rest())
            && self.motors.iter().all(Motor::has_potential)
            && self.links.iter().all(|link| {
                !link.joint.is_ball()
                    || self.coordinates[link.velocity..link.velocity + 3].iter().all(|c| c.force == 0.0)
            })
    }

    /// Whether anything dissipates energy.
    pub fn has_damping(&self) -> bool {
        self.coordinates.iter().any(|c| c.damping != 0.0)
            || self.curves.iter().any(|curve| curve.over == CurveOver::Velocity)
            || self.forces.iter().any(|force| force.law.has_damping())
            || self.motors.iter().any(Motor::has_damping)
            || self.rods.iter().any(|rod| rod.damping != 0.0)
            || self.modals.iter().any(|modal| !modal.modal.damping.is_empty())
    }

    /// A length that is typical of the scene (m): the largest distance within one body or one hinge, 1 where all are
    /// zero.
    pub fn length_scale(&self) -> f64 {
        let largest = self.bodies.iter().map(Body::extent).fold(0.0_f64, f64::max);
        if largest > 0.0 { largest } else { 1.0 }
    }

    /// A time that is typical of the scene (s): that of a fall over its length, 1 without gravity.
    pub fn time_scale(&self) -> f64 {
        let g = self.gravity.norm();
        if g > 0.0 { (self.length_scale() / g).sqrt() } else { 1.0 }
    }
}
