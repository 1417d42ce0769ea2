//! Cables: beams that are closed at their far end. Where both ends are follows from the given positions; the cable begins in
//! the shape of the elastic catenary between them.

use super::{BeamDescription, BeamShape, FarEnd};
use crate::element::catenary::Catenary;
use crate::model::Model;
use crate::model::couplings::{Closure, LoopDescription};
use crate::model::description::{Attachment, BodyDescription, Description, HingeDescription, HingeKind, Point};
use crate::model::problem::{Element, Problem, number};
use crate::spatial::Pose;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector2, Vector3, Vector6};

/// How a cable begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::model) struct Shape {
    catenary: Catenary,
    /// `1/EA` (1/N).
    compliance: f64,
}

impl Shape {
    /// The strain at a distance from the start (m).
    pub(in crate::model) fn strain(&self, s: f64) -> Vector6<f64> {
        let stretch = self.compliance * self.catenary.tension_at(s);
        Vector6::new(1.0 + stretch, 0.0, 0.0, 0.0, self.catenary.curvature(s), 0.0)
    }
}

/// A cable that has its hinge, its length and its loop already: the shape in which it begins, if it has one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::model) struct Laid(Option<Shape>);

/// A description whose cables have their hinges, lengths and loops, and keep them whatever positions it is given then: the loops come after
/// those that it has, cable by cable. One without such a shape comes back as it is.
pub(in crate::model) fn lay_once(given: &Description) -> Description {
    let Ok((mut laid, shapes)) = lay(given) else { return given.clone() };
    for (beam, shape) in laid.beams.iter_mut().zip(shapes) {
        beam.far.iter_mut().for_each(|far| far.laid = Some(Laid(shape)));
    }
    laid
}

/// A description whose cables have their hinges, lengths and loops, and the shapes in which they begin, one per beam.
///
/// # Errors
/// Cables that have no shape between their ends.
pub(in crate::model) fn lay(given: &Description) -> Result<(Description, Vec<Option<Shape>>), Vec<Problem>> {
    let (mut laid, mut shapes, mut problems) = (given.clone(), vec![None; given.beams.len()], Vec::new());
    let before = |beam: &BeamDescription| beam.far.as_ref().and_then(|far| far.laid);
    for (shape, beam) in shapes.iter_mut().zip(&given.beams) {
        *shape = before(beam).and_then(|Laid(shape)| shape);
    }
    // All cables of a scene are laid at once.
    if given.beams.iter().all(|beam| beam.far.is_none() || before(beam).is_some()) {
        return Ok((laid, shapes));
    }
    let Some(ends) = ends(given) else {
        // Of a scene that cannot be built that is said when it is built, its far ends included.
        let far = given.beams.iter().filter_map(|cable| Some(loop_of(cable, cable.far.as_ref()?, None)));
        laid.loops.extend(far);
        return Ok((laid, shapes));
    };
    let cables = laid.beams.iter_mut().enumerate().filter(|(_, beam)| beam.far.is_some());
    for ((index, cable), ends) in cables.zip(ends) {
        match closed(cable, ends, &given.gravity) {
            Ok((closed, shape)) => {
                laid.loops.push(closed);
                shapes[index] = shape;
            }
            Err((field, message, help)) => problems.push(Problem {
                element: Element::Beam(index),
                field: field.to_owned(),
                message,
                help: Some(help.to_owned()),
            }),
        }
    }
    if problems.is_empty() { Ok((laid, shapes)) } else { Err(problems) }
}

/// `world_from_body` at both ends of every cable, in the given positions.
fn ends(given: &Description) -> Option<Vec<[Pose; 2]>> {
    let mut open = Description {
        bodies: given.bodies.clone(),
        beams: given.beams.clone(),
        unphysical: given.unphysical.clone(),
        ..Description::default()
    };
    for beam in &mut open.beams {
        if let Some(far) = beam.far.take() {
            beam.hinge = HingeDescription::fixed().on(&beam.hinge.parent, beam.hinge.at.clone());
            // With any length it tells where it begins.
            if !(beam.shape.length() > 0.0) {
                beam.shape = BeamShape::Straight { length: 1.0 };
            }
            let hinge = HingeDescription::fixed().on(&far.at.body, far.at.point);
            open.bodies.push(BodyDescription::new(&far_name(&beam.name), hinge));
        }
    }
    let model = Model::build_loosely(&open).ok()?;
    let poses = poses(&model);
    let cables = given.beams.iter().filter(|beam| beam.far.is_some());
    cables.map(|cable| Some([poses[model.body(&cable.name)?], poses[model.body(&far_name(&cable.name))?]])).collect()
}

fn far_name(cable: &str) -> String {
    format!("{cable}/far")
}

/// `world_from_body` of all bodies where they are given.
fn poses(model: &Model) -> Vec<Pose> {
    let q = &model.start_position;
    let mut links = vec![Pose::identity(); model.links.len()];
    for (index, link) in model.links.iter().enumerate().skip(1) {
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(link.turn));
        let hinge = links[link.parent] * Pose::from_parts(link.offset.into(), turn);
        let own = link.joint.pose(&q[link.position..]).or_else(|| {
            let rod = &model.rods[link.joint.rod()?];
            let (turn, place) = rod.pose_at(rod.length, &q[link.position..link.position + rod.count()]);
            Some(pose(&turn, place))
        });
        links[index] = hinge * own.unwrap_or_else(Pose::identity);
    }
    model.bodies.iter().map(|body| links[body.link] * body.link_from_body).collect()
}

fn pose(turn: &Matrix3<f64>, place: Vector3<f64>) -> Pose {
    Pose::from_parts(place.into(), UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*turn)))
}

/// Gives a cable its hinge and its length, and what closes it: with the shape in which it begins.
fn closed(
    cable: &mut BeamDescription,
    [from, to]: [Pose; 2],
    gravity: &Vector3<f64>,
) -> Result<(LoopDescription, Option<Shape>), (&'static str, String, &'static str)> {
    let Some(far) = cable.far.clone() else { return Err(("between", "no end".to_owned(), "")) };
    let of = cable.section_per_length(0.0);
    let load = cable.load.filter(|load| !load.follows).map_or(Vector3::zeros(), |load| load.force);
    let weight = of.mass * gravity + load;
    let chord = to.translation.vector - from.translation.vector;
    let down = weight.try_normalize(0.0).unwrap_or_else(|| Vector3::new(0.0, 0.0, -1.0));
    let depth = chord.dot(&down);
    let across = chord - depth * down;
    let way = Vector2::new(across.norm(), depth);
    let compliance = if cable.free.stretch { 1.0 / of.stiffness[(0, 0)] } else { 0.0 };
    if let Some(tension) = far.pretension {
        if cable.sections.len() > 1 {
            let message = format!("`{}` has several sections and a pretension", cable.name);
            return Err((
                "pretension",
                message,
                "its length follows from a tension where it has one section: give `length`",
            ));
        }
        let Some(length) = Catenary::tensioned(way, tension, compliance, weight.norm()) else {
            let message = format!("`{}` cannot have a tension of {} N between its ends", cable.name, number(tension));
            return Err((
                "pretension",
                message,
                "its weight alone pulls more, or the ends are in one place: give `length`",
            ));
        };
        cable.shape = BeamShape::Straight { length };
        cable.far.as_mut().iter_mut().for_each(|far| far.pretension = None);
    }
    let length = cable.shape.length();
    if compliance == 0.0 && length < chord.norm() {
        let apart = number(chord.norm());
        let message = format!("`{}` is {} m long and its ends are {apart} m apart", cable.name, number(length));
        return Err(("length", message, "a longer one, or one that may stretch: `free = [\"bend\", \"stretch\"]`"));
    }
    // x across towards the far end, z against the weight.
    let any = if down.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let x =
        across.try_normalize(1e-12 * (1.0 + chord.norm())).unwrap_or_else(|| (any - any.dot(&down) * down).normalize());
    let level = pose(&Matrix3::from_columns(&[x, x.cross(&down), -down]), Vector3::zeros()).rotation;
    let along = level * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), way.y.atan2(way.x));
    let shape =
        Catenary::between(way, length, compliance, weight.norm()).map(|catenary| Shape { catenary, compliance });
    let slope = shape.map_or_else(|| way.y.atan2(way.x), |shape| shape.catenary.slope(0.0));
    let hinge = HingeDescription::on(HingeDescription::fixed(), &cable.hinge.parent, cable.hinge.at.clone());
    cable.hinge = match (far.clamped[0], cable.free.twist) {
        (true, _) => hinge.turned(from.rotation.inverse() * along),
        // Nothing resists a turn about itself where it does not twist: it has two angles.
        (false, false) => HingeDescription {
            kind: HingeKind::Universal { axes: [Vector3::y(), Vector3::z()] },
            position: vec![slope, 0.0],
            ..hinge.turned(from.rotation.inverse() * level)
        },
        (false, true) => {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), slope);
            HingeDescription {
                kind: HingeKind::Spherical,
                position: vec![turn.w, turn.i, turn.j, turn.k],
                ..hinge.turned(from.rotation.inverse() * level)
            }
        }
    };
    let closed = loop_of(cable, &far, far.clamped[1].then(|| to.rotation.inverse() * along));
    Ok((closed, shape.filter(|_| !far.clamped[0])))
}

/// What closes a cable; clamped with its tip's frame turned like this in the body at its end.
fn loop_of(cable: &BeamDescription, far: &FarEnd, clamped: Option<UnitQuaternion<f64>>) -> LoopDescription {
    let tip = Attachment { body: cable.name.clone(), point: Point::Marker("tip".to_owned()) };
    let kind = if clamped.is_some() { HingeKind::Fixed } else { HingeKind::Spherical };
    LoopDescription {
        name: cable.name.clone(),
        closure: Closure::Hinge(kind),
        between: [tip, far.at.clone()],
        frame: UnitQuaternion::identity(),
        second_frame: clamped,
    }
}
