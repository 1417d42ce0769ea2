//! What strains that are not free would be under what a beam bears.

use crate::dynamics::evaluated::Balanced;
use crate::element::Rod;
use crate::model::Beam;
use nalgebra::Vector6;

/// A strain that is not free, where the section forces would make most of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LockedStrain {
    /// Name of the beam.
    pub beam: String,
    /// `stretch`, `shear`, `twist` or `bend`.
    pub name: &'static str,
    /// What it would be; of twist and bend by how much the whole beam would turn (rad).
    pub strain: f64,
    /// The force or moment that it would follow from (N, N m).
    pub force: f64,
    /// Distance from the beam's root (m).
    pub s: f64,
}

/// The strains by the names that files have for them.
const STRAINS: [(&str, &[usize]); 4] = [("stretch", &[0]), ("shear", &[1, 2]), ("twist", &[3]), ("bend", &[4, 5])];

impl Balanced<'_> {
    /// Strains of all beams that they do not have.
    pub(crate) fn locked_strains(&self) -> Vec<LockedStrain> {
        self.system.model.beams.iter().flat_map(|beam| self.locked_of(beam)).collect()
    }

    fn locked_of(&self, beam: &Beam) -> Vec<LockedStrain> {
        let rods = &self.system.model.rods;
        let is_free =
            |strain: usize| beam.elements.iter().all(|element| rods[element.rod].free_strains().any(|i| i == strain));
        let locked: Vec<(&'static str, Vec<usize>)> =
            STRAINS.into_iter().map(|(name, of)| (name, of.to_vec())).filter(|(_, of)| !is_free(of[0])).collect();
        let mut most: Vec<LockedStrain> = Vec::new();
        for element in beam.elements.iter().filter(|_| !locked.is_empty()) {
            let rod = &rods[element.rod];
            for (k, slice) in rod.slices.iter().enumerate() {
                let forces = self.section_of(element, slice.at);
                for (name, strains) in &locked {
                    let (strain, force) = largest(rod, k, strains, &forces);
                    let strain = if strains[0] < 3 { strain } else { strain * beam.length };
                    let here =
                        LockedStrain { beam: beam.name.clone(), name, strain, force, s: element.from + slice.at };
                    match most.iter_mut().find(|one| one.name == *name) {
                        Some(one) if one.strain >= strain => {}
                        Some(one) => *one = here,
                        None => most.push(here),
                    }
                }
            }
        }
        most
    }
}

/// The largest of some strains at a station, and its force.
fn largest(rod: &Rod, station: usize, strains: &[usize], forces: &Vector6<f64>) -> (f64, f64) {
    let stiffness = &rod.sections[station];
    let of = |i: &usize| (forces[*i].abs() / stiffness[(*i, *i)], forces[*i]);
    // What has no stiffness bears nothing.
    strains
        .iter()
        .filter(|i| stiffness[(**i, **i)] > 0.0)
        .map(of)
        .fold((0.0, 0.0), |most, one| if one.0 > most.0 { one } else { most })
}
