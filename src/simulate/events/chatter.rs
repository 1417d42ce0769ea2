//! Formulas that switch to and fro without getting anywhere: `sign(v)` as friction, `sign(q + v)` as a control. What they do on each side of
//! a switch drives the scene back to it (a sliding mode, Filippov 1988). Only what switches with a speed can do so at once: a force drives
//! back to a place in swings.

use super::{Events, Function, Watch};
use crate::integrate::Stepper;
use crate::simulate::error::RunError;
use crate::simulate::problem::Equations;

/// A piece is left at once if its number has been no more than so many bands within it.
const BANDS: f64 = 4.0;
/// So many pieces that are left at once, one after the other, are a sliding mode.
const MOST: u32 = 3;

/// How often pieces of motors have been left at once, one after the other.
#[derive(Debug, Default)]
pub(super) struct Chatter(Vec<u32>);

impl Chatter {
    /// Takes note of a motor's switch; whether that is one too many.
    fn note(&mut self, motor: usize, at_once: bool) -> bool {
        if self.0.len() <= motor {
            self.0.resize(motor + 1, 0);
        }
        self.0[motor] = if at_once { self.0[motor] + 1 } else { 0 };
        self.0[motor] >= MOST
    }
}

impl Events {
    /// The motor whose formula switches to and fro, if the change of sign of a watch at a time within the last step is one switch too many.
    pub(super) fn chatters(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        index: usize,
        time: f64,
    ) -> Result<Option<usize>, RunError> {
        let Watch { function, lowest, band, .. } = self.watches[index];
        let Function::Law(boundary) = function else { return Ok(None) };
        let Some(motor) = motion.system.motor_of(boundary) else { return Ok(None) };
        // Steps begin where the last switch was, and looks may lie beyond this one.
        let middle = 0.5 * (stepper.previous_time() + time);
        self.move_to(motion, stepper, middle)?;
        let between = self.value(motion, function, time);
        let within = self.watches[index].towards(between).min(lowest);
        self.move_to(motion, stepper, time)?;
        // Ends of other pieces are as far as they are from here on.
        for watch in &mut self.watches {
            if matches!(watch.function, Function::Law(other) if other.element == boundary.element) {
                watch.lowest = f64::INFINITY;
            }
        }
        let is_speed = motion.switch(time, boundary, &self.state).is_speed;
        Ok((is_speed && self.chatter.note(motor, within > -BANDS * band)).then_some(motor))
    }
}
