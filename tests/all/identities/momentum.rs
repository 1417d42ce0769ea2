//! Momentum, action and reaction.

use super::{Start, scenes};
use crate::common::position_of;
use crate::common::{Options, Random, random_scene, relative_difference};
use crate::oracle::force::{Push, pushes};
use crate::oracle::place::{Placed, place};
use nalgebra::Vector3;
use stillpoint::dynamics::System;
use stillpoint::dynamics::applied;
use stillpoint::force::Describe;
use stillpoint::model::Description;
use stillpoint::model::Model;
use stillpoint::model::description::{Attachment, ForceKind, GROUND, HingeDescription, HingeKind};
use stillpoint::spatial::Wrench;

/// Force (or momentum) and moment (or angular momentum) about the origin.
fn about_origin(force: Vector3<f64>, moment: Vector3<f64>, at: &Vector3<f64>) -> Wrench {
    Wrench { force, moment: moment + at.cross(&force) }
}

fn numbers(wrench: &Wrench) -> Vec<f64> {
    wrench.force.iter().chain(&wrench.moment).copied().collect()
}

/// Momentum and angular momentum about the origin of every named body, welded ones too.
fn momenta(system: &mut System, q: &[f64], v: &[f64]) -> Vec<Wrench> {
    let at = system.at(0.0, q, v);
    let mut poses = Vec::new();
    at.poses(&mut poses);
    let of_body = |(body, pose): (&stillpoint::model::Body, &stillpoint::spatial::Pose)| {
        let link = &at.motion().links[body.link];
        let center = pose.translation.vector + pose.rotation * body.mass.center;
        let velocity = link.velocity + link.angular_velocity.cross(&(center - link.position));
        let own = pose.rotation.inverse() * link.angular_velocity;
        about_origin(body.mass.mass * velocity, pose.rotation * (body.mass.inertia * own), &center)
    };
    at.system().model().bodies.iter().zip(&poses).map(of_body).collect()
}

fn placed(description: &Description) -> Vec<Placed> {
    (0..description.bodies.len()).map(|index| place(description, Some(index))).collect()
}

/// Weights and force elements on one body, about the origin.
fn applied(description: &Description, placed: &[Placed], body: usize) -> Wrench {
    let weight = description.bodies[body].mass.mass * description.gravity;
    let mut sum = about_origin(weight, Vector3::zeros(), &placed[body].center);
    let on_body = |push: &Push| push.body == Some(body);
    for push in pushes(description, placed).into_iter().filter(on_body) {
        sum += about_origin(push.force, push.torque, &push.at);
    }
    sum
}

/// Tolerance: the error of the differences (see [`Start::rate`]), relative to the largest force or moment at work.
#[test]
fn every_body_gains_what_its_hinge_gives_less_what_it_passes_on() {
    for (seed, description) in scenes() {
        let start = Start::of(&description);
        let rates = start.rate(|system, q, v| momenta(system, q, v).iter().flat_map(numbers).collect());
        let placed = placed(&description);
        let hinge = |index: usize| {
            let reaction = start.reactions[index];
            about_origin(reaction.force, reaction.moment, &placed[index].position)
        };
        let mut expected = Vec::new();
        for (index, body) in description.bodies.iter().enumerate() {
            let mut sum = applied(&description, &placed, index) + hinge(index);
            for (child, given) in description.bodies.iter().enumerate() {
                if given.hinge.parent == body.name {
                    sum = sum - hinge(child);
                }
            }
            expected.extend(numbers(&sum));
        }
        let error = relative_difference(&rates, &expected);
        assert!(error < 1e-9, "seed {seed}: {error:e}");
    }
}

/// The same for the scene as a whole: the ground gives what the hinges on it carry and what force elements on it pull.
#[test]
fn total_momentum_grows_by_weights_loads_and_what_the_ground_gives() {
    for (seed, description) in scenes() {
        let start = Start::of(&description);
        let rates = start.rate(|system, q, v| {
            numbers(&momenta(system, q, v).into_iter().fold(Wrench::ZERO, |sum, momentum| sum + momentum))
        });
        let placed = placed(&description);
        let mut sum = Wrench::ZERO;
        for (index, body) in description.bodies.iter().enumerate() {
            sum += about_origin(body.mass.mass * description.gravity, Vector3::zeros(), &placed[index].center);
            if body.hinge.parent == GROUND {
                let reaction = start.reactions[index];
                sum += about_origin(reaction.force, reaction.moment, &placed[index].position);
            }
        }
        for force in &description.forces {
            let alone = Description { forces: vec![force.clone()], ..description.clone() };
            for push in pushes(&alone, &placed) {
                let load = matches!(force.kind, ForceKind::Load(_));
                let sign = if load { 1.0 } else { -1.0 };
                if load || push.body.is_none() {
                    sum += about_origin(sign * push.force, sign * push.torque, &push.at);
                }
            }
        }
        let error = relative_difference(&rates, &numbers(&sum));
        assert!(error < 1e-9, "seed {seed}: {error:e}");
    }
}

/// Round-off of one sum per element.
#[test]
fn springs_and_bushings_pull_both_ends_alike() {
    for (seed, mut description) in scenes() {
        description.forces.retain(|force| !matches!(force.kind, ForceKind::Load(_)));
        let start = Start::of(&description);
        let mut system = System::new(&start.model);
        let at = system.at(0.0, &start.model.start_position, &start.model.start_velocity);
        let placed = placed(&description);
        for (index, force) in start.model.forces.iter().enumerate() {
            let mut alone = Model::clone(&start.model);
            alone.forces = [force.clone()].into();
            let mut wrenches = vec![Wrench::ZERO; alone.links.len()];
            applied::apply(&applied::Laws::new(&alone), at.motion(), &mut wrenches);
            let mut sum = Wrench::ZERO;
            for (wrench, link) in wrenches.iter().zip(&at.motion().links) {
                sum += about_origin(wrench.force, wrench.moment, &link.position);
            }
            let alone = Description { forces: vec![description.forces[index].clone()], ..description.clone() };
            let of_one_end = &pushes(&alone, &placed)[0];
            let end = about_origin(of_one_end.force, of_one_end.torque, &of_one_end.at);
            let size = end.force.norm() + end.moment.norm();
            assert!(size > 0.0, "seed {seed}");
            assert!(sum.force.norm() + sum.moment.norm() < 1e-13 * size, "seed {seed}, {}", force.name);
        }
    }
}

/// A tree on a free hinge that only its own springs and bushings hold together.
fn adrift(seed: u64) -> Description {
    let options = Options { bodies: 2 + (seed as usize) % 10, springs: true, welds: true };
    let mut description = random_scene(seed + 9000, &options);
    let mut random = Random::new(seed);
    for index in 0..description.bodies.len() {
        let hinge = &mut description.bodies[index].hinge;
        if index == 0 {
            let position = position_of(&mut random, &HingeKind::Free);
            let velocity = random.list(6, -2.0, 2.0);
            *hinge = HingeDescription { position, velocity, ..HingeDescription::new(HingeKind::Free) };
        } else if hinge.parent == GROUND {
            hinge.parent = "b0".to_owned();
        }
    }
    let grounded = |end: &Attachment| end.body == GROUND;
    description.forces.retain(|force| match &force.kind {
        ForceKind::Load(_) => false,
        kind => !kind.attachments().iter().any(|(_, end)| grounded(end)),
    });
    description
}

/// Motors, springs and dampers within keep the momentum of the whole and its angular momentum. Relative to the largest
/// rate of a single body, within the error of the differences.
#[test]
fn what_drifts_freely_keeps_its_momentum_and_spin() {
    for seed in 0..40 {
        let mut description = adrift(seed);
        description.gravity = Vector3::zeros();
        let start = Start::of(&description);
        let rates = start.rate(|system, q, v| momenta(system, q, v).iter().flat_map(numbers).collect());
        let size = rates.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for i in 0..6 {
            let total: f64 = rates.iter().skip(i).step_by(6).sum();
            assert!(total.abs() < 1e-9 * size, "seed {seed}: {total:e} of {size}");
        }
    }
}

/// Gravity adds its acceleration to the free hinge and nothing to any other hinge or reaction. Round-off grows by the
/// condition number (a hundred) of at most eleven bodies.
#[test]
fn in_free_fall_gravity_is_not_felt() {
    for seed in 0..40 {
        let falling = adrift(seed);
        let mut floating = falling.clone();
        floating.gravity = Vector3::zeros();
        let (falling, floating) = (Start::of(&falling), Start::of(&floating));
        let gravity = falling.model.gravity;
        let mut expected = floating.a.clone();
        let free = falling.model.bodies[0].hinge.velocity;
        (0..3).for_each(|i| expected[free + i] += gravity[i]);
        assert!(relative_difference(&falling.a, &expected) < 1e-13, "seed {seed}");
        let of = |start: &Start| start.reactions.iter().flat_map(numbers).collect::<Vec<_>>();
        let (found, expected) = (of(&falling), of(&floating));
        assert!(relative_difference(&found, &expected) < 1e-13, "seed {seed}");
        assert!(falling.reactions[0].force.norm() < 1e-10, "the free hinge carries nothing");
    }
}
