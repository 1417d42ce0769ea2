//! A model as it was read: bodies with their joints, before hinges are made of them.

use super::super::log::{Place, Taken};
use super::super::xml::{Attribute, Element};
use super::model::{Instance, Model};
use super::settings::Settings;
use super::touch::{Pair, Touch};
use crate::model::description::MassProperties;
use nalgebra::{Isometry3, Vector3};
use std::collections::HashMap;

/// The world's place in the list of bodies.
pub(super) const WORLD: usize = 0;

/// Everything that moves, and what is fixed to it.
pub(super) struct Scene<'a> {
    pub(super) settings: Settings,
    /// The world first, then depth first as in the file.
    pub(super) bodies: Vec<Body<'a>>,
    /// In the order of the file.
    pub(super) joints: Vec<Joint<'a>>,
    pub(super) sites: Vec<Site>,
    /// Body and place in the list of its shapes, if it is there; empty without contacts.
    pub(super) geoms: Vec<(usize, Option<usize>)>,
    /// Bodies that do not touch each other.
    pub(super) excluded: Vec<[usize; 2]>,
    /// Geoms that touch each other.
    pub(super) pairs: Vec<Pair>,
    pub(super) names: Names,
    /// What stands before names of the elements that are being read; empty in the main model.
    pub(super) prefix: String,
    /// Attached models, in the order in which MuJoCo puts their actuators: inner ones first, the main one last.
    pub(super) instances: Vec<Instance>,
}

/// Places in the lists by name.
#[derive(Default)]
pub(super) struct Names {
    pub(super) bodies: HashMap<String, usize>,
    pub(super) joints: HashMap<String, usize>,
    pub(super) sites: HashMap<String, usize>,
    pub(super) geoms: HashMap<String, usize>,
    /// Names of elements that `<replicate>` has copied.
    pub(super) copied: Vec<String>,
    /// Names of joints that are fixed because they carry nothing with mass.
    pub(super) welded: Vec<String>,
}

pub(super) struct Body<'a> {
    pub(super) element: Element<'a>,
    pub(super) name: String,
    pub(super) parent: usize,
    /// In the parent, with all joints at their references.
    pub(super) pose: Isometry3<f64>,
    pub(super) joints: Vec<usize>,
    pub(super) mass: MassProperties,
    /// Its principal axes in its centre of mass as MuJoCo has them, body axes.
    pub(super) principal: Isometry3<f64>,
    pub(super) shapes: Vec<Drawn>,
    /// The part of its weight that is held up.
    pub(super) gravity_compensation: f64,
}

/// A solid that is drawn, or touches.
pub(super) struct Drawn {
    /// `box` and its numbers, or `mesh` and its file.
    pub(super) solid: Solid,
    pub(super) pose: Isometry3<f64>,
    pub(super) color: Option<[f64; 4]>,
    /// Whether it is drawn.
    pub(super) visible: bool,
    /// How it touches, if it can.
    pub(super) touch: Option<Touch>,
    pub(super) place: Place,
}

pub(super) enum Solid {
    /// Key and numbers as a scenario writes them.
    Numbers(&'static str, Vec<f64>),
    /// File and scale.
    Mesh(String, [f64; 3]),
}

/// A point with axes.
pub(super) struct Site {
    pub(super) name: Option<String>,
    pub(super) body: usize,
    pub(super) pose: Isometry3<f64>,
    pub(super) place: Place,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Hinge,
    Slide,
    Ball,
    Free,
}

impl Kind {
    /// Number of coordinates and of velocities.
    pub(super) fn counts(self) -> (usize, usize) {
        match self {
            Self::Hinge | Self::Slide => (1, 1),
            Self::Ball => (4, 3),
            Self::Free => (7, 6),
        }
    }

    pub(super) fn is_scalar(self) -> bool {
        matches!(self, Self::Hinge | Self::Slide)
    }
}

pub(super) struct Joint<'a> {
    pub(super) element: Element<'a>,
    /// As written; of unnamed ones `joint_1`, by its place in the body, from 0.
    pub(super) name: String,
    pub(super) body: usize,
    pub(super) kind: Kind,
    /// A free joint of which MuJoCo counts coordinates from the principal axes of a body that carries no others.
    pub(super) aligned: bool,
    /// Body axes, from the body's origin.
    pub(super) anchor: Vector3<f64>,
    pub(super) axis: Vector3<f64>,
    /// What `qpos` says where the displacement is zero.
    pub(super) reference: f64,
    /// The displacement at which the joint's own spring is relaxed.
    pub(super) relaxed: f64,
    /// Displacements.
    pub(super) range: Option<[f64; 2]>,
    /// What all actuators together may do in it.
    pub(super) motor_range: Option<[f64; 2]>,
    /// The actuators that this bounds.
    pub(super) parts: Vec<Part<'a>>,
    /// Time constant and damping ratio from which stiffness and damping follow.
    pub(super) spring_damper: Option<[f64; 2]>,
    pub(super) acting: Acting,
    /// Coordinates at the start as a hinge has them: displacements, quaternions.
    pub(super) start: Vec<f64>,
    pub(super) velocity: Vec<f64>,
}

/// An actuator in a joint: `force = gear · acts(gear · qpos)`.
pub(super) struct Part<'a> {
    pub(super) element: Element<'a>,
    pub(super) gear: f64,
    pub(super) acts: Acts,
    /// Of its force, before the gear.
    pub(super) bounds: Option<[f64; 2]>,
}

/// What an actuator does at a given input: `constant + slope · length + rate · d(length)/dt`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Acts {
    pub(super) constant: f64,
    pub(super) slope: f64,
    pub(super) rate: f64,
}

impl Acts {
    /// Whether it answers to where the joint is and how it moves.
    pub(super) fn is_servo(&self) -> bool {
        self.slope != 0.0 || self.rate != 0.0
    }
}

/// What acts in a joint: `−stiffness · displacement + pull − damping · rate + force`, and dry friction.
#[derive(Debug, Clone, Default)]
pub(super) struct Acting {
    pub(super) stiffness: f64,
    /// The sum of stiffnesses times relaxed displacements.
    pub(super) pull: f64,
    pub(super) damping: f64,
    pub(super) armature: f64,
    /// At rest and in motion.
    pub(super) friction: f64,
    /// Per velocity.
    pub(super) force: Vec<f64>,
}

impl Acting {
    /// Adds a spring that is relaxed at this displacement.
    pub(super) fn spring(&mut self, stiffness: f64, relaxed: f64) {
        self.stiffness += stiffness;
        self.pull += stiffness * relaxed;
    }
}

impl<'a> Scene<'a> {
    /// Reads on in an instance of a model: with its prefix and its settings.
    pub(super) fn enter(&mut self, instance: &Instance, models: &[Model<'a>]) {
        self.prefix.clone_from(&instance.prefix);
        self.settings = models[instance.model].settings.clone();
    }
    /// A name as the whole model has it.
    pub(super) fn full(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    /// Poses of all bodies in the world for displacements of scalar joints; balls and free bodies at their references.
    pub(super) fn poses(&self, displacement: impl Fn(&Joint<'_>) -> f64) -> Vec<Isometry3<f64>> {
        let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(self.bodies.len());
        for (index, body) in self.bodies.iter().enumerate() {
            let mut pose = if index == WORLD { Isometry3::identity() } else { poses[body.parent] * body.pose };
            for &joint in &body.joints {
                let joint = &self.joints[joint];
                match joint.kind {
                    Kind::Slide => pose *= nalgebra::Translation3::from(joint.axis * displacement(joint)),
                    Kind::Hinge => {
                        let turn = nalgebra::UnitQuaternion::from_scaled_axis(joint.axis * displacement(joint));
                        let anchor = nalgebra::Translation3::from(joint.anchor);
                        pose = pose * anchor * turn * anchor.inverse();
                    }
                    Kind::Ball | Kind::Free => {}
                }
            }
            poses.push(pose);
        }
        poses
    }

    /// All joints in the order in which `qpos` and `qvel` hold them: body by body.
    pub(super) fn in_order(&self) -> Vec<usize> {
        self.bodies.iter().flat_map(|body| body.joints.iter().copied()).collect()
    }

    /// Where the root marker of a body stands in the body's own frame: at the anchor of its last joint.
    pub(super) fn origin(&self, body: usize) -> Vector3<f64> {
        self.anchors(body).last().copied().unwrap_or_else(Vector3::zeros)
    }

    /// The points of a body at which its hinges sit, one per joint. A slide stays at the point before it.
    pub(super) fn anchors(&self, body: usize) -> Vec<Vector3<f64>> {
        let mut at = Vector3::zeros();
        let joints = self.bodies[body].joints.iter().map(|joint| &self.joints[*joint]);
        joints
            .map(|joint| {
                if matches!(joint.kind, Kind::Hinge | Kind::Ball) {
                    at = joint.anchor;
                }
                at
            })
            .collect()
    }
}

/// Something by name; otherwise that has been said.
pub(super) fn find(
    attribute: &Attribute<'_>,
    what: &str,
    names: &HashMap<String, usize>,
    scene: &Scene<'_>,
) -> Option<usize> {
    let name = scene.full(attribute.value);
    // There is one world, whatever is attached to it.
    let world = (what == "body" && attribute.value == "world").then_some(WORLD);
    let found = world.or_else(|| names.get(&name).copied());
    if found.is_none() && scene.names.copied.contains(&name) {
        let what = format!("`{}` is within a <replicate>: what refers to it is not copied", attribute.value);
        attribute.element.note(Taken::Ignored, what);
    } else if found.is_none() && what == "joint" && scene.names.welded.contains(&name) {
        let what =
            format!("the joint `{}` is fixed, for it carries nothing with mass: this is left out", attribute.value);
        attribute.element.note(Taken::Ignored, what);
    } else if found.is_none() && !scene.prefix.is_empty() {
        let what = format!("the {what} `{}` of its model is not attached: nor is what refers to it", attribute.value);
        attribute.element.note(Taken::Ignored, what);
    } else if found.is_none() {
        let near = attribute.element.log.near(attribute.value, names.keys().map(String::as_str));
        let near = near.map(|near| format!("did you mean `{near}`?"));
        let problem = attribute.wrong(&format!("is \"{}\": there is no such {what}", attribute.value));
        attribute.element.refuse(problem.maybe_help(near));
    }
    found
}
