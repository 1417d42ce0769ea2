//! Constant loads: dead (fixed in inertial axes) and follower (fixed in the link's axes).
//!
//! ```text
//! dead      f = F, m = arm × F + M;            potential −F·x, the torque has none
//! follower  f = R F, m = R (point × F + M);    turns with the link as a whole, no potential
//! ```

use super::end::Anchor;
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
}

impl ForceDescription {
    /// A force (N) that keeps its direction in space.
    pub fn load(name: &str, on: impl Into<Attachment>, force: impl Into<Vector3<f64>>) -> Self {
        let kind = Load { on: on.into(), force: force.into(), torque: Vector3::zeros(), axes: LoadAxes::Inertial };
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
        if self.on.body == GROUND {
            report.add("on", format!("`{name}` loads the ground"), "a load acts on a body");
        }
    }

    fn compile(&self, carriers: &[Carrier]) -> LoadLaw {
        let Carrier { end, turn } = carriers[0];
        match self.axes {
            LoadAxes::Inertial => LoadLaw { on: end, force: self.force, torque: self.torque, follows: false },
            LoadAxes::Body => {
                LoadLaw { on: end, force: turn * self.force, torque: turn * self.torque, follows: true }
            }
        }
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
        Self { on, force, torque: Vector3::zeros(), follows: false }
    }

    #[inline]
    fn wrench(&self, links: &[LinkMotion]) -> Wrench {
        let Self { on, force, torque, follows } = self;
        if *follows {
            let turn = &links[on.link].turn;
            let wrench = Wrench::at_arm(turn * force, turn * on.point);
            return Wrench { force: wrench.force, moment: wrench.moment + turn * torque };
        }
        let wrench = Wrench::at_arm(*force, Anchor::of(on, links).arm);
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
            give(0, Wrench { force: Vector3::zeros(), moment: arm.cross(&self.force) });
        }
    }

    fn potential(&self, links: &[LinkMotion]) -> f64 {
        if self.follows { 0.0 } else { -self.force.dot(&Anchor::of(&self.on, links).position) }
    }

    fn input(&self, links: &[LinkMotion]) -> f64 {
        let link = &links[self.on.link];
        if !self.follows {
            return self.torque.dot(&link.angular_velocity);
        }
        let wrench = self.wrench(links);
        wrench.force.dot(&link.velocity) + wrench.moment.dot(&link.angular_velocity)
    }

    fn dead(&self) -> Option<(usize, Vector3<f64>)> {
        (!self.follows).then_some((self.on.link, self.force))
    }

    fn has_potential(&self) -> bool {
        !self.follows && self.torque == Vector3::zeros()
    }

    fn magnitude(&self, _links: &[LinkMotion]) -> Magnitude {
        let force = self.force.norm();
        Magnitude { force, noise: force, moment: self.torque.norm(), ..Magnitude::default() }
    }

    fn picture(&self) -> Picture<'_> {
        Picture::Arrows { on: &self.on, force: self.force, torque: self.torque, turns: self.follows }
    }
}
