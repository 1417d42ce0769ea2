//! How a slip begins, goes straight on, turns and comes to rest.

use super::{Closed, ContactState, Contacts};
use nalgebra::Vector3;

/// Directions that differ by less are one, of what slips and of what begins to.
const PARALLEL: f64 = 1e-6;
const ALIKE: f64 = 0.5;
/// A slip has moved once it is so many times faster than what is told from rest.
const MOVED: f64 = 2.0;
/// A slip that ends may have turned while the step lasted: it is at rest up to so many times what is told from that.
pub(super) const ENDS: f64 = 4.0;
/// A difference of the friction of a slip that turns is taken over this part of its speed: it changes within that speed.
const OVER: f64 = 1e-2;
/// An event is located to less than this part of the speed that it watches for.
const LOCATED: f64 = 1e-6;

impl Closed {
    /// Whether it slips, and not straight on.
    fn turns(&self) -> bool {
        matches!(self.state, ContactState::Slip(_)) && !self.straight
    }
}

impl Contacts {
    /// The direction in which a contact slips.
    pub(super) fn direction(&self, closed: &Closed) -> Vector3<f64> {
        let ContactState::Slip(held) = closed.state else { return Vector3::zeros() };
        let (slip, speed) = (closed.slip, closed.slip.norm());
        let n = closed.meeting.normal;
        let flat = (held - n * n.dot(&held)).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        if held == Vector3::zeros() || closed.straight || slip.dot(&flat) <= 0.0 {
            return flat;
        }
        // What is told from rest has its own; what is slower has part of it, so that friction does not jump there.
        let part = speed / self.still;
        if part >= 1.0 { slip / speed } else { (flat * (1.0 - part) + slip / self.still).normalize() }
    }

    /// Slips begin in the directions that have been found: straight on where all of a couple have one, nearly.
    pub(super) fn begin_slips(&mut self) {
        for closed in &mut self.closed {
            closed.straight = false;
            closed.begins = match closed.state {
                ContactState::Slip(direction) => direction,
                _ => Vector3::zeros(),
            };
        }
        self.straighten();
    }

    /// Contacts of a couple that slip in one direction, nearly, do so straight on, in the mean of them.
    fn straighten(&mut self) {
        for at in 0..self.closed.len() {
            let couple = self.closed[at].key.couple;
            if self.closed[..at].iter().any(|closed| closed.key.couple == couple) {
                continue;
            }
            let own: Vec<usize> = (at..self.closed.len()).filter(|i| self.closed[*i].key.couple == couple).collect();
            let slip = |i: &usize| match self.closed[*i].state {
                ContactState::Slip(direction) if direction != Vector3::zeros() => Some(direction),
                _ => None,
            };
            let directions: Vec<Vector3<f64>> = own.iter().filter_map(slip).collect();
            let Some(mean) = directions.iter().sum::<Vector3<f64>>().try_normalize(1e-3) else { continue };
            let moves = own.iter().any(|i| self.closed[*i].slip.norm() > self.slow);
            let near = if moves { PARALLEL } else { ALIKE };
            let straight = directions.iter().all(|direction| (direction - mean).norm() <= near);
            for i in own {
                let closed = &mut self.closed[i];
                if let ContactState::Slip(direction) = &mut closed.state
                    && straight
                    && *direction != Vector3::zeros()
                {
                    *direction = mean;
                    closed.straight = true;
                }
            }
        }
    }

    /// Turns slips that begin to where nothing keeps them straight; those that have a direction, and all if it is the `last` turn, go
    /// on as they will, each in the direction that it was read with.
    pub(super) fn turn(&mut self, last: bool) {
        let mut couples: Vec<usize> =
            self.closed.iter().filter(|closed| closed.straight).map(|closed| closed.key.couple).collect();
        couples.dedup();
        for couple in couples {
            let own = |closed: &&Closed| closed.straight && closed.key.couple == couple;
            let across: f64 = self.closed.iter().filter(own).map(|closed| closed.across).sum();
            let moves = self.closed.iter().filter(own).any(|closed| closed.slip.norm() > self.slow);
            let friction = self.rubs(couple);
            let ends = last || moves || !(friction > 0.0);
            for closed in self.closed.iter_mut().filter(|closed| closed.straight && closed.key.couple == couple) {
                closed.straight = !ends;
                let ContactState::Slip(direction) = &mut closed.state else { continue };
                if ends {
                    *direction = closed.begins;
                } else {
                    let sideways = closed.meeting.normal.cross(direction);
                    *direction = (*direction - sideways * (across / friction)).normalize();
                }
            }
        }
    }

    /// The speed at which a slip has come to rest: none where it goes straight on or has only begun (m/s).
    pub(super) fn rest_of(&self, closed: &Closed) -> f64 {
        if closed.moved && !closed.straight { self.still } else { 0.0 }
    }

    /// Whether a slip that turns is as slow as what is told from rest, along the direction in which the step began.
    pub(super) fn has_come_to_rest(&self, was: &Closed, slip: &Vector3<f64>) -> bool {
        let rest = self.rest_of(was);
        matches!(was.state, ContactState::Slip(held) if rest > 0.0 && slip.dot(&held) <= rest * (1.0 + LOCATED))
    }

    /// Lowers the sizes of differences over velocity coordinates to what slips that turn allow in the last place.
    pub(in crate::simulate) fn refine(&self, sizes: &mut [f64]) {
        for (closed, frame) in self.closed.iter().zip(&self.frames).filter(|(closed, _)| closed.turns()) {
            let most = OVER * closed.slip.norm().max(self.still);
            for (i, column) in frame.columns[1..].iter().flatten() {
                sizes[*i] = sizes[*i].min(most / column.abs());
            }
        }
    }

    /// At the end of a step: what slips goes on in the direction that it has then.
    pub(in crate::simulate) fn turn_along(&mut self, step: f64) {
        self.accepted += 1;
        let acceleration = self.model.gravity.norm();
        for at in 0..self.closed.len() {
            let friction = self.law(self.closed[at].key.couple).friction.slide;
            let (still, closed) = (self.still, &mut self.closed[at]);
            closed.moved |= closed.slip.norm() > MOVED * still;
            let (ContactState::Slip(direction), speed) = (&mut closed.state, closed.slip.norm()) else { continue };
            if *direction == Vector3::zeros() || closed.straight || speed == 0.0 {
                continue;
            }
            // What hardly moves turns by a part: its direction is what the forces of a step leave of it.
            let part = if speed > still { 1.0 } else { (0.1 * speed / (step * friction * acceleration)).min(1.0) };
            *direction = (*direction * (1.0 - part) + closed.slip * (part / speed)).normalize();
        }
    }
}
