//! Beams at an instant: cross sections along them, placed by the exact shape of their elements, and what these bear.
//!
//! Poses of cross sections are kept behind those of the bodies, in one list: whoever moves by poses moves beams, too.

use super::Scene;
use super::beam::{BeamPicture, ElementPicture, SectionPicture};
use crate::element::section::Section;
use crate::element::{Rod, RodSection};
use crate::round_off::BEAM_LOAD;
use crate::spatial::{Pose, Wrench};
use nalgebra::{Isometry3, Matrix6, Rotation3, Translation3, UnitQuaternion, Vector3, Vector6};

/// Stretches of an element between cross sections; in long beams fewer.
const STRETCHES: usize = 10;
/// Cross sections of one beam, about, at most.
const MOST_RINGS: usize = 1500;

/// All beams of a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tubes {
    pub(super) beams: Vec<Tube>,
    /// How many bodies there are before the cross sections.
    bodies: usize,
    /// The size of the scene's forces and moments (N, N m).
    force: f64,
}

/// One beam.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tube {
    pub(super) name: String,
    pub(super) begin: usize,
    elements: Vec<Element>,
    /// Index of its first cross section in the list of poses.
    pub(super) first: usize,
    /// The sections of all its cross sections, from the root to the tip.
    pub(super) sections: Vec<Section>,
    /// Radius of a section that has no size (m).
    pub(super) wire: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct Element {
    rod: Rod,
    /// Index of its first coordinate in the positions of a sample.
    first: usize,
    body: usize,
    stretches: usize,
}

impl Tubes {
    /// Of a scene. A beam whose coordinates are not among the positions is left out.
    pub fn new(scene: &Scene) -> Self {
        let mut tubes = Self { beams: Vec::new(), bodies: scene.bodies.len(), force: scene.force_size() };
        let mut first = tubes.bodies;
        for beam in &scene.beams {
            let Some(tube) = Tube::new(scene, beam, first) else { continue };
            first += tube.sections.len();
            tubes.beams.push(tube);
        }
        tubes
    }

    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.beams.is_empty()
    }

    /// How many cross sections there are.
    pub fn count(&self) -> usize {
        self.beams.iter().map(|tube| tube.sections.len()).sum()
    }

    /// Adds the poses of all cross sections to those of the bodies.
    pub fn extend(&self, positions: &[f64], poses: &mut Vec<Pose>) {
        poses.truncate(self.bodies);
        for tube in &self.beams {
            let mut root = poses.get(tube.begin).copied().unwrap_or_default();
            poses.push(root);
            for element in &tube.elements {
                let q = positions.get(element.first..).unwrap_or_default();
                for k in 1..=element.stretches {
                    let s = element.rod.length * k as f64 / element.stretches as f64;
                    let (turn, place) = element.rod.pose_at(s, q);
                    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
                    poses.push(root * Isometry3::from_parts(Translation3::from(place), turn));
                }
                root = poses.get(element.body).copied().unwrap_or(root);
            }
        }
    }

    /// Whether all sections have a size: what is shown is von Mises' stress then, otherwise the moment.
    pub fn show_stress(&self) -> bool {
        let has_size = |section: &Section| section.geometry().is_some();
        !self.is_empty() && self.beams.iter().all(|tube| tube.sections.iter().all(has_size))
    }

    /// What the cross sections bear, in the order of their poses: the largest stress (Pa), or the moment (N m) if a section has no
    /// size. Forces are those that the elements' tips pass on, and linear between these; what is round-off of the forces of the scene is zero.
    pub fn loads(&self, poses: &[Pose], reactions: &[Wrench]) -> Vec<f64> {
        let by_stress = self.show_stress();
        let mut loads = Vec::new();
        for tube in &self.beams {
            let at = |body: usize| {
                let (pose, wrench) = (poses.get(body).copied().unwrap_or_default(), reactions.get(body));
                let back = |v: &Vector3<f64>| pose.rotation.inverse() * v;
                wrench.map_or(Vector6::zeros(), |wrench| {
                    let (force, moment) = (back(&wrench.force), back(&wrench.moment));
                    -Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
                })
            };
            let mut before = at(tube.begin);
            let mut sections = tube.sections.iter();
            let mut take = |forces: Vector6<f64>| {
                let forces = self.without_noise(forces);
                let stress = sections.next().and_then(|section| section.stress(&forces)).filter(|_| by_stress);
                loads.push(stress.map_or(forces.fixed_rows::<3>(3).norm(), |stress| stress.von_mises));
            };
            take(before);
            for element in &tube.elements {
                let after = at(element.body);
                for k in 1..=element.stretches {
                    let part = k as f64 / element.stretches as f64;
                    take(before + part * (after - before));
                }
                before = after;
            }
        }
        loads
    }

    /// Forces and moments (N, N m), zero for those that are round-off of the scene's.
    fn without_noise(&self, mut forces: Vector6<f64>) -> Vector6<f64> {
        for first in [0, 3] {
            if BEAM_LOAD.hides(forces.fixed_rows::<3>(first).norm(), self.force) {
                forces.fixed_rows_mut::<3>(first).fill(0.0);
            }
        }
        forces
    }
}

impl Tube {
    fn new(scene: &Scene, beam: &BeamPicture, first: usize) -> Option<Self> {
        let stretches = (MOST_RINGS / beam.elements.len().max(1)).clamp(1, STRETCHES);
        let elements = beam.elements.iter().map(|element| Element::new(scene, element, stretches));
        let elements: Vec<Element> = elements.collect::<Option<_>>()?;
        let mut sections = vec![section_at(&beam.sections, 0.0)];
        for (element, picture) in elements.iter().zip(&beam.elements) {
            let within = (1..=stretches).map(|k| element.rod.length * k as f64 / stretches as f64);
            sections.extend(within.map(|s| section_at(&beam.sections, picture.from + s)));
        }
        let wire = beam.sections.iter().find(|section| section.kind == "wire").and_then(|section| section.size.first());
        let length = elements.iter().map(|element| element.rod.length).sum::<f64>();
        let wire = wire.copied().filter(|radius| *radius > 0.0).unwrap_or(2e-3 * length);
        Some(Self { name: beam.name.clone(), begin: beam.begin, elements, first, sections, wire })
    }

    /// The body at its tip.
    pub(super) fn tip(&self) -> usize {
        self.elements.last().map_or(self.begin, |element| element.body)
    }
}

impl Element {
    fn new(scene: &Scene, picture: &ElementPicture, stretches: usize) -> Option<Self> {
        let none = RodSection { stiffness: Matrix6::zeros(), mass: 0.0, rotary: Vector3::zeros() };
        let reference: Vec<Vector6<f64>> = picture.reference.iter().map(|of| Vector6::from(*of)).collect();
        let rod = Rod::new(picture.length, picture.degree, &picture.free, &reference, |_| none);
        let owner = &scene.bodies[picture.body].name;
        let first = scene.positions.iter().position(|channel| channel.body == *owner)?;
        (first + rod.count() <= scene.positions.len()).then_some(Self { rod, first, body: picture.body, stretches })
    }
}

fn section_at(sections: &[SectionPicture], s: f64) -> Section {
    let of = |picture: &SectionPicture| match (picture.kind.as_str(), &picture.size[..]) {
        ("circle", &[radius]) => Section::Circle { radius },
        ("tube", &[outer, inner]) => Section::Tube { outer, inner },
        ("rectangle", &[width, height]) => Section::Rectangle { width, height },
        _ => Section::Stiffness(Matrix6::zeros()),
    };
    let after = sections.partition_point(|section| section.at <= s);
    match (sections.get(after.wrapping_sub(1)), sections.get(after)) {
        (Some(one), Some(other)) => {
            let part = (s - one.at) / (other.at - one.at);
            of(one).between(&of(other), part).unwrap_or_else(|| of(one))
        }
        (Some(only), None) | (None, Some(only)) => of(only),
        (None, None) => Section::Stiffness(Matrix6::zeros()),
    }
}
