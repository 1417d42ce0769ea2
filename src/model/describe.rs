//! Constructors with defaults and chained setters, for scenes in code; the example is in
//! [`description`](super::description).

use super::couplings::{DriveDescription, GearDescription, LoopDescription};
use super::description::*;
use super::motor::MotorDescription;
use super::shape::Shape;
use crate::element::modal::Modal;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::sync::Arc;

impl Description {
    /// An empty scene with a title, in the gravity of the Earth along −z.
    pub fn new(title: &str) -> Self {
        Self { title: title.to_owned(), ..Self::default() }
    }

    /// Sets the gravitational acceleration (m/s²).
    pub fn gravity(self, gravity: impl Into<Vector3<f64>>) -> Self {
        Self { gravity: gravity.into(), ..self }
    }

    /// Adds a body.
    pub fn body(mut self, body: BodyDescription) -> Self {
        self.bodies.push(body);
        self
    }

    /// Adds a flexible beam.
    pub fn beam(mut self, beam: BeamDescription) -> Self {
        self.beams.push(beam);
        self
    }

    /// Makes a body of this name a modal one.
    pub fn modal(mut self, body: &str, modal: Modal) -> Self {
        let (body, modal) = (body.to_owned(), Arc::new(modal));
        self.modals.push(ModalDescription { body, modal, file: None, position: Vec::new(), velocity: Vec::new() });
        self
    }

    /// Adds a spring, a bushing or a load.
    pub fn force(mut self, force: ForceDescription) -> Self {
        self.forces.push(force);
        self
    }

    /// Adds what closes a loop.
    pub fn closure(mut self, closure: LoopDescription) -> Self {
        self.loops.push(closure);
        self
    }

    /// Adds a given motion.
    pub fn drive(mut self, drive: DriveDescription) -> Self {
        self.drives.push(drive);
        self
    }

    /// Adds a motor.
    pub fn motor(mut self, motor: MotorDescription) -> Self {
        self.motors.push(motor);
        self
    }

    /// Adds a gear.
    pub fn gear(mut self, gear: GearDescription) -> Self {
        self.gears.push(gear);
        self
    }

    /// Adds what is asked of it.
    pub fn output(mut self, output: OutputDescription) -> Self {
        self.outputs.push(output);
        self
    }

    /// Adds what may touch what.
    pub fn contact(mut self, contact: ContactDescription) -> Self {
        self.contacts.push(contact);
        self
    }

    /// Adds an event.
    pub fn event(mut self, event: EventDescription) -> Self {
        self.events.push(event);
        self
    }
}

impl BodyDescription {
    /// A body without mass on its hinge.
    pub fn new(name: &str, hinge: HingeDescription) -> Self {
        let mass = MassProperties { mass: 0.0, center: Vector3::zeros(), inertia: Matrix3::zeros() };
        Self { name: name.to_owned(), mass, markers: Vec::new(), shapes: Vec::new(), hinge }
    }

    /// Sets the mass (kg).
    pub fn mass(mut self, mass: f64) -> Self {
        self.mass.mass = mass;
        self
    }

    /// Sets the centre of mass from the root marker, body axes (m).
    pub fn center(mut self, center: impl Into<Vector3<f64>>) -> Self {
        self.mass.center = center.into();
        self
    }

    /// Sets the principal moments of inertia xx, yy, zz about the **centre of mass**, body axes (kg m²). For a full
    /// matrix set `mass.inertia`.
    pub fn inertia(mut self, moments: impl Into<Vector3<f64>>) -> Self {
        self.mass.inertia = Matrix3::from_diagonal(&moments.into());
        self
    }

    /// Adds a named point, body axes (m).
    pub fn marker(mut self, name: &str, at: impl Into<Vector3<f64>>) -> Self {
        self.markers.push((name.to_owned(), at.into()));
        self
    }

    /// Adds a solid to its picture.
    pub fn shape(mut self, shape: Shape) -> Self {
        self.shapes.push(shape);
        self
    }
}

impl HingeDescription {
    /// Welds.
    pub fn fixed() -> Self {
        Self::new(HingeKind::Fixed)
    }

    /// Turns about an axis.
    pub fn revolute(axis: impl Into<Vector3<f64>>) -> Self {
        Self::new(HingeKind::Revolute { axis: axis.into() })
    }

    /// Slides along an axis.
    pub fn prismatic(axis: impl Into<Vector3<f64>>) -> Self {
        Self::new(HingeKind::Prismatic { axis: axis.into() })
    }

    /// Turns about an axis and slides along it by `pitch` (m/rad).
    pub fn screw(axis: impl Into<Vector3<f64>>, pitch: f64) -> Self {
        Self::new(HingeKind::Screw { axis: axis.into(), pitch })
    }

    /// Slides along a curve of the hinge frame.
    pub fn along(curve: GuideCurve, turn: AlongTurn) -> Self {
        Self { curve: Some(curve), ..Self::new(HingeKind::Along { turn }) }
    }

    /// Slides along and turns about an axis.
    pub fn cylindrical(axis: impl Into<Vector3<f64>>) -> Self {
        Self::new(HingeKind::Cylindrical { axis: axis.into() })
    }

    /// Turns about a first axis, then about a second one carried by the first.
    pub fn universal(first: impl Into<Vector3<f64>>, second: impl Into<Vector3<f64>>) -> Self {
        Self::new(HingeKind::Universal { axes: [first.into(), second.into()] })
    }

    /// Slides in the xy plane of the hinge frame and turns about its z.
    pub fn planar() -> Self {
        Self::new(HingeKind::Planar)
    }

    /// Turns freely.
    pub fn spherical() -> Self {
        Self::new(HingeKind::Spherical)
    }

    /// Moves freely.
    pub fn free() -> Self {
        Self::new(HingeKind::Free)
    }

    /// Hangs it on a body, or on [`GROUND`], at a point (m) or a marker.
    pub fn on(mut self, parent: &str, at: impl Into<Point>) -> Self {
        self.parent = parent.to_owned();
        self.at = at.into();
        self
    }

    /// Turns the hinge frame in the parent: `parent_from_hinge`.
    pub fn turned(self, frame: UnitQuaternion<f64>) -> Self {
        Self { frame, ..self }
    }

    /// Sets the start or guess, one number per coordinate; see [`HingeKind`] for order and units.
    pub fn position(self, position: impl Into<Vec<f64>>) -> Self {
        Self { position: position.into(), ..self }
    }

    /// Sets the start velocities.
    pub fn velocity(self, velocity: impl Into<Vec<f64>>) -> Self {
        Self { velocity: velocity.into(), ..self }
    }

    /// Sets the spring stiffness per velocity (N/m or N m/rad).
    pub fn stiffness(self, stiffness: impl Into<Vec<f64>>) -> Self {
        Self { stiffness: stiffness.into(), ..self }
    }

    /// Sets the damping per velocity (N s/m or N m s/rad).
    pub fn damping(self, damping: impl Into<Vec<f64>>) -> Self {
        Self { damping: damping.into(), ..self }
    }

    /// Sets the coordinates at which the spring is relaxed.
    pub fn rest(self, rest: impl Into<Vec<f64>>) -> Self {
        Self { rest: rest.into(), ..self }
    }

    /// Sets the added hinge inertia per velocity (kg or kg m²).
    pub fn armature(self, armature: impl Into<Vec<f64>>) -> Self {
        Self { armature: armature.into(), ..self }
    }

    /// Sets the constant motor force per velocity (N or N m).
    pub fn force(self, force: impl Into<Vec<f64>>) -> Self {
        Self { force: force.into(), ..self }
    }

    /// Sets dry friction (N or N m), the same at rest and in motion, one number per velocity.
    pub fn friction(self, friction: impl Into<Vec<f64>>) -> Self {
        Self { friction: friction.into().into_iter().map(DryFriction::new).collect(), ..self }
    }

    /// Adds stops of one coordinate.
    pub fn limit(mut self, limit: LimitDescription) -> Self {
        self.limits.push(limit);
        self
    }

    /// Held during statics.
    pub fn locked(self) -> Self {
        Self { lock: true, ..self }
    }
}
