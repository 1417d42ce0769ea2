//! What flexible beams bear: section forces along them, from the balance and from their strains, and the stress that they make.

mod diagram;
mod locked;
mod section;

pub use diagram::DiagramPoint;
pub(crate) use locked::LockedStrain;

use super::evaluated::Balanced;
use crate::element::stress::Stress;
use crate::model::Beam;
use crate::model::beam::{BeamElement, MUCH_TURN, Wound};
use crate::round_off::{EQUILIBRIUM, FORCE};
use crate::spatial::Pose;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3, Vector6};

/// The forces in one section, in its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionForces {
    /// Distance from the beam's root along the unstrained centre line (m).
    pub s: f64,
    /// What the part beyond exerts on the part before: normal force (tension > 0), shear forces along y and z (N), torque
    /// about x, bending moments about y and z (N m). From the balance of all that is beyond.
    pub forces: Vector6<f64>,
    /// The largest stress in the section; `None` of a section without a size.
    pub stress: Option<Stress>,
}

/// A beam at one state.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamState {
    /// Name.
    pub name: String,
    /// Whether it is a cable.
    pub is_cable: bool,
    /// Its tip: `world_from_tip`.
    pub tip: Pose,
    /// At all stations from the root to the tip.
    pub sections: Vec<SectionForces>,
    /// The largest stress of the beam: where von Mises' is largest along it, and its distance from the root (m); `None` if its
    /// sections have no size.
    pub stress: Option<(f64, Stress)>,
    /// How far the beam is from the exact solution for its loads.
    pub error: Discretization,
    /// The coordinates of its elements: lengths (m) and angles (rad) over one element.
    pub strains: Vec<Vec<f64>>,
}

/// What the two ways of computing section forces say about the elements of a beam: those that follow from the free strains, and those
/// that balance all that is beyond.
///
/// Both errors are parts of one. With `C` the stiffness of the free strains, `F` the forces of the balance and `G` their distance from
/// those of the strains,
///
/// ```text
/// (1)  forces = max |G| / max |F|                        ~ h^(p + 1)      forces by the length of the beam are moments
/// (2)  deflections = ∫ Gᵀ C⁻¹ G ds / ∫ Fᵀ C⁻¹ F ds        ~ h^(2 p + 2)
/// ```
///
/// For small deflections the error of the work of the loads is (2) exactly, if `F` is: strains that are compatible and forces that
/// balance are apart by the sum of both errors (Prager and Synge, 1947).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Discretization {
    /// Of the section forces: (1).
    pub forces: f64,
    /// Of deflections under the loads: (2).
    pub deflections: f64,
    /// Number of elements.
    pub elements: usize,
    /// Degree of their strains.
    pub degree: usize,
    /// The most that an element turns by (rad).
    pub turn: f64,
    /// Whether the section forces are no more than the round-off of the forces in the scene and of those that strains of one would
    /// make: then there is nothing to be wrong, and both errors are zero.
    pub idle: bool,
}

/// Up to this error by (2), a fifth of the whole in the norm of energy, errors fall as their leading term does.
const ASYMPTOTIC: f64 = 0.05;

/// An error of section forces below this is rounding.
const EXACT: f64 = 1e-9;

impl Discretization {
    /// How many elements have an error of the section forces of a given size, if it falls as (1) says: if it is not
    /// [asymptotic](Self::is_asymptotic), at least so many are needed.
    pub fn elements_for(&self, forces: f64) -> usize {
        let falls = (self.forces / forces).powf(1.0 / (self.degree + 1) as f64);
        let turns = if self.is_asymptotic() { 0.0 } else { self.turn / MUCH_TURN };
        ((self.elements as f64 * falls.max(turns)).ceil() as usize).max(1)
    }

    /// Whether the errors are so small that they fall as (1) and (2) say.
    pub fn is_asymptotic(&self) -> bool {
        self.forces < EXACT || (self.turn <= MUCH_TURN && self.deflections <= ASYMPTOTIC)
    }
}

/// Sums over the sections of a beam.
#[derive(Default)]
struct Gaps {
    /// The largest gaps of forces and of moments (N, N m).
    most: [f64; 2],
    /// The integrals above and below the line of the estimate of deflections (J).
    energies: [f64; 2],
}

impl Balanced<'_> {
    /// All beams, for the accelerations of the balance.
    pub fn beams(&self) -> Vec<BeamState> {
        self.system.model.beams.iter().map(|beam| self.beam(beam)).collect()
    }

    /// The beams with elements that turn by more than 1.5 rad, each with the error of its deflections over its length as (2) estimates
    /// it: what has no bending stiffness has none, and (2) says nothing of it.
    pub(crate) fn wound(&self, q: &[f64]) -> Vec<(Wound, f64)> {
        let beams = self.system.model.beams.iter();
        let wound = self.system.model.wound(q).into_iter().filter_map(|wound| {
            let beam = beams.clone().find(|beam| beam.name == wound.beam)?;
            let rods = beam.elements.iter().map(|element| &self.system.model.rods[element.rod]);
            let bends = rods.into_iter().any(|rod| rod.sections.iter().any(|of| of[(4, 4)] != 0.0));
            let error = self.beam(beam).error.deflections * self.deflection(beam) / beam.length;
            Some((wound, if bends { error } else { 0.0 }))
        });
        wound.collect()
    }

    /// How far the ends of elements are from where they are without strain, at most, seen from the root (m).
    fn deflection(&self, beam: &Beam) -> f64 {
        let (model, motion) = (&self.system.model, &self.system.motion);
        let Some(first) = beam.elements.first() else { return 0.0 };
        let root = motion.rods[first.rod].stations[0].link.pose();
        let (mut turn, mut place, mut most) = (Matrix3::identity(), Vector3::zeros(), 0.0_f64);
        for element in &beam.elements {
            let rod = &model.rods[element.rod];
            let (r, p) = rod.pose_at(rod.length, &vec![0.0; rod.count()]);
            (turn, place) = (turn * r, place + turn * p);
            let reached = root.inverse() * motion.links[element.link].pose();
            most = most.max((reached.translation.vector - place).norm());
        }
        most
    }

    /// How long the centre line of a beam is now (m).
    pub(crate) fn beam_length(&self, beam: usize) -> f64 {
        let of = |element: &BeamElement| {
            let (rod, at) = (&self.system.model.rods[element.rod], &self.system.motion.rods[element.rod]);
            rod.stretched(&at.q)
        };
        self.system.model.beams[beam].elements.iter().map(of).sum()
    }

    /// What round-off leaves of section forces (N m; forces by the length of the beam).
    fn round_off(&self, beam: &Beam) -> f64 {
        let of_scene = self.magnitudes().force.iter().fold(0.0_f64, |most, x| most.max(*x)) * beam.length.max(1.0);
        let mut of_strains = 0.0_f64;
        for element in &beam.elements {
            let rod = &self.system.model.rods[element.rod];
            for strain in rod.free_strains() {
                let by = if strain < 3 { beam.length } else { 1.0 / beam.length };
                rod.sections.iter().for_each(|of| of_strains = of_strains.max(by * of[(strain, strain)]));
            }
        }
        EQUILIBRIUM.of(of_scene) + FORCE.of(of_strains)
    }

    fn beam(&self, beam: &Beam) -> BeamState {
        let system = self.system;
        let (mut sections, mut gaps) = (Vec::new(), Gaps::default());
        for (index, element) in beam.elements.iter().enumerate() {
            let (rod, at) = (&system.model.rods[element.rod], &system.motion.rods[element.rod]);
            let free: Vec<usize> = rod.free_strains().collect();
            for k in 0..=rod.steps() {
                let slice = &rod.slices[k];
                let forces = self.section_of(element, slice.at);
                // A tip that is the root of the next element has been told with it.
                if index == 0 || k > 0 {
                    let s = element.from + slice.at;
                    let stress = beam.section_at(s).stress(&forces);
                    sections.push(SectionForces { s, forces, stress });
                }
                let gap = rod.sections[k] * rod.strained(slice.at, &at.q) - forces;
                gaps.add(&rod.sections[k], &free, [&gap, &forces], slice.length);
            }
        }
        let largest = |from: usize| {
            let all = sections.iter().flat_map(|section| section.forces.iter().skip(from).take(3));
            all.fold(0.0, |most: f64, x| most.max(x.abs()))
        };
        // Forces and moments by one measure: a force over the length of the beam is a moment.
        let size = largest(3).max(beam.length * largest(0));
        let idle = size <= self.round_off(beam);
        let part = |of: f64, whole: f64| if whole > 0.0 && !idle { of / whole } else { 0.0 };
        let turns = beam
            .elements
            .iter()
            .map(|element| system.model.rods[element.rod].winding(&system.motion.rods[element.rod].q));
        let error = Discretization {
            forces: part(gaps.most[1].max(beam.length * gaps.most[0]), size),
            deflections: part(gaps.energies[0], gaps.energies[1]),
            elements: beam.elements.len(),
            degree: beam.degree,
            turn: turns.fold(0.0, f64::max),
            idle,
        };
        let tip = beam.elements.last().map_or(Pose::identity(), |last| system.motion.links[last.link].pose());
        let strains = beam.elements.iter().map(|element| system.motion.rods[element.rod].q.clone()).collect();
        let stress = self.largest_stress(beam, &sections);
        BeamState { name: beam.name.clone(), is_cable: beam.is_cable, tip, sections, stress, error, strains }
    }
}

impl Gaps {
    /// Adds a station with a weight (m): the gap and the forces there, as far as strains are free.
    fn add(&mut self, stiffness: &Matrix6<f64>, free: &[usize], of: [&Vector6<f64>; 2], weight: f64) {
        for strain in free {
            let most = &mut self.most[usize::from(*strain >= 3)];
            *most = most.max(of[0][*strain].abs());
        }
        // Bending without stiffness bears nothing.
        let stiff: Vec<usize> = free.iter().copied().filter(|i| stiffness[(*i, *i)] > 0.0).collect();
        let inner = DMatrix::from_fn(stiff.len(), stiff.len(), |i, j| stiffness[(stiff[i], stiff[j])]);
        let Some(inner) = inner.cholesky() else { return };
        for (sum, of) in self.energies.iter_mut().zip(of) {
            let forces = DVector::from_iterator(stiff.len(), stiff.iter().map(|i| of[*i]));
            *sum += weight * forces.dot(&inner.solve(&forces));
        }
    }
}
