//! What is recorded of a run, and when.

use super::couplings;
use super::ledger::{Ledger, interpolate};
use super::outputs::StateOutputs;
use crate::integrate::Stepper;
use crate::model::Model;
use crate::model::beam::Wound;
use crate::record::{ContactPush, Recorder, Sample};
use crate::round_off::MEANT_TIME;
use crate::simulate::checks::finite;
use crate::simulate::error::RunError;
use crate::simulate::problem::Equations;
use crate::simulate::state::State;
use crate::spatial::{Pose, Wrench};
use std::time::{Duration, Instant};

/// Between samples it is asked this often whether to go on: steps that are full of samples take long.
const PATIENCE: Duration = Duration::from_millis(50);

/// Samples at equal times, and at the very end.
pub(in crate::simulate) struct Sampler {
    rate: f64,
    end: f64,
    pub(in crate::simulate) count: usize,
    /// Index of the next sample: due at `next / rate`.
    next: u64,
    /// Scratch.
    state: State,
    accelerations: Vec<f64>,
    residual: Vec<f64>,
    poses: Vec<Pose>,
    reactions: Vec<Wrench>,
    couplings: Vec<f64>,
    /// What contacts push with; of what rests the same at all times.
    pub(in crate::simulate) contacts: Vec<ContactPush>,
    /// Beams with elements that turned by too much, each where its elements turned most, and when (s).
    pub(in crate::simulate) wound: Vec<(f64, Wound)>,
    /// `None` for a model without outputs.
    outputs: Option<StateOutputs>,
}

impl Sampler {
    /// Of a run from one time to another (s).
    pub(in crate::simulate) fn new(model: &Model, rate: f64, [begin, end]: [f64; 2]) -> Self {
        let n = model.velocity_count();
        Self {
            rate,
            end,
            count: 0,
            // One that is due at the beginning but for rounding is the first of the run.
            next: MEANT_TIME.above(begin * rate).floor() as u64 + 1,
            state: State { position: model.start_position.clone(), velocity: model.start_velocity.clone() },
            accelerations: vec![0.0; n],
            residual: vec![0.0; n],
            poses: Vec::new(),
            reactions: Vec::new(),
            couplings: Vec::new(),
            contacts: Vec::new(),
            wound: Vec::new(),
            outputs: StateOutputs::new(model),
        }
    }

    /// Every sample due within the last step up to a time, the ledger with them; false if `go_on` asked to stop.
    pub(in crate::simulate) fn up_to(
        &mut self,
        motion: &mut Equations,
        ledger: &mut Ledger,
        stepper: &mut dyn Stepper<Equations>,
        until: f64,
        recorder: &mut dyn Recorder,
        go_on: &mut dyn FnMut(f64, &State) -> bool,
    ) -> Result<bool, RunError> {
        let mut asked = Instant::now();
        // The last one is made once.
        while ((self.next - 1) as f64) < self.rate * self.end {
            let due = (self.next as f64 / self.rate).min(self.end);
            let last = due >= self.end;
            if due > until {
                return Ok(true);
            }
            let mut state = std::mem::take(&mut self.state);
            ledger.advance(motion, stepper, &mut state, due)?;
            interpolate(motion, stepper, due, &mut state)?;
            self.sample(motion, ledger, due, &state, recorder)?;
            self.next += 1;
            let goes_on = asked.elapsed() < PATIENCE || go_on(due, &state);
            self.state = state;
            if last || !goes_on {
                return Ok(goes_on);
            }
            if asked.elapsed() >= PATIENCE {
                asked = Instant::now();
            }
        }
        Ok(true)
    }

    /// The ledger up to the end of a step or to what happens before.
    pub(in crate::simulate) fn close(
        &mut self,
        motion: &mut Equations,
        ledger: &mut Ledger,
        stepper: &mut dyn Stepper<Equations>,
        until: f64,
    ) -> Result<(), RunError> {
        ledger.advance(motion, stepper, &mut self.state, until)
    }

    /// The outputs at a state; empty for a model without.
    pub(in crate::simulate) fn outputs(
        &mut self,
        motion: &mut Equations,
        ledger: &Ledger,
        time: f64,
        state: &State,
    ) -> Result<Vec<f64>, RunError> {
        let Some(outputs) = &mut self.outputs else { return Ok(Vec::new()) };
        let account = ledger.energy(&motion.energies(time, &state.position, &state.velocity));
        let found = outputs.at(motion, time, state, [account.work, account.dissipated]);
        found.map(<[f64]>::to_vec).map_err(|fault| RunError::Sample { time, fault })
    }

    /// One sample. Nothing is recorded that is not a number, nor a state beyond a rigid stop.
    pub(in crate::simulate) fn sample(
        &mut self,
        motion: &mut Equations,
        ledger: &mut Ledger,
        time: f64,
        state: &State,
        recorder: &mut dyn Recorder,
    ) -> Result<(), RunError> {
        motion.guard(time, state)?;
        motion.guard_shapes(time, state)?;
        let (q, v) = (&state.position, &state.velocity);
        let fault = |fault| RunError::Sample { time, fault };
        motion.accelerations(time, q, v, &mut self.accelerations).map_err(fault)?;
        motion.choose_forces(time, q, v).map_err(fault)?;
        let touches = !motion.model().contacts.is_empty();
        if let Some(contacts) = &motion.contacts {
            contacts.pushes(&mut self.contacts);
        }
        let mut at = motion.at(time, q, v);
        at.share_multipliers().map_err(fault)?;
        at.residual(&self.accelerations, &mut self.residual).map_err(fault)?.reactions(&mut self.reactions);
        couplings::fill(&mut at, &self.accelerations, &mut self.couplings);
        at.poses(&mut self.poses);
        let energies = motion.energies(time, q, v);
        let captured = motion.contacts.as_ref().filter(|contacts| contacts.is_captured());
        let energy = match captured.map(|contacts| contacts.not_booked(time)) {
            Some(impulses) => ledger.on_the_way(&energies, impulses),
            None => ledger.close(&energies),
        };
        let outputs = match &mut self.outputs {
            Some(outputs) => outputs.at(motion, time, state, [energy.work, energy.dissipated]).map_err(fault)?,
            None => &[],
        };
        let sample = Sample {
            time,
            positions: q,
            velocities: v,
            accelerations: &self.accelerations,
            bodies: &self.poses,
            reactions: &self.reactions,
            couplings: &self.couplings,
            outputs,
            energy,
        };
        finite::check(motion.model(), &sample, &self.contacts)?;
        if touches {
            recorder.contacts(time, &self.contacts)?;
        }
        recorder.sample(&sample)?;
        self.count += 1;
        let wound = motion.model().wound(q).into_iter().map(|wound| (time, wound));
        keep_worst(&mut self.wound, wound);
        Ok(())
    }
}

/// Adds beams with elements that turn by too much to others, and keeps of each beam where its elements turn most.
pub(in crate::simulate) fn keep_worst(kept: &mut Vec<(f64, Wound)>, more: impl IntoIterator<Item = (f64, Wound)>) {
    for (time, wound) in more {
        match kept.iter_mut().find(|(_, known)| known.beam == wound.beam) {
            Some(known) if known.1.turn >= wound.turn => {}
            Some(known) => *known = (time, wound),
            None => kept.push((time, wound)),
        }
    }
}
