//! The energy ledger: where energy is, what loads put in, what dampers take out, and what the integrator lost.
//!
//! Powers are integrated from one time that is asked for to the next: ends of steps, samples, events. No quadrature reaches
//! across an event, at which powers jump.

use super::error::{RunError, named};
use super::problem::Motion;
use super::state::State;
use crate::dynamics::{Energies, Powers};
use crate::integrate::Stepper;
use crate::model::{Model, StopLaw};
use crate::record::Energy;

/// Nodes and weights of the Gauss rule on 0…1 that integrates powers over a step: exact to degree 9, so that what collocation
/// methods have wrong between their points cancels as it does at their ends.
const WHOLE: [(f64, f64); 5] = [
    (0.046_910_077_030_668_004, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// That for a part of a step, exact to degree 5.
const PART: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Energies of a run so far.
#[derive(Debug, Clone)]
pub(super) struct Ledger {
    start: Energies,
    /// Up to when powers are integrated (s).
    time: f64,
    work: f64,
    dissipated: f64,
    /// Largest imbalance so far (J).
    pub drift: f64,
    /// Whether any power flows that no potential stands for.
    flows: bool,
}

/// What the ledger of a run has at its end, for the run that goes on with another structure (J).
#[derive(Debug, Clone, Copy)]
pub(super) struct Booked {
    /// Kinetic plus potential energy at the very start.
    pub(super) start: f64,
    pub(super) work: f64,
    pub(super) dissipated: f64,
    pub(super) drift: f64,
}

impl Ledger {
    /// Goes on with what an earlier run has booked.
    pub(super) fn going_on(self, booked: Option<&Booked>) -> Self {
        let Some(&Booked { start, work, dissipated, drift }) = booked else { return self };
        Self { start: Energies { kinetic: start, potential: 0.0 }, work, dissipated, drift, ..self }
    }

    pub(super) fn new(model: &Model, time: f64, start: Energies) -> Self {
        let damped = |law: StopLaw| matches!(law, StopLaw::Compliant { damping, .. } if damping > 0.0);
        let stops = model.stops.iter().any(|stop| damped(stop.law));
        let flows = model.has_damping()
            || stops
            || !model.hinge_friction.is_empty()
            || !model.contacts.is_empty()
            || !model.is_conservative()
            || !model.drives.is_empty()
            || !model.motors.is_empty();
        Self { start, time, work: 0.0, dissipated: 0.0, drift: 0.0, flows }
    }

    /// Integrates powers up to a time within the last step, `state` being scratch: a scene without dampers, loads and motors
    /// pays nothing.
    ///
    /// # Errors
    /// A state within the step that cannot be evaluated.
    pub(super) fn advance(
        &mut self,
        motion: &mut Motion,
        stepper: &mut dyn Stepper<Motion>,
        state: &mut State,
        until: f64,
    ) -> Result<(), RunError> {
        let (from, length) = (self.time, until - self.time);
        if !(length > 0.0) {
            return Ok(());
        }
        self.time = until;
        if !self.flows {
            return Ok(());
        }
        let is_part = length < 0.5 * (stepper.time() - stepper.previous_time());
        for (node, weight) in if is_part { &PART[..] } else { &WHOLE[..] } {
            let time = from + node * length;
            interpolate(motion, stepper, time, state)?;
            let Powers { input, dissipated } = motion.powers(time, &state.position, &state.velocity);
            self.work += weight * length * input;
            self.dissipated += weight * length * dissipated;
        }
        Ok(())
    }

    /// Energy that an impact takes out (J).
    pub(super) fn lose(&mut self, energy: f64) {
        self.dissipated += energy;
    }

    /// Work of drives in an impact (J).
    pub(super) fn put_in(&mut self, energy: f64) {
        self.work += energy;
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

    /// Takes note of the state at the end of what was integrated, of a step or at a sample; gives its ledger.
    pub(super) fn close(&mut self, now: &Energies) -> Energy {
        let energy = self.energy(now);
        self.drift = self.drift.max(energy.error.abs());
        energy
    }
}

/// The state at a time within the last step. Between the ends of a step loops are closed to the accuracy of the
/// interpolation only: it is settled on them.
///
/// # Errors
/// A time at which the state cannot be evaluated.
pub(super) fn interpolate(
    motion: &mut Motion,
    stepper: &mut dyn Stepper<Motion>,
    time: f64,
    State { position, velocity }: &mut State,
) -> Result<(), RunError> {
    stepper.interpolate(motion, time, position, velocity).map_err(|error| named(motion.model(), &error))?;
    motion.settle(time, position, velocity).map_err(|fault| RunError::Sample { time, fault })
}
