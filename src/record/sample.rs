//! One instant of a run.

use crate::spatial::{Pose, Wrench};

/// What is recorded at one instant: borrowed from the run, no copies.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// Simulated time [s].
    pub time: f64,
    /// Hinge coordinates, in the order of `Scene::positions`.
    pub positions: &'a [f64],
    /// Hinge velocities, in the order of `Scene::velocities`.
    pub velocities: &'a [f64],
    /// Hinge accelerations.
    pub accelerations: &'a [f64],
    /// Poses of the named bodies' root markers: `world_from_body`.
    pub bodies: &'a [Pose],
    /// What the hinge passes to each named body at its root marker, inertial axes.
    pub reactions: &'a [Wrench],
    /// Where the energy is.
    pub energy: Energy,
}

/// The energy ledger [J].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Kinetic.
    pub kinetic: f64,
    /// Gravity, springs, and loads of constant direction.
    pub potential: f64,
    /// Work done since the start by what is neither conservative nor a damper.
    pub work: f64,
    /// Taken out by dampers since the start.
    pub dissipated: f64,
    /// `kinetic + potential + dissipated − work`, less its value at the start: zero but for integration error.
    pub error: f64,
}
