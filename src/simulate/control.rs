//! Controllers in a run: what they have set, what they remember, and when they act next.
//!
//! Instants are `k T` in absolute time, so that a run that goes on keeps them. Steps end just before an instant; there all that are
//! due read the same outputs, then their inputs change at once. An instant at the end of a run is the first of the run that goes on.

use crate::dynamics::System;
use crate::model::Model;
use crate::round_off::{TIME, has_come};
use crate::simulate::error::RunError;
use crate::simulate::state::State;
use std::sync::Arc;

/// A steady input that differs by more than this part is another one.
const STEADY: f64 = 1e-9;

/// What a function sees at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Sensed<'s> {
    /// Time (s).
    pub time: f64,
    /// Positions and velocities.
    pub state: &'s State,
    /// The numbers of all outputs, in the order of the model.
    pub outputs: &'s [f64],
}

/// A function as a controller: it sets the inputs of the model, in the order of [`Model::inputs`] (N or N m), or says why it cannot,
/// which ends the run.
pub type Law<'f> = dyn FnMut(Sensed<'_>, &mut [f64]) -> Result<(), String> + 'f;

/// A function that acts in addition to the controllers of the scene, after those that are due at the same instant.
pub struct Function<'f> {
    /// Time between its instants (s), > 0.
    pub period: f64,
    /// What it does there.
    pub law: &'f mut Law<'f>,
}

/// The instants of one period.
#[derive(Debug, Clone, Copy)]
struct Clock {
    period: f64,
    /// Index of the next one.
    next: f64,
}

impl Clock {
    /// With the first instant at a time (s) or after it.
    fn new(period: f64, begin: f64) -> Self {
        Self { period, next: (TIME.below(begin / period) - TIME.of(1.0)).ceil() }
    }

    fn due(&self) -> f64 {
        self.next * self.period
    }

    /// Whether it is due at a time; then the next one is.
    fn strikes(&mut self, time: f64) -> bool {
        let strikes = has_come(self.due(), time);
        self.next += f64::from(u8::from(strikes));
        strikes
    }
}

/// All controllers of a run.
pub(super) struct Control<'f> {
    model: Arc<Model>,
    clocks: Vec<Clock>,
    /// What the controllers of the model remember.
    pub(super) memories: Vec<Vec<f64>>,
    function: Option<(Clock, &'f mut Law<'f>)>,
    /// The last instant (s).
    last: Option<f64>,
    sensed: Vec<f64>,
    set: Vec<f64>,
}

impl<'f> Control<'f> {
    /// Of a run that begins at a time (s); `None` if nothing acts.
    pub(super) fn new(model: &Arc<Model>, begin: f64, function: Option<Function<'f>>) -> Option<Self> {
        if model.controllers.is_empty() && function.is_none() {
            return None;
        }
        Some(Self {
            model: Arc::clone(model),
            clocks: model.controllers.iter().map(|one| Clock::new(one.period, begin)).collect(),
            memories: model.controllers.iter().map(|one| one.memory().to_vec()).collect(),
            function: function.map(|function| (Clock::new(function.period, begin), function.law)),
            last: None,
            sensed: Vec::new(),
            set: Vec::new(),
        })
    }

    /// The next instant (s).
    pub(super) fn next(&self) -> f64 {
        let function = self.function.iter().map(|(clock, _)| clock.due());
        self.clocks.iter().map(Clock::due).chain(function).fold(f64::INFINITY, f64::min)
    }

    /// Whether an instant is at this time.
    pub(super) fn is_due(&self, time: f64) -> bool {
        has_come(self.next(), time)
    }

    /// Whether this time was the last instant.
    pub(super) fn acted(&self, time: f64) -> bool {
        self.last == Some(time)
    }

    /// Lets all act that are due.
    ///
    /// # Errors
    /// The controller whose value is not a finite number, and what a function says.
    pub(super) fn act(&mut self, system: &mut System, sensed: Sensed<'_>) -> Result<(), RunError> {
        let Sensed { time, outputs, .. } = sensed;
        self.last = Some(time);
        let all = self.model.controllers.iter().zip(&mut self.clocks).zip(&mut self.memories);
        for ((controller, clock), memory) in all.filter(|((_, clock), _)| has_come(clock.due(), time)) {
            clock.strikes(time);
            self.sensed.clear();
            self.sensed.extend(controller.senses.iter().map(|place| outputs[*place]));
            controller.act(time, &self.sensed, memory, &mut self.set);
            for (input, force) in controller.drives.iter().zip(&self.set) {
                if !force.is_finite() {
                    let input = self.model.motors[self.model.inputs[*input]].name.clone();
                    let reason = unfit(&input, *force);
                    return Err(RunError::Controller { time, name: controller.name.clone(), reason });
                }
                system.inputs()[*input] = *force;
            }
        }
        let Some((clock, law)) = &mut self.function else { return Ok(()) };
        if clock.strikes(time) {
            let wrong = |reason: String| RunError::Controller { time, name: "function".to_owned(), reason };
            law(sensed, system.inputs()).map_err(wrong)?;
            let bad = self.model.inputs.iter().zip(&*system.inputs()).find(|(_, force)| !force.is_finite());
            if let Some((motor, force)) = bad {
                return Err(wrong(unfit(&self.model.motors[*motor].name, *force)));
            }
        }
        Ok(())
    }
}

/// What is wrong with a value that is not finite.
fn unfit(input: &str, force: f64) -> String {
    let what = if force.is_nan() { "what is not a number" } else { "an infinite number" };
    format!("it sets `{input}` to {what}")
}

/// The first controller that pushes otherwise at an equilibrium than the input that statics has found it with.
///
/// # Errors
/// [`RunError::Unsteady`].
pub(super) fn check_steady(model: &Model, outputs: &[f64]) -> Result<(), RunError> {
    let mut set = Vec::new();
    for controller in &model.controllers {
        let sensed: Vec<f64> = controller.senses.iter().map(|place| outputs[*place]).collect();
        controller.act(0.0, &sensed, &mut controller.memory().to_vec(), &mut set);
        for (input, asked) in controller.drives.iter().zip(&set) {
            let motor = &model.motors[model.inputs[*input]];
            let (given, asked) = (motor.given().unwrap_or(0.0), motor.saturated(*asked).force);
            let differs = (asked - given).abs() > STEADY * asked.abs().max(given.abs()).max(1.0);
            if differs || asked.is_nan() {
                let (name, input) = (controller.name.clone(), motor.name.clone());
                return Err(RunError::Unsteady { name, input, given, asked });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_are_met_once_whoever_begins_where() {
        for period in [0.1, 0.01, 1.0 / 3.0, 7e-4] {
            let mut whole = Clock::new(period, 0.0);
            for k in 0..1000_u32 {
                let time = f64::from(k) * period;
                assert_eq!(whole.due(), time);
                // As a run that ended there goes on, written by a user or counted by a grid.
                for begin in [time, time.next_up(), time * (1.0 - f64::EPSILON)] {
                    assert_eq!(Clock::new(period, begin).due(), time, "{period} {k}");
                }
                assert!(whole.strikes(time) && !whole.strikes(time));
            }
        }
    }
}
