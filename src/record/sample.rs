//! One instant of a run.

use super::{RecordError, Scene};
use crate::spatial::{Pose, Wrench};

/// What is recorded at one instant: borrowed from the run, no copies.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// Simulated time (s).
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
    /// What drives, motors, gears and loops push with, in the order of `Scene::couplings`.
    pub couplings: &'a [f64],
    /// Outputs, in the order of `Scene::outputs`.
    pub outputs: &'a [f64],
    /// Where the energy is.
    pub energy: Energy,
}

/// The energy ledger (J).
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

impl Sample<'_> {
    /// A copy that stands on its own.
    pub fn to_owned(&self) -> OwnedSample {
        OwnedSample {
            time: self.time,
            positions: self.positions.to_vec(),
            velocities: self.velocities.to_vec(),
            accelerations: self.accelerations.to_vec(),
            bodies: self.bodies.to_vec(),
            reactions: self.reactions.to_vec(),
            couplings: self.couplings.to_vec(),
            outputs: self.outputs.to_vec(),
            energy: self.energy,
        }
    }

    /// Checks that the arrays are as long as the scene says.
    pub(super) fn check(&self, scene: &Scene) -> Result<(), RecordError> {
        let lengths = [
            ("positions", self.positions.len(), scene.positions.len()),
            ("velocities", self.velocities.len(), scene.velocities.len()),
            ("accelerations", self.accelerations.len(), scene.velocities.len()),
            ("body poses", self.bodies.len(), scene.bodies.len()),
            ("reactions", self.reactions.len(), scene.bodies.len()),
            ("couplings", self.couplings.len(), scene.couplings.len()),
            ("outputs", self.outputs.len(), scene.outputs.len()),
        ];
        match lengths.into_iter().find(|(_, found, expected)| found != expected) {
            Some((what, found, expected)) => Err(RecordError::Mismatch { time: self.time, what, found, expected }),
            None => Ok(()),
        }
    }
}

/// One instant, standing on its own: what a reader gives back.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OwnedSample {
    /// Simulated time (s).
    pub time: f64,
    /// Hinge coordinates, in the order of `Scene::positions`.
    pub positions: Vec<f64>,
    /// Hinge velocities, in the order of `Scene::velocities`.
    pub velocities: Vec<f64>,
    /// Hinge accelerations.
    pub accelerations: Vec<f64>,
    /// Poses of the named bodies' root markers: `world_from_body`.
    pub bodies: Vec<Pose>,
    /// What the hinge passes to each named body at its root marker, inertial axes.
    pub reactions: Vec<Wrench>,
    /// What drives, motors, gears and loops push with, in the order of `Scene::couplings`.
    pub couplings: Vec<f64>,
    /// Outputs, in the order of `Scene::outputs`.
    pub outputs: Vec<f64>,
    /// Where the energy is.
    pub energy: Energy,
}

impl OwnedSample {
    /// This sample, borrowed.
    pub fn borrow(&self) -> Sample<'_> {
        Sample {
            time: self.time,
            positions: &self.positions,
            velocities: &self.velocities,
            accelerations: &self.accelerations,
            bodies: &self.bodies,
            reactions: &self.reactions,
            couplings: &self.couplings,
            outputs: &self.outputs,
            energy: self.energy,
        }
    }
}
