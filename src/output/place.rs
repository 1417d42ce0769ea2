//! All outputs of one place outside of runs, where nothing touches and no work has been counted.

use super::{Given, Outputs, Varied};
use crate::dynamics::{Evaluated, Fault, Powers};

/// What stops do at a place; by default no stop is touched.
#[derive(Debug, Clone, Default)]
pub struct AtStops {
    /// What they push each velocity coordinate with (N or N m); empty if none is touched.
    pub pushes: Vec<f64>,
    /// What is stored in them (J).
    pub stored: f64,
    /// What they take out (W).
    pub dissipated: f64,
}

/// What outputs are at a place.
#[derive(Debug, Clone)]
pub struct Looked {
    /// Their numbers.
    pub values: Vec<f64>,
    /// How these vary, one list for each direction; not a number for one that is not known.
    pub variations: Vec<Vec<f64>>,
}

impl Outputs {
    /// All numbers at a place with these hinge accelerations, and how they vary along directions. Rows push with the multipliers that are in the
    /// system.
    ///
    /// # Errors
    /// As [`Outputs::evaluate`], and a place that cannot be evaluated.
    pub fn look(
        &mut self,
        mut at: Evaluated<'_>,
        accelerations: &[f64],
        stops: &AtStops,
        along: &[Varied<'_>],
    ) -> Result<Looked, Fault> {
        at.share_multipliers()?;
        let mut energies = at.energies();
        energies.potential += stops.stored;
        let (mut residual, mut reactions) = (vec![0.0; accelerations.len()], Vec::new());
        let balanced = at.residual(accelerations, &mut residual)?;
        balanced.reactions(&mut reactions);
        let mut powers = Powers::default();
        if Self::asks_power(balanced.system().model()) {
            powers = balanced.powers(accelerations);
            powers.dissipated += stops.dissipated;
        }
        let given = Given {
            accelerations,
            reactions: &reactions,
            stops: &stops.pushes,
            contacts: &[],
            energies,
            account: [0.0; 2],
            powers,
        };
        let values = self.evaluate(&balanced, &given)?.to_vec();
        let variations = along.iter().map(|by| self.vary(&balanced, &given, by).to_vec()).collect();
        Ok(Looked { values, variations })
    }
}
