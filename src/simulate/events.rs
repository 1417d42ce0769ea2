//! Events: numbers that change sign as a scene moves, found on the dense output of a step.
//!
//! Every function is looked at five times in a step, so that a coordinate which goes there and back within one is
//! seen where it stays long enough; between two looks of different sign the time is found by bisection to 10⁻¹² of
//! itself. How exact that is in the motion itself is a matter of the step's tolerance.
//!
//! A function that made an event keeps the sign it has afterwards until it is seen with the other one: rounding at the
//! start of the next step makes no second event.

use super::error::{RunError, named};
use super::problem::Motion;
use super::run::State;
use super::stops::Side;
use crate::force::Act;
use crate::integrate::Stepper;
use crate::model::watch::Direction;
use crate::model::{Model, StopLaw, Watched};
use std::fmt;

/// Looks within a step, its end included.
const LOOKS: u32 = 5;
/// The time of an event is known to this part of itself.
const TIME: f64 = 1e-12;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A coordinate hit a rigid stop and came back.
    Impact,
    /// A coordinate came to rest on a rigid stop.
    Rest,
    /// A coordinate left a rigid stop it rested on.
    Release,
    /// A coordinate ran onto a compliant stop.
    Contact,
    /// A compliant stop no longer pushes.
    Separation,
    /// A crossing the user asked for.
    Crossing,
    /// A force element switched; what it calls that.
    Force(&'static str),
    /// Another integrator took over.
    Switch,
}

impl Kind {
    /// In JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Impact => "impact",
            Self::Rest => "rest",
            Self::Release => "release",
            Self::Contact => "contact",
            Self::Separation => "separation",
            Self::Crossing => "crossing",
            Self::Force(name) => name,
            Self::Switch => "switch",
        }
    }
}

/// Something that happened in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Occurrence {
    /// When (s).
    pub time: f64,
    /// What.
    pub kind: Kind,
    /// The name of the event or force, the body whose hinge it is, or the integrator that took over.
    pub name: String,
    /// The value that was crossed (m or rad), of a rope the length of its path (m); of a switch the step that led there (s).
    pub value: f64,
    /// How fast the number changed before (per second); of a switch nothing.
    pub speed: f64,
}

impl fmt::Display for Occurrence {
    /// Without the time.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, name, value, speed, .. } = self;
        match kind {
            Kind::Switch => write!(f, "`{name}` takes over after a step of {value:.3e} s"),
            _ => write!(f, "{} of `{name}` at {value:.6}, speed {speed:.6}", kind.name()),
        }
    }
}

/// A function whose change of sign is an event.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Function {
    /// The depth in a stop, rigid or compliant.
    Depth(Side),
    /// The push of a compliant stop.
    Push(Side),
    /// What presses on a held stop; held in this place of the list.
    Pressure(usize),
    /// An event of the model.
    User(usize),
    /// Where a force element switches.
    Force(usize),
}

#[derive(Debug)]
struct Watch {
    function: Function,
    /// Positive before the event.
    positive: bool,
}

/// An event that changes how the scene goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Turn {
    /// A rigid stop is hit.
    Strike(Side),
    /// A held coordinate is let go.
    Release(usize),
    /// A compliant stop pushes from now on, or no longer.
    Push(Side, bool),
    /// A force element switched: the step ends there, so that none goes across the kink of its force.
    Switch,
    /// The run ends; index of the event.
    Stop(usize),
}

/// The earliest event of a step that changes how the scene goes on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub(super) time: f64,
    pub(super) turn: Turn,
}

/// What is watched, and what happened so far.
#[derive(Debug)]
pub(super) struct Events {
    watches: Vec<Watch>,
    pub(super) happened: Vec<Occurrence>,
    state: State,
}

impl Events {
    /// `None` for a model without stops, events and force elements that switch.
    pub(super) fn new(model: &Model, start: &State) -> Option<Self> {
        let any = !model.stops.is_empty() || !model.events.is_empty() || model.switching().next().is_some();
        any.then(|| Self { watches: Vec::new(), happened: Vec::new(), state: start.clone() })
    }

    /// Takes the signs at the start of a run or after a turn; what is watched depends on what is held.
    pub(super) fn arm(&mut self, motion: &mut Motion<'_>, time: f64, state: &State) {
        let model = motion.model();
        let held = motion.held().to_vec();
        let mut functions: Vec<Function> = (0..held.len()).map(Function::Pressure).collect();
        for (index, stop) in model.stops.iter().enumerate() {
            for sign in stop.signs() {
                let side = Side { stop: index, sign };
                if held.contains(&side) {
                    continue;
                }
                if !motion.pushes(side) {
                    functions.push(Function::Depth(side));
                }
                if matches!(stop.law, StopLaw::Compliant { .. }) {
                    functions.push(Function::Push(side));
                }
            }
        }
        functions.extend((0..model.events.len()).map(Function::User));
        functions.extend(model.switching().map(Function::Force));
        let before = std::mem::take(&mut self.watches);
        for function in functions {
            let value = self.value(motion, function, time, state);
            let positive = match function {
                // On the limit itself the speed tells, and inside is where a rigid stop leaves it.
                Function::Depth(side) => {
                    let stop = &model.stops[side.stop];
                    let slack = ROUNDINGS * f64::EPSILON * stop.limit(side.sign).abs().max(1.0);
                    match stop.law {
                        StopLaw::Rigid { .. } => value > slack,
                        StopLaw::Compliant { .. } if value.abs() <= slack => {
                            side.sign * state.velocity[stop.velocity] > 0.0
                        }
                        StopLaw::Compliant { .. } => value > 0.0,
                    }
                }
                Function::Push(side) => motion.pushes(side) || value > 0.0,
                Function::Pressure(_) => true,
                Function::User(_) | Function::Force(_) => {
                    let old = before.iter().find(|watch| watch.function == function);
                    old.map_or(value > 0.0, |watch| watch.positive)
                }
            };
            self.watches.push(Watch { function, positive });
        }
    }

    /// Looks at the last step up to its end: notes what is only to be noted, and gives the first event that turns it.
    pub(super) fn look<'m>(
        &mut self,
        motion: &mut Motion<'m>,
        stepper: &mut dyn Stepper<Motion<'m>>,
    ) -> Result<Option<Hit>, RunError> {
        let (from, to) = (stepper.previous_time(), stepper.time());
        let mut left = from;
        for look in 1..=LOOKS {
            let right = if look == LOOKS { to } else { from + (to - from) * f64::from(look) / f64::from(LOOKS) };
            // All changes between these two looks, in order of time.
            let mut found: Vec<(f64, usize)> = Vec::new();
            for index in 0..self.watches.len() {
                let Watch { function, positive } = self.watches[index];
                if (self.at(motion, stepper, function, right)? > 0.0) != positive {
                    let time = self.locate(motion, stepper, index, left, right)?;
                    found.push((time, index));
                }
            }
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (time, index) in found {
                if let Some(turn) = self.happen(motion, stepper, time, index)? {
                    return Ok(Some(Hit { time, turn }));
                }
            }
            left = right;
        }
        Ok(None)
    }

    /// The first time between two looks at which a function has changed its sign.
    fn locate<'m>(
        &mut self,
        motion: &mut Motion<'m>,
        stepper: &mut dyn Stepper<Motion<'m>>,
        index: usize,
        mut left: f64,
        mut right: f64,
    ) -> Result<f64, RunError> {
        let Watch { function, positive } = self.watches[index];
        let step = right - left;
        while right - left > 0.5 * TIME * right.abs().max(step) {
            let middle = 0.5 * (left + right);
            if middle <= left || middle >= right {
                break;
            }
            match (self.at(motion, stepper, function, middle)? > 0.0) == positive {
                true => left = middle,
                false => right = middle,
            }
        }
        Ok(right)
    }

    /// Takes note of a change of sign; the turn where it is one.
    fn happen<'m>(
        &mut self,
        motion: &mut Motion<'m>,
        stepper: &mut dyn Stepper<Motion<'m>>,
        time: f64,
        index: usize,
    ) -> Result<Option<Turn>, RunError> {
        let Watch { function, positive } = self.watches[index];
        self.watches[index].positive = !positive;
        let model = motion.model();
        let speed = self.speed(motion, stepper, function, time)?;
        let happened = &mut self.happened;
        let mut note = |kind: Kind, name: &str, value: f64| {
            happened.push(Occurrence { time, kind, name: name.to_owned(), value, speed });
        };
        let of_stop = |side: Side| {
            let stop = &model.stops[side.stop];
            (model.bodies[stop.body].name.as_str(), stop.limit(side.sign))
        };
        Ok(match function {
            Function::Depth(side) => match model.stops[side.stop].law {
                // Said when it is known whether it comes back.
                StopLaw::Rigid { .. } if !positive => Some(Turn::Strike(side)),
                StopLaw::Rigid { .. } => None,
                StopLaw::Compliant { .. } if !positive => {
                    let (name, value) = of_stop(side);
                    note(Kind::Contact, name, value);
                    Some(Turn::Push(side, true))
                }
                StopLaw::Compliant { .. } => None,
            },
            Function::Push(side) => {
                let (name, value) = of_stop(side);
                let inside = model.stops[side.stop].depth(side.sign, &self.state.position) > 0.0;
                match (motion.pushes(side), positive) {
                    (true, true) => {
                        note(Kind::Separation, name, value);
                        Some(Turn::Push(side, false))
                    }
                    (false, false) if inside => {
                        note(Kind::Contact, name, value);
                        Some(Turn::Push(side, true))
                    }
                    _ => None,
                }
            }
            Function::Pressure(held) => {
                let (name, value) = of_stop(motion.held()[held]);
                note(Kind::Release, name, value);
                Some(Turn::Release(held))
            }
            Function::User(event) => {
                let event_of = &model.events[event];
                let counts = match event_of.direction {
                    Direction::Up => !positive,
                    Direction::Down => positive,
                    Direction::Both => true,
                };
                if counts {
                    note(Kind::Crossing, &event_of.name, event_of.value);
                }
                (counts && event_of.stops).then_some(Turn::Stop(event))
            }
            Function::Force(index) => {
                let force = &model.forces[index];
                if let Some(names) = force.law.switches() {
                    let kind = Kind::Force(names[usize::from(!positive)]);
                    note(kind, &force.name, motion.switch(time, index, &self.state).at);
                }
                Some(Turn::Switch)
            }
        })
    }

    /// How fast the watched number changes at a time; that of a push or a pressure is not of interest.
    fn speed<'m>(
        &mut self,
        motion: &mut Motion<'m>,
        stepper: &mut dyn Stepper<Motion<'m>>,
        function: Function,
        time: f64,
    ) -> Result<f64, RunError> {
        self.at(motion, stepper, function, time)?;
        let model = motion.model();
        let velocity = &self.state.velocity;
        Ok(match function {
            Function::Depth(side) | Function::Push(side) => velocity[model.stops[side.stop].velocity],
            Function::Pressure(_) => 0.0,
            Function::User(event) => match &model.events[event].of {
                Watched::Position(index) => motion.position_speed(*index, &self.state),
                Watched::Point(end, axis) => motion.point_velocity(time, end, &self.state).dot(axis),
            },
            Function::Force(index) => motion.switch(time, index, &self.state).rate,
        })
    }

    /// A function at a time within the last step; the state there stays in `state`.
    fn at<'m>(
        &mut self,
        motion: &mut Motion<'m>,
        stepper: &mut dyn Stepper<Motion<'m>>,
        function: Function,
        time: f64,
    ) -> Result<f64, RunError> {
        let mut state = std::mem::replace(&mut self.state, State { position: Vec::new(), velocity: Vec::new() });
        let model = motion.model();
        let found = stepper.interpolate(motion, time, &mut state.position, &mut state.velocity);
        let value = self.value(motion, function, time, &state);
        self.state = state;
        found.map_err(|error| named(model, &error))?;
        Ok(value)
    }

    fn value(&self, motion: &mut Motion<'_>, function: Function, time: f64, state: &State) -> f64 {
        let model = motion.model();
        let State { position, velocity } = state;
        match function {
            Function::Depth(side) => model.stops[side.stop].depth(side.sign, position),
            Function::Push(side) => model.stops[side.stop].push(side.sign, position, velocity),
            Function::Pressure(held) => motion.pressure(time, state, held),
            Function::User(event) => {
                let event = &model.events[event];
                let number = match &event.of {
                    Watched::Position(index) => position[*index],
                    Watched::Point(end, axis) => motion.point(time, end, state).dot(axis),
                };
                number - event.value
            }
            Function::Force(index) => motion.switch(time, index, state).value,
        }
    }
}

/// A coordinate this many roundings from its limit is on it.
const ROUNDINGS: f64 = 64.0;
