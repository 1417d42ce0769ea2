//! What must not matter: where the world is, which way it is turned, and in which order it is described.

use super::{Start, scenes};
use crate::common::{Random, relative_difference};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use stillpoint::dynamics::System;
use stillpoint::model::Description;
use stillpoint::model::description::*;
use stillpoint::spatial::{Pose, Wrench};

/// Round-off, grown by the condition number (a hundred) of at most thirteen bodies.
const TOLERANCE: f64 = 1e-13;

fn poses(start: &Start) -> Vec<Pose> {
    let mut system = System::new(&start.model);
    let mut poses = Vec::new();
    system.at(0.0, &start.model.start_position, &start.model.start_velocity).poses(&mut poses);
    poses
}

/// The same scene with gravity, ground hinges, ground ends of force elements and loads fixed in space moved by `world`.
fn in_another_world(description: &Description, world: &Pose) -> Description {
    let mut moved = description.clone();
    moved.gravity = world.rotation * moved.gravity;
    for body in &mut moved.bodies {
        if body.hinge.parent == GROUND {
            let Point::At(at) = &mut body.hinge.at else { unreachable!("the ground has no markers") };
            *at = world.rotation * *at + world.translation.vector;
            body.hinge.frame = world.rotation * body.hinge.frame;
        }
    }
    for force in &mut moved.forces {
        match &mut force.kind {
            // A bushing is relaxed where the axes of its ends are parallel: the ground's axes must turn too.
            ForceKind::Rope(Rope { through, .. }) => {
                through.iter_mut().filter(|end| end.body == GROUND).for_each(|end| end.body = "laboratory".to_owned());
            }
            ForceKind::Spring(Spring { between, .. })
            | ForceKind::Bushing(Bushing { between, .. })
            | ForceKind::Curve(Curve { between, .. }) => {
                between.iter_mut().filter(|end| end.body == GROUND).for_each(|end| end.body = "laboratory".to_owned());
            }
            ForceKind::Load(Load { force, torque, axes: LoadAxes::Inertial, .. }) => {
                *force = world.rotation * *force;
                *torque = world.rotation * *torque;
            }
            ForceKind::Load(Load { axes: LoadAxes::Body, .. }) => {}
            ForceKind::Slider(_) => unreachable!("its scenes are in `sliders`"),
        }
    }
    let at = Point::At(world.translation.vector);
    moved.bodies.push(BodyDescription {
        name: "laboratory".to_owned(),
        mass: MassProperties { mass: 0.0, center: Vector3::zeros(), inertia: Matrix3::zeros() },
        markers: Vec::new(),
        shapes: Vec::new(),
        hinge: HingeDescription { at, frame: world.rotation, ..HingeDescription::new(HingeKind::Fixed) },
    });
    moved
}

/// The shift of a few metres costs no digit: moments are taken at the markers.
#[test]
fn turning_and_shifting_the_world_changes_nothing_within_it() {
    for (seed, description) in scenes() {
        let mut random = Random::new(seed);
        let world = Pose::from_parts(random.vector(5.0).into(), random.turn());
        let (here, there) = (Start::of(&description), Start::of(&in_another_world(&description, &world)));
        assert!(relative_difference(&there.a, &here.a) < TOLERANCE, "seed {seed}");
        let turned = |wrench: &Wrench| [world.rotation * wrench.force, world.rotation * wrench.moment];
        let plain = |wrench: &Wrench| [wrench.force, wrench.moment];
        let flat =
            |list: Vec<[Vector3<f64>; 2]>| list.concat().iter().flat_map(|v| [v.x, v.y, v.z]).collect::<Vec<_>>();
        let expected = flat(here.reactions.iter().map(turned).collect());
        let found = flat(there.reactions.iter().take(here.reactions.len()).map(plain).collect());
        assert!(relative_difference(&found, &expected) < TOLERANCE, "seed {seed}");
        for (here, there) in poses(&here).iter().zip(poses(&there)) {
            let gap = (world * here).inverse() * there;
            assert!(gap.translation.vector.norm() + gap.rotation.angle() < 1e-12, "seed {seed}");
        }
    }
}

/// A kilometre away as at the origin: the sweeps never take moments about the origin, so only the positions themselves
/// lose digits there, 1e-16 × 1 km = 1e-13 m, which springs to the ground turn into forces. Moments about the origin
/// would lose the square of the distance, six digits.
#[test]
fn a_kilometre_from_the_origin_accelerations_are_the_same() {
    for (seed, description) in scenes() {
        let away = Pose::from_parts(Vector3::new(600.0, -800.0, 50.0).into(), UnitQuaternion::identity());
        let (here, there) = (Start::of(&description), Start::of(&in_another_world(&description, &away)));
        let error = relative_difference(&there.a, &here.a);
        assert!(error < 1e-11, "seed {seed}: {error:e}");
    }
}

#[test]
fn the_order_of_the_description_does_not_matter() {
    for (seed, description) in scenes() {
        let mut random = Random::new(seed);
        let mut shuffled = description.clone();
        for last in (1..shuffled.bodies.len()).rev() {
            shuffled.bodies.swap(last, random.below(last + 1));
        }
        for last in (1..shuffled.forces.len()).rev() {
            shuffled.forces.swap(last, random.below(last + 1));
        }
        let (first, second) = (Start::of(&description), Start::of(&shuffled));
        let (mut found, mut expected) = (Vec::new(), Vec::new());
        let (mut carried, mut to_carry) = (Vec::new(), Vec::new());
        for body in &description.bodies {
            found.extend_from_slice(second.of_hinge(&body.name));
            expected.extend_from_slice(first.of_hinge(&body.name));
            let (second, first) = (second.reaction(&body.name), first.reaction(&body.name));
            carried.extend(second.force.iter().chain(&second.moment));
            to_carry.extend(first.force.iter().chain(&first.moment));
        }
        assert_eq!(found.len(), first.a.len());
        assert!(relative_difference(&found, &expected) < TOLERANCE, "seed {seed}");
        assert!(relative_difference(&carried, &to_carry) < TOLERANCE, "seed {seed}");
    }
}
