//! The instants of controllers within the time loop: steps end there, and inputs change between two steps.

use super::Run;
use crate::round_off::TIME;
use crate::simulate::control::{Control, Sensed};
use crate::simulate::error::RunError;
use crate::simulate::events::Kind;
use crate::simulate::problem::Equations;
use crate::simulate::settings::Settings;
use crate::simulate::state::State;
use crate::simulate::stops::instant;

impl Run<'_, '_> {
    /// The next time at which steps have to end (s): a break of the timetable, an instant of a controller, the end of the run.
    pub(super) fn next(&self, time: f64) -> f64 {
        let next = self.timetable.next(time);
        let instant = self.control.as_ref().map_or(f64::INFINITY, Control::next);
        // What is meant to be one time is.
        if instant < TIME.below(self.timetable.end(next)) { instant } else { next }
    }

    /// Where steps towards the next such time end: at an instant of a controller, on which nothing but the inputs changes.
    pub(super) fn segment_end(&self, next: f64) -> f64 {
        if self.is_due(next) && !self.timetable.breaks_at(next) { next } else { self.timetable.end(next) }
    }

    pub(super) fn is_due(&self, time: f64) -> bool {
        time < self.end && self.control.as_ref().is_some_and(|control| control.is_due(time))
    }

    /// Mass that is gone from one time to the next, between which nothing moves, takes its energy along.
    pub(super) fn lose_mass(&mut self, motion: &mut Equations, before: f64, after: f64) {
        if self.model.burns.is_empty() {
            return;
        }
        let State { position, velocity } = &self.state;
        let [with, without] = [before, after].map(|time| motion.energies(time, position, velocity));
        self.ledger.put_in(without.kinetic + without.potential - with.kinetic - with.potential);
    }

    /// Brings velocities onto what drives ask for from a time on, if that is not what they asked for just before it: an impulse of the
    /// drives, whose work is booked. Nothing holds during it; what strikes a stop by it is answered then.
    pub(super) fn jump(
        &mut self,
        motion: &mut Equations,
        settings: &Settings,
        [before, at]: [f64; 2],
    ) -> Result<(), RunError> {
        if !self.model.drives.iter().any(|drive| drive.motion.jumps(before, at)) {
            return Ok(());
        }
        let fault = |fault| RunError::Sample { time: at, fault };
        let State { position, velocity } = &self.state;
        let kinetic = motion.energies(before, position, velocity).kinetic;
        let held = motion.held().to_vec();
        motion.hold(at, &self.state, &[]).map_err(fault)?;
        motion.settle(at, &mut self.state.position, &mut self.state.velocity).map_err(fault)?;
        motion.hold(at, &self.state, &held).map_err(fault)?;
        let State { position, velocity } = &self.state;
        self.ledger.put_in(motion.energies(at, position, velocity).kinetic - kinetic);
        self.resolve(motion, settings, at)
    }

    /// Decides anew what strikes, rests and sticks at a time at which what acts has changed.
    pub(super) fn resolve(&mut self, motion: &mut Equations, settings: &Settings, time: f64) -> Result<(), RunError> {
        if let Some(events) = &mut self.events {
            let outcome = instant::resolve(motion, time, &mut self.state, settings.absolute_tolerance, None)?;
            self.ledger.lose(outcome.lost);
            self.ledger.put_in(outcome.work);
            events.happened.extend(outcome.happened.into_iter().filter(|one| one.kind != Kind::Contact));
            events.arm(motion, time, &self.state);
        }
        self.ledger.close(&motion.energies(time, &self.state.position, &self.state.velocity));
        Ok(())
    }

    /// Lets controllers act that are due at a time, and decides anew what rests and sticks under what they set.
    pub(super) fn control(&mut self, motion: &mut Equations, settings: &Settings, time: f64) -> Result<(), RunError> {
        if !self.is_due(time) {
            return Ok(());
        }
        let outputs = self.sampler.outputs(motion, &self.ledger, time, &self.state)?;
        let Some(control) = &mut self.control else { return Ok(()) };
        control.act(&mut motion.system, Sensed { time, state: &self.state, outputs: &outputs })?;
        if self.events.is_none() {
            return Ok(());
        }
        self.resolve(motion, settings, time)
    }
}
