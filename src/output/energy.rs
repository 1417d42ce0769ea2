//! Energies and powers of the scene.

use super::question::{At, Measure};
use crate::model::output::{EnergyKind, PowerKind};

impl Measure for EnergyKind {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        let [work, dissipated] = at.given.account;
        out[0] = match self {
            Self::Kinetic => at.given.energies.kinetic,
            Self::Potential => at.given.energies.potential,
            Self::Input => work,
            Self::Dissipated => dissipated,
        };
    }
}

impl Measure for PowerKind {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        out[0] = match self {
            Self::Input => at.given.powers.input,
            Self::Dissipated => at.given.powers.dissipated,
        };
    }
}
