//! A beam as bodies: one on its hinge, one at the tip of every element.

use super::cable::Shape;
use super::{BeamDescription, BeamShape, Section};
use crate::element::{Rod, RodSection};
use crate::force::load::LoadAxes;
use crate::force::{Attachment, ForceDescription, ForceKind, Load};
use crate::model::description::{BodyDescription, Description, HingeDescription, HingeKind, MassProperties, Point};
use crate::model::modal::{self, ModalBodies};
use nalgebra::{Matrix3, Matrix6, UnitQuaternion, Vector3};
use std::collections::{HashMap, HashSet};

/// A description with the bodies of its beams, and what else these are.
#[derive(Debug)]
pub(in crate::model) struct Expanded {
    pub(in crate::model) description: Description,
    /// The flexible element between a body and its parent.
    pub(in crate::model) rods: HashMap<usize, Rod>,
    /// Its coordinates at the start, where it has strains.
    pub(in crate::model) strained: HashMap<usize, Vec<f64>>,
    /// The rates of these, where it has some.
    pub(in crate::model) rates: HashMap<usize, Vec<f64>>,
    /// One per beam.
    pub(in crate::model) beams: Vec<Bodies>,
    /// Which beam has a name.
    by_name: HashMap<String, usize>,
    /// The bodies where the elements of beams begin and end, by their names: no description names these.
    inner: HashMap<String, usize>,
    /// Bodies where a first element begins, welded to the one on its hinge.
    welded: HashSet<usize>,
    /// One per modal body.
    pub(in crate::model) modals: Vec<ModalBodies>,
}

/// The bodies of a beam.
#[derive(Debug)]
pub(in crate::model) struct Bodies {
    pub(in crate::model) name: String,
    pub(in crate::model) length: f64,
    pub(in crate::model) is_cable: bool,
    pub(in crate::model) degree: usize,
    pub(in crate::model) sections: Vec<(f64, Section)>,
    /// On the beam's hinge.
    pub(in crate::model) root: usize,
    /// Where its first element begins: that one, or one welded to it.
    pub(in crate::model) begin: usize,
    /// At the tips of the elements, with the distance of the element's root and of its tip from the beam's root (m).
    pub(in crate::model) tips: Vec<(usize, [f64; 2])>,
    markers: Vec<(String, f64)>,
}

/// Distances nearer than this part of the length are one.
const SAME: f64 = 1e-9;

impl Expanded {
    /// Whether a body is where the first element of a beam begins, welded to the one on its hinge.
    pub(in crate::model) fn is_welded(&self, body: usize) -> bool {
        self.welded.contains(&body)
    }

    /// Whether a body is one that a modal body is taken apart into, beside that on its hinge.
    pub(in crate::model) fn is_modal(&self, body: usize) -> bool {
        self.modals.iter().any(|modal| modal.inner == body || modal.tips.contains(&body))
    }

    /// The body and the point of it that a point of a beam is; `None` for other bodies and unknown markers.
    pub(in crate::model) fn place(&self, body: &str, point: &Point) -> Option<(usize, Vector3<f64>)> {
        if let Some(modal) = self.modals.iter().find(|modal| modal.name == body) {
            return modal.place(point);
        }
        let Some(beam) = self.by_name.get(body).map(|beam| &self.beams[*beam]) else {
            // A beam puts its own loads on its inner bodies.
            let is_root = *point == Point::Marker("root".to_owned());
            return self.inner.get(body).filter(|_| is_root).map(|of| (*of, Vector3::zeros()));
        };
        let name = match point {
            Point::At(at) => return Some((beam.tips.last()?.0, *at)),
            Point::Marker(name) => name,
        };
        if name == "root" {
            return Some((beam.begin, Vector3::zeros()));
        }
        let at = match name.as_str() {
            "tip" => beam.length,
            _ => beam.markers.iter().find(|(marker, _)| marker == name)?.1,
        };
        let of = beam.tips.iter().find(|(_, [_, to])| (to - at).abs() <= SAME * beam.length)?;
        Some((of.0, Vector3::zeros()))
    }
}

/// Adds the bodies of all modal bodies and beams after the others; cables begin in their shapes, one per beam.
pub(in crate::model) fn expand(mut description: Description, shapes: &[Option<Shape>]) -> Expanded {
    let beams = description.beams.clone();
    let modals = modal::expand(&mut description);
    let mut expanded = Expanded {
        description,
        rods: HashMap::new(),
        strained: HashMap::new(),
        rates: HashMap::new(),
        beams: Vec::with_capacity(beams.len()),
        by_name: HashMap::new(),
        inner: HashMap::new(),
        welded: HashSet::new(),
        modals,
    };
    for (beam, shape) in beams.iter().zip(shapes) {
        add(&mut expanded, beam, shape.as_ref());
    }
    lay_sliders(&mut expanded);
    expanded
}

/// Finds the nodes of the beams along which points slide.
fn lay_sliders(expanded: &mut Expanded) {
    let Description { forces, bodies, .. } = &mut expanded.description;
    for force in forces {
        let ForceKind::Slider(slider) = &mut force.kind else { continue };
        let Some(beam) = expanded.by_name.get(&slider.along).map(|beam| &expanded.beams[*beam]) else { continue };
        let tips = beam.tips.iter().map(|(tip, [_, to])| (*tip, *to));
        slider.lay(std::iter::once((beam.begin, 0.0)).chain(tips).map(|(body, s)| (bodies[body].name.clone(), s)));
    }
}

/// Where elements begin and end: the beam is cut at its markers and where the law of its section changes, and the elements are
/// shared out between them.
fn ends(beam: &BeamDescription) -> Vec<f64> {
    let length = beam.shape.length();
    let markers = beam.markers.iter().map(|(_, at)| *at);
    let mut cuts: Vec<f64> = markers.chain(beam.sections.iter().map(|(at, _)| *at)).collect();
    cuts.retain(|at| *at > SAME * length && *at < length * (1.0 - SAME));
    cuts.push(length);
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| (*a - *b).abs() <= SAME * length);
    let mut ends = vec![0.0];
    let mut from = 0.0;
    for to in cuts {
        let share = (beam.elements as f64 * (to - from) / length).round().max(1.0) as usize;
        ends.extend((1..=share).map(|i| if i == share { to } else { from + (to - from) * i as f64 / share as f64 }));
        from = to;
    }
    ends
}

fn add(expanded: &mut Expanded, beam: &BeamDescription, shape: Option<&Shape>) {
    let (length, free) = (beam.shape.length(), beam.free.indices());
    let ends = ends(beam);
    let bodies = &mut expanded.description.bodies;
    let root = bodies.len();
    bodies.push(body(&beam.name, beam.hinge.clone()));
    let (mut turn, mut place) = beam.shape.begin();
    let begin = if (turn, place) == (Matrix3::identity(), Vector3::zeros()) {
        root
    } else {
        let mut weld = HingeDescription::fixed().on(&beam.name, Point::At(place));
        weld.frame = UnitQuaternion::from_matrix(&turn);
        bodies.push(body(&format!("{}/0", beam.name), weld));
        root + 1
    };
    let mut tips = Vec::with_capacity(ends.len());
    let mut given = [&beam.strains, &beam.strain_rates].map(|list| list.iter().copied());
    for (index, ends) in ends.windows(2).enumerate() {
        let section = |s: f64| -> RodSection { beam.section_per_length(ends[0] + s) };
        let ends = [ends[0], ends[1]];
        let reference = beam.shape.reference(ends, beam.twist / length);
        let mut rod = Rod::new(ends[1] - ends[0], beam.degree, &free, &reference, section);
        rod.damping = beam.damping;
        if let Some(load) = &beam.load {
            (rod.load, rod.follows) = (load.force, load.follows);
        }
        let bodies = &mut expanded.description.bodies;
        let (here, parent) = (bodies.len(), bodies.len() - 1);
        let mut hinge = HingeDescription::new(HingeKind::Fixed);
        hinge.parent = bodies[parent].name.clone();
        let [strains, rates] = given.each_mut().map(|list| list.take(rod.count()).collect::<Vec<f64>>());
        bodies.push(body(&format!("{}/{}", beam.name, index + 1), hinge));
        let unstrained = vec![0.0; rod.count()];
        let (r, p) = rod.pose_at(rod.length, &unstrained);
        (turn, place) = (turn * r, place + turn * p);
        let last = rod.slices.len() - 1;
        weigh(&mut bodies[parent], &rod, 0);
        weigh(&mut bodies[here], &rod, last);
        for (body, station) in [(parent, 0), (here, last)] {
            let name = bodies[body].name.clone();
            expanded.description.unphysical.insert(name.clone());
            end_load(&mut expanded.description.forces, beam, &name, &rod, station);
        }
        let markers = beam.markers.iter().filter(|(_, at)| (at - ends[1]).abs() <= SAME * length);
        let reached: Vec<_> = markers.map(|(name, _)| (name.clone(), place)).collect();
        expanded.description.bodies[root].markers.extend(reached);
        tips.push((here, [ends[0], ends[1]]));
        if !rates.is_empty() {
            expanded.rates.insert(here, rates);
        }
        if !strains.is_empty() {
            expanded.strained.insert(here, strains);
        } else if let Some(shape) = shape {
            expanded.strained.insert(here, rod.fit(|s| shape.strain(ends[0] + s)));
        }
        expanded.rods.insert(here, rod);
    }
    expanded.description.bodies[root].markers.push(("tip".to_owned(), place));
    let (name, markers, is_cable) = (beam.name.clone(), beam.markers.clone(), beam.far.is_some());
    let (degree, sections) = (beam.degree, beam.sections.clone());
    let bodies = &expanded.description.bodies;
    let inner = std::iter::once(begin).chain(tips.iter().map(|(tip, _)| *tip));
    expanded.inner.extend(inner.map(|body| (bodies[body].name.clone(), body)));
    expanded.welded.extend((begin != root).then_some(begin));
    expanded.by_name.insert(name.clone(), expanded.beams.len());
    expanded.beams.push(Bodies { name, length, is_cable, degree, sections, root, begin, tips, markers });
}

impl BeamDescription {
    /// How far the ends of its elements are from a centre line through points, at most, without strain (m).
    pub(crate) fn strays(&self) -> f64 {
        let BeamShape::Points(guide) = &self.shape else { return 0.0 };
        let twist_rate = self.twist / self.shape.length();
        let none = RodSection { stiffness: Matrix6::identity(), mass: 0.0, rotary: Vector3::zeros() };
        let (mut turn, mut place) = self.shape.begin();
        let mut most = 0.0_f64;
        for ends in ends(self).windows(2) {
            let reference = self.shape.reference([ends[0], ends[1]], twist_rate);
            let rod = Rod::new(ends[1] - ends[0], 0, &[0], &reference, |_| none);
            let (r, p) = rod.pose_at(rod.length, &[0.0]);
            (turn, place) = (turn * r, place + turn * p);
            most = most.max((guide.at(guide.range()[0] + ends[1]).place - place).norm());
        }
        most
    }

    /// How many coordinates its elements have.
    pub(in crate::model) fn strain_count(&self) -> usize {
        (ends(self).len() - 1) * (self.degree + 1) * self.free.indices().len()
    }
}

fn body(name: &str, hinge: HingeDescription) -> BodyDescription {
    BodyDescription::new(name, hinge)
}

/// Adds the slice of an element's end to the body there.
fn weigh(body: &mut BodyDescription, rod: &Rod, station: usize) {
    let slice = &rod.slices[station];
    let MassProperties { mass, inertia, .. } = &mut body.mass;
    *mass += slice.mass;
    *inertia += slice.inertia.matrix();
}

/// The line load on the slice of an element's end, as a load on the body there.
fn end_load(forces: &mut Vec<ForceDescription>, beam: &BeamDescription, on: &str, rod: &Rod, station: usize) {
    let Some(load) = &beam.load else { return };
    let kind = Load {
        on: Attachment { body: on.to_owned(), point: Point::Marker("root".to_owned()) },
        force: rod.slices[station].length * load.force,
        torque: Vector3::zeros(),
        axes: if load.follows { LoadAxes::Body } else { LoadAxes::Inertial },
        over_time: None,
    };
    forces.push(ForceDescription { name: format!("{}.load/{}", beam.name, forces.len()), kind: kind.into() });
}
