//! Events of the model at which a run ends, or a stage comes, and what else is at the same instant.
//!
//! Where a stop is struck or a curve ends there the value of the event is that of the limit. Such an event comes first. What follows it may have no stop and no curve any more: a stage that opens the hinge lets the body fly on. If
//! the run goes on with the stop, it is struck at once.
//!
//! Other events of the model are crossed at once: what goes on from there begins beyond their values, and would never see them crossed.

use super::{Equations, Events, Function, Hit, Model, RunError, Stepper, TIME, Transition, Watch};
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
        let last = Self::same_instant(motion, stepper, [from, until]);
        let mut found = None;
        for index in 0..self.watches.len() {
            let Function::User(event) = self.watches[index].function else { continue };
            if motion.model().events[event].stops && self.is_met(motion, stepper, index, last)? {
                found = self.transition(motion, index).map(|stop| (index, stop));
            }
            if found.is_some() {
                break;
            }
        }
        self.move_to(motion, stepper, until)?;
        Ok(found)
    }

    /// Takes all events of the model as seen that are crossed where one ends the run, at the end of an interval with the time of a search
    /// around it; those that would end it by themselves are kept. Gives the time at which all are crossed (s).
    pub(super) fn cross_at_once(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        [from, until]: [f64; 2],
    ) -> Result<f64, RunError> {
        let (mut time, last) = (until, Self::same_instant(motion, stepper, [from, until]));
        for index in 0..self.watches.len() {
            let Function::User(event) = self.watches[index].function else { continue };
            if self.is_met(motion, stepper, index, last)? && self.counts(motion.model(), index) {
                if motion.model().events[event].stops {
                    self.together.push(event);
                }
                self.cross(motion, stepper, last, index)?;
                time = last;
            }
        }
        self.move_to(motion, stepper, time)?;
        Ok(time)
    }

    /// Takes all events of the model as seen that are met at the end of a run; the first of those that would have ended it. A step goes no further,
    /// so that they may be crossed but for rounding, and whatever goes on from there begins beyond them.
    pub(in crate::simulate) fn at_end(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
    ) -> Result<Option<Hit>, RunError> {
        let (time, mut first) = (stepper.time(), None);
        for index in 0..self.watches.len() {
            let Function::User(event) = self.watches[index].function else { continue };
            if !self.is_met(motion, stepper, index, time)? || !self.counts(motion.model(), index) {
                continue;
            }
            match (motion.model().events[event].stops, first) {
                (true, None) => first = Some(Hit { time, transition: Transition::Stop(event) }),
                (true, Some(_)) => self.together.push(event),
                (false, _) => {}
            }
            self.cross(motion, stepper, time, index)?;
        }
        self.move_to(motion, stepper, time)?;
        Ok(first)
    }

    /// Until when something is at the same instant as what was found at the end of an interval (s): two instants are located, each with the
    /// error of that.
    fn same_instant(motion: &Equations, stepper: &dyn Stepper<Equations>, [from, until]: [f64; 2]) -> f64 {
        (until + 2.0 * Self::width(motion, [from, until])).min(stepper.time())
    }

    /// Whether the value of an event of the model is met at a time, to which the state is taken: crossed but for rounding, as no step goes on
    /// beyond its end, and widths may be less than a digit of the value. It may have been that near at the last look, too: a step ends where a
    /// curve does.
    fn is_met(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        index: usize,
        time: f64,
    ) -> Result<bool, RunError> {
        self.move_to(motion, stepper, time)?;
        let value = self.value(motion, self.watches[index].function, time);
        let watch = &mut self.watches[index];
        watch.found = value;
        let after = watch.towards(value);
        Ok(after > -watch.band && after - watch.lowest > watch.band)
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
