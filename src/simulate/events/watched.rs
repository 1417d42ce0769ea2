//! What is watched: the functions whose changes of sign are events, and their rates.

use super::super::contact::Aspect;
use super::super::problem::Equations;
use super::super::state::State;
use super::{Events, Function};
use crate::dynamics::applied::{Rubbing, rate_of};
use crate::model::{Model, Quantity, Watched};
use crate::round_off::WATCHED;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// How the number of an event of the model may jump as a scene moves on smoothly: no crossing of the value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Jump {
    /// It does not, or what jumps is meant.
    None,
    /// An angle about an axis, by a turn.
    Turn,
    /// A quaternion, to its negative.
    Sign,
}

/// A number that is this far (rad, 1) beyond its value where it was found to have passed it has jumped across.
const ACROSS: f64 = 1e-3;

impl Jump {
    pub(super) fn of(model: &Model, watched: &Watched) -> Self {
        let Watched::Output(number) = watched else { return Self::None };
        match model.outputs.iter().find(|output| output.range().contains(number)).map(|output| &output.quantity) {
            Some(Quantity::Angle(angle)) if angle.about.is_some() => Self::Turn,
            Some(Quantity::Orientation(_)) => Self::Sign,
            _ => Self::None,
        }
    }

    /// Whether a number has come across by a jump that it is this far beyond.
    pub(super) fn is_made(self, beyond: f64) -> bool {
        self != Self::None && beyond.abs() > ACROSS
    }

    /// A number less the value of its event; of angles the nearest of all turns, so that the jump is half a turn from the value.
    fn less(self, number: f64, value: f64) -> f64 {
        let less = number - value;
        if self == Self::Turn && value.abs() <= PI { less - TAU * (less / TAU).round() } else { less }
    }
}

impl Events {
    /// Looks what accelerations are at the state, and what holds.
    fn press(&mut self, motion: &mut Equations, time: f64) {
        if !self.pressed {
            motion.press(time, &self.state, &mut self.accelerations, &mut self.reserves);
            self.pressed = true;
        }
    }

    /// How fast the watched number changes at the state; 0 for a push or a reserve, and for an output whose rate is not
    /// known.
    pub(super) fn rate(&mut self, motion: &mut Equations, function: Function, time: f64) -> f64 {
        let model = &Arc::clone(motion.model());
        if let Function::Speed(index) = function {
            self.press(motion, time);
            return self.along(motion, index, &self.accelerations);
        }
        if let Function::Contact(aspect) = function {
            return self.contact(motion, aspect, time)[1];
        }
        match function {
            Function::Contact(_) => 0.0,
            Function::End(end) => {
                let end = &model.curve_ends[end];
                end.side.sign() * self.state.velocity[end.velocity]
            }
            Function::Depth(side) => side.at.sign() * self.state.velocity[model.stops[side.stop].velocity],
            Function::Push(_) | Function::Reserve(_) | Function::Speed(_) | Function::Breakaway(_) => 0.0,
            Function::User(event) => {
                Some(self.speed(motion, event, time)).filter(|speed| !speed.is_nan()).unwrap_or(0.0)
            }
            Function::Law(boundary) => motion.switch(time, boundary, &self.state).rate,
        }
    }

    /// How fast the number of an event changes at the state; not a number if that is not known.
    pub(super) fn speed(&mut self, motion: &mut Equations, event: usize, time: f64) -> f64 {
        let model = &Arc::clone(motion.model());
        match &model.events[event].of {
            Watched::Position(_) => self.state.velocity[self.velocities[event]],
            Watched::Point(end, axis) => motion.point_velocity(time, end, &self.state).dot(axis),
            Watched::Output(number) => self.output(motion, time, *number)[1],
        }
    }

    /// What the number of an event is measured in.
    pub(super) fn unit(&self, model: &Model, event: usize) -> String {
        match &model.events[event].of {
            Watched::Position(_) => model.coordinate_unit(self.velocities[event]),
            Watched::Point(..) => "m",
            Watched::Output(number) => model.output_unit(*number),
        }
        .to_owned()
    }

    /// What rounding makes of the number of an event at the state.
    pub(super) fn noise(&mut self, motion: &mut Equations, event: usize, time: f64) -> f64 {
        let model = &Arc::clone(motion.model());
        let noise = match &model.events[event].of {
            Watched::Position(place) => {
                let is_distance = model.coordinate_unit(self.velocities[event]) == "m";
                self.noise.of_place(self.state.position[*place], is_distance)
            }
            Watched::Point(end, axis) => self.noise.of_place(motion.point(time, end, &self.state).dot(axis), true),
            Watched::Output(number) => {
                let seen = self.outputs.as_mut().and_then(|outputs| outputs.seen(motion, time, &self.state));
                seen.map_or(0.0, |[values, _]| self.noise.of_number(*number, time, values))
            }
        };
        noise.max(WATCHED.of(model.events[event].value.abs().max(1.0)))
    }

    /// What contacts do at the state, and its rate.
    fn contact(&mut self, motion: &mut Equations, aspect: Aspect, time: f64) -> [f64; 2] {
        self.press(motion, time);
        let Equations { contacts: Some(contacts), system, .. } = motion else { return [0.0; 2] };
        contacts.watched(aspect, system)
    }

    /// A number of an output and its rate.
    fn output(&mut self, motion: &mut Equations, time: f64, number: usize) -> [f64; 2] {
        let state = &self.state;
        self.outputs.as_mut().map_or([f64::NAN; 2], |outputs| outputs.watched(motion, time, state, number))
    }

    /// Velocities or accelerations in the direction in which something slides.
    fn along(&self, motion: &Equations, friction: usize, of: &[f64]) -> f64 {
        match motion.system.phase().rubbing[friction] {
            Rubbing::Slides(direction) => rate_of(&motion.model().hinge_friction[friction], of).dot(&direction),
            _ => 0.0,
        }
    }

    /// A function at the state.
    pub(super) fn value(&mut self, motion: &mut Equations, function: Function, time: f64) -> f64 {
        if let Function::Reserve(held) = function {
            self.press(motion, time);
            return self.reserves[held];
        }
        if let Function::Contact(aspect) = function {
            return self.contact(motion, aspect, time)[0];
        }
        let model = &Arc::clone(motion.model());
        let State { position, velocity } = &self.state;
        match function {
            Function::Contact(_) => 0.0,
            Function::Depth(side) => model.stops[side.stop].depth(side.at, position),
            Function::End(end) => model.curve_ends[end].beyond(position),
            Function::Push(side) => model.stops[side.stop].push(side.at, position, velocity),
            Function::Reserve(held) => self.reserves[held],
            Function::Speed(index) => {
                let friction = &model.hinge_friction[index];
                let rest = if friction.count == 1 { 0.0 } else { motion.rest_speed(friction.velocity, self.tolerance) };
                self.along(motion, index, velocity) - rest
            }
            Function::Breakaway(index) => rate_of(&model.hinge_friction[index], velocity).norm(),
            Function::User(index) => {
                let event = &model.events[index];
                let number = match &event.of {
                    Watched::Position(place) => position[*place],
                    Watched::Point(end, axis) => motion.point(time, end, &self.state).dot(axis),
                    Watched::Output(number) => self.output(motion, time, *number)[0],
                };
                self.jumps[index].less(number, event.value)
            }
            Function::Law(boundary) => motion.switch(time, boundary, &self.state).value,
        }
    }
}
