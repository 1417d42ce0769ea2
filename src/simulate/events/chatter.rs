//! Formulas that switch to and fro without getting anywhere: `sign(v)` as friction, `sign(q + v)` as a control. What they do on each side of
//! a switch drives the scene back to it (a sliding mode, Filippov 1988). What switches with a speed does so at once; a force drives back to
//! a place in swings, and where something takes energy out these become ever shorter, within a finite time (`sign(q)` beside dry friction).

use super::{Events, Function, Watch};
use crate::integrate::Stepper;
use crate::simulate::error::RunError;
use crate::simulate::problem::Equations;

/// A piece is left at once if its number has been no more than so many bands within it.
const BANDS: f64 = 4.0;
/// So many pieces that are left at once, one after the other, are a sliding mode.
const MOST: u32 = 3;
/// Swings of so many bands and more are followed.
const FOLLOWED: f64 = 100.0;
/// Over swings that get shorter by this factor the part by which each is shorter is compared.
const SHORTER: f64 = 16.0;
/// What is left of that part where every swing loses the same share of itself: all of it. Where damping takes the energy out, whose share
/// goes with the root of the swing, it is a quarter, and there is no end of swings.
const KEEPS: f64 = 0.6;

/// How motors have switched to and fro until now.
#[derive(Debug, Default)]
pub(super) struct Chatter(Vec<Motor>);

/// How a motor has.
#[derive(Debug, Default, Clone)]
struct Motor {
    /// Pieces of speeds left at once, one after the other.
    at_once: u32,
    /// The last swing about a place.
    last: f64,
    /// The swing from which on swings get shorter, and the part by which it was shorter than the one before.
    first: Option<[f64; 2]>,
}

impl Motor {
    /// Whether swings end within a finite time, and this one is among the last.
    fn accumulates(&mut self, swing: f64, band: f64) -> bool {
        let part = 1.0 - swing / self.last;
        self.last = swing;
        let Some([first, first_part]) = self.first.filter(|_| part > 0.0) else {
            self.first = (part > 0.0 && part < 1.0).then_some([swing, part]);
            return false;
        };
        if swing > first / SHORTER {
            return false;
        }
        self.first = Some([swing, part]);
        part > KEEPS * first_part && swing < FOLLOWED * band
    }
}

impl Chatter {
    /// Takes note of a motor's switch that was `within` a piece by so much; whether that is one too many.
    fn note(&mut self, motor: usize, is_speed: bool, within: f64, band: f64) -> bool {
        if self.0.len() <= motor {
            self.0.resize(motor + 1, Motor::default());
        }
        let motor = &mut self.0[motor];
        if !is_speed {
            return motor.accumulates(within.abs(), band);
        }
        motor.at_once = if within > -BANDS * band { motor.at_once + 1 } else { 0 };
        motor.at_once >= MOST
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
        Ok(self.chatter.note(motor, is_speed, within, band).then_some(motor))
    }
}
