//! Outputs: what a user asks of a scene, as it is described and as it is compiled. Their values are in [`crate::output`].

mod compile;
mod named;

pub(super) use compile::{attachments, compile};

use super::End;
use super::description::Attachment;
use crate::formula::Formula;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// A number, or a list of numbers, that a user asks of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputDescription {
    /// Unique name.
    pub name: String,
    /// What it is.
    pub of: QuantityDescription,
}

impl OutputDescription {
    /// An output of this name.
    pub fn new(name: &str, of: QuantityDescription) -> Self {
        Self { name: name.to_owned(), of }
    }
}

/// What an output is, by names.
#[derive(Debug, Clone, PartialEq)]
pub enum QuantityDescription {
    /// Where a point is, how fast it moves, or its acceleration, seen from the ground.
    Point {
        /// Which of the three.
        order: Order,
        /// The point.
        on: Attachment,
        /// The direction of one component, of any length but zero, in `axes`; `None` for all three components.
        axis: Option<Vector3<f64>>,
        /// In which axes.
        axes: Axes,
    },
    /// Distance of two points.
    Distance {
        /// The points.
        between: [Attachment; 2],
    },
    /// Angle between two directions.
    Angle {
        /// The one direction.
        of: DirectionDescription,
        /// The direction from which the angle is measured.
        against: DirectionDescription,
        /// The axis about which it is positive, axes of the body of `against`: both directions are projected along it.
        /// `None` for the angle in their own plane, 0…π.
        about: Option<Vector3<f64>>,
    },
    /// Orientation of a body: quaternion w, x, y, z, `world_from_body`.
    Orientation {
        /// Body name.
        body: String,
    },
    /// Coordinates of a hinge.
    Coordinate {
        /// Their address.
        of: String,
    },
    /// Velocities of a hinge.
    Rate {
        /// Their address.
        of: String,
    },
    /// What a named element pushes or pulls with.
    Force {
        /// Name of a force element, motor, drive, gear, loop or contact, or of a body whose hinge has limits.
        of: String,
        /// Which of six numbers, of a contact of the first three, from 0; `None` for all of them.
        component: Option<usize>,
    },
    /// Length of a spring, curve, rope, beam or cable.
    Length {
        /// Its name.
        of: String,
    },
    /// What a hinge passes to its body, at the body's root marker: force, then moment.
    Reaction {
        /// Body name.
        body: String,
        /// Which of six numbers, from 0; `None` for all of them.
        component: Option<usize>,
        /// In which axes.
        axes: Axes,
    },
    /// What the part of a beam or cable beyond a section exerts on the part before it, in the section's axes: normal force,
    /// shear along y and z, torque, bending moments about y and z.
    Section {
        /// Name of the beam.
        of: String,
        /// Unstretched distance from its root (m).
        s: f64,
        /// Which of six numbers, from 0, or [`SectionQuantity::STRESS`]; `None` for the six of them.
        component: Option<usize>,
    },
    /// An energy of the scene.
    Energy(EnergyKind),
    /// A power of the scene.
    Power(PowerKind),
    /// A formula in other outputs and the time `t` (s).
    Expression {
        /// As written.
        text: String,
        /// What it measures.
        unit: String,
    },
}

/// Which derivative with respect to time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Position (m).
    Position,
    /// Velocity (m/s).
    Velocity,
    /// Acceleration (m/s²).
    Acceleration,
}

/// The axes in which components are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Axes {
    /// Fixed in space.
    #[default]
    Inertial,
    /// Fixed in the body.
    Body,
}

/// A direction that a body carries.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionDescription {
    /// Body name or [`GROUND`](super::description::GROUND).
    pub body: String,
    /// In the axes of the body, of any length but zero.
    pub axis: Vector3<f64>,
}

/// Which energy (J).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EnergyKind {
    /// Of the motion.
    Kinetic,
    /// Of gravity, springs and stops, and of loads and motors that have one.
    Potential,
    /// What motors, drives and loads without a potential have put in since the start of a run.
    Input,
    /// What dampers and impacts have taken out since the start of a run.
    Dissipated,
}

/// Which power (W).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PowerKind {
    /// Put in by motors, drives and loads without a potential.
    Input,
    /// Taken out by dampers.
    Dissipated,
}

/// An output, compiled.
#[derive(Debug, Clone)]
pub struct Output {
    /// Name.
    pub name: String,
    /// SI unit of each of its numbers.
    pub units: Vec<String>,
    /// Index of its first number among those of all outputs.
    pub first: usize,
    /// What it is.
    pub quantity: Quantity,
}

impl Output {
    /// The places of its numbers among those of all outputs.
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.units.len()
    }

    /// What each of its numbers is called: the name, or `name[0]`, `name[1]`, … if there are several.
    pub fn labels(&self) -> impl Iterator<Item = String> {
        let single = self.units.len() == 1;
        (0..self.units.len())
            .map(move |index| if single { self.name.clone() } else { format!("{}[{index}]", self.name) })
    }
}

/// The output itself, or the first of those that it follows from through formulas, that `is` what is looked for.
pub fn follows_from<'a>(outputs: &'a [Output], output: &'a Output, is: impl Fn(&Output) -> bool) -> Option<&'a Output> {
    let mut seen = vec![false; outputs.len()];
    let mut waiting = vec![output];
    while let Some(output) = waiting.pop() {
        if is(output) {
            return Some(output);
        }
        let Quantity::Expression(expression) = &output.quantity else { continue };
        for (other, seen) in outputs.iter().zip(&mut seen) {
            // The first variable of a formula is the time.
            if !*seen && other.range().any(|number| expression.formula.uses(number + 1)) {
                *seen = true;
                waiting.push(other);
            }
        }
    }
    None
}

/// What an output is, compiled.
#[derive(Debug, Clone)]
pub enum Quantity {
    /// Of a point.
    Point(PointQuantity),
    /// Distance of two points.
    Distance(DistanceQuantity),
    /// Angle between two directions.
    Angle(AngleQuantity),
    /// Orientation of a body.
    Orientation(OrientationQuantity),
    /// Coordinates of a hinge.
    Coordinate(CoordinateQuantity),
    /// Velocities of a hinge.
    Rate(RateQuantity),
    /// What an element pushes or pulls with.
    Force(ForceQuantity),
    /// Length of a spring, curve or rope.
    Length(LengthQuantity),
    /// What a beam bears.
    Section(SectionQuantity),
    /// What a hinge passes on.
    Reaction(ReactionQuantity),
    /// An energy.
    Energy(EnergyKind),
    /// A power.
    Power(PowerKind),
    /// A formula.
    Expression(ExpressionQuantity),
}

/// Position, velocity or acceleration of a point.
#[derive(Debug, Clone)]
pub struct PointQuantity {
    /// Which derivative.
    pub order: Order,
    /// The point.
    pub end: End,
    /// Unit vector, in the axes below.
    pub axis: Option<Vector3<f64>>,
    /// `link_from_axes` of body axes; `None` for inertial axes.
    pub turn: Option<Matrix3<f64>>,
}

/// Distance of two points.
#[derive(Debug, Clone, Copy)]
pub struct DistanceQuantity {
    /// The points.
    pub ends: [End; 2],
}

/// Angle between two directions.
#[derive(Debug, Clone, Copy)]
pub struct AngleQuantity {
    /// Links and unit vectors in their axes: `of`, `against`.
    pub directions: [(usize, Vector3<f64>); 2],
    /// Unit vector in the axes of the second link.
    pub about: Option<Vector3<f64>>,
}

/// Orientation of a body.
#[derive(Debug, Clone, Copy)]
pub struct OrientationQuantity {
    /// Index of the body.
    pub body: usize,
}

/// Coordinates of a hinge.
#[derive(Debug, Clone)]
pub struct CoordinateQuantity {
    /// Indices into the position vector.
    pub range: Range<usize>,
}

/// Velocities of a hinge.
#[derive(Debug, Clone)]
pub struct RateQuantity {
    /// Indices into the velocity vector.
    pub range: Range<usize>,
}

/// What has a length.
#[derive(Debug, Clone, Copy)]
pub enum LengthQuantity {
    /// A force element, by its index.
    Line(usize),
    /// A beam, by its index.
    Beam(usize),
}

/// What an element pushes or pulls with.
#[derive(Debug, Clone)]
pub struct ForceQuantity {
    /// The element.
    pub source: Source,
    /// Which of six numbers; `None` for all there are.
    pub component: Option<usize>,
}

/// What has a force.
#[derive(Debug, Clone)]
pub enum Source {
    /// A spring, curve or rope by its index: its pull.
    Line(usize),
    /// Another force element by its index: six numbers at its last point.
    Element(usize),
    /// Index of a motor.
    Motor(usize),
    /// Index of a drive.
    Drive(usize),
    /// Index of a gear.
    Gear(usize),
    /// Index of a loop of type `rod`: its pull.
    Rod(usize),
    /// Index of any other loop: six numbers at its second end.
    Loop(usize),
    /// Index of a contact: what all that touches by it exerts on the second bodies, three numbers.
    Contact(usize),
    /// Velocity coordinates with stops.
    Stops(Vec<usize>),
}

/// What a hinge passes to its body.
#[derive(Debug, Clone, Copy)]
pub struct ReactionQuantity {
    /// Index of the body.
    pub body: usize,
    /// Which of six numbers.
    pub component: Option<usize>,
    /// In which axes.
    pub axes: Axes,
}

/// What a beam bears in a section.
#[derive(Debug, Clone, Copy)]
pub struct SectionQuantity {
    /// Index of the beam.
    pub beam: usize,
    /// Unstretched distance from its root (m).
    pub s: f64,
    /// Which of six numbers, or [`SectionQuantity::STRESS`].
    pub component: Option<usize>,
}

impl SectionQuantity {
    /// The component after the six section forces: von Mises' stress where it is largest in the section (Pa).
    pub const STRESS: usize = 6;
}

/// A formula in the time and the numbers of all outputs: variable 0 is the time (s), variable `k + 1` is number `k`.
#[derive(Debug, Clone)]
pub struct ExpressionQuantity {
    /// The formula.
    pub formula: Formula,
    /// It follows from outputs of lower depth: those that are no expressions have depth 0.
    pub depth: usize,
}
