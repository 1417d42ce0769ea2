//! Events: numbers that change sign as a scene moves, found on the dense output of a step.
//!
//! Every function is looked at several times in a step, and between two looks at its extremum if its rate says that there is
//! one on the far side, so that a coordinate which goes there and back within one look is seen, too; expressions may do more, see `hidden.rs`. Between two times of
//! different sign the event is located to 10⁻¹² of the scene's time, or to the rounding of time (`search.rs`). How exact that is in the motion itself is a matter
//! of the step's tolerance. Beside loops, drives and gears states are settled on them first, as samples are.
//!
//! Laws that are smooth in parts only (ropes, straight tables, formulas that switch) are watched as stops are, see `switching.rs`.
//!
//! A function that made an event keeps the sign it has afterwards until it is seen with the other one by more than rounding (`noise.rs`):
//! that at the start of the next step makes no second event, nor does a number that loops hold where it is.

mod chatter;
pub(super) mod dead_centre;
mod ending;
mod hidden;
mod noise;
mod occurrence;
pub(super) mod search;
pub(super) mod switching;
pub(super) mod timetable;
mod watch;
mod watched;

pub use self::occurrence::{Kind, Occurrence};
use self::search::Search;
use crate::dynamics::Boundary;
use crate::dynamics::applied::{Rubbing, rate_of};
use crate::integrate::Stepper;
use crate::model::stop::sides;
use crate::model::{Model, StopLaw, StopSide, Watched};
use crate::round_off::WATCHED;
use crate::simulate::contact::Aspect;
use crate::simulate::error::RunError;
use crate::simulate::problem::Equations;
use crate::simulate::samples::ledger::interpolate;
use crate::simulate::samples::outputs::StateOutputs;
use crate::simulate::state::State;
use chatter::Chatter;
use hidden::Hidden;
use noise::Noise;
use std::sync::Arc;
use watch::Watch;
use watched::Jump;

/// The time of an event is known to this part of the scene's own, or to the rounding of time.
const TIME: f64 = 1e-12;
/// Halvings in search of an extremum.
const MOST_HALVINGS: u32 = 50;

/// A function whose change of sign is an event.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Function {
    /// The depth in a stop, rigid or compliant.
    Depth(StopSide),
    /// The push of a compliant stop.
    Push(StopSide),
    /// How far the force of what is held is within its range; in this place of the list.
    Reserve(usize),
    /// The speed of what slides against dry friction, in the direction in which it did when the step began; of a spherical hinge
    /// above the speed of rest, which is approached by ever shorter steps of an explicit method: its direction turns faster the
    /// slower it is.
    Speed(usize),
    /// The speed of what rests because it is tied to what is held.
    Breakaway(usize),
    /// An event of the model.
    User(usize),
    /// Where a law changes that is smooth elsewhere.
    Law(Boundary),
    /// What contacts do.
    Contact(Aspect),
    /// How far a body is beyond an end of the curve that it is guided along.
    End(usize),
}

/// An event that changes how the scene goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Transition {
    /// A rigid stop is hit.
    Strike(StopSide),
    /// What is held is let go; its first velocity coordinate.
    Release(usize),
    /// What slid against this dry friction is at rest.
    Still(usize),
    /// What rested in spite of this dry friction moves.
    Breakaway(usize),
    /// A compliant stop pushes from now on, or no longer.
    Push(StopSide, bool),
    /// A compliant stop that pushes no longer is relaxed: the power of its damper has a kink there.
    Relax(StopSide),
    /// A law changes: the step ends there, so that none goes across.
    Switch(Boundary),
    /// The formula of a motor switches to and fro: it has no value where it is.
    Chatter(usize),
    /// Bodies meet or part, stick or slip; whether a force has left its cone.
    Contact { at_limit: bool },
    /// The run ends; index of the event.
    Stop(usize),
    /// A body leaves the curve that it is guided along; index of the end.
    Leave(usize),
}

/// The earliest event of a step that changes how the scene goes on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub(super) time: f64,
    pub(super) transition: Transition,
}

/// What is watched, and what happened so far.
#[derive(Debug)]
pub(super) struct Events {
    search: Search,
    watches: Vec<Watch>,
    /// The velocity coordinate of each event that watches a position.
    velocities: Vec<usize>,
    /// How the number of each event may jump.
    jumps: Vec<Jump>,
    /// Absolute tolerance of the run.
    tolerance: f64,
    /// Whether it goes on from another run, which has seen what was met at its end.
    goes_on: bool,
    pub(super) happened: Vec<Occurrence>,
    /// Events at which the run would end, too, where it does.
    pub(super) together: Vec<usize>,
    state: State,
    /// Accelerations at the state, and how far what is held is within its range, see [`Equations::press`]; once they are known.
    pressed: bool,
    accelerations: Vec<f64>,
    reserves: Vec<f64>,
    /// `None` if no event watches an output.
    outputs: Option<StateOutputs>,
    /// `None` if no event watches an expression.
    hidden: Option<Box<Hidden>>,
    noise: Noise,
    chatter: Chatter,
}

impl Events {
    /// `None` for a model without stops, events and laws that change.
    pub(super) fn new(model: &Model, start: &State, search: Search, (tolerance, goes_on): (f64, bool)) -> Option<Self> {
        let any = !model.stops.is_empty()
            || !model.hinge_friction.is_empty()
            || !model.events.is_empty()
            || !model.contacts.is_empty()
            || !model.curve_ends.is_empty()
            || model.has_boundaries();
        let velocity = |of: &Watched| match of {
            Watched::Position(index) => {
                let link = model.links.iter().find(|link| link.joint.is_scalar() && link.position == *index);
                link.map_or(0, |link| link.velocity)
            }
            Watched::Point(..) | Watched::Output(_) => 0,
        };
        let velocities = model.events.iter().map(|event| velocity(&event.of)).collect();
        let jumps = model.events.iter().map(|event| Jump::of(model, &event.of)).collect();
        let state = start.clone();
        let watched = model.events.iter().any(|event| matches!(event.of, Watched::Output(_)));
        let outputs = StateOutputs::new(model).filter(|_| watched);
        any.then(|| Self {
            search,
            watches: Vec::new(),
            velocities,
            jumps,
            tolerance,
            goes_on,
            happened: Vec::new(),
            together: Vec::new(),
            accelerations: vec![0.0; state.velocity.len()],
            state,
            pressed: false,
            reserves: Vec::new(),
            outputs,
            hidden: Hidden::new(model),
            noise: Noise::new(model),
            chatter: Chatter::default(),
        })
    }

    /// Forgets signs that were taken before what touches was known: what it pushes with is no crossing.
    pub(super) fn forget(&mut self) {
        self.watches.clear();
    }

    /// Takes the signs at the start of a run or after a transition; what is watched depends on the discrete state.
    pub(super) fn arm(&mut self, motion: &mut Equations, time: f64, state: &State) {
        let model = &Arc::clone(motion.model());
        // Captured steps follow rigid stops and dry friction by themselves, and compliant stops from step to step: an event on the way through one
        // would cut its impulses short.
        let captured = motion.is_captured();
        let held = if captured { &[] } else { motion.held() };
        let rubbing = if captured { &[] } else { motion.system.phase().rubbing.as_slice() };
        let rests = |side: &StopSide| held.iter().any(|held| held.stop == Some(*side));
        let mut functions: Vec<Function> = (0..held.len()).map(Function::Reserve).collect();
        functions.extend(rubbing.iter().enumerate().filter_map(|(index, rubbing)| match rubbing {
            Rubbing::Sticks => None,
            Rubbing::Slides(_) => Some(Function::Speed(index)),
            Rubbing::Dependent(_) => Some(Function::Breakaway(index)),
        }));
        for side in sides(&model.stops).filter(|side| !captured && !rests(side)) {
            if !motion.system.phase().pushes(side) {
                functions.push(Function::Depth(side));
            }
            if !model.stops[side.stop].is_rigid() {
                functions.push(Function::Push(side));
            }
        }
        functions.extend((0..model.events.len()).map(Function::User));
        functions.extend((0..model.curve_ends.len()).map(Function::End));
        functions.extend(motion.system.boundaries().map(Function::Law));
        functions.extend(motion.contacts.iter().flat_map(|contacts| contacts.aspects()).map(Function::Contact));
        self.state.clone_from(state);
        self.pressed = false;
        self.outputs.iter_mut().for_each(StateOutputs::forget);
        let before = std::mem::take(&mut self.watches);
        for function in functions {
            let last = [self.value(motion, function, time), self.rate(motion, function, time)];
            let band = match function {
                Function::Depth(side) => motion.touching(side),
                Function::Push(side) => match model.stops[side.stop].law {
                    StopLaw::Compliant { stiffness, .. } => stiffness * motion.touching(side),
                    StopLaw::Rigid { .. } => 0.0,
                },
                Function::End(end) => model.curve_ends[end].slack,
                Function::Reserve(_) => 0.0,
                Function::Speed(index) => motion.still(model.hinge_friction[index].velocity),
                Function::Breakaway(index) => 10.0 * motion.still(model.hinge_friction[index].velocity),
                Function::User(event) => self.noise(motion, event, time),
                Function::Contact(aspect) => motion.contacts.as_ref().map_or(0.0, |contacts| contacts.band(aspect)),
                Function::Law(boundary) => {
                    let switch = motion.switch(time, boundary, &self.state);
                    motion.level(boundary, &switch, self.tolerance)
                }
            };
            let old = before.iter().find(|watch| watch.function == function);
            let positive = match function {
                Function::Depth(_) | Function::End(_) => last[0] > band,
                // An impact elsewhere may let a stop push that has let go; one that is not touched waits for that.
                Function::Push(side) => {
                    let apart = model.stops[side.stop].depth(side.at, &state.position) <= motion.touching(side);
                    motion.system.phase().pushes(side) || apart && last[0] > band
                }
                Function::Speed(index) if model.hinge_friction[index].count != 1 => last[0] > 0.0,
                Function::Reserve(_) | Function::Speed(_) => true,
                Function::Breakaway(_) => false,
                Function::Contact(_) => last[0] > -band,
                Function::Law(boundary) => motion.system.side(boundary),
                // What the run before has found is at its value to the last digits; what is further off may be about to come.
                Function::User(event) => old.map_or_else(
                    || match self.goes_on && last[0].abs() <= WATCHED.of(model.events[event].value.abs().max(1.0)) {
                        true => last[1] > 0.0,
                        false => last[0] > 0.0,
                    },
                    |watch| watch.positive,
                ),
            };
            let still = match function {
                Function::Depth(side) => motion.still(model.stops[side.stop].velocity),
                // What rounding leaves of a curve's end is on the curve, however fast it goes there.
                _ => f64::INFINITY,
            };
            let mut watch = Watch { function, positive, band, still, lowest: 0.0, last, next: last, found: 0.0 };
            watch.lowest = watch.lowest_since(old);
            self.watches.push(watch);
        }
    }

    /// Looks at the last step up to its end: notes what is only to be noted, and gives the first transition.
    pub(super) fn look(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
    ) -> Result<Option<Hit>, RunError> {
        let (from, to) = (stepper.previous_time(), stepper.time());
        let (mut left, mut look, looks) = (from, 1, self.search.looks);
        self.hidden.iter_mut().for_each(|hidden| hidden.begin());
        while look <= looks {
            let end = if look == looks { to } else { from + (to - from) * f64::from(look) / f64::from(looks) };
            let mut right = self.shown_until(motion, stepper, [left, end])?;
            self.look_at(motion, stepper, right)?;
            match self.excursion(motion, stepper, [left, right])? {
                Some(beyond) => {
                    right = beyond;
                    self.look_at(motion, stepper, right)?;
                }
                None => look += u32::from(right >= end),
            }
            if let Some(hit) = self.first(motion, stepper, [left, right])? {
                return Ok(Some(hit));
            }
            self.watches.iter_mut().for_each(Watch::take_next);
            left = right;
        }
        self.turn_along(motion, to);
        motion.contacts.iter_mut().for_each(|contacts| contacts.turn_along(to - from));
        Ok(None)
    }

    /// At the end of a step: what slides in a spherical hinge turns its direction.
    fn turn_along(&mut self, motion: &mut Equations, time: f64) {
        for at in 0..self.watches.len() {
            let Function::Speed(index) = self.watches[at].function else { continue };
            let friction = motion.model().hinge_friction[index];
            let Some(direction) = rate_of(&friction, &self.state.velocity).try_normalize(0.0) else { continue };
            if friction.count == 1 {
                continue;
            }
            motion.system.phase_mut().rubbing[index] = Rubbing::Slides(direction);
            let function = Function::Speed(index);
            self.watches[at].last = [self.value(motion, function, time), self.rate(motion, function, time)];
        }
    }

    /// Values and rates at a time within the last step.
    fn look_at(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        time: f64,
    ) -> Result<(), RunError> {
        self.move_to(motion, stepper, time)?;
        for index in 0..self.watches.len() {
            let function = self.watches[index].function;
            self.watches[index].next = [self.value(motion, function, time), self.rate(motion, function, time)];
            if let Function::User(event) = function {
                self.watches[index].band = self.noise(motion, event, time);
            }
        }
        Ok(())
    }

    /// A time between two looks at which a function has changed its sign that has the old one at both.
    fn excursion(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        interval: [f64; 2],
    ) -> Result<Option<f64>, RunError> {
        let mut first: Option<f64> = None;
        for index in 0..self.watches.len() {
            let [mut left, mut right] = interval;
            let watch = &self.watches[index];
            let (function, band) = (watch.function, watch.band);
            let mut ends = [watch.last, watch.next].map(|[value, rate]| [watch.towards(value), watch.towards(rate)]);
            for _ in 0..MOST_HALVINGS {
                let [[a, rise], [b, fall]] = ends;
                // A rate that falls from `rise` to `fall` adds no more than this.
                let reach = a.max(b) + (right - left) * rise.max(-fall);
                let middle = 0.5 * (left + right);
                let turns = b <= band && rise > 0.0 && fall < 0.0 && reach > band;
                if !turns || middle <= left || middle >= right {
                    break;
                }
                self.move_to(motion, stepper, middle)?;
                let at = [self.value(motion, function, middle), self.rate(motion, function, middle)];
                let at = at.map(|x| self.watches[index].towards(x));
                if at[0] > band {
                    first = Some(first.map_or(middle, |first| first.min(middle)));
                    break;
                }
                if at[1] > 0.0 {
                    (left, ends[0]) = (middle, at);
                } else {
                    (right, ends[1]) = (middle, at);
                }
            }
        }
        Ok(first)
    }

    /// Takes note of all changes between two looks up to the first that is a transition; that one.
    fn first(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        interval: [f64; 2],
    ) -> Result<Option<Hit>, RunError> {
        let (mut until, mut first) = (interval[1], None);
        let mut notes: Vec<(f64, usize)> = Vec::new();
        for index in 0..self.watches.len() {
            if !self.watches[index].changed() {
                continue;
            }
            let Some(time) = self.locate(motion, stepper, index, [interval[0], until])? else { continue };
            match self.transition(motion, index) {
                Some(transition) => (until, first) = (time, Some((index, transition))),
                None => notes.push((time, index)),
            }
        }
        notes.retain(|(time, _)| *time <= until);
        notes.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (time, index) in notes {
            self.cross(motion, stepper, time, index)?;
        }
        let Some((mut index, mut transition)) = first else { return Ok(None) };
        if matches!(transition, Transition::Strike(_) | Transition::Leave(_))
            && let Some((ends, stop)) = self.ends_at(motion, stepper, [interval[0], until])?
        {
            (index, transition) = (ends, stop);
        }
        if let Transition::Switch(_) = transition
            && let Some(motor) = self.chatters(motion, stepper, index, until)?
        {
            transition = Transition::Chatter(motor);
        }
        self.cross(motion, stepper, until, index)?;
        if let Transition::Stop(_) = transition {
            until = self.cross_at_once(motion, stepper, [interval[0], until])?;
        }
        Ok(Some(Hit { time: until, transition }))
    }

    /// The first time in an interval at which a function has changed its sign, the state being that then; `None` if it has
    /// not at its end.
    fn locate(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        index: usize,
        [left, right]: [f64; 2],
    ) -> Result<Option<f64>, RunError> {
        let Watch { function, last, band, .. } = self.watches[index];
        // At zero, unless that was passed by rounding before.
        let passed = self.watches[index].towards(last[0]) > 0.0;
        let level = if passed || matches!(function, Function::End(_)) { band } else { 0.0 };
        let width = Self::width(motion, [left, right]);
        let mut beyond = |this: &mut Self, time: f64, level: f64| {
            this.move_to(motion, stepper, time)?;
            let now = [this.value(motion, function, time), this.rate(motion, function, time)];
            let watch = &this.watches[index];
            let value = if watch.still.is_finite() { watch.beyond(now) } else { watch.towards(now[0]) - level };
            Ok::<f64, RunError>(value)
        };
        let end = beyond(self, right, band)?;
        if !(end > 0.0) {
            return Ok(None);
        }
        let ends = [beyond(self, left, level)?, beyond(self, right, level)?];
        let root = self.search.root;
        let time = root.locate([left, right], ends, width, |time| beyond(self, time, level))?;
        self.move_to(motion, stepper, time)?;
        self.watches[index].found = self.value(motion, function, time);
        Ok(Some(time))
    }

    /// The transition that a change of sign is, if it is one, the state being that at its time.
    fn transition(&self, motion: &Equations, index: usize) -> Option<Transition> {
        let Watch { function, positive, .. } = self.watches[index];
        let model = &Arc::clone(motion.model());
        match function {
            Function::Depth(side) => match (model.stops[side.stop].law, positive) {
                (StopLaw::Rigid { .. }, true) => None,
                (StopLaw::Rigid { .. }, false) => Some(Transition::Strike(side)),
                (StopLaw::Compliant { .. }, true) => Some(Transition::Relax(side)),
                (StopLaw::Compliant { .. }, false) => Some(Transition::Push(side, true)),
            },
            Function::Push(side) => {
                let inside = model.stops[side.stop].depth(side.at, &self.state.position) > 0.0;
                match (motion.system.phase().pushes(side), positive) {
                    (true, true) => Some(Transition::Push(side, false)),
                    (false, false) if inside => Some(Transition::Push(side, true)),
                    _ => None,
                }
            }
            Function::Reserve(held) => motion.held().get(held).map(|held| Transition::Release(held.velocity)),
            Function::Speed(index) => positive.then_some(Transition::Still(index)),
            Function::Breakaway(index) => Some(Transition::Breakaway(index)),
            Function::Law(boundary) => Some(Transition::Switch(boundary)),
            Function::End(end) => (!positive).then_some(Transition::Leave(end)),
            Function::Contact(aspect) => {
                positive.then_some(Transition::Contact { at_limit: aspect == Aspect::Reserve })
            }
            Function::User(event) => {
                (self.counts(model, index) && model.events[event].stops).then_some(Transition::Stop(event))
            }
        }
    }

    /// Takes a change of sign as seen, and notes a crossing that the user asked for and a force that switches. What stops do
    /// is told of by the instant that follows.
    fn cross(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        time: f64,
        index: usize,
    ) -> Result<(), RunError> {
        let Watch { function, positive, .. } = self.watches[index];
        if let Function::Law(boundary) = function {
            self.move_to(motion, stepper, time)?;
            self.happened.extend(motion.occurrence(time, boundary, !positive, &self.state));
        }
        if let Function::User(event) = function
            && self.counts(motion.model(), index)
        {
            self.move_to(motion, stepper, time)?;
            let (speed, unit) = (self.speed(motion, event, time), self.unit(motion.model(), event));
            let event = &motion.model().events[event];
            let (kind, name, value) = (Kind::Crossing, event.name.clone(), event.value);
            self.happened.push(Occurrence { time, kind, name, value, unit, speed, between: None });
        }
        let watch = &mut self.watches[index];
        watch.positive = !watch.positive;
        watch.lowest = watch.towards(watch.last[0]);
        Ok(())
    }

    /// Takes the state to a time within the last step.
    fn move_to(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        time: f64,
    ) -> Result<(), RunError> {
        self.pressed = false;
        interpolate(motion, stepper, time, &mut self.state)
    }
}
