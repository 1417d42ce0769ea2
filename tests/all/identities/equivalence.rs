//! Two descriptions of the same thing: a body in two welded halves, a hinge as a chain of simpler ones.

use super::{Start, scenes};
use crate::common::{Random, relative_difference};
use crate::oracle::place::{named, point_in_body};
use nalgebra::{Matrix3, Vector3};
use stillpoint::model::Description;
use stillpoint::model::description::*;
use stillpoint::spatial::Pose;

/// Round-off, grown by the condition number (a hundred) of at most thirteen bodies.
const TOLERANCE: f64 = 1e-13;

/// Divides a body into two halves that overlap: masses in any proportion, centres a little apart, one welded to the
/// other at some point with axes of its own. What hung on the body or pulled at it is shared among them.
fn halved(description: &Description, index: usize, random: &mut Random) -> Description {
    let mut halved = description.clone();
    let whole = description.bodies[index].mass;
    let share = random.between(0.2, 0.8);
    // At most 0.17 m apart: the inertias that are left are those of bodies (the random ones have a spread of 0.02 kg m²
    // and more in every direction, the halves a reduced mass of at most 0.5 kg).
    let apart = random.vector(0.1);
    let between =
        share * (1.0 - share) * whole.mass * (apart.norm_squared() * Matrix3::identity() - apart * apart.transpose());
    let left = whole.inertia - between;
    let weld = Pose::from_parts(random.vector(0.4).into(), random.turn());
    let turn = weld.rotation.to_rotation_matrix().into_inner();
    halved.bodies[index].mass = MassProperties {
        mass: share * whole.mass,
        center: whole.center - (1.0 - share) * apart,
        inertia: share * left,
    };
    let center = weld.inverse() * nalgebra::Point3::from(whole.center + share * apart);
    let inertia = (1.0 - share) * turn.transpose() * left * turn;
    let name = &description.bodies[index].name;
    let other = format!("other half of {name}");
    let hinge = HingeDescription {
        parent: name.clone(),
        at: Point::At(weld.translation.vector),
        frame: weld.rotation,
        ..HingeDescription::new(HingeKind::Fixed)
    };
    let on_other = |point: &Point| {
        let at = point_in_body(description, named(description, name), point);
        Point::At((weld.inverse() * nalgebra::Point3::from(at)).coords)
    };
    for body in halved.bodies.iter_mut().filter(|body| body.hinge.parent == *name) {
        if random.below(2) == 0 {
            body.hinge.parent.clone_from(&other);
            body.hinge.at = on_other(&body.hinge.at);
            body.hinge.frame = weld.rotation.inverse() * body.hinge.frame;
        }
    }
    let mut share_out = |end: &mut Attachment| {
        let moves = end.body == *name && random.below(2) == 0;
        if moves {
            *end = Attachment { body: other.clone(), point: on_other(&end.point) };
        }
        moves
    };
    for force in &mut halved.forces {
        match &mut force.kind {
            ForceKind::Spring(Spring { between, .. }) | ForceKind::Curve(Curve { between, .. }) => {
                for end in between {
                    share_out(end);
                }
            }
            ForceKind::Rope(Rope { through, .. }) => {
                for end in through {
                    share_out(end);
                }
            }
            ForceKind::Load(Load { on, force, torque, axes, .. }) => {
                if share_out(on) && *axes == LoadAxes::Body {
                    *force = weld.rotation.inverse() * *force;
                    *torque = weld.rotation.inverse() * *torque;
                }
            }
            // Relaxed where the axes of both bodies are parallel: it stays where the axes are.
            ForceKind::Bushing(_) => {}
            ForceKind::Slider(_) => unreachable!("its scenes are in `sliders`"),
        }
    }
    halved.bodies.push(BodyDescription {
        name: other,
        mass: MassProperties {
            mass: (1.0 - share) * whole.mass,
            center: center.coords,
            inertia: 0.5 * (inertia + inertia.transpose()),
        },
        markers: Vec::new(),
        shapes: Vec::new(),
        hinge,
    });
    halved
}

#[test]
fn a_body_and_its_two_halves_welded_together_move_alike() {
    for (seed, description) in scenes() {
        let mut random = Random::new(seed);
        let index = random.below(description.bodies.len());
        let (whole, halves) = (Start::of(&description), Start::of(&halved(&description, index, &mut random)));
        let all = |start: &Start| -> Vec<f64> {
            description.bodies.iter().flat_map(|body| start.of_hinge(&body.name).to_vec()).collect()
        };
        assert!(relative_difference(&all(&halves), &all(&whole)) < TOLERANCE, "seed {seed}");
        assert_same_reactions(&description, &halves, &whole, seed);
    }
}

/// The hinges of the named bodies carry the same, relative to the largest.
fn assert_same_reactions(description: &Description, found: &Start, expected: &Start, seed: u64) {
    let all = |start: &Start| -> Vec<f64> {
        let reactions = description.bodies.iter().map(|body| start.reaction(&body.name));
        reactions.flat_map(|wrench| [wrench.force, wrench.moment]).flat_map(|v| [v.x, v.y, v.z]).collect()
    };
    let error = relative_difference(&all(found), &all(expected));
    assert!(error < TOLERANCE, "seed {seed}: {error:e}");
}

/// A hinge of a chain, and which coordinate and velocity of the whole it begins with.
struct Part {
    kind: HingeKind,
    position: usize,
    velocity: usize,
}

/// The elementary hinges that a hinge is a chain of. Where it can be, they are in another order than that of the
/// coordinates: slides commute, and so do a slide and a turn along one axis.
fn chain(kind: &HingeKind) -> Vec<Part> {
    let plain = |kind: HingeKind, at: usize| Part { kind, position: at, velocity: at };
    let slide = |axis: Vector3<f64>, at: usize| plain(HingeKind::Prismatic { axis }, at);
    let turn = |axis: Vector3<f64>, at: usize| plain(HingeKind::Revolute { axis }, at);
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
    match *kind {
        HingeKind::Cylindrical { axis } => vec![turn(axis, 1), slide(axis, 0)],
        HingeKind::Universal { axes } => vec![turn(axes[0], 0), turn(axes[1], 1)],
        HingeKind::Planar => vec![slide(y, 1), slide(x, 0), turn(z, 2)],
        HingeKind::Free => vec![slide(z, 2), slide(x, 0), slide(y, 1), plain(HingeKind::Spherical, 3)],
        simple => vec![plain(simple, 0)],
    }
}

/// The hinge of one link of a chain; the first one's when it has no link before it.
fn part_of(hinge: &HingeDescription, part: &Part, before: Option<String>) -> HingeDescription {
    let (positions, velocities) = part.kind.counts();
    let cut = |list: &[f64], from: usize, count: usize| list.get(from..from + count).unwrap_or(&[]).to_vec();
    let own = HingeDescription {
        position: cut(&hinge.position, part.position, positions),
        rest: cut(&hinge.rest, part.position, positions),
        velocity: cut(&hinge.velocity, part.velocity, velocities),
        stiffness: cut(&hinge.stiffness, part.velocity, velocities),
        damping: cut(&hinge.damping, part.velocity, velocities),
        armature: cut(&hinge.armature, part.velocity, velocities),
        force: cut(&hinge.force, part.velocity, velocities),
        ..HingeDescription::new(part.kind)
    };
    match before {
        Some(parent) => HingeDescription { parent, ..own },
        None => HingeDescription { parent: hinge.parent.clone(), at: hinge.at.clone(), frame: hinge.frame, ..own },
    }
}

/// The name of a link of a chain: the last one is the body itself.
fn link_name(body: &BodyDescription, step: usize) -> String {
    if step + 1 == chain(&body.hinge.kind).len() { body.name.clone() } else { format!("{} {step}", body.name) }
}

/// Every hinge of one kind as its chain, with bodies without mass between the elementary hinges.
fn taken_apart(description: &Description, kind_name: &str) -> Description {
    let mut apart = Description { bodies: Vec::new(), ..description.clone() };
    for body in &description.bodies {
        if body.hinge.kind.name() != kind_name {
            apart.bodies.push(body.clone());
            continue;
        }
        let parts = chain(&body.hinge.kind);
        for (step, part) in parts.iter().enumerate() {
            let before = step.checked_sub(1).map(|before| link_name(body, before));
            let hinge = part_of(&body.hinge, part, before);
            let mut link = BodyDescription { name: link_name(body, step), hinge, ..body.clone() };
            if step + 1 < parts.len() {
                link.mass = MassProperties { mass: 0.0, center: Vector3::zeros(), inertia: Matrix3::zeros() };
            }
            apart.bodies.push(link);
        }
    }
    apart
}

/// In every scene that has such a hinge.
fn assert_hinge_is_its_chain(kind_name: &str) {
    let mut count = 0;
    for (seed, description) in scenes() {
        let (whole, apart) = (Start::of(&description), Start::of(&taken_apart(&description, kind_name)));
        let (mut found, mut expected) = (Vec::new(), Vec::new());
        for body in &description.bodies {
            let first = expected.len();
            expected.extend_from_slice(whole.of_hinge(&body.name));
            if body.hinge.kind.name() == kind_name {
                count += 1;
                found.resize(expected.len(), f64::NAN);
                for (step, part) in chain(&body.hinge.kind).iter().enumerate() {
                    let at = first + part.velocity;
                    let own = apart.of_hinge(&link_name(body, step));
                    found[at..at + own.len()].copy_from_slice(own);
                }
            } else {
                found.extend_from_slice(apart.of_hinge(&body.name));
            }
        }
        assert!(relative_difference(&found, &expected) < TOLERANCE, "seed {seed}");
        assert_same_reactions(&description, &apart, &whole, seed);
    }
    assert!(count > 30, "{count}");
}

#[test]
fn a_cylindrical_hinge_is_a_turn_and_a_slide_along_the_same_axis() {
    assert_hinge_is_its_chain("cylindrical");
}

#[test]
fn a_universal_hinge_is_two_turns_with_a_massless_cross_between_them() {
    assert_hinge_is_its_chain("universal");
}

#[test]
fn a_planar_hinge_is_two_slides_and_a_turn() {
    assert_hinge_is_its_chain("planar");
}

#[test]
fn a_free_hinge_is_three_slides_and_a_ball() {
    assert_hinge_is_its_chain("free");
}
