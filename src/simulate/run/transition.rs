//! What follows from an event within the time loop.

use super::{Run, fixed_step};
use crate::integrate::Method;
use crate::model::problem::number;
use crate::model::stop::sides;
use crate::model::{CurveEnd, StopSide};
use crate::simulate::error::RunError;
use crate::simulate::events::{Hit, Kind, Transition};
use crate::simulate::problem::Equations;
use crate::simulate::settings::Settings;
use crate::simulate::stops::instant::{self, Outcome};

/// A guard behind the search for events: the end of a curve is passed by no more than this part of its slack.
const PASSED: f64 = 1e3;

impl Run<'_, '_> {
    fn leaves(&self, time: f64, end: &CurveEnd) -> RunError {
        let hinge = self.model.bodies[end.body].name.clone();
        RunError::Leaves { time, hinge, at: end.at, speed: self.state.velocity[end.velocity] }
    }

    /// Nothing is beyond the curve that it is guided along.
    pub(super) fn guard_curves(&self, time: f64) -> Result<(), RunError> {
        let far = |end: &&CurveEnd| end.beyond(&self.state.position) > PASSED * end.slack;
        self.model.curve_ends.iter().find(far).map_or(Ok(()), |end| Err(self.leaves(time, end)))
    }

    /// What an event at a rigid limit leaves beyond it by rounding is put on the limit: whatever goes on from there starts within it.
    fn put_on_limits(&mut self, motion: &mut Equations, time: f64) -> Result<(), RunError> {
        let stops = &self.model.stops;
        let is_beyond = |side: &StopSide| {
            stops[side.stop].is_rigid() && stops[side.stop].depth(side.at, &self.state.position) > 0.0
        };
        let beyond: Vec<StopSide> = sides(stops).filter(is_beyond).collect();
        if beyond.is_empty() || motion.is_captured() {
            return Ok(());
        }
        let fault = |fault| RunError::Sample { time, fault };
        let held = motion.held().to_vec();
        motion.lift(time, &mut self.state, &beyond).map_err(fault)?;
        motion.hold(time, &self.state, &held).map_err(fault)
    }

    /// What follows from an event.
    pub(super) fn transition(
        &mut self,
        motion: &mut Equations,
        settings: &Settings,
        method: Method,
        Hit { time, transition }: Hit,
    ) -> Result<(), RunError> {
        if let Transition::Stop(event) = transition {
            self.put_on_limits(motion, time)?;
            let name = |event: usize| self.model.events[event].name.clone();
            self.stopped_by = Some(name(event));
            let together = self.events.as_mut().map_or_else(Vec::new, |events| std::mem::take(&mut events.together));
            self.stopped_with = together.into_iter().map(name).collect();
            return Ok(());
        }
        if let Transition::Leave(end) = transition {
            return Err(self.leaves(time, &self.model.curve_ends[end]));
        }
        if let Some(rule) = self.model.contacts.first().filter(|_| self.rests) {
            let why = format!("at t = {} s a stop or dry friction lets go of what rests", number(time));
            return Err(RunError::Contact { name: rule.name.clone(), why });
        }
        let touches = |side: StopSide| {
            let velocity = self.model.stops[side.stop].velocity;
            motion.contacts.as_ref().is_some_and(|contacts| contacts.is_beside(velocity))
        };
        if let Transition::Strike(side) = transition
            && touches(side)
            && self.try_capture(motion, time)
        {
            // A rigid stop of what may touch: captured steps resolve both.
            self.arm(motion, time);
            return Ok(());
        }
        let outcome = match transition {
            Transition::Contact { .. } => Outcome::default(),
            Transition::Switch(boundary) => {
                let [q, v] = [&self.state.position, &self.state.velocity];
                let before = motion.energies(time, q, v).potential;
                motion.system.cross(boundary);
                // What it jumps by may be across other boundaries at once.
                let happened = motion.switch_laws(time, &self.state, settings.absolute_tolerance);
                // What lets go takes with it what it has stored.
                let lost = before - motion.energies(time, q, v).potential;
                Outcome { happened, lost, ..Outcome::default() }
            }
            Transition::Chatter(motor) => {
                // A method that looks at its errors would take ever shorter steps.
                if fixed_step(self.model, settings, method).is_none() {
                    return Err(RunError::Chatters { time, motor: self.model.motors[motor].name.clone() });
                }
                self.go_across(motion, motor);
                Outcome::default()
            }
            Transition::Relax(_) => Outcome::default(),
            _ => instant::resolve(motion, time, &mut self.state, settings.absolute_tolerance, Some(transition))?,
        };
        self.ledger.lose(outcome.lost);
        self.ledger.put_in(outcome.work);
        self.touch(motion, time, transition == Transition::Contact { at_limit: true })?;
        self.ledger.close(&motion.energies(time, &self.state.position, &self.state.velocity));
        let pushed = outcome.happened.iter().any(|occurrence| occurrence.kind == Kind::Contact);
        let storm = self.event_pace.see(time, self.end);
        if let Some(storm) = storm.filter(|_| !self.try_capture(motion, time) && !self.go_across_all(motion)) {
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

    /// Follows the formula of a motor as it stands from now on, and tells so at the end.
    fn go_across(&mut self, motion: &mut Equations, motor: usize) {
        motion.system.follow_across(motor);
        self.across.push(self.model.motors[motor].name.clone());
    }

    /// Does so for all motors whose formulas end steps; whether there was any.
    fn go_across_all(&mut self, motion: &mut Equations) -> bool {
        let mut motors: Vec<usize> = motion.system.boundaries().filter_map(|own| motion.system.motor_of(own)).collect();
        motors.dedup();
        motors.iter().for_each(|motor| self.go_across(motion, *motor));
        !motors.is_empty()
    }
}
