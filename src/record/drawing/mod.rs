//! What is drawn of a scene: a list of parts, each with triangles that never change and a place at every instant.
//!
//! Pictures, films, glTF files and reports are made of this one list, so that they show the same. The Rerun viewer has solids and lines of
//! its own; it shares the solids (`solids.rs`) of bodies, the room that they take and the radii of coils.
//!
//! - Bodies are their shapes. A body without any is drawn as rods to its points, or as the box of its inertia, on a rod if that is off its
//!   hinge; if other bodies have shapes, a body without shape, points and inertia is not drawn.
//! - Beams are their sections along the centre line, coloured by what they bear ([`Drawing::shaded`]).
//! - Springs are coils, dampers cylinders with a piston rod, ropes and rods thin cylinders between their points, curves that bodies are
//!   guided along are wires.
//! - Bushings are blocks of rubber between two plates, which move with the frames: they are sheared, squeezed and twisted as they are.
//! - What is hinged to the ground gets a pin along the axis of its hinge, or a small cube, and so do lines that end on the ground.
//! - Loads, hinge axes, reactions and forces of contacts are arrows, if they are asked for; those of bodies that frames do not hold make no
//!   frame larger.

mod anchor;
pub(super) mod bounds;
pub(super) mod ground;
pub(super) mod lines;
pub(super) mod mount;
mod parts;
mod place;
pub(super) mod shades;
mod shape;
pub(super) mod sweep;
mod triangles;

pub use place::{Part, Placement};
pub use shades::{Legend, shade};
pub use triangles::Triangles;

use super::contact::ContactPush;
use super::scene::{LoadPicture, Scene};
use super::solids::{Form, Solid, drop_of_beams, solids};
use super::tubes::Tubes;
use crate::spatial::{Pose, Wrench};
use anchor::Anchor as End;
use bounds::{Bounds, Outline};
use nalgebra::Point3;

/// What is drawn beside bodies and lines, and what is framed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Extras {
    /// Axes of the hinges as arrows.
    pub hinges: bool,
    /// Frames hold the bodies for which this is true, by their indices, and what is between them; others may leave the picture.
    /// Empty: all.
    pub framed: Vec<bool>,
}

/// When loads are drawn that change over time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoadTime {
    /// As they are then (s).
    At(f64),
    /// As they are at each of the times that they are given at, all beside each other: a frame that holds these holds them at all times.
    All,
}

impl LoadTime {
    fn factors(self, load: &LoadPicture) -> Vec<f64> {
        match (self, &load.over_time) {
            (Self::At(time), _) => vec![load.factor(time)],
            (Self::All, Some(over_time)) => over_time.values.clone(),
            (Self::All, None) => vec![1.0],
        }
    }
}

/// Whether there is a ground to draw: none where nothing falls and no body is a plane.
pub(super) fn has_ground(scene: &Scene) -> bool {
    let planes = scene.bodies.iter().flat_map(|body| &body.shapes).any(|shape| shape.kind == "plane");
    planes || scene.extent.is_none_or(|extent| extent.weight > 0.0)
}

/// Everything that is drawn of a scene.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// In the order of the scene: bodies, lines, the ground's marks, then what was asked for.
    pub parts: Vec<Part>,
    /// What cannot be drawn, in words.
    pub notes: Vec<String>,
    /// What the colours of beams mean, if they have colours.
    pub legend: Option<Legend>,
    outlines: Vec<Outline>,
    /// See [`Extras::framed`].
    framed: Vec<bool>,
    scene: Scene,
    /// Extent of the scene (m).
    size: f64,
}

impl Drawing {
    /// Of a scene; `start` has the poses of its bodies at some instant, by which the sizes of marks are chosen. Beams are drawn where
    /// poses are given with those of their cross sections ([`Tubes::extend`]).
    pub fn new(scene: &Scene, start: &[Pose], extras: Extras) -> Self {
        let mut solids = solids(scene);
        drop_stand_ins(scene, &mut solids);
        let outlines: Vec<Outline> = solids.iter().map(|solids| Outline::new(solids)).collect();
        drop_of_beams(scene, &mut solids);
        let mut drawing = Self {
            parts: Vec::new(),
            notes: Vec::new(),
            legend: None,
            outlines,
            framed: extras.framed,
            scene: scene.clone(),
            size: 1.0,
        };
        drawing.measure(start);
        drawing.add_bodies(&solids);
        // Meshes are known now.
        drawing.measure(start);
        drawing.add_lines();
        drawing.add_mounts();
        drawing.add_curves();
        drawing.add_beams();
        drawing.add_ground();
        let mut parts = std::mem::take(&mut drawing.parts);
        for part in &mut parts {
            let is_left_out = part.bodies().any(|body| !drawing.frames(Some(body)));
            part.unbounded |= is_left_out;
        }
        let mut drawing = Self { parts, ..drawing };
        if extras.hinges {
            drawing.add_hinges();
        }
        drawing
    }

    /// Adds loads as arrows.
    pub fn with_loads(mut self, at: LoadTime) -> Self {
        self.add_loads(at);
        self
    }

    /// Adds what the hinges pass to the bodies at one instant, as arrows that stay where they are.
    pub fn with_reactions(mut self, poses: &[Pose], reactions: &[Wrench]) -> Self {
        self.add_reactions(poses, reactions);
        self
    }

    /// Adds what contacts push with at one instant, as arrows that stay where they are.
    pub fn with_contacts(mut self, contacts: &[ContactPush]) -> Self {
        self.add_contacts(contacts);
        self
    }

    pub(super) fn body_name(&self, body: usize) -> &str {
        self.scene.bodies.get(body).map_or("", |body| body.name.as_str())
    }

    pub(super) fn bounds<'p>(&self, poses: impl IntoIterator<Item = &'p [Pose]>) -> Bounds {
        let mut bounds = Bounds::default();
        for poses in poses {
            if self.framed.is_empty() {
                bounds.include_bodies(&self.outlines, poses);
            }
            let framed = self.outlines.iter().zip(poses).zip(&self.framed).filter(|(_, framed)| **framed);
            framed.for_each(|((outline, pose), _)| bounds.include_body(outline, pose));
            let within = |ends: &&[End]| ends.iter().all(|(body, _)| self.frames(*body));
            let lines = self.scene.lines.iter().map(|line| line.ends.as_slice());
            let bushings = self.scene.bushings.iter().map(|bushing| bushing.ends.as_slice());
            lines.chain(bushings).filter(within).for_each(|ends| bounds.include_ends(ends, poses));
            let curves = self.scene.curves.iter().filter(|curve| self.frames(curve.body));
            curves.for_each(|curve| bounds.include_curve(curve, poses));
        }
        // If nothing has a size, the places of hinges have.
        if bounds.is_empty() || !(bounds.size().max() > 0.0) {
            self.scene.bodies.iter().for_each(|body| bounds.include(&body.hinge_at.into(), 0.5));
        }
        bounds
    }

    /// Whether there is a ground to draw.
    pub(super) fn has_ground(&self) -> bool {
        has_ground(&self.scene)
    }

    /// Whether frames hold a body; they hold the ground.
    fn frames(&self, body: Option<usize>) -> bool {
        body.and_then(|body| self.framed.get(body)).copied().unwrap_or(true)
    }

    fn measure(&mut self, start: &[Pose]) {
        self.size = self.bounds([start]).size().norm().max(f64::MIN_POSITIVE);
    }

    /// Replaces the outline of a mesh, which is known once it is read.
    fn outline(&mut self, body: usize, triangles: &Triangles, pose: &Pose) {
        let corners = triangles.positions.iter().map(|at| pose * Point3::from(at.map(f64::from)));
        self.outlines[body].include(corners);
    }
}

/// Balls that stand for bodies of which nothing is known, beside bodies with shapes of their own.
fn drop_stand_ins(scene: &Scene, solids: &mut [Vec<Solid>]) {
    if scene.bodies.iter().all(|body| body.shapes.is_empty()) {
        return;
    }
    for (body, solids) in scene.bodies.iter().zip(solids) {
        let is_ball = |solid: &Solid| matches!(solid.form, Form::Ball(_));
        if body.shapes.is_empty() && solids.iter().all(is_ball) {
            solids.clear();
        }
    }
}
