//! What couples hinges beyond the tree, as a user describes it: closed loops, drives and gears.

use super::description::{Attachment, HingeKind};
use nalgebra::UnitQuaternion;

/// Closes a kinematic loop: a hinge, or a rigid rod, between two points that are already connected through the tree.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopDescription {
    /// Unique name; scenario files without one get `loop[i]`.
    pub name: String,
    /// What joins the two ends.
    pub closure: Closure,
    /// The two ends; the loop's frame is carried by the first.
    pub between: [Attachment; 2],
    /// Turn of the loop's frame in the first body: `first_body_from_loop`.
    pub frame: UnitQuaternion<f64>,
    /// Turn of the loop's frame in the second body: `second_body_from_loop`. `None`: the frames coincide in the
    /// positions as they are given.
    pub second_frame: Option<UnitQuaternion<f64>>,
}

/// What joins the two ends of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Closure {
    /// A hinge; axes in the loop's frame.
    Hinge(HingeKind),
    /// A rigid rod without mass, free to turn at both ends.
    Rod {
        /// Distance between the ends (m), > 0.
        length: f64,
    },
}

impl Closure {
    /// Name in scenario files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Hinge(kind) => kind.name(),
            Self::Rod { .. } => "rod",
        }
    }
}

/// A coordinate of a body's hinge.
#[derive(Debug, Clone, PartialEq)]
pub struct CoordinateName {
    /// The body whose hinge it is.
    pub body: String,
    /// Which of the hinge's coordinates, from 0; a turn or a slide, not a part of a quaternion.
    pub index: usize,
}

/// A hinge coordinate that follows a given motion, whatever force that takes.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveDescription {
    /// Unique name; scenario files without one get `drive[i]`.
    pub name: String,
    /// What is driven.
    pub coordinate: CoordinateName,
    /// The motion.
    pub motion: MotionDescription,
}

/// A motion of a coordinate over time, in m or rad. What it leaves open is taken from the hinge's given position.
#[derive(Debug, Clone, PartialEq)]
pub enum MotionDescription {
    /// Stays at the given position.
    Hold,
    /// At a constant rate from the given position.
    Rate {
        /// Rate (m/s or rad/s).
        rate: f64,
    },
    /// Smoothly from the given position to another one; velocity and acceleration vanish at both ends.
    Ramp {
        /// Where it ends (m or rad).
        to: f64,
        /// When it begins (s).
        begin: f64,
        /// How long it takes (s), > 0.
        duration: f64,
    },
    /// `offset + amplitude sin(2π frequency t + phase)`.
    Sine {
        /// (m or rad); `None`: the given position.
        offset: Option<f64>,
        /// Amplitude (m or rad).
        amplitude: f64,
        /// Frequency (Hz).
        frequency: f64,
        /// Phase (rad).
        phase: f64,
    },
    /// A cubic spline through points, at rest before the first and after the last.
    Table {
        /// (s), increasing.
        times: Vec<f64>,
        /// Values (m or rad).
        values: Vec<f64>,
    },
    /// A formula in the time `t` (s).
    Expression {
        /// As written.
        text: String,
    },
}

/// A fixed ratio between two coordinates: `q₁ = ratio q₂ + offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct GearDescription {
    /// Unique name; scenario files without one get `gear[i]`.
    pub name: String,
    /// The two coordinates.
    pub between: [CoordinateName; 2],
    /// What they have in common.
    pub kind: GearKind,
    /// The first where the second is zero (m or rad); `None`: they are engaged in the given positions. With an offset a
    /// first coordinate whose position is not given starts where the gear has it.
    pub offset: Option<f64>,
}

/// Kinds of gears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GearKind {
    /// The first moves `ratio` times as far as the second; both turn, or both slide.
    Ratio {
        /// Not zero.
        ratio: f64,
    },
    /// A rack (first, slides) on a pinion (second, turns).
    Rack {
        /// Distance per angle: the pinion's radius (m), not zero; negative for the other side.
        radius: f64,
    },
    /// A nut (first, slides) on a screw (second, turns).
    Screw {
        /// Distance per full turn (m), not zero; negative for a left-hand thread.
        lead: f64,
    },
}

impl GearKind {
    /// Name in scenario files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ratio { .. } => "ratio",
            Self::Rack { .. } => "rack",
            Self::Screw { .. } => "screw",
        }
    }

    /// `dq₁/dq₂`.
    pub fn factor(&self) -> f64 {
        match *self {
            Self::Ratio { ratio } => ratio,
            Self::Rack { radius } => radius,
            Self::Screw { lead } => lead / std::f64::consts::TAU,
        }
    }
}
