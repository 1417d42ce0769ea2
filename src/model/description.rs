//! What a user describes: plain data, not yet checked. [`Model::build`](super::Model::build) checks it and compiles it.
//!
//! SI units and radians throughout. Nothing here is resolved: parents and markers are still names, so that code and
//! scenario files go through the same checks.
//!
//! Constructors fill in the defaults, setters chain:
//!
//! ```
//! use stillpoint::model::Model;
//! use stillpoint::model::description::{BodyDescription, Description, ForceDescription, GROUND, HingeDescription};
//!
//! let door = HingeDescription::revolute([0.0, 0.0, 1.0]).damping([0.2]).position([0.4]);
//! let latch = HingeDescription::prismatic([1.0, 0.0, 0.0]).on("door", "edge").stiffness([500.0]);
//! let scene = Description::new("Door with a latch")
//!     .body(
//!         BodyDescription::new("door", door)
//!             .mass(20.0)
//!             .center([0.4, 0.0, 1.0])
//!             .inertia([2.0, 3.0, 1.1])
//!             .marker("edge", [0.8, 0.0, 1.0]),
//!     )
//!     .body(BodyDescription::new("latch", latch).mass(0.1))
//!     .force(ForceDescription::spring("closer", ("door", [0.3, 0.0, 2.0]), (GROUND, [0.0, 0.3, 2.0]), 80.0, 0.3, 5.0));
//! let model = Model::build(&scene).expect("a sound scene");
//! assert_eq!((model.bodies.len(), model.degrees_of_freedom()), (2, 2));
//! ```

pub use super::beam::{BeamDescription, BeamShape, FarEnd, FreeStrains, LineLoad, Material, Section};
pub use super::burn::BurnDescription;
pub use super::contact::{ContactDescription, DryFriction};
pub use super::controller::{ControlLawDescription, ControllerDescription};
use super::couplings::{DriveDescription, GearDescription, LoopDescription};
pub use super::hinge_curve::{CurveOver, HingeCurveDescription};
pub use super::modal::ModalDescription;
use super::motor::MotorDescription;
pub use super::output::{
    Axes, DirectionDescription, EnergyKind, Order, OutputDescription, PowerKind, QuantityDescription,
};
use super::parameter::NamedNumbers;
use super::shape::Shape;
pub use super::stage::{StageDescription, When};
pub use super::stop::{LimitDescription, StopLaw};
pub use super::watch::{Direction, EventDescription, WatchedDescription};
pub use crate::element::guide::GuideCurve;
pub use crate::force::load::{LoadAxes, OverTime};
pub use crate::force::table::Interpolation;
pub use crate::force::timeline::Timeline;
pub use crate::force::{
    Attachment, Bushing, Curve, ForceDescription, ForceKind, GROUND, Load, Point, Rope, Slider, Spring,
};
pub use crate::hinge::{AlongTurn, HingeKind};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::collections::HashSet;

/// A scene: bodies, each with the hinge that carries it, and what pushes them.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// One line for people.
    pub title: String,
    /// Gravitational acceleration, inertial axes (m/s²).
    pub gravity: Vector3<f64>,
    /// The bodies in any order: a child may stand before its parent.
    pub bodies: Vec<BodyDescription>,
    /// Flexible beams.
    pub beams: Vec<BeamDescription>,
    /// Which bodies are modal ones.
    pub modals: Vec<ModalDescription>,
    /// Names of bodies whose inertia is taken though no body can have it: models of other programs have such.
    pub unphysical: HashSet<String>,
    /// Bodies whose mass burns away.
    pub burns: Vec<BurnDescription>,
    /// Springs, bushings and loads.
    pub forces: Vec<ForceDescription>,
    /// What closes kinematic loops.
    pub loops: Vec<LoopDescription>,
    /// Coordinates with a given motion.
    pub drives: Vec<DriveDescription>,
    /// Coordinates in a fixed ratio.
    pub gears: Vec<GearDescription>,
    /// Forces in coordinates that follow a law.
    pub motors: Vec<MotorDescription>,
    /// What sets motors of type `input` while a run goes on.
    pub controllers: Vec<ControllerDescription>,
    /// What a run takes note of.
    pub events: Vec<EventDescription>,
    /// Changes of structure in a run, in the order in which they are listed.
    pub stages: Vec<StageDescription>,
    /// Numbers with names that all this follows from.
    pub named: NamedNumbers,
    /// What may touch what; nothing else does.
    pub contacts: Vec<ContactDescription>,
    /// Numbers that are asked of it.
    pub outputs: Vec<OutputDescription>,
}

impl Default for Description {
    fn default() -> Self {
        Self {
            title: String::new(),
            gravity: Vector3::new(0.0, 0.0, -9.80665),
            bodies: Vec::new(),
            beams: Vec::new(),
            modals: Vec::new(),
            unphysical: HashSet::new(),
            burns: Vec::new(),
            forces: Vec::new(),
            loops: Vec::new(),
            drives: Vec::new(),
            gears: Vec::new(),
            motors: Vec::new(),
            controllers: Vec::new(),
            events: Vec::new(),
            stages: Vec::new(),
            named: NamedNumbers::default(),
            contacts: Vec::new(),
            outputs: Vec::new(),
        }
    }
}

/// A rigid body and the hinge that carries it.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyDescription {
    /// Unique name.
    pub name: String,
    /// Mass, centre of mass and inertia.
    pub mass: MassProperties,
    /// Named points, body axes, from the root marker (m).
    pub markers: Vec<(String, Vector3<f64>)>,
    /// For pictures, and what touches other bodies.
    pub shapes: Vec<Shape>,
    /// The inboard hinge.
    pub hinge: HingeDescription,
}

/// Mass properties of a rigid body, body axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Mass (kg), ≥ 0.
    pub mass: f64,
    /// Centre of mass from the root marker (m).
    pub center: Vector3<f64>,
    /// Inertia about the **centre of mass** (kg m²), symmetric.
    pub inertia: Matrix3<f64>,
}

/// The inboard hinge of a body: where it sits on the parent, which motion it leaves free, and what acts in it.
///
/// The lists hold one value per coordinate (`position`) or per velocity (all others); a list of one value where more
/// are needed is not widened here. Empty lists mean the defaults: zero, and the identity for a quaternion.
#[derive(Debug, Clone, PartialEq)]
pub struct HingeDescription {
    /// Which motion is free.
    pub kind: HingeKind,
    /// The curve of [`HingeKind::Along`], hinge frame; `None` for all others.
    pub curve: Option<GuideCurve>,
    /// Name of the parent body, or [`GROUND`].
    pub parent: String,
    /// Where on the parent.
    pub at: Point,
    /// Fixed turn of the hinge frame in the parent: `parent_from_hinge`.
    pub frame: UnitQuaternion<f64>,
    /// Start or guess, see [`HingeKind`] for order and units.
    pub position: Vec<f64>,
    /// Start velocities.
    pub velocity: Vec<f64>,
    /// Spring stiffness per velocity (N/m or N m/rad).
    pub stiffness: Vec<f64>,
    /// Damping per velocity (N s/m or N m s/rad).
    pub damping: Vec<f64>,
    /// Coordinates at which the spring is relaxed (as `position`: a quaternion for spherical hinges).
    pub rest: Vec<f64>,
    /// Added hinge inertia per velocity (kg or kg m²).
    pub armature: Vec<f64>,
    /// Constant motor force per velocity (N or N m).
    pub force: Vec<f64>,
    /// Dry friction per velocity; of a ball's three the first bounds the size of the torque.
    pub friction: Vec<DryFriction>,
    /// Held during statics.
    pub lock: bool,
    /// Stops of its coordinates.
    pub limits: Vec<LimitDescription>,
    /// Springs and dampers by tables.
    pub curves: Vec<HingeCurveDescription>,
}

impl HingeDescription {
    /// A hinge of this kind on the ground's origin with nothing acting in it.
    pub fn new(kind: HingeKind) -> Self {
        Self {
            kind,
            curve: None,
            parent: GROUND.to_owned(),
            at: Point::At(Vector3::zeros()),
            frame: UnitQuaternion::identity(),
            position: Vec::new(),
            velocity: Vec::new(),
            stiffness: Vec::new(),
            damping: Vec::new(),
            rest: Vec::new(),
            armature: Vec::new(),
            force: Vec::new(),
            friction: Vec::new(),
            lock: false,
            limits: Vec::new(),
            curves: Vec::new(),
        }
    }
}
