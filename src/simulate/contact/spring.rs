//! Compliant contact: a spring and a damper along the normal of every closed contact, which never pull.
//!
//! ```text
//! (1)  λ_n = max(0, k δ − d u_n),   δ = −gap;   open from gap > 0 on
//! ```
//!
//! Across it there is no friction: points that stick to a surface which gives way along its normal alone would hold a body that rocks on
//! two of them, whose distance along the surface changes.
//!
//! Nothing is struck: forces begin where shapes meet. Where (1) would pull, the contact is closed and bears nothing ([`Closed::pushes`]); what
//! its spring holds there is lost.

use super::{Closed, Contacts};
use crate::contact::frame::Frame;
use crate::contact::geometry::feature::Meeting;
use crate::contact::pairs::{DEEPER, Key};
use crate::dynamics::{Factorized, System};
use crate::model::StopLaw;
use nalgebra::Vector3;

/// A force below this part of the largest is none: then it is the motion that says whether a contact bears.
const NO_FORCE: f64 = 1e-10;

impl Contacts {
    /// Stiffness (N/m) and damping (N s/m) of a couple; `None` if it is rigid.
    pub(super) fn spring(&self, couple: usize) -> Option<[f64; 2]> {
        match self.law(couple).law {
            StopLaw::Compliant { stiffness, damping } => Some([stiffness, damping]),
            StopLaw::Rigid { .. } => None,
        }
    }

    pub(super) fn is_rigid(&self, couple: usize) -> bool {
        self.spring(couple).is_none()
    }

    /// Whether any contact is compliant.
    pub(in crate::simulate) fn is_compliant(&self) -> bool {
        self.model.contacts.iter().any(|rule| matches!(rule.law, StopLaw::Compliant { .. }))
    }

    /// (1) without its bound (N); `None` if the couple is rigid.
    pub(super) fn pressure(&self, frame: &Frame) -> Option<f64> {
        let [k, d] = self.spring(frame.key.couple)?;
        Some(-k * frame.meeting.gap - d * frame.speed.x)
    }

    /// Whether a compliant contact bears from a time (s) on. Where its force is rounding, one that was closed before begins or ends
    /// to push: it is the event of that; of one that closes now the motion says it.
    pub(super) fn bears(&self, frame: &Frame, time: f64) -> bool {
        let was = || self.closed.iter().find(|was| was.key == frame.key);
        self.pressure(frame).is_none_or(|force| match force.abs() <= NO_FORCE * self.scale {
            true => was().map_or(frame.speed.x < 0.0, |was| was.pushes == (was.since == time)),
            false => force > 0.0,
        })
    }

    /// Whether shapes overlap at a contact by more than rounding.
    pub(super) fn is_deep(&self, frame: &Frame) -> bool {
        frame.meeting.gap < -1e-4 * super::GAP * self.pairs.couples[frame.key.couple].size
    }

    /// What the spring of a closed contact presses with (N); zero if it is rigid.
    pub(super) fn sprung(&self, closed: &Closed, frame: &Frame) -> f64 {
        self.pressure(frame).filter(|force| closed.pushes && *force > 0.0).unwrap_or(0.0)
    }

    /// Adds what springs of closed contacts do to accelerations, and keeps their forces.
    pub(super) fn press_springs(&mut self, mass: &mut Factorized<'_>, a: &mut [f64]) {
        if !self.closed.iter().any(|closed| !self.is_rigid(closed.key.couple)) {
            return;
        }
        let mut push = vec![0.0; a.len()];
        for at in 0..self.closed.len() {
            let force = Vector3::x() * self.sprung(&self.closed[at], &self.frames[at]);
            self.frames[at].push(&force, &mut push);
            self.closed[at].force += self.frames[at].basis * force;
        }
        let mut change = vec![0.0; a.len()];
        mass.answer_impulse(&push, &mut change);
        a.iter_mut().zip(&change).for_each(|(a, change)| *a += change);
    }

    /// Energy in springs at the place of a system (J).
    pub(in crate::simulate) fn potential(&mut self, system: &System) -> f64 {
        if !self.is_compliant() {
            return 0.0;
        }
        self.pairs.place_at(system.links());
        self.closed.iter().filter(|closed| closed.pushes).map(|closed| self.stored(&closed.key)).sum()
    }

    /// Energy in the spring of a contact where shapes are placed (J).
    fn stored(&self, key: &Key) -> f64 {
        let gap = self.pairs.meeting(key).map_or(0.0, |meeting| meeting.gap.min(0.0));
        self.spring(key.couple).map_or(0.0, |[k, _]| 0.5 * k * gap * gap)
    }

    /// What springs of contacts hold that bear no more, less what those hold that bear again (J), from which ones bore before.
    pub(super) fn released(&mut self, before: &[(Key, bool)], system: &System) -> f64 {
        if !self.is_compliant() {
            return 0.0;
        }
        self.pairs.place_at(system.links());
        let changed = |closed: &Closed| {
            let (_, pushed) = before.iter().find(|(key, _)| *key == closed.key)?;
            let sign = f64::from(i8::from(*pushed) - i8::from(closed.pushes));
            Some(sign * self.stored(&closed.key))
        };
        self.closed.iter().filter_map(changed).sum()
    }

    /// Power that dampers of closed contacts take out at the last place (W).
    pub(super) fn damped(&self) -> f64 {
        let each = self.closed.iter().zip(&self.frames).filter(|(closed, _)| closed.pushes);
        each.filter_map(|(_, frame)| self.spring(frame.key.couple).map(|[_, d]| d * frame.speed.x.powi(2))).sum()
    }

    /// Whether features of a compliant couple touch: no deeper than the shapes themselves, unless that is little.
    pub(super) fn touches_springs(&self, meeting: &Meeting, depth: impl Fn() -> f64, size: f64) -> bool {
        meeting.gap > -super::MISSED * size || meeting.gap >= -DEEPER * depth()
    }
}
