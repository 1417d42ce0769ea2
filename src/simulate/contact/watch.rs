//! Numbers whose change of sign is an event of contact.

use super::{Closed, ContactState, Contacts, GAP, STRAIGHT};
use crate::contact::cone::Law;
use crate::contact::frame::Frame;
use crate::contact::geometry::feature::Meeting;
use crate::contact::pairs::{DEEPER, LOOSE};
use crate::dynamics::System;
use nalgebra::Vector3;

/// What is watched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::simulate) enum Aspect {
    /// Gap of a couple where it is not closed.
    Gap(usize),
    /// How far the forces of all closed contacts are within their cones, in parts of the largest.
    Reserve,
    /// How far closed contacts are inside of where they count.
    Inside,
    /// How far what keeps slips straight is below [`super::STRAIGHT`].
    Straight,
    /// What the spring of a closed contact bears, or would pull with (in parts of the largest force).
    Spring(usize),
    /// How deep a closed contact that bears nothing is (m).
    Depth(usize),
    /// Slip of a closed contact along the direction in which the step began, less what is told from rest if it turns.
    Slip(usize),
}

/// What sticks and slips all the same by more than so many times what is a slip does not stick.
const DRAGGED: f64 = 2.0;
/// A slip that begins is straight to so many times what one that moves is: where rolling ends it accelerates from nothing, and takes as long as its
/// direction to turn by hundreds of that to get a speed.
const BEGINS: f64 = 32.0;
/// A point that is fixed to a rim lands with a gap of this part of the size, less than what is none, while the disc tips over the rim's lowest
/// point: that would run around the rim as the tilt passes zero, within 10⁻¹³ s if a push across is as small as rounding.
const LANDS: f64 = 0.5 * GAP;
/// Forces beyond their cones by less than this part are round-off of what balances them.
pub(super) const BEYOND: f64 = 1e-8;

impl Contacts {
    /// What there is to watch in the regime, with contacts in their states.
    pub(in crate::simulate) fn aspects(&self) -> Vec<Aspect> {
        if self.follows_steps() {
            return Vec::new();
        }
        let mut aspects: Vec<Aspect> = (0..self.pairs.couples.len()).map(Aspect::Gap).collect();
        if !self.closed.is_empty() {
            aspects.extend([Aspect::Reserve, Aspect::Inside]);
        }
        let slips =
            |at: usize| matches!(self.closed[at].state, ContactState::Slip(direction) if direction != Vector3::zeros());
        aspects.extend(self.closed.iter().any(|closed| closed.straight).then_some(Aspect::Straight));
        aspects.extend((0..self.closed.len()).filter(|at| slips(*at)).map(Aspect::Slip));
        for at in (0..self.closed.len()).filter(|at| !self.is_rigid(self.closed[*at].key.couple)) {
            aspects.push(Aspect::Spring(at));
            aspects.extend((!self.closed[at].pushes).then_some(Aspect::Depth(at)));
        }
        aspects
    }

    /// What is rounding of an aspect. Forces may begin a little beyond their cones, where they have just reached them: twice as much is an event.
    pub(in crate::simulate) fn band(&self, aspect: Aspect) -> f64 {
        match aspect {
            Aspect::Gap(couple) => 1e-4 * GAP * self.pairs.couples[couple].size,
            Aspect::Reserve => BEYOND.max(-2.0 * self.reserve()),
            Aspect::Inside | Aspect::Straight => 0.0,
            Aspect::Spring(_) => 1e-12,
            Aspect::Depth(at) => 1e-4 * GAP * self.pairs.couples[self.closed[at].key.couple].size,
            Aspect::Slip(_) => 1e-3 * self.slow,
        }
    }

    /// An aspect and its rate where [`Contacts::correct`] was last, whose hinge accelerations were `a`; rate 0 if it is not known.
    pub(in crate::simulate) fn watched(&self, aspect: Aspect, system: &System) -> [f64; 2] {
        match aspect {
            Aspect::Gap(couple) => *self.gaps[couple].get_or_init(|| self.gap(couple, system)),
            Aspect::Reserve => [self.reserve(), 0.0],
            Aspect::Inside => [self.inside(), 0.0],
            Aspect::Straight => [STRAIGHT - self.bent(), 0.0],
            Aspect::Spring(at) => {
                let force = self.pressure(&self.frames[at]).unwrap_or(0.0) / self.scale;
                [if self.closed[at].pushes { force } else { -force }, 0.0]
            }
            Aspect::Depth(at) => [-self.closed[at].meeting.gap, -self.frames[at].speed.x],
            Aspect::Slip(at) => {
                let closed = &self.closed[at];
                let ContactState::Slip(held) = closed.state else { return [1.0, 0.0] };
                [closed.slip.dot(&held) - self.rest_of(closed), 0.0]
            }
        }
    }

    /// The largest force that keeps a slip straight, in parts of friction.
    pub(super) fn bent(&self) -> f64 {
        let each = self.closed.iter().filter(|closed| closed.straight).map(|closed| {
            let least = 1e-9 * self.scale;
            let across = closed.across.abs() / self.rubs(closed.key.couple).max(least);
            // What hardly slips has no direction of its own yet: the one that friction has may be off by more, as it is soon over.
            if closed.slip.norm() > self.slow { across } else { across / BEGINS }
        });
        each.fold(0.0, f64::max)
    }

    /// Friction of all that slips straight on of a couple (N).
    pub(super) fn rubs(&self, couple: usize) -> f64 {
        let own = self.closed.iter().filter(|closed| closed.straight && closed.key.couple == couple);
        own.map(|closed| self.law(couple).friction.slide * closed.meeting.normal.dot(&closed.force)).sum()
    }

    fn inside(&self) -> f64 {
        let each = self.closed.iter().map(|closed| {
            let size = self.pairs.couples[closed.key.couple].size;
            closed.meeting.inside.min(closed.meeting.flat) + LOOSE * size
        });
        each.fold(f64::INFINITY, f64::min)
    }

    /// The smallest gap of a couple among pairs that are not closed, and its rate.
    fn gap(&self, couple: usize, system: &System) -> [f64; 2] {
        let apart = self.pairs.apart(couple);
        let [a, b] = self.pairs.couples[couple].pieces;
        let links = [a, b].map(|piece| &system.links()[self.pairs.pieces[piece].link]);
        let speed =
            |i: usize, x: &Vector3<f64>| links[i].velocity + links[i].angular_velocity.cross(&(x - links[i].position));
        let balls = [a, b].iter().all(|piece| self.pairs.pieces[*piece].reach.is_finite());
        if apart > 0.0 && balls {
            let (from, to) = (self.pairs.middle(a), self.pairs.middle(b));
            let rate = (to - from).normalize().dot(&(speed(1, &to) - speed(0, &from)));
            return [apart, rate];
        }
        let size = self.pairs.couples[couple].size;
        let overlap = std::cell::OnceCell::new();
        let best = std::cell::Cell::new([f64::INFINITY, 0.0]);
        let normal = std::cell::Cell::new(Vector3::zeros());
        let is_closed = |meeting: &Meeting| {
            self.closed.iter().any(|closed| {
                closed.key.couple == couple
                    && closed.state != ContactState::Spare
                    && (closed.key.features == meeting.features
                        || (closed.meeting.point - meeting.point).norm() < 10.0 * LOOSE * size)
            })
        };
        // Features that are behind each other are none of shapes that are apart, nor those of the far side of others.
        let depth = || *overlap.get_or_init(|| self.pairs.depth(couple));
        let is_own = |gap: f64| gap > -GAP * size || depth() > 0.0 && gap >= -DEEPER * depth();
        let counts = |meeting: &Meeting| {
            let is_nearest = meeting.flat >= -GAP * size && meeting.gap < best.get()[0] + LANDS * size;
            is_nearest && !is_closed(meeting) && is_own(meeting.gap)
        };
        // A disc that comes down on its rim lands before its lowest point runs around the rim.
        let tips = self.closed.iter().any(|closed| closed.key.couple == couple && closed.meeting.tips());
        // Of what does not count it is all the same whether it passes by.
        let put = |meeting: Meeting| {
            if counts(&meeting) {
                let u = speed(1, &meeting.cores[1]) - speed(0, &meeting.cores[0]);
                let rate = meeting.normal.dot(&u);
                let lands = tips && meeting.flat.is_finite() && rate < -self.slow;
                let gap = if lands { meeting.gap - LANDS * size } else { meeting.gap };
                if gap < best.get()[0] {
                    best.set([gap, rate]);
                    normal.set(meeting.normal);
                }
            }
        };
        self.pairs.meetings(couple, [GAP * size, f64::INFINITY], |meeting| !counts(meeting), put);
        let [gap, rate] = best.get();
        // What is deep inside has other features nearest than those that it came in by: where none proves that shapes are apart they are asked.
        let touches = |closed: &Closed| closed.key.couple == couple && closed.state != ContactState::Spare;
        let unproven = gap > 0.0 && balls && !(gap.is_finite() && self.pairs.apart_along(couple, &normal.get()) > 0.0);
        if unproven && !self.closed.iter().any(touches) && depth() > GAP * size {
            return [-depth(), 0.0];
        }
        [gap, rate]
    }

    /// Of forces of least norm; of those that are best if these are none and rows are linearly dependent.
    pub(super) fn reserve(&self) -> f64 {
        *self.reserve.get_or_init(|| self.look())
    }

    fn look(&self) -> f64 {
        let dragged = self.dragged();
        if dragged > DRAGGED * self.kept {
            return -dragged / self.kept;
        }
        let bears = self.closed.iter().filter(|closed| closed.may_push());
        let least = bears.map(|closed| self.inward(closed, &closed.force)).fold(f64::INFINITY, f64::min) / self.scale;
        if least < 0.0 { self.best().map_or(least, |(best, _)| best.max(least)) } else { least }
    }

    /// How far a force is within the cone of a contact (N).
    pub(super) fn inward(&self, closed: &Closed, force: &Vector3<f64>) -> f64 {
        let n = closed.meeting.normal.dot(force);
        let across = (force - closed.meeting.normal * n).norm();
        let friction = self.law(closed.key.couple).friction.stick;
        if closed.state == ContactState::Stick { n.min(friction * n - across) } else { n }
    }

    /// The largest slip of what sticks and is moved along by what friction cannot hold up, as a drive: rows that depend on others are
    /// not kept by themselves (m/s).
    fn dragged(&self) -> f64 {
        let slips = |closed: &Closed| closed.state == ContactState::Stick && closed.slip.norm() > DRAGGED * self.kept;
        if !self.closed.iter().any(slips) {
            return 0.0;
        }
        let dropped = self.dropped();
        let own = self.closed.iter().enumerate().filter(|(at, closed)| slips(closed) && dropped.contains(at));
        own.map(|(_, closed)| closed.slip.norm()).fold(0.0, f64::max)
    }

    /// The laws of contacts as they move; friction at rest is `less` than it is by that part, and that of what gives way is not less at first.
    pub(super) fn laws(&self, frames: &[Frame], less: f64) -> Vec<Law> {
        let law = |frame: &Frame| {
            let friction = self.law(frame.key.couple).friction;
            let slip = frame.slip();
            if !self.is_rigid(frame.key.couple) {
                return Law::Bounded { bound: 0.0 };
            }
            match slip.norm() {
                speed if speed > self.slow => {
                    Law::Sliding { friction: friction.slide, direction: frame.flat(&(slip / speed)) }
                }
                _ => {
                    let stick = friction.stick * (1.0 - less);
                    Law::Coulomb {
                        stick,
                        // What has not reached its limit may hold.
                        slide: if less < 0.0 && self.gives(frame) { stick } else { stick.min(friction.slide) },
                    }
                }
            }
        };
        frames.iter().map(law).collect()
    }
}
