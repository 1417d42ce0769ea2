//! Loads: dead (fixed in inertial axes) and follower (fixed in the link's axes), constant or in proportion to a table over time.
//!
//! ```text
//! dead      f = F, m = arm × F + M;            potential −F·x, the torque has none
//! follower  f = R F, m = R (point × F + M);    turns with the link as a whole, no potential
//! ```
//!
//! What changes with time has no potential either: all that it does is work.

use super::end::Anchor;
use super::timeline::Timeline;
use super::{Act, Attachment, Carrier, Describe, End, ForceDescription, GROUND, Magnitude, Picture, Report};
use crate::spatial::Wrench;
use crate::spatial::link::{LinkMotion, LinkVariation};
use nalgebra::Vector3;

/// A constant force and torque.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// Where it acts.
    pub on: Attachment,
    /// Force (N).
    pub force: Vector3<f64>,
    /// Torque (N m).
    pub torque: Vector3<f64>,
    /// Constant in which axes.
    pub axes: LoadAxes,
    /// What scales both over time; `None` for what is always the same.
    pub over_time: Option<OverTime>,
}

/// A factor by a table over time.
#[derive(Debug, Clone, PartialEq)]
pub struct OverTime {
    /// (s)
    pub timeline: Timeline,
    /// The factor at those times.
    pub values: Vec<f64>,
}

/// The axes in which a load is constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LoadAxes {
    /// Keeps its direction in space.
    #[default]
    Inertial,
    /// Turns with the body (a follower load: not conservative).
    Body,
}

/// A load, compiled; force and torque in the axes in which they are constant: inertial ones or the link's.
#[derive(Debug, Clone)]
pub struct LoadLaw {
    on: End,
    force: Vector3<f64>,
    torque: Vector3<f64>,
    follows: bool,
    over_time: Option<Box<OverTime>>,
    /// Now; 1 for what is always the same.
    factor: f64,
}

impl ForceDescription {
    /// A force (N) that keeps its direction in space.
    pub fn load(name: &str, on: impl Into<Attachment>, force: impl Into<Vector3<f64>>) -> Self {
        let (force, torque) = (force.into(), Vector3::zeros());
        let kind = Load { on: on.into(), force, torque, axes: LoadAxes::Inertial, over_time: None };
        Self { name: name.to_owned(), kind: kind.into() }
    }
}

impl Describe for Load {
    type Law = LoadLaw;

    fn attachments(&self) -> Vec<(String, &Attachment)> {
        vec![("on".to_owned(), &self.on)]
    }

    fn check(&self, report: &mut Report<'_>) {
        let name = report.name;
        for (key, vector) in [("force", &self.force), ("torque", &self.torque)] {
            if !vector.iter().all(|x| x.is_finite()) {
                let message = format!("`{key}` of `{name}` is [{}, {}, {}]", vector.x, vector.y, vector.z);
                report.add(key, message, "give finite N, N m");
            }
        }
        if let Some(OverTime { timeline, values }) = &self.over_time {
            if let Some(flaw) = timeline.flaw(values.len()) {
                let help = "times must not decrease, and each has a value; given twice, the value jumps there";
                report.add("over_time", format!("`over_time` of `{name}` {flaw}"), help);
            } else if let Some(bad) = values.iter().find(|x| !x.is_finite()) {
                report.add("over_time", format!("`over_time` of `{name}` has the value {bad}"), "give finite numbers");
            }
        }
        if self.on.body == GROUND {
            report.add("on", format!("`{name}` loads the ground"), "a load acts on a body");
        }
    }

    fn compile(&self, carriers: &[Carrier]) -> LoadLaw {
        let Carrier { end, turn } = carriers[0];
        let follows = self.axes == LoadAxes::Body;
        let own = |x: Vector3<f64>| if follows { turn * x } else { x };
        let over_time = self.over_time.clone().map(Box::new);
        let mut law =
            LoadLaw { on: end, force: own(self.force), torque: own(self.torque), follows, over_time, factor: 1.0 };
        law.set_time(0.0);
        law
    }

    fn numbers(&self, key: &str) -> Vec<(f64, &'static str)> {
        match key {
            "force" => self.force.iter().map(|x| (*x, "N")).collect(),
            "torque" => self.torque.iter().map(|x| (*x, "N m")).collect(),
            _ => Vec::new(),
        }
    }

    fn set(&mut self, key: &str, index: usize, value: f64) {
        match key {
            "force" => self.force[index] = value,
            _ => self.torque[index] = value,
        }
    }
}

impl LoadLaw {
    /// A force (N) at a point that keeps its direction in space.
    pub fn dead(on: End, force: Vector3<f64>) -> Self {
        Self { on, force, torque: Vector3::zeros(), follows: false, over_time: None, factor: 1.0 }
    }

    /// What it is now, with a force (N) and a torque (N m) more, in the axes in which it is constant.
    pub fn with(&self, [force, torque]: [Vector3<f64>; 2]) -> Self {
        let (force, torque) = (self.factor * self.force + force, self.factor * self.torque + torque);
        Self { on: self.on, force, torque, follows: self.follows, over_time: None, factor: 1.0 }
    }

    /// Where it acts, force (N) and torque (N m), and whether they turn with the link; `None` if they change over time.
    pub(super) fn numbers(&self) -> Option<(End, [Vector3<f64>; 2], bool)> {
        self.over_time.is_none().then_some((self.on, [self.force, self.torque], self.follows))
    }

    #[inline]
    fn wrench(&self, links: &[LinkMotion]) -> Wrench {
        let Self { on, follows, factor, .. } = self;
        let (force, torque) = (*factor * self.force, *factor * self.torque);
        if *follows {
            let turn = &links[on.link].turn;
            let wrench = Wrench::at_arm(turn * force, turn * on.point);
            return Wrench { force: wrench.force, moment: wrench.moment + turn * torque };
        }
        let wrench = Wrench::at_arm(force, Anchor::of(on, links).arm);
        Wrench { force: wrench.force, moment: wrench.moment + torque }
    }
}

impl Act for LoadLaw {
    fn ends(&self) -> &[End] {
        std::slice::from_ref(&self.on)
    }

    #[inline]
    fn wrenches(&self, links: &[LinkMotion], give: &mut impl FnMut(usize, Wrench)) {
        give(0, self.wrench(links));
    }

    fn vary(&self, links: &[LinkMotion], by: &[LinkVariation], give: &mut impl FnMut(usize, Wrench)) {
        let turn = by[self.on.link].turn;
        if self.follows {
            let wrench = self.wrench(links);
            give(0, Wrench { force: turn.cross(&wrench.force), moment: turn.cross(&wrench.moment) });
        } else {
            let arm = turn.cross(&Anchor::of(&self.on, links).arm);
            give(0, Wrench { force: Vector3::zeros(), moment: arm.cross(&(self.factor * self.force)) });
        }
    }

    fn potential(&self, links: &[LinkMotion]) -> f64 {
        if self.follows || self.over_time.is_some() { 0.0 } else { -self.force.dot(&Anchor::of(&self.on, links).position) }
    }

    fn input(&self, links: &[LinkMotion]) -> f64 {
        let link = &links[self.on.link];
        if !self.follows && self.over_time.is_none() {
            return self.torque.dot(&link.angular_velocity);
        }
        let wrench = self.wrench(links);
        wrench.force.dot(&link.velocity) + wrench.moment.dot(&link.angular_velocity)
    }

    fn dead(&self) -> Option<(usize, Vector3<f64>)> {
        let force = self.factor * self.force;
        (!self.follows || force == Vector3::zeros()).then_some((self.on.link, force))
    }

    fn has_potential(&self) -> bool {
        !self.follows && self.torque == Vector3::zeros() && self.over_time.is_none()
    }

    fn potential_at_rest(&self, links: &[LinkMotion]) -> f64 {
        match self.follows || self.over_time.is_none() {
            true => 0.0,
            false => -self.factor * self.force.dot(&Anchor::of(&self.on, links).position),
        }
    }

    fn has_potential_at_rest(&self) -> bool {
        !self.follows && self.torque == Vector3::zeros()
    }

    fn magnitude(&self, _links: &[LinkMotion]) -> Magnitude {
        let (force, moment) = (self.factor.abs() * self.force.norm(), self.factor.abs() * self.torque.norm());
        Magnitude { force, noise: force, moment, noise_moment: moment, ..Magnitude::default() }
    }

    fn steady_until(&self) -> f64 {
        let Some(OverTime { timeline, values }) = self.over_time.as_deref() else { return f64::INFINITY };
        let first = timeline.at(0.0).mix(values);
        let other = (0..values.len()).find(|row| timeline.times[*row] > 0.0 && values[*row] != first);
        other.map_or(f64::INFINITY, |row| timeline.times[row.saturating_sub(1)].max(0.0))
    }

    fn times(&self) -> &[f64] {
        self.over_time.as_ref().map_or(&[], |over_time| &over_time.timeline.times)
    }

    fn set_time(&mut self, time: f64) {
        if let Some(OverTime { timeline, values }) = self.over_time.as_deref() {
            self.factor = timeline.at(time).mix(values);
        }
    }

    fn picture(&self) -> Picture<'_> {
        Picture::Arrows {
            on: &self.on,
            force: self.force,
            torque: self.torque,
            turns: self.follows,
            over_time: self.over_time.as_deref(),
        }
    }
}
