//! What flexible beams bear: section forces along them, from the balance and from their strains.

use super::evaluated::Balanced;
use crate::element::{Rod, RodMotion, joined};
use crate::model::Beam;
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

    fn beam(&self, beam: &Beam) -> BeamState {
        let system = self.system;
        let (mut sections, mut gaps) = (Vec::new(), [0.0_f64; 2]);
        for (index, element) in beam.elements.iter().enumerate() {
            let (rod, at) = (&system.model.rods[element.rod], &system.motion.rods[element.rod]);
            let felt = &system.balance.rods[element.rod];
            // A tip that is the root of the next element has been told with it.
            for k in usize::from(index > 0)..=rod.steps() {
                let forces = section(rod, at, felt, k, &system.model.gravity);
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
        BeamState { name: beam.name.clone(), tip, sections, discretization_error, strains }
    }
}

/// The forces in the section at a station. Of the slice there only the part counts that stands for the length beyond, so that
/// the weight beyond is exact.
fn section(rod: &Rod, at: &RodMotion, felt: &RodBalance, k: usize, gravity: &Vector3<f64>) -> Vector6<f64> {
    let (slice, link, a) = (&rod.slices[k], &at.stations[k].link, &felt.accelerations[k]);
    let after: f64 = rod.slices[k + 1..].iter().map(|slice| slice.length).sum();
    let beyond = (rod.length - slice.at - after) / slice.length;
    let w = link.angular_velocity;
    let own = Wrench {
        force: slice.mass * (a.linear - gravity) - rod.load_at(k, &link.turn),
        moment: link.inertia * a.angular + w.cross(&(link.inertia * w)),
    };
    // The slice at the root belongs to the link there.
    let mut f = felt.forces[k];
    f.add_times(if k == 0 { 1.0 } else { beyond - 1.0 }, &own);
    let (force, moment) = (link.turn.tr_mul(&f.force), link.turn.tr_mul(&f.moment));
    -joined(&force, &moment)
}
