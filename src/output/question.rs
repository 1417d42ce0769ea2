//! What every kind of output answers.

use crate::constraint::LoopReaction;
use crate::dynamics::{Balanced, Energies, Powers};
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use nalgebra::Vector3;

/// What a caller knows of a place besides its force balance.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a> {
    /// Hinge accelerations, those of the balance.
    pub accelerations: &'a [f64],
    /// What the hinge passes to each named body at its root marker, inertial axes.
    pub reactions: &'a [Wrench],
    /// What stops push each velocity coordinate with (N or N m); empty if none is touched.
    pub stops: &'a [f64],
    /// What each contact of the model exerts on its second bodies, inertial axes (N); empty if nothing touches.
    pub contacts: &'a [Vector3<f64>],
    /// Energies, with those of stops.
    pub energies: Energies,
    /// Work put in and energy taken out since the start of a run (J); zero in statics.
    pub account: [f64; 2],
    /// Powers; looked at only if [`Outputs::asks_power`](super::Outputs::asks_power).
    pub powers: Powers,
}

/// A direction in which a place varies; hinge coordinates, velocities and accelerations as in
/// [`Direction`](crate::motion::variation::Direction).
#[derive(Debug, Clone, Copy, Default)]
pub struct Varied<'a> {
    /// δt (s).
    pub time: f64,
    /// δq
    pub position: &'a [f64],
    /// δq̇
    pub velocity: &'a [f64],
    /// δq̈; empty where it is not known: variations of accelerations are not known then.
    pub acceleration: &'a [f64],
    /// Variations of all numbers of the outputs as the caller knows them, for those that cannot be had here; empty if none is.
    pub others: &'a [f64],
}

/// A place at which outputs are evaluated.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    pub(super) balanced: &'a Balanced<'a>,
    pub(super) given: &'a Given<'a>,
    /// What loops pass, in the order of the model; empty if no output asks for it.
    pub(super) loops: &'a [LoopReaction],
    /// The time (s), then the numbers of the outputs, those of lower depth being known.
    pub(super) values: &'a [f64],
}

/// How a place varies.
#[derive(Clone, Copy)]
pub(super) struct Variation<'a> {
    pub(super) links: &'a [LinkVariation],
    pub(super) by: &'a Varied<'a>,
    /// Of the time, then of the outputs, those of lower depth being known.
    pub(super) values: &'a [f64],
}

/// A kind of output.
pub(super) trait Measure {
    /// Its numbers at a place.
    fn value(&self, at: &At<'_>, out: &mut [f64]);

    /// Their variations; false if they are not known.
    fn vary(&self, _at: &At<'_>, _by: &Variation<'_>, _out: &mut [f64]) -> bool {
        false
    }
}
