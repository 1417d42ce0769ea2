//! The steps of one stepper within the time loop, and what ends them.

use super::Run;
use crate::integrate::Stepper;
use crate::record::Recorder;
use crate::simulate::checks::pace::{Creep, Pace};
use crate::simulate::choice::Choice;
use crate::simulate::error::{RunError, component_name, named};
use crate::simulate::events::{Hit, Transition, dead_centre};
use crate::simulate::problem::Equations;
use crate::simulate::samples::ledger::interpolate;
use crate::simulate::state::State;
use crate::simulate::stops::instant;
use std::time::Instant;

/// What ended the steps of one stepper, and when (s). More than one may: a run that creeps is captured at a transition, too.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ending {
    pub(super) time: f64,
    pub(super) transition: Option<Transition>,
    /// Another method goes on, or captured steps end.
    pub(super) switches: bool,
    /// Captured steps go on.
    pub(super) captures: bool,
    /// The run was told to end.
    pub(super) stopped: bool,
}

impl Ending {
    /// Whether anything ended them.
    fn is_reached(&self) -> bool {
        self.transition.is_some() || self.switches || self.captures || self.stopped
    }
}

impl Run<'_, '_> {
    /// Steps from a time on, up to where the stepper ends or to what ends them before.
    pub(super) fn steps(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        choice: &mut Choice,
        from: f64,
        recorder: &mut dyn Recorder,
        go_on: &mut dyn FnMut(f64, &State) -> bool,
    ) -> Result<Ending, RunError> {
        let mut pace = Pace::new(from).until(self.timetable.formula_stretch(from).map(|[_, end]| end));
        let mut ending = Ending { time: from, transition: None, switches: false, captures: false, stopped: false };
        while !stepper.finished() && !ending.is_reached() {
            let hit = match self.step(motion, stepper) {
                Err(_) if self.try_capture(motion, ending.time) => return Ok(Ending { captures: true, ..ending }),
                hit => hit?,
            };
            let time = hit.map_or(stepper.time(), |hit| hit.time);
            (ending.time, ending.transition) = (time, hit.map(|hit| hit.transition));
            ending.stopped = !self.tell(motion, stepper, time, recorder, go_on)?;
            recorder.pause()?;
            self.close_step(motion, stepper, time)?;
            if let (true, Some(events)) = (motion.is_captured(), &mut self.events) {
                events.happened.extend(instant::press(motion, time, &mut self.state));
            }
            if let Some(creep) = pace.see(time, self.end).filter(|_| !choice.method.needs_step()) {
                ending.captures = self.try_capture(motion, time);
                if !ending.captures {
                    return Err(self.creeps(stepper, creep));
                }
            }
            if ending.transition.is_none() && !ending.captures && self.toils(motion, stepper, time) {
                ending.captures = self.try_capture(motion, time);
            }
            ending.stopped |= !go_on(time, &self.state);
            ending.switches =
                ending.transition.is_none() && (choice.review(motion, stepper) || self.hands_back(motion, time));
        }
        Ok(ending)
    }

    pub(super) fn creeps(&self, stepper: &dyn Stepper<Equations>, Creep { step, left }: Creep) -> RunError {
        let (time, limiting) = (stepper.time(), stepper.limiting());
        let component = component_name(self.model, limiting).unwrap_or_else(|| limiting.to_string());
        dead_centre::beside(RunError::Creep { time, step, left, component }, self.model, time, &self.state)
    }

    /// One step, and the state at its end or at what happens before.
    fn step(&mut self, motion: &mut Equations, stepper: &mut dyn Stepper<Equations>) -> Result<Option<Hit>, RunError> {
        let before = Instant::now();
        let hit = self.step_and_look(motion, stepper);
        self.wall += before.elapsed();
        hit
    }

    fn step_and_look(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
    ) -> Result<Option<Hit>, RunError> {
        let (model, state) = (self.model, &self.state);
        stepper
            .step(motion)
            .map_err(|error| dead_centre::beside(named(model, &error), model, stepper.time(), state))?;
        let Some(events) = &mut self.events else {
            self.state.position.copy_from_slice(stepper.position());
            self.state.velocity.copy_from_slice(stepper.velocity());
            return Ok(None);
        };
        let mut hit = events.look(motion, stepper)?;
        if hit.is_none() && stepper.time() >= self.end {
            hit = events.at_end(motion, stepper)?;
        }
        self.ledger.undisturbed = hit.is_none() && events.happened.is_empty();
        let until = hit.map_or(stepper.time(), |hit| hit.time);
        interpolate(motion, stepper, until, &mut self.state)?;
        motion.guard(until, &self.state)?;
        self.guard_curves(until)?;
        Ok(hit)
    }

    /// The account of a step up to its end or to what happened before.
    pub(super) fn close_step(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        until: f64,
    ) -> Result<(), RunError> {
        if self.model.is_constrained() {
            self.gap = self.gap.max(motion.at(until, &self.state.position, &self.state.velocity).gap());
        }
        self.sampler.close(motion, &mut self.ledger, stepper, until)?;
        if let Some(contacts) = &mut motion.contacts {
            let [lost, work] = contacts.taken();
            self.ledger.lose(lost);
            self.ledger.put_in(work);
        }
        self.guard_contacts(motion, until)?;
        self.ledger.close(&motion.energies(until, &self.state.position, &self.state.velocity));
        Ok(())
    }
}
