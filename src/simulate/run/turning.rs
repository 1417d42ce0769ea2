//! What follows from an event within the time loop.

use super::Run;
use crate::integrate::Method;
use crate::simulate::error::RunError;
use crate::simulate::events::{Hit, Kind, Turn};
use crate::simulate::instant::{self, Outcome};
use crate::simulate::problem::Motion;
use crate::simulate::settings::Settings;

impl Run<'_, '_> {
    /// What follows from an event.
    pub(super) fn turn(
        &mut self,
        motion: &mut Motion,
        settings: &Settings,
        method: Method,
        Hit { time, turn }: Hit,
    ) -> Result<(), RunError> {
        if let Turn::Stop(event) = turn {
            self.stopped_by = Some(self.model.events[event].name.clone());
            return Ok(());
        }
        if let Some(rule) = self.model.contacts.first().filter(|_| self.rests || matches!(turn, Turn::Strike(_))) {
            let what = if self.rests {
                "a stop or dry friction lets go of what rests"
            } else {
                "a rigid stop is hit, which is not there yet beside contact in motion"
            };
            let why = format!("at t = {time} s {what}");
            return Err(RunError::Contact { name: rule.name.clone(), why });
        }
        let outcome = match turn {
            Turn::Contact { .. } => Outcome::default(),
            Turn::Switch(boundary) => {
                motion.system.cross(boundary);
                Outcome::default()
            }
            Turn::Relax(_) => Outcome::default(),
            _ => instant::resolve(motion, time, &mut self.state, settings.absolute_tolerance, Some(turn))?,
        };
        self.ledger.lose(outcome.lost);
        self.ledger.put_in(outcome.work);
        self.touch(motion, time, turn == Turn::Contact { at_limit: true })?;
        self.ledger.close(&motion.energies(time, &self.state.position, &self.state.velocity));
        let pushed = outcome.happened.iter().any(|occurrence| occurrence.kind == Kind::Contact);
        if let Some(storm) = self.turns.see(time, self.end).filter(|_| !self.catch(motion, time)) {
            let last = outcome.happened.last().or(self.happened.last());
            let name = last.map_or_else(String::new, |last| last.name.clone());
            return Err(RunError::Storm { time, count: storm.count, span: storm.span, left: self.end - time, name });
        }
        if let Some(events) = &mut self.events {
            events.happened.extend(outcome.happened);
        }
        self.arm(motion, time);
        // A stiff stop that pushes from now on.
        if pushed { self.refuse_hopeless(motion, method, time) } else { Ok(()) }
    }
}
