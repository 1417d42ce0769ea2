//! The parts of a drawing, from its scene.

use super::anchor::{Anchor, toward};
use super::lines::{coil_radii, free_length};
use super::mount::mounts;
use super::place::{Part, Place};
use super::sweep::Sweep;
use super::{Drawing, LoadTime, Triangles, Tubes};
use crate::record::contact::{ContactPush, still};
use crate::record::scene::{BodyPicture, LinePicture};
use crate::record::solids::{Form, Solid};
use crate::spatial::{Pose, Wrench};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use std::collections::HashMap;
use std::sync::Arc;

const SPRING: [f64; 4] = [0.36, 0.40, 0.44, 1.0];
const ROPE: [f64; 4] = [0.48, 0.38, 0.24, 1.0];
const ROD: [f64; 4] = [0.45, 0.47, 0.50, 1.0];
const CURVE: [f64; 4] = [0.52, 0.54, 0.58, 1.0];
const BEAM: [f64; 4] = [0.62, 0.67, 0.72, 1.0];
const GROUND: [f64; 4] = [0.30, 0.31, 0.33, 1.0];
const FORCE: [f64; 4] = [0.78, 0.24, 0.16, 1.0];
const TORQUE: [f64; 4] = [0.51, 0.27, 0.67, 1.0];
const REACTION: [f64; 4] = [0.16, 0.43, 0.24, 1.0];
const STICK: [f64; 4] = [0.18, 0.62, 0.27, 1.0];
const SLIP: [f64; 4] = [0.93, 0.49, 0.10, 1.0];
const HINGE: [f64; 4] = [0.84, 0.63, 0.19, 1.0];

/// Radii of ropes and curves, and of rods, against the scene.
const ROPE_RADIUS: f64 = 0.0025;
const ROD_RADIUS: f64 = 0.005;
/// Round forms of a larger radius against the scene have all their sides.
const FINE: f64 = 0.01;
/// The ground's pins and cubes against the scene.
const MARK: f64 = 0.014;
/// The longest arrow against the scene, and the shortest against the longest.
const ARROW: f64 = 0.2;
const SHORTEST: f64 = 0.2;
/// The length of a hinge's axis against the scene.
const AXIS: f64 = 0.12;

/// What a part is, before it is known whether frames hold it.
struct Sketch<'a> {
    name: &'a str,
    triangles: Arc<Triangles>,
    color: [f64; 4],
    place: Place,
}

impl Sketch<'_> {
    fn part(self, unbounded: bool, is_arrow: bool) -> Part {
        let Self { name, triangles, color, place } = self;
        Part { name: name.to_owned(), triangles, color, unbounded, is_arrow, place }
    }
}

impl Drawing {
    pub(super) fn add_bodies(&mut self, solids: &[Vec<Solid>]) {
        let mut known: HashMap<String, Arc<Triangles>> = HashMap::new();
        for (body, solids) in solids.iter().enumerate() {
            for solid in solids {
                let name = self.scene.bodies[body].name.clone();
                let key = key(&solid.form);
                let triangles = match known.get(&key) {
                    Some(triangles) => Ok(triangles.clone()),
                    None => Triangles::of(&solid.form, FINE * self.size).map(Arc::new),
                };
                match triangles {
                    Ok(triangles) => {
                        if let Form::Mesh { .. } = solid.form {
                            self.outline(body, &triangles, &solid.pose);
                        }
                        known.insert(key, triangles.clone());
                        let place = Place::Body { body: Some(body), pose: solid.pose, scale: [1.0; 3] };
                        let sketch = Sketch { name: &name, triangles, color: solid.color, place };
                        self.parts.push(sketch.part(solid.unbounded, false));
                    }
                    Err(error) => self.notes.push(format!("{name}: {error}; it is not drawn")),
                }
            }
        }
    }

    /// Springs as coils, dampers as cylinders with a rod, ropes and rods as thin cylinders from point to point.
    pub(super) fn add_lines(&mut self) {
        let coils = coil_radii(&self.scene, self.size);
        let (rod, damper) = (Arc::new(Triangles::rod()), Arc::new(Triangles::damper()));
        for (line, coil) in self.scene.lines.iter().zip(coils) {
            let (color, thin) = match line {
                LinePicture { pulls_only: true, .. } => (ROPE, ROPE_RADIUS),
                line if line.is_damper || free_length(line).is_some() => (SPRING, ROPE_RADIUS),
                _ => (ROD, ROD_RADIUS),
            };
            let (triangles, radius) = match (coil, free_length(line)) {
                (Some(radius), Some(length)) => {
                    let slenderness = (length / radius).clamp(4.0, 40.0);
                    (Arc::new(Triangles::coil(slenderness)), radius)
                }
                (Some(radius), None) => (damper.clone(), radius),
                _ => (rod.clone(), thin * self.size),
            };
            for pair in line.ends.windows(2) {
                let place = Place::Span { ends: [pair[0], pair[1]], radius };
                let sketch = Sketch { name: &line.name, triangles: triangles.clone(), color, place };
                self.parts.push(sketch.part(false, false));
            }
        }
    }

    /// Bushings as blocks of rubber between plates.
    pub(super) fn add_mounts(&mut self) {
        for (name, mount) in mounts(&self.scene, &self.outlines, self.size) {
            let place = Place::Mounted(mount);
            let sketch = Sketch { name: &name, triangles: Arc::new(Triangles::empty()), color: ROD, place };
            self.parts.push(sketch.part(false, false));
        }
    }

    /// Curves that bodies are guided along, as wires.
    pub(super) fn add_curves(&mut self) {
        for curve in &self.scene.curves {
            let path: Vec<Vector3<f64>> = curve.points.iter().map(|at| (*at).into()).collect();
            let Some(wire) = Triangles::wire(&path, ROPE_RADIUS * self.size) else { continue };
            let place = Place::Body { body: curve.body, pose: Pose::identity(), scale: [1.0; 3] };
            let sketch = Sketch { name: &curve.name, triangles: Arc::new(wire), color: CURVE, place };
            self.parts.push(sketch.part(false, false));
        }
    }

    /// Beams as their sections along the centre line.
    pub(super) fn add_beams(&mut self) {
        for tube in &Tubes::new(&self.scene).beams {
            let sweep = Arc::new(Sweep::new(tube, 0.6 * ROPE_RADIUS * self.size));
            let place = Place::Swept { sweep, tints: Vec::new() };
            let sketch = Sketch { name: &tube.name, triangles: Arc::default(), color: BEAM, place };
            self.parts.push(sketch.part(false, false));
        }
    }

    /// Marks of what is fixed to the ground.
    pub(super) fn add_ground(&mut self) {
        let edge = MARK * self.size;
        let rod = Arc::new(Triangles::rod());
        let cube = Triangles::of(&Form::Box([edge; 3]), 0.0).map(Arc::new).unwrap_or_default();
        let mark = |name: &str, triangles: &Arc<Triangles>, pose: Pose, scale: [f64; 3]| {
            let place = Place::Body { body: None, pose, scale };
            Sketch { name, triangles: triangles.clone(), color: GROUND, place }.part(false, false)
        };
        let cube_at = |name: &str, [x, y, z]: [f64; 3]| mark(name, &cube, Pose::translation(x, y, z), [1.0; 3]);
        let mut marks = Vec::new();
        for body in self.scene.bodies.iter().filter(|body| body.parent.is_none()) {
            match (body.hinge.as_str(), axes(body).first()) {
                ("revolute", Some(axis)) => {
                    let start = Vector3::from(body.hinge_at) - 2.0 * edge * axis;
                    let pose = Isometry3::from_parts(Translation3::from(start), toward(axis));
                    marks.push(mark(&body.name, &rod, pose, [0.5 * edge, 0.5 * edge, 4.0 * edge]));
                }
                ("universal" | "spherical", _) => marks.push(cube_at(&body.name, body.hinge_at)),
                // Other hinges let the body leave the point that they begin at.
                _ => {}
            }
        }
        for line in &self.scene.lines {
            let held = line.ends.len() - usize::from(line.goes_on);
            let on_ground = line.ends[..held].iter().filter(|(body, _)| body.is_none());
            marks.extend(on_ground.map(|(_, at)| cube_at(&line.name, *at)));
        }
        self.parts.extend(marks);
    }

    /// Loads as they are at one time (s), from where they act.
    pub(super) fn add_loads(&mut self, at: LoadTime) {
        let arrow = Arc::new(Triangles::arrow());
        let [force, torque] = self.scene.largest_loads();
        let mut arrows = Vec::new();
        for load in &self.scene.loads {
            for factor in at.factors(load) {
                for (of, full, color) in [(load.force, force, FORCE), (load.torque, torque, TORQUE)] {
                    let Some((turn, length)) = self.arrow(&(factor * Vector3::from(of)), full) else { continue };
                    let anchor: Anchor = (Some(load.body), load.at);
                    let place = match load.turns {
                        true => {
                            let pose = Isometry3::from_parts(Translation3::from(load.at), turn);
                            Place::Body { body: anchor.0, pose, scale: [length; 3] }
                        }
                        false => Place::Point { at: anchor, turn, scale: length },
                    };
                    let sketch = Sketch { name: &load.name, triangles: arrow.clone(), color, place };
                    arrows.push(sketch.part(!self.frames(Some(load.body)), true));
                }
            }
        }
        self.parts.extend(arrows);
    }

    /// Axes of the hinges, carried by the parents.
    pub(super) fn add_hinges(&mut self) {
        let arrow = Arc::new(Triangles::arrow());
        let length = AXIS * self.size;
        let mut arrows = Vec::new();
        for (index, body) in self.scene.bodies.iter().enumerate() {
            for axis in axes(body) {
                let start = Vector3::from(body.hinge_at) - 0.5 * length * axis;
                let pose = Isometry3::from_parts(Translation3::from(start), toward(&axis));
                let place = Place::Body { body: body.parent, pose, scale: [length; 3] };
                let sketch = Sketch { name: &body.name, triangles: arrow.clone(), color: HINGE, place };
                arrows.push(sketch.part(!self.frames(Some(index)), true));
            }
        }
        self.parts.extend(arrows);
    }

    /// What the hinges pass to the bodies, at the root markers.
    pub(super) fn add_reactions(&mut self, poses: &[Pose], reactions: &[Wrench]) {
        let arrow = Arc::new(Triangles::arrow());
        let full = reactions.iter().map(|one| one.force.norm()).filter(|x| x.is_finite()).fold(0.0, f64::max);
        let mut arrows = Vec::new();
        for (index, ((body, pose), reaction)) in self.scene.bodies.iter().zip(poses).zip(reactions).enumerate() {
            let Some((turn, length)) = self.arrow(&reaction.force, full) else { continue };
            let at: Anchor = (None, (pose * Point3::origin()).coords.into());
            let place = Place::Point { at, turn, scale: length };
            let sketch = Sketch { name: &body.name, triangles: arrow.clone(), color: REACTION, place };
            arrows.push(sketch.part(!self.frames(Some(index)), true));
        }
        self.parts.extend(arrows);
    }

    /// What contacts push with, from where it acts: green what sticks, orange what slips.
    pub(super) fn add_contacts(&mut self, contacts: &[ContactPush]) {
        let (arrow, still) = (Arc::new(Triangles::arrow()), still(&self.scene));
        let sizes = contacts.iter().map(|one| Vector3::from(one.force).norm());
        let full = sizes.filter(|x| x.is_finite()).fold(0.0, f64::max);
        let index = |name: &String| self.scene.bodies.iter().position(|body| body.name == *name);
        let mut arrows = Vec::new();
        for one in contacts {
            let Some((turn, length)) = self.arrow(&one.drawn(&still).into(), full) else { continue };
            let color = if one.slips { SLIP } else { STICK };
            let place = Place::Point { at: (None, one.point), turn, scale: length };
            let sketch = Sketch { name: &one.between.join(", "), triangles: arrow.clone(), color, place };
            let is_framed = one.between.iter().any(|name| self.frames(index(name)));
            arrows.push(sketch.part(!is_framed, true));
        }
        self.parts.extend(arrows);
    }

    /// Direction and length of an arrow (m); `None` for zero.
    fn arrow(&self, vector: &Vector3<f64>, full: f64) -> Option<(UnitQuaternion<f64>, f64)> {
        let length = vector.norm();
        let drawn = full > 0.0 && length > 0.0 && length.is_finite();
        drawn.then(|| (toward(vector), ARROW * self.size * (length / full).clamp(SHORTEST, 1.0)))
    }
}

/// Unit vectors along the axes of a hinge, in the parent's axes.
fn axes(body: &BodyPicture) -> Vec<Vector3<f64>> {
    body.hinge_axes.iter().filter_map(|axis| Vector3::from(*axis).try_normalize(0.0)).collect()
}

/// A text by which equal forms are recognized.
fn key(form: &Form) -> String {
    match form {
        Form::Mesh { file, scale, .. } => format!("{file} {scale:?}"),
        form => format!("{form:?}"),
    }
}
