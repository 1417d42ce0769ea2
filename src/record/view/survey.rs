//! What is learnt of a recording before it is drawn: how much room the motion takes, what moves, what pulls.

use super::forces::tension;
use crate::record::drawing::bounds::{Bounds, Outline};
use crate::record::{Sample, Scene, Tubes};
use crate::spatial::Pose;
use nalgebra::{Point3, Vector3};

/// Most points of a trace.
const TRACE: usize = 2000;

/// What all samples together say.
#[derive(Debug, Clone, Default)]
pub(super) struct Survey {
    /// Room of the motion.
    pub(super) bounds: Bounds,
    /// How far each hinge coordinate moves, and each velocity.
    pub(super) positions: Vec<Range>,
    pub(super) velocities: Vec<Range>,
    /// What each coupling pushes, or how wide it gapes.
    pub(super) couplings: Vec<Range>,
    /// How far each energy is from zero: kinetic, potential, work, dissipated, error.
    pub(super) energies: [f64; 5],
    /// The largest pull of a spring (N).
    pub(super) tension: f64,
    /// The largest reaction (N).
    pub(super) reaction: f64,
    /// What beams bear at most (Pa, or N m if one has no size).
    pub(super) borne: f64,
    tubes: Tubes,
    /// Number of samples.
    pub(super) samples: usize,
}

/// Least and greatest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range(f64, f64);

impl Default for Range {
    fn default() -> Self {
        Self(f64::INFINITY, f64::NEG_INFINITY)
    }
}

impl Range {
    fn include(&mut self, value: f64) {
        *self = Self(self.0.min(value), self.1.max(value));
    }

    /// Greatest less least; zero of nothing.
    pub(super) fn width(self) -> f64 {
        (self.1 - self.0).max(0.0)
    }

    /// The greatest magnitude; zero of nothing.
    pub(super) fn largest(self) -> f64 {
        self.1.max(-self.0).max(0.0)
    }
}

impl Survey {
    /// Nothing learnt yet.
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            positions: vec![Range::default(); scene.positions.len()],
            velocities: vec![Range::default(); scene.velocities.len()],
            couplings: vec![Range::default(); scene.couplings.len()],
            tubes: Tubes::new(scene),
            ..Self::default()
        }
    }

    /// Learns from a sample whose arrays fit the scene.
    pub(super) fn include(&mut self, sample: &Sample, scene: &Scene, outlines: &[Outline]) {
        self.bounds.include_bodies(outlines, sample.bodies);
        self.bounds.include_ends(scene.ends(), sample.bodies);
        scene.curves.iter().for_each(|curve| self.bounds.include_curve(curve, sample.bodies));
        self.positions.iter_mut().zip(sample.positions).for_each(|(range, x)| range.include(*x));
        self.velocities.iter_mut().zip(sample.velocities).for_each(|(range, x)| range.include(*x));
        self.couplings.iter_mut().zip(sample.couplings).for_each(|(range, x)| range.include(*x));
        let energy = &sample.energy;
        let energies = [energy.kinetic, energy.potential, energy.work, energy.dissipated, energy.error];
        self.energies.iter_mut().zip(energies).for_each(|(largest, x)| *largest = largest.max(x.abs()));
        self.include_forces(sample, scene);
        self.samples += 1;
    }

    /// The pulls and reactions of a sample alone.
    pub(super) fn include_forces(&mut self, sample: &Sample, scene: &Scene) {
        let pulls = scene.lines.iter().filter_map(|line| tension(line, sample.bodies));
        self.tension = pulls.map(f64::abs).filter(|x| x.is_finite()).fold(self.tension, f64::max);
        let reactions = sample.reactions.iter().map(|reaction| reaction.force.norm());
        self.reaction = reactions.filter(|x| x.is_finite()).fold(self.reaction, f64::max);
        if !self.tubes.is_empty() {
            // Loads follow from what bodies pass on: cross sections need no places.
            let loads = self.tubes.loads(sample.bodies, sample.reactions).into_iter();
            self.borne = loads.filter(|x| x.is_finite()).fold(self.borne, f64::max);
        }
    }
}

/// The centre of mass of the whole scene; `None` if nothing that moves has mass.
pub(super) fn center_of_mass(scene: &Scene, poses: &[Pose]) -> Option<Vector3<f64>> {
    let mut mass = 0.0;
    let mut moment = Vector3::zeros();
    for (body, pose) in scene.bodies.iter().zip(poses) {
        mass += body.mass;
        moment += body.mass * (pose * Point3::from(body.center)).coords;
    }
    (mass > 0.0).then(|| moment / mass)
}

/// The way of a point, with as many points as can be seen.
#[derive(Debug, Clone)]
pub(super) struct Trace {
    points: Vec<[f32; 3]>,
    stride: usize,
    skipped: usize,
}

impl Default for Trace {
    fn default() -> Self {
        Self { points: Vec::new(), stride: 1, skipped: 0 }
    }
}

impl Trace {
    /// Adds a point, or leaves it out where there are many.
    pub(super) fn push(&mut self, point: [f32; 3]) {
        self.skipped += 1;
        if self.skipped < self.stride && !self.points.is_empty() {
            return;
        }
        self.skipped = 0;
        self.points.push(point);
        if self.points.len() >= TRACE {
            let mut keep = [true, false].into_iter().cycle();
            self.points.retain(|_| keep.next().unwrap_or(true));
            self.stride *= 2;
        }
    }

    /// What is drawn.
    pub(super) fn points(&self) -> &[[f32; 3]] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_stays_short_and_keeps_its_ends() {
        let mut trace = Trace::default();
        (0..100_000).for_each(|k| trace.push([k as f32, 0.0, 0.0]));
        let points = trace.points();
        assert!(points.len() < TRACE && points.len() >= TRACE / 2, "{}", points.len());
        assert_eq!(points[0][0], 0.0);
        assert!(points[points.len() - 1][0] > 99_000.0);
        assert!(points.windows(2).all(|pair| pair[1][0] > pair[0][0]));
    }
}
