//! What strains that are not free would be.

use super::{BeamDescription, FreeStrains};
use crate::element::quadrature;

/// What a force would strain where the strains are not free; of free ones zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Locked {
    /// Along the beam.
    pub stretch: f64,
    /// Across it.
    pub shear: f64,
    /// The part of a cantilever's deflection under even load that is from shear.
    pub share: f64,
}

impl FreeStrains {
    /// As it is written in a file: `free = ["bend", "twist"]`.
    pub(crate) fn written(self) -> String {
        let all = [(self.bend, "bend"), (self.twist, "twist"), (self.stretch, "stretch"), (self.shear, "shear")];
        let words: Vec<String> = all.iter().filter(|(free, _)| *free).map(|(_, word)| format!("\"{word}\"")).collect();
        format!("`free = [{}]`", words.join(", "))
    }
}

impl BeamDescription {
    /// What a force would strain at most where the section gives way most.
    pub(crate) fn locked(&self, force: f64) -> Locked {
        let mut locked = Locked { stretch: 0.0, shear: 0.0, share: 0.0 };
        let length = self.shape.length();
        for (s, _) in &self.sections {
            let c = self.section_per_length(*s).stiffness;
            let sheared = c[(1, 1)].min(c[(2, 2)]);
            if !self.free.stretch {
                locked.stretch = locked.stretch.max(force / c[(0, 0)]);
            }
            if !self.free.shear {
                locked.shear = locked.shear.max(force / sheared);
                // P L/2 κGA beside P L³/8 EI.
                let shear = 4.0 * c[(4, 4)].max(c[(5, 5)]) / (sheared * length * length);
                locked.share = locked.share.max(shear / (1.0 + shear));
            }
        }
        locked
    }

    /// Its mass (kg).
    pub(crate) fn mass(&self) -> f64 {
        let length = self.shape.length();
        quadrature().map(|(t, w)| w * length * self.section_per_length(t * length).mass).sum()
    }
}
