//! Contact in motion within the time loop.

use super::Run;
use crate::integrate::{Method, Statistics, Stepper};
use crate::model::problem::{number, significant};
use crate::simulate::contact::{Contacts, MISSED, Trouble};
use crate::simulate::error::RunError;
use crate::simulate::events::{Kind, Occurrence};
use crate::simulate::problem::{Equations, REST_SPEEDS};
use crate::simulate::resting;
use crate::simulate::settings::Settings;
use std::sync::Arc;

use crate::model::Model;

/// Lets bodies touch from now on.
///
/// # Errors
/// [`RunError::Contact`] of a shape that cannot.
pub(super) fn allow(motion: &mut Equations, model: &Arc<Model>, settings: &Settings) -> Result<(), RunError> {
    let refuse = |why: String| RunError::Contact { name: model.contacts[0].name.clone(), why };
    let mut contacts = Contacts::new(model, settings.gap).map_err(|why| refuse(why.to_string()))?;
    let speed = model.length_scale() / model.time_scale();
    let still = settings.absolute_tolerance * speed;
    contacts.set_tolerance(REST_SPEEDS * still, still);
    motion.contacts = Some(Box::new(contacts));
    Ok(())
}

fn told(time: f64, trouble: Trouble) -> RunError {
    match trouble {
        Trouble::Fault(fault) => RunError::Sample { time, fault },
        Trouble::Contact { between, why } | Trouble::Undecided { between, why } => {
            RunError::Touch { time, between, why }
        }
    }
}

/// So many steps show how fast events let a run advance.
const TOIL: u64 = 24;
/// A step between events is worth this part of a captured one, which has three solutions of the cone problem.
const WORTH: f64 = 0.25;

fn tried(statistics: &Statistics) -> u64 {
    statistics.steps + statistics.rejected_steps
}

impl Run<'_, '_> {
    /// Looks at events from a time on.
    pub(super) fn arm(&mut self, motion: &mut Equations, time: f64) {
        if let Some(events) = &mut self.events {
            events.arm(motion, time, &self.state);
        }
    }

    /// Resolves what contacts do at an instant, after everything else that changes there; `at_limit` if a force has left its cone.
    ///
    /// # Errors
    /// [`RunError::Touch`], or a state that cannot be evaluated.
    pub(super) fn touch(&mut self, motion: &mut Equations, time: f64, at_limit: bool) -> Result<(), RunError> {
        self.decide(motion, time, at_limit)?;
        // What is compliant strikes nothing, and steps do not capture it.
        let notes = |contacts: &mut Box<Contacts>| {
            !contacts.is_captured() && !contacts.is_compliant() && contacts.note_event(time)
        };
        if motion.contacts.as_mut().is_some_and(notes) {
            self.note_switch(time, "capture");
        }
        Ok(())
    }

    /// As [`touch`](Self::touch) at the beginning of a run; where it `goes_on` that is no event.
    ///
    /// # Errors
    /// As [`touch`](Self::touch).
    pub(super) fn touch_as(&mut self, motion: &mut Equations, time: f64, goes_on: bool) -> Result<(), RunError> {
        if goes_on { self.decide(motion, time, false) } else { self.touch(motion, time, false) }
    }

    fn decide(&mut self, motion: &mut Equations, time: f64, at_limit: bool) -> Result<(), RunError> {
        let stopped: Vec<usize> =
            motion.held().iter().filter(|held| held.stop.is_some()).map(|held| held.velocity).collect();
        let Equations { contacts: Some(contacts), system, .. } = motion else { return Ok(()) };
        if contacts.is_captured() {
            return Ok(());
        }
        let fault = |fault| RunError::Sample { time, fault };
        if !contacts.is_at_rest() && contacts.is_tied_up(system, time, &self.state, &stopped).map_err(fault)? {
            // Dry friction of hinges, or a stop that holds, and contacts in one tree are followed by captured steps alone.
            return self.capture_or(motion, time, || "dry friction of hinges, or a stop, beside it".to_owned());
        }
        let before = system.at(time, &self.state.position, &self.state.velocity).energies();
        let kept = self.state.clone();
        let changed = match contacts.resolve(system, time, &mut self.state, at_limit) {
            Ok(changed) => changed,
            // What one cone problem does not decide steps do, one after the other.
            Err(Trouble::Undecided { why, .. }) => {
                self.state = kept;
                return self.capture_or(motion, time, || why);
            }
            Err(trouble) => return Err(told(time, trouble)),
        };
        let after = system.at(time, &self.state.position, &self.state.velocity).energies();
        if contacts.deepest().is_some_and(|(_, depth)| depth > MISSED) {
            self.state = kept;
            return self.capture_or(motion, time, || "shapes overlap that no contact keeps apart".to_owned());
        }
        self.ledger.lose(changed.lost + changed.released);
        // Only an impact does work on what drives move.
        if changed.struck && !self.model.drives.is_empty() {
            self.ledger.put_in(after.kinetic - before.kinetic + changed.lost);
        }
        let rules = &self.model.contacts;
        let occurrence = |told: crate::simulate::contact::Told| Occurrence {
            time,
            kind: told.kind,
            name: rules[told.rule].name.clone(),
            value: 0.0,
            unit: "m".to_owned(),
            speed: told.speed,
            between: Some(told.between),
        };
        if let Some(events) = &mut self.events {
            events.happened.extend(changed.told.into_iter().map(occurrence));
        }
        if resting::is_steady(self.model) && self.control.is_none() {
            let mut a = vec![0.0; self.state.velocity.len()];
            let fault = |fault| RunError::Sample { time, fault };
            motion.accelerations(time, &self.state.position, &self.state.velocity, &mut a).map_err(fault)?;
            if let Some(contacts) = &mut motion.contacts {
                contacts.rest_if_still(&mut self.state, &a);
            }
        }
        Ok(())
    }

    /// Proves that captured steps keep shapes apart.
    ///
    /// # Errors
    /// [`RunError::Touch`] of shapes that have sunk into each other.
    pub(super) fn guard_contacts(&self, motion: &mut Equations, time: f64) -> Result<(), RunError> {
        let Equations { contacts: Some(contacts), system, .. } = motion else { return Ok(()) };
        if !contacts.is_captured() {
            return Ok(());
        }
        system.at(time, &self.state.position, &self.state.velocity);
        match contacts.sunk(system) {
            None => Ok(()),
            Some((between, depth)) => {
                let why = format!("captured steps let them sink by {} % of their size", significant(100.0 * depth, 3));
                Err(RunError::Touch { time, between, why })
            }
        }
    }

    /// Lets captured steps go on.
    ///
    /// # Errors
    /// [`RunError::Contact`] of compliant contact, which they do not know, with the reason why they have to.
    fn capture_or(&mut self, motion: &mut Equations, time: f64, why: impl FnOnce() -> String) -> Result<(), RunError> {
        if self.try_capture(motion, time) {
            return Ok(());
        }
        let name = self.model.contacts[0].name.clone();
        let why = format!("at t = {} s compliant contact cannot go on by events ({})", number(time), why());
        Err(RunError::Contact { name, why })
    }

    /// Lets captured steps go on where events do not; false if there are no contacts that they could capture.
    pub(super) fn try_capture(&mut self, motion: &mut Equations, time: f64) -> bool {
        let can = |contacts: &&mut Box<Contacts>| !contacts.is_captured() && !contacts.is_compliant();
        let Some(contacts) = motion.contacts.as_mut().filter(can) else { return false };
        contacts.capture_from(time);
        self.note_switch(time, "capture");
        true
    }

    /// Tells what steps from here.
    fn note_switch(&mut self, time: f64, name: &str) {
        if let Some(events) = &mut self.events {
            let name = name.to_owned();
            let unit = "s".to_owned();
            events.happened.push(Occurrence {
                time,
                kind: Kind::Switch,
                name,
                value: 0.0,
                unit,
                speed: 0.0,
                between: None,
            });
        }
    }

    /// Whether captured steps may end: nothing changes, or nothing moves.
    pub(super) fn hands_back(&self, motion: &Equations, time: f64) -> bool {
        let steady = resting::is_steady(self.model) && self.control.is_none();
        motion.contacts.as_ref().is_some_and(|contacts| contacts.is_calm(time) || steady && contacts.is_still())
    }

    /// Whether steps between events advance so little since captured ones handed back that these would have done better.
    pub(super) fn toils(&self, motion: &Equations, stepper: &dyn Stepper<Equations>, time: f64) -> bool {
        let Some(contacts) = motion.contacts.as_ref().filter(|contacts| !contacts.is_captured()) else { return false };
        // What flies freely takes the steps that its own motion asks for.
        if !contacts.is_busy() {
            return false;
        }
        let Some((since, before)) = self.handed_back else { return false };
        let tried = tried(&self.statistics) + tried(stepper.statistics()) - before;
        tried >= TOIL && time - since < WORTH * contacts.captured_step() * tried as f64
    }

    /// Ends captured steps: events go on, or everything rests.
    ///
    /// # Errors
    /// As [`Run::touch`].
    pub(super) fn hand_back(
        &mut self,
        motion: &mut Equations,
        settings: &Settings,
        time: f64,
        method: Method,
    ) -> Result<(), RunError> {
        let Some(contacts) = &mut motion.contacts else { return Ok(()) };
        if contacts.is_still() {
            self.state.velocity.fill(0.0);
            let raised = motion.raise_to_rest(time, &mut self.state.position, &self.state.velocity);
            raised.map_err(|fault| RunError::Sample { time, fault })?;
            // The last step had other points of contact, and its forces brought to rest what moved.
            motion.balance_at_rest(time, &self.state).map_err(|fault| RunError::Sample { time, fault })?;
            if let Some(contacts) = &mut motion.contacts {
                contacts.freeze();
            }
        } else {
            contacts.end_capture();
            // Stops and dry friction hold by themselves again.
            self.resolve(motion, settings, time)?;
            self.touch(motion, time, false)?;
        }
        if !motion.is_captured() {
            self.note_switch(time, method.name());
            self.handed_back = Some((time, tried(&self.statistics)));
        }
        self.ledger.close(&motion.energies(time, &self.state.position, &self.state.velocity));
        self.arm(motion, time);
        Ok(())
    }
}
