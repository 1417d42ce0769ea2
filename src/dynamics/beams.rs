//! What flexible beams bear: section forces along them, from the balance and from their strains.

use super::evaluated::Balanced;
use crate::element::{Rod, RodMotion, joined, quadrature};
use crate::model::Beam;
use crate::model::beam::BeamElement;
use crate::spatial::{Pose, Wrench};
use crate::transfer::flexible::RodBalance;
use nalgebra::{Vector3, Vector6};

/// The forces in one section, in its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionForces {
    /// Distance from the beam's root along the unstrained centre line (m).
    pub s: f64,
    /// What the part beyond exerts on the part before: normal force (tension > 0), shear forces along y and z (N), torque
    /// about x, bending moments about y and z (N m). From the balance of all that is beyond.
    pub forces: Vector6<f64>,
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
    /// How far the section forces of the free strains are from those of the balance at most, over the largest: an estimate of
    /// the error of the strains.
    pub discretization_error: f64,
    /// The coordinates of its elements: lengths (m) and angles (rad) over one element.
    pub strains: Vec<Vec<f64>>,
}

impl Balanced<'_> {
    /// All beams, for the accelerations of the balance.
    pub fn beams(&self) -> Vec<BeamState> {
        self.system.model.beams.iter().map(|beam| self.beam(beam)).collect()
    }

    /// What a beam bears at a distance from its root (m).
    pub(crate) fn section(&self, beam: usize, s: f64) -> Vector6<f64> {
        let elements = &self.system.model.beams[beam].elements;
        let element = elements.iter().rev().find(|element| element.from <= s).or(elements.first());
        element.map_or(Vector6::zeros(), |element| self.section_of(element, s - element.from))
    }

    /// What an element bears at a distance from its root: what the tip bears and the loads on the way to it, interpolated
    /// between the stations by the polynomial through them. If its integral differs from the sum of the stations at the root, the difference is shared out along the element: at both ends it bears what the balance says.
    fn section_of(&self, element: &BeamElement, s: f64) -> Vector6<f64> {
        let system = self.system;
        let (rod, at) = (&system.model.rods[element.rod], &system.motion.rods[element.rod]);
        let (felt, gravity) = (&system.balance.rods[element.rod], &system.model.gravity);
        let (last, root) = (rod.steps(), &at.stations[0].link);
        let place = |s: f64| {
            let (turn, place) = rod.pose_at(s, &at.q);
            (root.turn * turn, root.turn * place)
        };
        let per_length = |k: usize| own(rod, at, felt, k, gravity).times(1.0 / rod.slices[k].length);
        let of_stations: Vec<Wrench> = (0..=last).map(per_length).collect();
        let part = |k: usize, s: f64| {
            let others = (0..=last).filter(|j| *j != k);
            others.map(|j| (s - rod.slices[j].at) / (rod.slices[k].at - rod.slices[j].at)).product::<f64>()
        };
        // The slice at the tip belongs to the link there.
        let mut end = felt.forces[last];
        end.add_times(-1.0, &own(rod, at, felt, last, gravity));
        let beyond = |s: f64| {
            let here = place(s).1;
            let mut sum = end.shifted(place(rod.length).1 - here);
            for (node, weight) in quadrature() {
                let there = s + node * (rod.length - s);
                let mut load = Wrench::ZERO;
                of_stations.iter().enumerate().for_each(|(k, own)| load.add_times(part(k, there), own));
                sum.add_times(weight * (rod.length - s), &load.shifted(place(there).1 - here));
            }
            sum
        };
        let mut missed = felt.forces[0] + own(rod, at, felt, 0, gravity);
        missed.add_times(-1.0, &beyond(0.0));
        let (mut sum, turn) = (beyond(s), place(s).0);
        sum.add_times(1.0 - s / rod.length, &missed);
        -joined(&turn.tr_mul(&sum.force), &turn.tr_mul(&sum.moment))
    }

    /// How long the centre line of a beam is now (m).
    pub(crate) fn beam_length(&self, beam: usize) -> f64 {
        let of = |element: &BeamElement| {
            let (rod, at) = (&self.system.model.rods[element.rod], &self.system.motion.rods[element.rod]);
            rod.stretched(&at.q)
        };
        self.system.model.beams[beam].elements.iter().map(of).sum()
    }

    fn beam(&self, beam: &Beam) -> BeamState {
        let system = self.system;
        let (mut sections, mut gaps) = (Vec::new(), [0.0_f64; 2]);
        for (index, element) in beam.elements.iter().enumerate() {
            let (rod, at) = (&system.model.rods[element.rod], &system.motion.rods[element.rod]);
            // A tip that is the root of the next element has been told with it.
            for k in usize::from(index > 0)..=rod.steps() {
                let forces = self.section_of(element, rod.slices[k].at);
                sections.push(SectionForces { s: element.from + rod.slices[k].at, forces });
                let strained = rod.sections[k] * rod.strained(rod.slices[k].at, &at.q);
                for strain in rod.free_strains() {
                    let gap = (strained[strain] - forces[strain]).abs();
                    let of = usize::from(strain >= 3);
                    gaps[of] = gaps[of].max(gap);
                }
            }
        }
        let largest = |from: usize| {
            let all = sections.iter().flat_map(|section| section.forces.iter().skip(from).take(3));
            all.fold(0.0, |most: f64, x| most.max(x.abs()))
        };
        // Forces and moments by one measure: a force over the length of the beam is a moment.
        let size = largest(3).max(beam.length * largest(0));
        let discretization_error = if size > 0.0 { gaps[1].max(beam.length * gaps[0]) / size } else { 0.0 };
        let tip = beam.elements.last().map_or(Pose::identity(), |last| system.motion.links[last.link].pose());
        let strains = beam.elements.iter().map(|element| system.motion.rods[element.rod].q.clone()).collect();
        BeamState { name: beam.name.clone(), is_cable: beam.is_cable, tip, sections, discretization_error, strains }
    }
}

/// What a slice needs: its inertia with its weight, less the load on it.
fn own(rod: &Rod, at: &RodMotion, felt: &RodBalance, k: usize, gravity: &Vector3<f64>) -> Wrench {
    let (slice, link, a) = (&rod.slices[k], &at.stations[k].link, &felt.accelerations[k]);
    let w = link.angular_velocity;
    Wrench {
        force: slice.mass * (a.linear - gravity) - rod.load_at(k, &link.turn),
        moment: link.inertia * a.angular + w.cross(&(link.inertia * w)),
    }
}
