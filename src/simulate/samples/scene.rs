//! The still part of a recording, from a model.

use super::guides;
use crate::force::{Act, LineKind, Picture};
use crate::hinge::{HingeKind, Names};
use crate::model::beam::Section;
use crate::model::couplings::Closure;
use crate::model::description::OverTime;
use crate::model::shape::{Geometry, Shape};
use crate::model::{Beam, BeamElement, Body, End, Loop, ModalBody, Model, Output};
use crate::motion::Motion;
use crate::record::beam::{BeamPicture, ElementPicture, SectionPicture};
use crate::record::scene::{
    BodyPicture, BushingPicture, Channel, Extent, FactorPicture, LinePicture, LoadPicture, Scene, ShapePicture,
};
use crate::spatial::Pose;
use nalgebra::{Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::sync::Arc;

/// A plane is drawn so many times as large as the scene's length, and larger by so many times the way to what stands on it...
const GROUND: f64 = 4.0;
const BEYOND: f64 = 3.0;
/// ... and so many times as thick as the scene's length.
const THIN: f64 = 0.04;
/// The ends of a beam's and of a cable's elements are drawn as balls of this part of its length.
const POINT: f64 = 0.004;
const CABLE_POINT: f64 = 0.002;
/// And the interfaces of a modal body of this part of the distance of the furthest one from its root.
const MODAL_POINT: f64 = 0.01;

/// The still part of a recording whose structure does not change.
pub(in crate::simulate) fn of_structure(model: &Arc<Model>) -> Scene {
    let mut by_position: Vec<&Body> = model.bodies.iter().collect();
    by_position.sort_by_key(|body| (body.hinge.position, body.hinge.kind.counts().0));
    let channels = |names: fn(&HingeKind) -> Names, units: [&str; 2]| -> Vec<Channel> {
        let of_body = |body: &&Body| {
            let owner = body.name.clone();
            let of_hinge = names(&body.hinge.kind).iter().map(move |(name, unit)| Channel {
                body: owner.clone(),
                name: (*name).to_owned(),
                unit: (*unit).to_owned(),
            });
            of_hinge.chain(strains(model, body, units)).chain(modal(model, body, units)).collect::<Vec<_>>()
        };
        by_position.iter().flat_map(of_body).collect()
    };
    let springs = model.forces.iter().filter_map(|force| line(model, &force.name, force.law.picture()));
    let rods = model.loops.iter().filter_map(|closed| rod(model, closed));
    Scene {
        title: model.title.clone(),
        bodies: bodies(model),
        lines: springs.chain(rods).chain(model.modals.iter().flat_map(arms)).chain(guides::lines(model)).collect(),
        bushings: model.forces.iter().filter_map(|force| bushing(model, &force.name, force.law.picture())).collect(),
        beams: model.beams.iter().map(|one| beam(model, one)).collect(),
        curves: guides::curves(model),
        loads: model.forces.iter().filter_map(|force| load(model, &force.name, force.law.picture())).collect(),
        positions: channels(HingeKind::positions, ["m", "rad"]),
        velocities: channels(HingeKind::velocities, ["m/s", "rad/s"]),
        couplings: super::couplings::channels(model),
        outputs: outputs(model),
        not_unique: super::couplings::not_unique(model),
        watched: !(model.stops.is_empty() && model.hinge_friction.is_empty() && model.events.is_empty())
            || model.switching().next().is_some(),
        extent: Some(extent(model)),
    }
}

/// How large it is.
pub(in crate::simulate) fn extent(model: &Model) -> Extent {
    let length = model.length_scale();
    Extent {
        bodies: model.bodies.iter().filter(|body| !body.is_inner).count(),
        freedoms: model.degrees_of_freedom(),
        length,
        weight: model.total_mass() * model.gravity.norm() * length.max(1.0),
    }
}

/// All bodies; those of a beam are points of its centre line, for viewers that know no beams, those of a modal body its
/// interfaces.
fn bodies(model: &Model) -> Vec<BodyPicture> {
    let length = model.length_scale();
    let slab = [GROUND * length + BEYOND * footprint(model), THIN * length];
    let mut pictures: Vec<_> = model.bodies.iter().map(|body| picture(body, slab)).collect();
    for modal in &model.modals {
        let length = modal.modal.tips.iter().map(|tip| tip.place.norm()).fold(modal.modal.center().norm(), f64::max);
        // What is drawn of the root is its shapes, if it has some: rods to its markers would show where the interfaces were.
        let is_bare = |body: &&usize| pictures[**body].shapes.is_empty();
        let bodies = [modal.root, modal.inner];
        let all: Vec<usize> = bodies.iter().chain(&modal.tips).filter(is_bare).copied().collect();
        all.into_iter().for_each(|body| pictures[body].shapes = vec![ball(MODAL_POINT * length)]);
    }
    for beam in &model.beams {
        let point = ball(thickness(model, beam));
        for body in std::iter::once(beam.begin).chain(beam.elements.iter().map(|element| element.body)) {
            pictures[body].shapes = vec![point.clone()];
        }
    }
    pictures
}

/// How far the root markers of the bodies are from the middles of planes at the start, along these planes (m); 0 without planes.
fn footprint(model: &Model) -> f64 {
    let mut planes = Vec::new();
    for body in &model.bodies {
        let of_body = body.shapes.iter().filter(|shape| shape.visible);
        planes.extend(of_body.filter_map(|shape| match &shape.geometry {
            Geometry::Plane(normal) => Some((body, shape.pose, normal.normalize())),
            _ => None,
        }));
    }
    if planes.is_empty() {
        return 0.0;
    }
    let mut motion = Motion::new(model);
    motion.update(model, &model.start_position, &vec![0.0; model.velocity_count()]);
    let places: Vec<Point3<f64>> =
        model.bodies.iter().map(|body| motion.body_pose(body).translation.vector.into()).collect();
    let of_plane = |(body, pose, normal): &(&Body, Pose, Vector3<f64>)| {
        let plane = motion.body_pose(body) * pose;
        let aside = |place: &Point3<f64>| {
            let way = plane.inverse_transform_point(place).coords;
            (way - way.dot(normal) * normal).norm()
        };
        places.iter().map(aside).filter(|far| far.is_finite()).fold(0.0, f64::max)
    };
    planes.iter().map(of_plane).fold(0.0, f64::max)
}

/// A ball about the root marker of its body.
fn ball(radius: f64) -> ShapePicture {
    ShapePicture {
        kind: "sphere".to_owned(),
        size: vec![radius],
        file: None,
        position: [0.0; 3],
        quaternion: [1.0, 0.0, 0.0, 0.0],
        color: None,
    }
}

/// How often a beam goes around without strain: one that is wound up is that much smaller than it is long.
fn turns(model: &Model, beam: &Beam) -> f64 {
    let turned = |element: &BeamElement| {
        let rod = &model.rods[element.rod];
        rod.turned(&vec![0.0; rod.count()])[1]
    };
    beam.elements.iter().map(turned).sum::<f64>() / std::f64::consts::TAU
}

/// A beam is drawn by its sections; one without a size as a wire.
fn beam(model: &Model, beam: &Beam) -> BeamPicture {
    let element = |element: &BeamElement| {
        let rod = &model.rods[element.rod];
        ElementPicture {
            body: element.body,
            from: element.from,
            length: rod.length,
            degree: beam.degree,
            free: rod.free_strains().collect(),
            reference: rod.reference().iter().map(|of| (*of).into()).collect(),
        }
    };
    let section = |(at, section): &(f64, Section)| {
        let (kind, size) = match *section {
            Section::Circle { radius } => ("circle", vec![radius]),
            Section::Tube { outer, inner } => ("tube", vec![outer, inner]),
            Section::Rectangle { width, height } => ("rectangle", vec![width, height]),
            Section::Stiffness(_) => ("wire", vec![thickness(model, beam)]),
        };
        SectionPicture { at: *at, kind: kind.to_owned(), size }
    };
    BeamPicture {
        name: beam.name.clone(),
        begin: beam.begin,
        elements: beam.elements.iter().map(element).collect(),
        sections: beam.sections.iter().map(section).collect(),
    }
}

/// The radius that a beam without a size is drawn with (m).
fn thickness(model: &Model, beam: &Beam) -> f64 {
    let part = if beam.is_cable { CABLE_POINT } else { POINT };
    part * beam.length / (1.0 + turns(model, beam))
}

/// A modal body is drawn as lines from its root to its other interfaces.
fn arms(modal: &ModalBody) -> impl Iterator<Item = LinePicture> + '_ {
    modal.tips.iter().zip(&modal.modal.tips).map(|(body, tip)| LinePicture {
        name: format!("{}.{}", modal.name, tip.name),
        ends: vec![(Some(modal.root), [0.0; 3]), (Some(*body), [0.0; 3])],
        ..LinePicture::default()
    })
}

/// The channels of the coordinates of a modal body, if a body has those: displacements and turns of its interfaces, amplitudes of
/// its modes.
fn modal(model: &Model, body: &Body, [length, angle]: [&str; 2]) -> Vec<Channel> {
    let Some(modal) = model.links[body.link].joint.modal().filter(|_| body.is_element) else { return Vec::new() };
    let channel = |(name, is_length): &(String, bool)| Channel {
        body: body.name.clone(),
        name: name.clone(),
        unit: if *is_length { length } else { angle }.to_owned(),
    };
    model.modals[modal].modal.coordinates.iter().map(channel).collect()
}

/// One channel for each coordinate of the flexible element that ends at a body, if one does: `bend_y_0` is the mean, `bend_y_1`
/// changes sign in the middle.
fn strains(model: &Model, body: &Body, [length, angle]: [&str; 2]) -> Vec<Channel> {
    const NAMES: [&str; 6] = ["stretch", "shear_y", "shear_z", "twist", "bend_y", "bend_z"];
    let rod = model.links[body.link].joint.rod().filter(|_| body.is_element);
    let Some(rod) = rod.map(|rod| &model.rods[rod]) else { return Vec::new() };
    let free = rod.free_strains().count();
    let channel = |i: usize| Channel {
        body: body.name.clone(),
        name: format!("{}_{}", NAMES[rod.strain_of(i)], i / free),
        unit: if rod.strain_of(i) < 3 { length } else { angle }.to_owned(),
    };
    (0..rod.count()).map(channel).collect()
}

/// One channel for each number of the outputs.
fn outputs(model: &Model) -> Vec<Channel> {
    let of_output = |output: &Output| {
        let labels = output.labels().zip(output.units.clone());
        labels.map(|(name, unit)| Channel { body: String::new(), name, unit }).collect::<Vec<_>>()
    };
    model.outputs.iter().flat_map(of_output).collect()
}

fn picture(body: &Body, slab: [f64; 2]) -> BodyPicture {
    let i = &body.mass.inertia;
    let turn = body.hinge.parent_from_hinge.rotation;
    BodyPicture {
        name: body.name.clone(),
        parent: body.parent,
        mass: body.mass.mass,
        center: body.mass.center.into(),
        inertia: [i.m11, i.m22, i.m33, i.m12, i.m13, i.m23],
        markers: body.markers.iter().map(|(name, at)| (name.clone(), (*at).into())).collect(),
        shapes: body.shapes.iter().filter(|one| one.visible).map(|one| shape(one, slab)).collect(),
        hinge: body.hinge.kind.name().to_owned(),
        hinge_axes: body.hinge.kind.axes().iter().map(|axis| (turn * axis.normalize()).into()).collect(),
        hinge_at: body.hinge.parent_from_hinge.translation.vector.into(),
        own_axes: body.hinge.kind.axes().iter().map(|axis| axis.normalize().into()).collect(),
    }
}

/// A plane is a slab, so long and so thick (m), whose upper face it is.
fn shape(shape: &Shape, [reach, thick]: [f64; 2]) -> ShapePicture {
    let mut pose = shape.pose;
    if let Geometry::Plane(normal) = &shape.geometry {
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), normal)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        pose *= turn * Translation3::new(0.0, 0.0, -0.5 * thick);
    }
    let (kind, size, file) = match &shape.geometry {
        Geometry::Box(edges) => ("box", vec![edges.x, edges.y, edges.z], None),
        Geometry::Sphere(radius) => ("sphere", vec![*radius], None),
        Geometry::Cylinder { radius, length } => ("cylinder", vec![*radius, *length], None),
        Geometry::Capsule { radius, length } => ("capsule", vec![*radius, *length], None),
        Geometry::Plane(_) => ("plane", vec![reach, reach, thick], None),
        Geometry::Mesh { file, scale, .. } => {
            ("mesh", vec![scale.x, scale.y, scale.z], Some(file.display().to_string()))
        }
    };
    let turn = pose.rotation;
    ShapePicture {
        kind: kind.to_owned(),
        size,
        file,
        position: pose.translation.vector.into(),
        quaternion: [turn.w, turn.i, turn.j, turn.k],
        color: shape.color,
    }
}

/// Lines are drawn between the named bodies they are attached to.
fn line(model: &Model, name: &str, picture: Picture<'_>) -> Option<LinePicture> {
    let Picture::Line { through, kind } = picture else { return None };
    let ends = through.iter().map(|end| (end.body, on_body(model, end))).collect();
    let line = LinePicture { name: name.to_owned(), ends, ..LinePicture::default() };
    Some(match kind {
        LineKind::Spring { stiffness, length } => LinePicture { spring: Some([stiffness, length]), ..line },
        LineKind::Curved { length } => LinePicture { coil: Some(length), ..line },
        LineKind::Damper => LinePicture { is_damper: true, ..line },
        LineKind::Rope { stiffness, length } => {
            LinePicture { spring: Some([stiffness, length]), pulls_only: true, ..line }
        }
    })
}

/// The frames of bushings are given in the axes of the named bodies that they join.
fn bushing(model: &Model, name: &str, picture: Picture<'_>) -> Option<BushingPicture> {
    let Picture::Block { ends, frames, stiffness } = picture else { return None };
    let on_ground = UnitQuaternion::identity();
    let frame = |k: usize| {
        let body_from_link = |body: usize| model.bodies[body].link_from_body.rotation.inverse();
        let link_from_frame = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frames[k]));
        let turn = ends[k].body.map_or(on_ground, body_from_link) * link_from_frame;
        [turn.w, turn.i, turn.j, turn.k]
    };
    let ends = [0, 1].map(|k| (ends[k].body, on_body(model, &ends[k])));
    Some(BushingPicture { name: name.to_owned(), ends, frames: [frame(0), frame(1)], stiffness: (*stiffness).into() })
}

/// Rigid rods that close loops have no body that could be drawn.
fn rod(model: &Model, closed: &Loop) -> Option<LinePicture> {
    let Closure::Rod { .. } = closed.closure else { return None };
    let ends = closed.ends.iter().map(|end| (end.body, on_body(model, end))).collect();
    Some(LinePicture { name: closed.name.clone(), ends, ..LinePicture::default() })
}

/// A load on the ground moves nothing and is not drawn.
fn load(model: &Model, name: &str, picture: Picture<'_>) -> Option<LoadPicture> {
    let Picture::Arrows { on, force, torque, turns, over_time } = picture else { return None };
    let body = on.body?;
    let turn = if turns { model.bodies[body].link_from_body.rotation.inverse() } else { UnitQuaternion::identity() };
    let (force, torque) = ((turn * force).into(), (turn * torque).into());
    let factor = |over_time: &OverTime| FactorPicture {
        times: over_time.timeline.times.clone(),
        values: over_time.values.clone(),
    };
    let over_time = over_time.map(factor);
    Some(LoadPicture { name: name.to_owned(), body, at: on_body(model, on), force, torque, turns, over_time })
}

/// The point in the axes of its body.
fn on_body(model: &Model, end: &End) -> [f64; 3] {
    let point = match end.body {
        Some(body) => model.bodies[body].link_from_body.inverse() * Point3::from(end.point),
        None => Point3::from(end.point),
    };
    point.coords.into()
}
