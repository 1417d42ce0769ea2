//! Section forces along a beam, element by element: what diagrams are drawn from, and where the stress is largest.

use super::SectionForces;
use crate::dynamics::evaluated::Balanced;
use crate::element::Rod;
use crate::element::stress::Stress;
use crate::model::Beam;
use nalgebra::{Matrix6, Vector6};

/// Stretches of an element between which a maximum is looked for.
const FINE: usize = 10;

/// What a beam bears at a point of an element. Where two elements meet there is one of each: loads at the joint are between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiagramPoint {
    /// Index of the element, from the root.
    pub element: usize,
    /// What it bears by the balance, at which distance, with which stress.
    pub section: SectionForces,
    /// The section forces that follow from the strains; not a number where a strain is not free.
    pub by_strains: Vector6<f64>,
}

impl Balanced<'_> {
    /// A beam at equal distances within each of its elements, ends included: `stretches` + 1 points an element.
    pub fn diagram(&self, beam: &Beam, stretches: usize) -> Vec<DiagramPoint> {
        let system = self.system;
        let of_element = |index: usize| {
            let element = &beam.elements[index];
            let (rod, at) = (&system.model.rods[element.rod], &system.motion.rods[element.rod]);
            (0..=stretches).map(move |k| {
                let within = rod.length * k as f64 / stretches as f64;
                let (forces, s) = (self.section_of(element, within), element.from + within);
                let strained = stiffness(rod, within) * rod.strained(within, &at.q);
                let mut by_strains = Vector6::from_element(f64::NAN);
                rod.free_strains().for_each(|strain| by_strains[strain] = strained[strain]);
                let stress = beam.section_at(s).stress(&forces);
                DiagramPoint { element: index, section: SectionForces { s, forces, stress }, by_strains }
            })
        };
        (0..beam.elements.len()).flat_map(of_element).collect()
    }

    /// The largest stress of a beam and its distance from the root (m): that of the stations, or one nearby between them.
    pub(super) fn largest_stress(&self, beam: &Beam, stations: &[SectionForces]) -> Option<(f64, Stress)> {
        let told = stations.iter().filter_map(|section| Some((section.s, section.stress?)));
        let larger = |a: (f64, Stress), b: (f64, Stress)| if b.1.von_mises > a.1.von_mises { b } else { a };
        let most = told.reduce(larger)?;
        let touches = |index: &usize| {
            let (element, rounding) = (&beam.elements[*index], 1e-9 * beam.length);
            let to = element.from + self.system.model.rods[element.rod].length;
            (element.from - rounding..=to + rounding).contains(&most.0)
        };
        let near = (0..beam.elements.len()).filter(touches).flat_map(|index| {
            let element = beam.elements[index];
            let length = self.system.model.rods[element.rod].length;
            (0..=FINE).filter_map(move |k| {
                let within = length * k as f64 / FINE as f64;
                let s = element.from + within;
                Some((s, beam.section_at(s).stress(&self.section_of(&element, within))?))
            })
        });
        Some(near.fold(most, larger))
    }
}

/// The stiffness of an element's section: the polynomial through those of its stations.
fn stiffness(rod: &Rod, s: f64) -> Matrix6<f64> {
    let part = |k: usize| {
        let others = rod.slices.iter().enumerate().filter(|(j, _)| *j != k);
        others.map(|(_, other)| (s - other.at) / (rod.slices[k].at - other.at)).product::<f64>()
    };
    rod.sections.iter().enumerate().map(|(k, of)| part(k) * of).sum()
}
