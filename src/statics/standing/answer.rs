//! The answer about a pose: whether it stands, by how much, and how it would give way.

use super::closed::Contact;
use super::mechanism::Mechanism;
use crate::contact::support::{Certificate, Verdict};
use crate::statics::certify::stability::Stability;
use nalgebra::Vector3;

/// What a contact bears.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactForce {
    /// Where, and between which bodies.
    pub contact: Contact,
    /// On the second body, inertial axes (N).
    pub force: Vector3<f64>,
    /// Part of the cone that it uses, 0 … 1.
    pub share: f64,
}

/// What dry friction of a hinge holds.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionForce {
    /// The hinge, as in [`crate::model::Model::label`].
    pub hinge: String,
    /// First velocity coordinate.
    pub velocity: usize,
    /// (N or N m), one number per velocity coordinate that is bounded together.
    pub force: Vec<f64>,
    /// Part of what it can hold, 0 … 1.
    pub share: f64,
}

/// Whether a pose stands.
#[derive(Debug, Clone)]
pub struct StandingReport {
    /// The verdict.
    pub verdict: Verdict,
    /// What there is to spare, or is lacking (negative), in parts of the loads.
    pub slack: f64,
    /// What closed contacts bear: the forces of least norm if it stands, else those that come nearest.
    pub contacts: Vec<ContactForce>,
    /// What dry friction holds.
    pub friction: Vec<FrictionForce>,
    /// Dimension of the forces that balance each other at supports that bear.
    pub self_stresses: usize,
    /// The smallest part of all coefficients and bounds of friction at which it stands; `None` if no friction changes the
    /// verdict.
    pub friction_margin: Option<f64>,
    /// The ranges that were asked for.
    pub margins: Margins,
    /// What a wedged scene has to be squeezed with at least (N).
    pub squeeze: Option<f64>,
    /// How it gives way: along which motion it falls, or would fall first as friction is taken away.
    pub mechanism: Option<Mechanism>,
    /// How far the answer is from exact.
    pub certificate: Certificate,
    /// What kind of rest it is along the motions that contacts leave free; `None` if it does not stand.
    pub(in crate::statics) stability: Option<Stability>,
    /// What rigid stops that are touched push with: velocity coordinate and force (N or N m).
    pub(super) stop_forces: Vec<(usize, f64)>,
}

/// A range of values within which a pose stands, and how it gives way at both ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    /// What moves.
    pub name: String,
    /// Lowest and highest value; infinite if nothing gives way.
    pub range: [f64; 2],
    /// Hinge velocities of the mechanism at each end; empty if nothing gives way.
    pub motions: [Vec<f64>; 2],
}

/// All ranges that were asked for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Margins {
    /// Of numbers of the scene, by address.
    pub numbers: Vec<Interval>,
    /// Horizontal load in parts of the weight, by direction (`+x`, `-y`, …), and the mechanism there.
    pub tilt: Vec<(String, f64, Vec<f64>)>,
    /// Of inputs that are unknown: the range of each, the others being free.
    pub inputs: Vec<Interval>,
    /// Which of them no program decides, and why: the verdict stands without them; and from where on a scene stands only if it has been
    /// squeezed.
    pub notes: Vec<String>,
}
