//! Events of the model at which a run ends, or a stage comes, where a stop is struck or a curve ends at the same instant: the value of the
//! event is that of the limit.
//!
//! Such an event comes first. What follows it may have no stop and no curve any more: a stage that opens the hinge lets the body fly on. If
//! the run goes on with the stop, it is struck at once.

use super::{Equations, Events, Function, Model, RunError, Stepper, TIME, Transition, Watch};
use crate::model::watch::Direction;
use crate::round_off::EVENT_TIME;

impl Events {
    /// The event at which a run ends that is crossed at the end of an interval, with the time of a search around it: its place in the list,
    /// and what it is. The state is left at the end of the interval.
    pub(super) fn ends_at(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        [from, until]: [f64; 2],
    ) -> Result<Option<(usize, Transition)>, RunError> {
        // Two instants are located, each with that error.
        let last = (until + 2.0 * Self::width(motion, [from, until])).min(stepper.time());
        let mut found = None;
        for index in 0..self.watches.len() {
            let Function::User(event) = self.watches[index].function else { continue };
            if !motion.model().events[event].stops {
                continue;
            }
            self.move_to(motion, stepper, last)?;
            let value = self.value(motion, Function::User(event), last);
            let watch = &mut self.watches[index];
            let after = watch.towards(value);
            // A value is crossed that is met but for rounding: no step goes on beyond its end, and widths may be less than a digit of the value.
            // It may have been that near at the last look, too: a step ends where a curve does.
            watch.found = value;
            if after > -watch.band && after - watch.lowest > watch.band {
                found = self.transition(motion, index).map(|stop| (index, stop));
            }
            if found.is_some() {
                break;
            }
        }
        self.move_to(motion, stepper, until)?;
        Ok(found)
    }

    /// Whether a change of sign of an event of the model goes the way that counts.
    pub(super) fn counts(&self, model: &Model, index: usize) -> bool {
        let Watch { function: Function::User(event), positive, found, .. } = self.watches[index] else { return false };
        if self.jumps[event].is_made(found) {
            return false;
        }
        match model.events[event].direction {
            Direction::Up => !positive,
            Direction::Down => positive,
            Direction::Both => true,
        }
    }

    /// How exactly a change of sign within an interval is located (s).
    pub(super) fn width(motion: &Equations, [left, right]: [f64; 2]) -> f64 {
        0.5 * EVENT_TIME.of(right.abs().max(right - left)).max(TIME * motion.model().time_scale())
    }
}

impl Watch {
    /// The lowest value, with that of the watch before it, if it is one of the same sign: how far an event of the model has come does not
    /// depend on what else has happened since.
    pub(super) fn lowest_since(&self, old: Option<&Watch>) -> f64 {
        let counts = matches!(self.function, Function::User(_) | Function::Law(_));
        let was = old.filter(|old| counts && old.positive == self.positive);
        was.map_or(f64::INFINITY, |old| old.lowest).min(self.towards(self.last[0]))
    }
}
