//! The compiled tree: hinges taken apart into elementary ones, welds merged.

use super::beam::{Beam, BeamElement, Bodies, Expanded};
use super::build::Place;
use super::couple::couple;
use super::description::{AlongTurn, Description, HingeDescription, HingeKind, MassProperties};
use super::link::Link;
use super::modal::{ModalBodies, ModalBody};
use super::problem::{Element, Problem};
use super::{
    Body, Coordinate, End, Force, Halves, Hinge, Model, burn, contact, controller, guided, hinge_curve, output, watch,
};
use crate::element::Rod;
use crate::element::guide::Guide;
use crate::force::{Carrier, Describe};
use crate::hinge::Joint;
use crate::hinge::joint::quaternion;
use crate::round_off::UNIT_NORM;
use crate::spatial::{Pose, Principal, Sym3};
use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use std::sync::Arc;

/// The compiled tree while it grows.
pub(super) struct Tree<'a> {
    description: &'a Description,
    whole: Option<&'a Expanded>,
    rods: Vec<Rod>,
    links: Vec<Link>,
    bodies: Vec<Option<Body>>,
    coordinates: Vec<Coordinate>,
    start_position: Vec<f64>,
    start_velocity: Vec<f64>,
}

impl<'a> Tree<'a> {
    pub(super) fn new(description: &'a Description, whole: Option<&'a Expanded>) -> Self {
        Self {
            description,
            whole,
            rods: Vec::new(),
            links: vec![Link::ground()],
            bodies: vec![None; description.bodies.len()],
            coordinates: Vec::new(),
            start_position: Vec::new(),
            start_velocity: Vec::new(),
        }
    }

    /// The link a body is part of and where it stands on it; the ground for `None`.
    fn carrier(&self, body: Option<usize>) -> (usize, Pose) {
        match body.and_then(|body| self.bodies[body].as_ref()) {
            Some(body) => (body.link, body.link_from_body),
            None => (0, Pose::identity()),
        }
    }

    pub(super) fn grow(&mut self, index: usize, parent: Option<usize>, at: Vector3<f64>) {
        let given = &self.description.bodies[index];
        let parent_from_hinge = Isometry3::from_parts(Translation3::from(at), given.hinge.frame);
        let (carrier, link_from_parent) = self.carrier(parent);
        let turn = link_from_parent.rotation * given.hinge.frame;
        let base = Pose::from_parts(Translation3::from(seen_from(&link_from_parent, &at)), turn);
        let hinge = Hinge {
            kind: given.hinge.kind,
            parent_from_hinge,
            position: self.start_position.len(),
            velocity: self.start_velocity.len(),
            lock: given.hinge.lock,
        };
        let rod = self.whole.and_then(|whole| whole.rods.get(&index));
        let modal = self.whole.and_then(|whole| modal_joint(whole, index));
        let mut joints = match rod {
            None if modal.is_some() => modal.into_iter().map(|joint| (joint, UnitQuaternion::identity())).collect(),
            Some(rod) => vec![(Joint::Flex { rod: self.rods.len(), count: rod.count() }, UnitQuaternion::identity())],
            None => given.hinge.kind.elementary(&given.hinge.rest),
        };
        for (joint, _) in &mut joints {
            if let Joint::Along { rod } = joint {
                *rod = self.rods.len();
            }
        }
        self.rods.extend(rod.cloned().or_else(|| guide(&given.hinge)));
        let (link, link_from_body) = match joints.last() {
            None => (carrier, base),
            Some((_, hinge_from_link)) => {
                let turn = hinge_from_link.inverse();
                (self.add_links(index, carrier, &base, &joints), Pose::from_parts(Translation3::identity(), turn))
            }
        };
        if !joints.is_empty() {
            self.add_coordinates(index);
        }
        weld(&mut self.links[link], &given.mass, &link_from_body);
        self.bodies[index] = Some(Body {
            name: given.name.clone(),
            parent,
            link,
            link_from_body,
            is_element: rod.is_some() || modal.is_some_and(|joint| joint.is_flex()),
            is_inner: rod.is_some() || modal.is_some() || self.whole.is_some_and(|whole| whole.is_welded(index)),
            mass: given.mass,
            markers: given.markers.clone(),
            shapes: given.shapes.clone(),
            hinge,
        });
    }

    /// One link per elementary joint; only the first sits away from its parent's root marker.
    fn add_links(
        &mut self,
        body: usize,
        carrier: usize,
        base: &Pose,
        joints: &[(Joint, UnitQuaternion<f64>)],
    ) -> usize {
        let (mut position, mut velocity) = (self.start_position.len(), self.start_velocity.len());
        let mut parent = carrier;
        let (mut parent_from_hinge, mut offset) = (base.rotation, base.translation.vector);
        for (joint, hinge_from_link) in joints {
            let turn = *(parent_from_hinge * hinge_from_link).to_rotation_matrix().matrix();
            if joint.interface().is_some() {
                // The coordinates that move it are those of the link that carries it.
                (position, velocity) = (self.links[carrier].position, self.links[carrier].velocity);
            }
            let link = Link {
                parent,
                joint: *joint,
                offset,
                turn,
                straight: turn == Matrix3::identity(),
                position,
                velocity,
                body,
                ..Link::ground()
            };
            let (positions, velocities) = joint.counts();
            position += positions;
            velocity += velocities;
            parent = self.links.len();
            self.links.push(link);
            (parent_from_hinge, offset) = (hinge_from_link.inverse(), Vector3::zeros());
        }
        parent
    }

    fn add_coordinates(&mut self, body: usize) {
        let hinge = &self.description.bodies[body].hinge;
        let modal = self.whole.and_then(|whole| whole.modals.iter().find(|modal| modal.inner == body));
        let rod = self.whole.and_then(|whole| whole.rods.get(&body));
        let count = rod.map(Rod::count).or_else(|| modal.map(|modal| modal.modal.count()));
        let flexible = count.map(|count| (count, count));
        let (positions, velocities) = flexible.unwrap_or_else(|| hinge.kind.counts());
        let value = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(0.0);
        // A list of rest positions of a hinge with a quaternion is longer than its velocities; the quaternion itself
        // is kept in the ball's joint.
        let scalars = hinge.kind.plain_coordinates();
        let [strains, strain_rates] = match modal {
            Some(modal) => modal.start.each_ref().map(Some),
            None => [
                self.whole.and_then(|whole| whole.strained.get(&body)),
                self.whole.and_then(|whole| whole.rates.get(&body)),
            ],
        };
        let rates = strain_rates.unwrap_or(&hinge.velocity);
        for i in 0..velocities {
            self.coordinates.push(Coordinate {
                body,
                stiffness: value(&hinge.stiffness, i),
                damping: value(&hinge.damping, i),
                rest: if i < scalars { value(&hinge.rest, i) } else { 0.0 },
                armature: value(&hinge.armature, i),
                force: value(&hinge.force, i),
                lock: hinge.lock,
            });
            self.start_velocity.push(value(rates, i));
        }
        let strained = strains.unwrap_or(&hinge.position);
        for i in 0..positions {
            let identity = if i == scalars && positions != velocities { 1.0 } else { 0.0 };
            let given = strained.get(i).copied().unwrap_or(identity);
            self.start_position.push(given);
        }
        if positions != velocities {
            let at = self.start_position.len() - 4;
            let given = &mut self.start_position[at..];
            // One that is written with all its digits keeps them.
            let norm = given.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (norm - 1.0).abs() > UNIT_NORM.of(1.0) {
                let unit = quaternion(given);
                given.copy_from_slice(&[unit.w, unit.i, unit.j, unit.k]);
            }
        }
    }

    /// Where every subtree ends, and what every link's whole inertia is.
    pub(super) fn close(&mut self) {
        for index in 0..self.links.len() {
            self.links[index].subtree_end = index + 1;
        }
        for index in (1..self.links.len()).rev() {
            let (end, parent) = (self.links[index].subtree_end, self.links[index].parent);
            self.links[parent].subtree_end = self.links[parent].subtree_end.max(end);
        }
        for link in &mut self.links {
            link.principal = Principal::of(&link.inertia);
        }
    }

    /// Hinges on which nothing with inertia hangs: their acceleration is not determined.
    pub(super) fn massless_subtrees(&self) -> Vec<Problem> {
        let has_mass = |link: &Link| !link.is_massless() || link.joint.modal().is_some();
        let mut carried: Vec<bool> = self.links.iter().map(has_mass).collect();
        let driven = self.driven();
        let mut problems = Vec::new();
        for index in (1..self.links.len()).rev() {
            let link = &self.links[index];
            let undetermined = |body: &Body| {
                let range = body.hinge.velocity..body.hinge.velocity + body.hinge.kind.counts().1;
                body.link == index && range.into_iter().any(|i| self.coordinates[i].armature == 0.0 && !driven[i])
            };
            if carried[index] {
                carried[link.parent] = true;
            } else if self.bodies[link.body].as_ref().is_some_and(undetermined) {
                let name = &self.description.bodies[link.body].name;
                problems.push(Problem {
                    element: Element::Body(link.body),
                    field: "mass".to_owned(),
                    message: format!(
                        "neither `{name}` nor anything it carries has mass: its hinge would be undetermined"
                    ),
                    help: Some(format!(
                        "give it a mass, weld it with a fixed hinge (`massless = \"weld\"` in `model`, or `convert \
                         --weld-massless`, for all of a model), or give the hinge an armature, as with `--set {}.armature=1e-6`",
                        name.split('[').next().unwrap_or(name)
                    )),
                });
            }
        }
        problems.reverse();
        problems
    }

    /// Which velocity coordinates follow a drive: their accelerations are given.
    fn driven(&self) -> Vec<bool> {
        let mut driven = vec![false; self.coordinates.len()];
        for drive in &self.description.drives {
            let scalars = self.links.iter().skip(1).filter(|link| {
                self.description.bodies[link.body].name == drive.coordinate.body && link.joint.is_scalar()
            });
            if let Some(link) = scalars.into_iter().nth(drive.coordinate.index) {
                driven[link.velocity] = true;
            }
        }
        driven
    }

    pub(super) fn finish(
        self,
        places: &[Vec<Place>],
        loops: &[[Place; 2]],
        watched: &[Option<Place>],
        asked: &[Vec<Place>],
    ) -> Result<Model, Vec<Problem>> {
        let end = |place: &Place| {
            let (link, link_from_body) = self.carrier(place.0);
            End { link, body: place.0, point: seen_from(&link_from_body, &place.1) }
        };
        let turn = |place: &Place| self.carrier(place.0).1.rotation;
        let forces = self.description.forces.iter().zip(places).map(|(force, places)| Force {
            name: force.name.clone(),
            law: force
                .kind
                .compile(&places.iter().map(|at| Carrier { end: end(at), turn: turn(at) }).collect::<Vec<_>>()),
        });
        let forces = forces.collect();
        let bodies: Vec<Body> = self.bodies.iter().flatten().cloned().collect();
        let stops = watch::stops(self.description, &bodies);
        let curve_ends = guided::ends(&self.links, &self.rods, &stops);
        let hinge_friction = contact::hinge_friction(self.description, &bodies);
        let mut model = Model {
            title: self.description.title.clone(),
            gravity: self.description.gravity,
            forces,
            loops: Vec::new(),
            drives: Vec::new(),
            gears: Vec::new(),
            motors: Vec::new(),
            inputs: Vec::new(),
            controllers: Vec::new(),
            curves: hinge_curve::compile(self.description, &bodies, &self.links),
            independent_rows: None,
            stops,
            hinge_friction,
            contacts: contact::rules(self.description),
            events: Vec::new(),
            outputs: Vec::new(),
            stages: None,
            bodies,
            halves: if self.rods.is_empty() && self.modals().is_empty() { Halves::of(&self.links) } else { None },
            modals: self.modals(),
            beams: self.beams(),
            rods: self.rods.clone(),
            curve_ends,
            burns: Vec::new(),
            links: self.links.iter().cloned().collect(),
            coordinates: self.coordinates.clone(),
            start_position: self.start_position.clone(),
            start_velocity: self.start_velocity.clone(),
        };
        let carrier = |place: &Place| (end(place), turn(place));
        burn::compile(self.description, &mut model);
        let mut problems = couple(self.description, loops, &carrier, &mut model);
        if problems.is_empty() {
            problems = output::compile(self.description, asked, &carrier, &mut model);
        }
        if problems.is_empty() {
            problems = watch::events(self.description, end, watched, &mut model);
        }
        if problems.is_empty() {
            problems = controller::compile(self.description, &mut model);
        }
        if problems.is_empty() { Ok(model) } else { Err(problems) }
    }
}

impl Tree<'_> {
    /// The modal bodies, with the links of their coordinates.
    fn modals(&self) -> Vec<ModalBody> {
        let modal = |of: &ModalBodies| ModalBody {
            name: of.name.clone(),
            root: of.root,
            inner: of.inner,
            link: self.bodies[of.inner].as_ref().map_or(0, |body| body.link),
            tips: of.tips.clone(),
            links: of.tips.iter().map(|tip| self.bodies[*tip].as_ref().map_or(0, |body| body.link)).collect(),
            modal: Arc::clone(&of.modal),
        };
        self.whole.map_or(Vec::new(), |whole| whole.modals.iter().map(modal).collect())
    }

    /// The beams, with the links of their elements.
    fn beams(&self) -> Vec<Beam> {
        let link = |body: usize| self.bodies[body].as_ref().map_or(0, |body| body.link);
        let element = |(body, ends): &(usize, [f64; 2])| {
            let link = link(*body);
            self.links[link].joint.rod().map(|rod| BeamElement { from: ends[0], rod, link, body: *body })
        };
        let beam = |of: &Bodies| Beam {
            name: of.name.clone(),
            root: of.root,
            begin: of.begin,
            elements: of.tips.iter().filter_map(element).collect(),
            length: of.length,
            is_cable: of.is_cable,
            degree: of.degree,
            sections: of.sections.clone(),
        };
        self.whole.map_or(Vec::new(), |whole| whole.beams.iter().map(beam).collect())
    }
}

/// What the link of a body is that a modal body is taken apart into.
fn modal_joint(whole: &Expanded, body: usize) -> Option<Joint> {
    whole.modals.iter().enumerate().find_map(|(modal, of)| {
        if of.inner == body {
            return Some(Joint::Modal { modal, count: of.modal.count() });
        }
        of.tips.iter().position(|tip| *tip == body).map(|tip| Joint::Interface { modal, tip })
    })
}

/// The element of a hinge along a curve, which has been checked.
fn guide(hinge: &HingeDescription) -> Option<Rod> {
    let (curve, HingeKind::Along { turn }) = (hinge.curve.as_ref()?, hinge.kind) else { return None };
    Guide::new(curve, turn != AlongTurn::Held).ok().map(Rod::guided)
}

/// A point of a body in the axes of its link. By the matrix: between axes that are the same but for their names it
/// moves numbers without rounding them.
fn seen_from(link_from_body: &Pose, point: &Vector3<f64>) -> Vector3<f64> {
    link_from_body.rotation.to_rotation_matrix() * point + link_from_body.translation.vector
}

/// Adds a body's mass and inertia to the link it is welded to. Inertia counts also where there is no mass with it.
pub(super) fn weld(link: &mut Link, mass: &MassProperties, link_from_body: &Pose) {
    let center = seen_from(link_from_body, &mass.center);
    let turn = link_from_body.rotation.to_rotation_matrix();
    let about_center = Sym3::symmetric_part(&mass.inertia).turned(turn.matrix());
    let total = link.mass + mass.mass;
    if total > 0.0 {
        link.center = (link.mass * link.center + mass.mass * center) / total;
    }
    link.mass = total;
    link.inertia += about_center + Sym3::steiner(mass.mass, center);
}
