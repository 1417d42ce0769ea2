//! What is recorded of a run, and when.

use super::couplings;
use super::error::{RunError, named};
use super::ledger::Ledger;
use super::problem::Motion;
use super::run::State;
use crate::integrate::Stepper;
use crate::model::Model;
use crate::record::{Recorder, Sample};
use crate::spatial::{Pose, Wrench};

/// Samples at equal times, and at the very end.
pub(super) struct Sampler {
    rate: f64,
    end: f64,
    pub(super) count: usize,
    /// Index of the next sample: due at `next / rate`.
    next: u64,
    /// What was interpolated last.
    pub(super) state: State,
    accelerations: Vec<f64>,
    residual: Vec<f64>,
    poses: Vec<Pose>,
    reactions: Vec<Wrench>,
    couplings: Vec<f64>,
}

impl Sampler {
    pub(super) fn new(model: &Model, rate: f64, end: f64) -> Self {
        let n = model.velocity_count();
        Self {
            rate,
            end,
            count: 0,
            next: 1,
            state: State { position: model.start_position.clone(), velocity: model.start_velocity.clone() },
            accelerations: vec![0.0; n],
            residual: vec![0.0; n],
            poses: Vec::new(),
            reactions: Vec::new(),
            couplings: Vec::new(),
        }
    }

    /// The state inside the last step, into `state`.
    pub(super) fn interpolate<'m>(
        &mut self,
        motion: &mut Motion<'m>,
        stepper: &mut dyn Stepper<Motion<'m>>,
        time: f64,
    ) -> Result<(), RunError> {
        let State { position, velocity } = &mut self.state;
        stepper.interpolate(motion, time, position, velocity).map_err(|error| named(motion.model(), &error))?;
        // Between the ends of a step loops are closed to the accuracy of the interpolation only.
        motion.settle(time, position, velocity).map_err(|fault| RunError::Sample { time, fault })?;
        Ok(())
    }

    /// Every sample due within the last step up to a time.
    pub(super) fn up_to<'m>(
        &mut self,
        motion: &mut Motion<'m>,
        ledger: &Ledger,
        stepper: &mut dyn Stepper<Motion<'m>>,
        until: f64,
        recorder: &mut dyn Recorder,
    ) -> Result<(), RunError> {
        loop {
            let due = (self.next as f64 / self.rate).min(self.end);
            let last = due >= self.end;
            if due > until {
                return Ok(());
            }
            self.interpolate(motion, stepper, due)?;
            let state = self.state.clone();
            self.sample(motion, ledger, due, &state, recorder)?;
            self.next += 1;
            if last {
                return Ok(());
            }
        }
    }

    pub(super) fn sample(
        &mut self,
        motion: &mut Motion<'_>,
        ledger: &Ledger,
        time: f64,
        state: &State,
        recorder: &mut dyn Recorder,
    ) -> Result<(), RunError> {
        let (q, v) = (&state.position, &state.velocity);
        let fault = |fault| RunError::Sample { time, fault };
        motion.accelerations(time, q, v, &mut self.accelerations).map_err(fault)?;
        let system = motion.at(time);
        system.share_multipliers(q, v).map_err(fault)?;
        system.residual(q, v, &self.accelerations, &mut self.residual).map_err(fault)?;
        couplings::fill(system, &self.accelerations, &mut self.couplings);
        system.reactions(&mut self.reactions);
        system.poses(&mut self.poses);
        let energy = ledger.energy(&motion.energies(time, q, v));
        recorder.sample(&Sample {
            time,
            positions: q,
            velocities: v,
            accelerations: &self.accelerations,
            bodies: &self.poses,
            reactions: &self.reactions,
            couplings: &self.couplings,
            energy,
        })?;
        self.count += 1;
        Ok(())
    }
}
