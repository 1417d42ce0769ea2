//! The energy ledger: where energy is, what loads put in, what dampers take out, and what the integrator lost.

use crate::dynamics::{Energies, Powers};
use crate::model::{Model, StopLaw};
use crate::record::Energy;

/// Nodes and weights of the Gauss rule on 0…1 that integrates powers over a step: exact to degree 5, more than the
/// dense output it is applied to.
pub(super) const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Energies of a run so far.
#[derive(Debug, Clone)]
pub(super) struct Ledger {
    start: Energies,
    work: f64,
    dissipated: f64,
    /// Largest imbalance so far (J).
    pub drift: f64,
    /// Whether any power flows that no potential stands for.
    flows: bool,
}

impl Ledger {
    pub(super) fn new(model: &Model, start: Energies) -> Self {
        let damped = |law: StopLaw| matches!(law, StopLaw::Compliant { damping, .. } if damping > 0.0);
        let stops = model.stops.iter().any(|stop| damped(stop.law));
        let flows = model.has_damping()
            || stops
            || !model.is_conservative()
            || !model.drives.is_empty()
            || !model.motors.is_empty();
        Self { start, work: 0.0, dissipated: 0.0, drift: 0.0, flows }
    }

    /// Whether powers have to be integrated: a scene without dampers and motors pays nothing for them.
    pub(super) fn flows(&self) -> bool {
        self.flows
    }

    pub(super) fn add(&mut self, powers: &Powers, duration: f64) {
        self.work += powers.input * duration;
        self.dissipated += powers.dissipated * duration;
    }

    /// Energy that an impact takes out (J).
    pub(super) fn lose(&mut self, energy: f64) {
        self.dissipated += energy;
    }

    /// The ledger of a state at the end of what was integrated.
    pub(super) fn energy(&self, now: &Energies) -> Energy {
        let total = now.kinetic + now.potential + self.dissipated - self.work;
        Energy {
            kinetic: now.kinetic,
            potential: now.potential,
            work: self.work,
            dissipated: self.dissipated,
            error: total - self.start.kinetic - self.start.potential,
        }
    }

    /// Takes note of the state at the end of a step.
    pub(super) fn close_step(&mut self, now: &Energies) {
        let energy = self.energy(now);
        self.drift = self.drift.max(energy.error.abs());
    }
}
