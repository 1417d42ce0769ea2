//! The kinds of hinge: what each says of itself agrees with how it moves.

use crate::common::{Random, hinge_kind, position_of};
use nalgebra::{Isometry3, Matrix6, Translation3, UnitQuaternion, Vector3, Vector6};
use stillpoint::hinge::{Condition, DECLARED, Joint};
use stillpoint::model::Model;
use stillpoint::model::description::{BodyDescription, Description, HingeDescription, HingeKind};
use stillpoint::motion::Motion;

/// Random hinges on the ground, at random coordinates, with the pose of their body.
fn cases(count: u64) -> impl Iterator<Item = (HingeKind, Isometry3<f64>)> {
    (0..count).map(|seed| {
        let random = &mut Random::new(seed);
        let kind = hinge_kind(random, true);
        let mut hinge = HingeDescription::new(kind);
        hinge.position = position_of(random, &kind);
        let body = BodyDescription::new("body", hinge).mass(1.0).center(random.vector(0.2)).inertia([0.1; 3]);
        let model = Model::build(&Description::new("").body(body)).unwrap();
        let mut motion = Motion::new(&model);
        motion.update(&model, &model.start_position, &model.start_velocity);
        (kind, motion.body_pose(&model.bodies[0]))
    })
}

fn residual(condition: &Condition, pose: &Isometry3<f64>) -> f64 {
    match condition {
        Condition::Along(axis) => axis.dot(&pose.translation.vector),
        Condition::Aligned { first, second, cosine } => first.dot(&(pose.rotation * second)) - cosine,
        Condition::Thread { axis, pitch, .. } => {
            let angle = 2.0 * pose.rotation.imag().dot(axis).atan2(pose.rotation.w);
            let (off, lead) = (axis.dot(&pose.translation.vector) - pitch * angle, std::f64::consts::TAU * pitch);
            off - lead * (off / lead).round()
        }
    }
}

/// As a loop a hinge forbids what it does not let a body do, and nothing else: its conditions hold wherever its coordinates
/// take the body, and their gradients span all but as many directions as it has velocities.
#[test]
fn conditions_of_loops_leave_the_motions_of_the_tree() {
    for (seed, (kind, pose)) in cases(400).enumerate() {
        let conditions = kind.conditions();
        for condition in &conditions {
            let left = residual(condition, &pose);
            assert!(left.abs() < 1e-13, "{seed}: {kind:?}: {condition:?} leaves {left}");
        }
        let mut gradients = Matrix6::zeros();
        for (row, condition) in conditions.iter().enumerate() {
            for column in 0..6 {
                // Central differences: errors of some 1e-10 beside gradients of size one.
                let at = |step: f64| {
                    let by = Vector6::ith(column, step);
                    let turn = UnitQuaternion::from_scaled_axis(by.fixed_rows::<3>(3).into_owned());
                    let shift = Translation3::from(pose.translation.vector + by.fixed_rows::<3>(0));
                    residual(condition, &Isometry3::from_parts(shift, turn * pose.rotation))
                };
                gradients[(row, column)] = (at(1e-6) - at(-1e-6)) / 2e-6;
            }
        }
        let (_, velocities) = kind.counts();
        assert_eq!(gradients.rank(1e-6), 6 - velocities, "{seed}: {kind:?}");
        assert_eq!(conditions.len(), 6 - velocities, "{seed}: {kind:?}");
    }
}

/// What both frames share stays shared.
#[test]
fn shared_directions_do_not_turn() {
    for (seed, (kind, pose)) in cases(400).enumerate() {
        for shared in kind.shared() {
            let apart = (pose.rotation * shared - shared).norm();
            assert!(apart < 1e-13 * shared.norm().max(1.0), "{seed}: {kind:?}: {apart}");
        }
    }
}

/// Names and units, coordinates of the elementary joints and what files declare: one count each.
#[test]
fn counts_agree() {
    for (seed, (kind, _)) in cases(200).enumerate() {
        let joints = kind.elementary(&[]);
        let sum = |of: fn(&Joint) -> usize| joints.iter().map(|(joint, _)| of(joint)).sum::<usize>();
        let counts = (sum(|joint| joint.counts().0), sum(|joint| joint.counts().1));
        assert_eq!(kind.counts(), counts, "{seed}: {kind:?}");
        assert_eq!(kind.plain_coordinates(), sum(|joint| usize::from(joint.is_scalar())), "{seed}: {kind:?}");
        // Each plain coordinate has the unit of its joint, and its velocity the same per second.
        let plain = joints.iter().filter(|(joint, _)| joint.is_scalar());
        for (i, (joint, _)) in plain.enumerate() {
            let unit = if joint.is_slide() { "m" } else { "rad" };
            assert_eq!((kind.positions()[i].1, kind.velocities()[i].1), (unit, &*format!("{unit}/s")), "{kind:?}");
        }
        let declared = DECLARED.iter().find(|declared| declared.name == kind.name()).unwrap();
        assert_eq!(declared.velocities, counts.1);
        assert_eq!(declared.closes.is_some(), !kind.conditions().is_empty(), "{kind:?}");
    }
}

/// An axis without direction is refused with the name of its owner, in trees and in loops alike.
#[test]
fn axes_without_direction_are_refused() {
    let (good, zero, infinite) = (Vector3::x(), Vector3::zeros(), Vector3::new(0.0, f64::INFINITY, 0.0));
    for bad in [zero, infinite, Vector3::repeat(f64::NAN)] {
        let kinds = [
            HingeKind::Revolute { axis: bad },
            HingeKind::Prismatic { axis: bad },
            HingeKind::Screw { axis: bad, pitch: 0.01 },
            HingeKind::Cylindrical { axis: bad },
            HingeKind::Universal { axes: [bad, good] },
            HingeKind::Universal { axes: [good, bad] },
            HingeKind::Universal { axes: [good, -2.0 * good] },
        ];
        for kind in kinds {
            let mut found = Vec::new();
            kind.check("hinge of `arm`", &mut |key, message, _| found.push((key, message)));
            let [(key, message)] = &found[..] else { panic!("{kind:?}: {found:?}") };
            let universal = matches!(kind, HingeKind::Universal { .. });
            assert_eq!(*key, if universal { "axes" } else { "axis" });
            assert!(message.contains("hinge of `arm`"), "{message}");
        }
    }
}
