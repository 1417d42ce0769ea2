//! States of closed contacts by an active set: which stick, slip and lift follows from the forces that their rows give.
//!
//! ```text
//! (3)  stick → slip along −λ_t    where |λ_t| > μ λ_n          slip → along u̇_t, or stick       where that is not against λ_t
//!      stick, slip → open         where λ_n < 0                open → stick                    where u̇_n < 0
//! ```
//!
//! (A primal-dual active set, semismooth Newton's method for Coulomb's law: Alart, Curnier, *Comput. Methods Appl. Mech. Eng.* 92, 1991; Hüeber,
//! Stadler, Wohlmuth, *SIAM J. Sci. Comput.* 30, 2008.) It begins with everything at rest stuck, and changes all at once what contradicts:
//! where forces are not unique it ends with those of least norm, and gives to like contacts like states. Of sweeps, which take one contact
//! after the other, both depend on their order. Where it does not end they decide.

use super::decide::{SINKS, SLIPS};
use super::watch::BEYOND;
use super::{Closed, ContactState, Contacts};
use crate::contact::frame::Frame;
use crate::dynamics::{Fault, System};
use crate::simulate::state::State;
use nalgebra::Vector3;

/// Rounds of (3).
const MOST_ROUNDS: usize = 12;
/// Directions of slips that begin are found to this part of their acceleration.
const ALONG: f64 = 1e-11;

impl Contacts {
    /// Finds states whose rows contradict nothing; false if (3) does not end. Friction at rest is `less` than it is by that part, `size` is that
    /// of the accelerations without contact.
    ///
    /// # Errors
    /// A state that cannot be evaluated.
    pub(super) fn by_rows(
        &mut self,
        system: &mut System,
        state: &State,
        frames: &[Frame],
        [size, less]: [f64; 2],
    ) -> Result<bool, Fault> {
        if self.closed.iter().any(|closed| !self.is_rigid(closed.key.couple)) {
            return Ok(false);
        }
        for _ in 0..MOST_ROUNDS {
            let fits = self.fits(system, state, frames, size)?;
            self.compare();
            let within = self.reserve() >= -BEYOND;
            // Forces that are not unique may be within their cones though those of least norm are not.
            let is_held = within && less <= 0.0;
            // Of rows that depend on each other some are not kept: what they say has to hold all the same.
            let drifts = |(closed, rate): (&Closed, &Vector3<f64>)| {
                closed.state == ContactState::Stick && rate.yz().norm() > SINKS * size
            };
            if self.closed.iter().zip(&fits.rates).any(drifts) {
                return Ok(false);
            }
            let next: Vec<_> =
                fits.rates.iter().enumerate().map(|(at, rate)| self.next(at, rate, [size, less], is_held)).collect();
            if next.iter().all(Option::is_none) {
                let holds = within && fits.rises && fits.brakes;
                if holds {
                    let mut rates = fits.rates.iter();
                    let opens = |rate: Option<&Vector3<f64>>| rate.is_some_and(|rate| rate.x > SLIPS * size);
                    self.closed.retain(|closed| !(opens(rates.next()) && closed.state == ContactState::Spare));
                }
                return Ok(holds);
            }
            for (closed, next) in self.closed.iter_mut().zip(next) {
                closed.state = next.unwrap_or(closed.state);
            }
            self.begin_slips();
        }
        Ok(false)
    }

    /// Another state of a contact by (3), if it contradicts; `rate` is how it accelerates, in its basis.
    fn next(&self, at: usize, rate: &Vector3<f64>, [size, less]: [f64; 2], is_held: bool) -> Option<ContactState> {
        let (closed, frame) = (&self.closed[at], &self.frames[at]);
        let force = frame.basis.tr_mul(&closed.force);
        let (beyond, friction) = (BEYOND * self.scale, self.law(closed.key.couple).friction);
        let across = |y: f64, z: f64| frame.basis.column(1) * y + frame.basis.column(2) * z;
        match closed.state {
            ContactState::Spare => (rate.x < -SINKS * size).then(|| self.moves(frame, self.slow)),
            _ if rate.x > SINKS * size || force.x < -beyond && !is_held => Some(ContactState::Spare),
            ContactState::Stick if is_held => None,
            ContactState::Stick => {
                let most = friction.stick * (1.0 - less.max(0.0)) * force.x;
                let slips = force.yz().norm() > most + if less > 0.0 { 0.0 } else { beyond };
                let along = -across(force.y, force.z).try_normalize(0.0)?;
                slips.then_some(ContactState::Slip(along))
            }
            ContactState::Slip(_) if closed.slip.norm() > self.slow || friction.slide == 0.0 => None,
            // What a couple's points share is turned with them, but all have to slip.
            ContactState::Slip(direction) if closed.straight => {
                (across(rate.y, rate.z).dot(&direction) <= SLIPS * size).then_some(ContactState::Stick)
            }
            ContactState::Slip(direction) => {
                let along = across(rate.y, rate.z);
                match along.norm() > SLIPS * size && along.dot(&direction) > 0.0 {
                    true => {
                        let along = along.normalize();
                        ((along - direction).norm() > ALONG).then_some(ContactState::Slip(along))
                    }
                    false => Some(ContactState::Stick),
                }
            }
        }
    }
}
