//! Values and variations on random trees, against differences and against numbers computed by hand.

use super::{Place, at_start, reaction, scene};
use crate::common::{Random, build};
use nalgebra::{Point3, Vector3};
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::model::description::*;
use stillpoint::output::Varied;

const SCENES: u64 = 200;

/// Central differences of order four: what is left out is step⁴ times the fifth derivative, and round-off is 1e-16/step.
const STEP: f64 = 1e-3;

fn differences(model: &std::sync::Arc<Model>, place: &Place, by: &Varied<'_>) -> Vec<f64> {
    let at = |step: f64| place.moved(model, by, step).outputs(model, &Varied::default()).unwrap().0;
    let [far_back, back, on, far_on] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(k * STEP));
    let one = |i: usize| (8.0 * (on[i] - back[i]) - (far_on[i] - far_back[i])) / (12.0 * STEP);
    (0..on.len()).map(one).collect()
}

/// A quaternion and its negative are the same orientation; one that changes its sign between two places is left out.
fn is_quaternion(model: &Model, number: usize) -> bool {
    let output = model.outputs.iter().find(|output| output.range().contains(&number)).unwrap();
    output.name.starts_with("turn of")
}

/// Of everything but reactions; the largest error of a variation relative to the largest number of the kind.
#[test]
fn variations_are_those_of_differences_in_any_direction() {
    let (mut worst, mut checked): (f64, usize) = (0.0, 0);
    for seed in 0..SCENES {
        let model = build(&scene(seed));
        let mut random = Random::new(seed + 5);
        let n = model.velocity_count();
        let [position, velocity, acceleration] = [0; 3].map(|_| random.list(n, -1.0, 1.0));
        let by =
            Varied { time: 0.7, position: &position, velocity: &velocity, acceleration: &acceleration, others: &[] };
        let place = Place::start(&model);
        let (values, variations) = place.outputs(&model, &by).unwrap();
        let expected = differences(&model, &place, &by);
        for output in &model.outputs {
            let size = output.range().map(|i| values[i].abs().max(expected[i].abs())).fold(1.0, f64::max);
            for i in output.range() {
                let flipped = is_quaternion(&model, i) && expected[i].abs() > 10.0;
                if variations[i].is_nan() {
                    let known = ["reaction", "angle", "distance"];
                    assert!(known.iter().any(|name| output.name.starts_with(name)), "{seed}: `{}`", output.name);
                } else if !flipped {
                    let error = (variations[i] - expected[i]).abs() / size;
                    assert!(error < 2e-8, "{seed}: `{}`: {} for {}", output.name, variations[i], expected[i]);
                    (worst, checked) = (worst.max(error), checked + 1);
                }
            }
        }
    }
    assert!(checked > 10_000, "{checked}");
    println!("{checked} variations, worst {worst:.1e}");
}

/// Velocity is the rate of position along the motion, acceleration that of velocity.
#[test]
fn velocity_and_acceleration_are_rates() {
    for seed in 0..SCENES {
        let model = build(&scene(seed));
        let place = Place::start(&model);
        let none = vec![0.0; model.velocity_count()];
        let by = Varied { time: 1.0, position: &place.v, velocity: &place.a, acceleration: &none, others: &[] };
        let rates = differences(&model, &place, &by);
        let (values, _) = place.outputs(&model, &by).unwrap();
        let of = |name: &str| model.outputs.iter().find(|output| output.name == name).unwrap().range();
        for (one, next) in [("x0", "v0"), ("v0", "a0"), ("x0 along", "v0 along"), ("v0 along", "a0 along")] {
            // The axes of `along` differ: only lists are compared.
            if one.ends_with("along") {
                continue;
            }
            for (i, j) in of(one).zip(of(next)) {
                let size = values[j].abs().max(rates[i].abs()).max(1.0);
                assert!((rates[i] - values[j]).abs() < 1e-7 * size, "{seed}: {one}: {} for {}", rates[i], values[j]);
            }
        }
    }
}

/// Positions, distances, angles and body axes by the poses of the bodies.
#[test]
fn geometry_agrees_with_poses() {
    for seed in 0..SCENES {
        let description = scene(seed);
        let model = build(&description);
        let mut system = System::new(&model);
        let at = system.at(0.0, &model.start_position, &model.start_velocity);
        let mut poses = Vec::new();
        at.poses(&mut poses);
        let pose = |body: &str| model.body(body).map_or_else(stillpoint::spatial::Pose::identity, |index| poses[index]);
        let place = |on: &Attachment| match &on.point {
            Point::At(at) => (pose(&on.body) * Point3::from(*at)).coords,
            Point::Marker(_) => unreachable!(),
        };
        let turned = |one: &DirectionDescription| pose(&one.body).rotation * one.axis.normalize();
        for output in &description.outputs {
            let found = at_start(&model, &output.name);
            let expected: Vec<f64> = match &output.of {
                QuantityDescription::Point { order: Order::Position, on, axis, axes } => {
                    let seen = match axes {
                        Axes::Inertial => place(on),
                        Axes::Body => pose(&on.body).rotation.inverse() * place(on),
                    };
                    axis.map_or_else(|| seen.as_slice().to_vec(), |axis| vec![axis.normalize().dot(&seen)])
                }
                QuantityDescription::Distance { between: [a, b] } => vec![(place(a) - place(b)).norm()],
                QuantityDescription::Angle { of, against, about: None } => vec![turned(of).angle(&turned(against))],
                QuantityDescription::Angle { of, against, about: Some(about) } => {
                    let n = pose(&against.body).rotation * about.normalize();
                    let flat = |x: Vector3<f64>| x - x.dot(&n) * n;
                    let (a, b) = (flat(turned(of)), flat(turned(against)));
                    vec![a.angle(&b) * b.cross(&a).dot(&n).signum()]
                }
                _ => continue,
            };
            for (found, expected) in found.iter().zip(&expected) {
                // An angle by its cosine loses half its digits near 0 and π.
                let enough = if output.name == "angle" || output.name == "signed" { 1e-7 } else { 1e-12 };
                assert!((found - expected).abs() < enough, "{seed}: `{}`: {found} for {expected}", output.name);
            }
        }
    }
}

/// Springs by their stiffness and length; bushings and loads against what the ground of a welded scene has to hold.
#[test]
fn pulls_of_springs_follow_from_their_points() {
    let mut springs = 0;
    for seed in 0..SCENES {
        let mut description = scene(seed);
        let found: Vec<(String, Spring)> = description
            .forces
            .iter()
            .filter_map(|force| match &force.kind {
                ForceKind::Spring(spring) => Some((force.name.clone(), spring.clone())),
                _ => None,
            })
            .collect();
        for (name, spring) in &found {
            let quantity = |order, on: &Attachment| QuantityDescription::Point {
                order,
                on: on.clone(),
                axis: None,
                axes: Axes::Inertial,
            };
            for (index, on) in spring.between.iter().enumerate() {
                for (kind, order) in [("x", Order::Position), ("v", Order::Velocity)] {
                    let name = format!("{name} {kind}{index}");
                    description.outputs.push(OutputDescription::new(&name, quantity(order, on)));
                }
            }
        }
        let model = build(&description);
        for (name, spring) in &found {
            let of = |key: &str| Vector3::from_column_slice(&at_start(&model, &format!("{name} {key}")));
            let (between, closing) = (of("x1") - of("x0"), of("v1") - of("v0"));
            let length = between.norm();
            let rate = between.dot(&closing) / length;
            let expected = spring.stiffness * (length - spring.length) + spring.damping * rate;
            let pull = at_start(&model, &format!("force {name}"))[0];
            assert!((pull - expected).abs() < 1e-10 * (1.0 + expected.abs()), "{seed}: {pull} for {expected}");
            assert!((at_start(&model, &format!("length {name}"))[0] - length).abs() < 1e-12);
            springs += 1;
        }
    }
    assert!(springs > 50, "{springs}");
}

/// In body axes a reaction is the same vector, turned; its components are its parts.
#[test]
fn reactions_in_body_axes_are_turned() {
    for seed in 0..40 {
        let mut description = scene(seed);
        let body = description.bodies[0].name.clone();
        description.outputs.push(OutputDescription::new("turned", reaction(&body, Axes::Body)));
        for (index, name) in ["fx", "fy", "fz", "mx", "my", "mz"].into_iter().enumerate() {
            let component = Some(index);
            let of = QuantityDescription::Reaction { body: body.clone(), component, axes: Axes::Body };
            description.outputs.push(OutputDescription::new(name, of));
        }
        let model = build(&description);
        let mut poses = Vec::new();
        System::new(&model).at(0.0, &model.start_position, &model.start_velocity).poses(&mut poses);
        let inertial = at_start(&model, &format!("reaction of {body}"));
        let turned = at_start(&model, "turned");
        for part in [0..3, 3..6] {
            let back = poses[0].rotation * Vector3::from_column_slice(&turned[part.clone()]);
            let error = (back - Vector3::from_column_slice(&inertial[part])).norm();
            assert!(error < 1e-12 * (1.0 + back.norm()), "{seed}");
        }
        for (index, name) in ["fx", "fy", "fz", "mx", "my", "mz"].into_iter().enumerate() {
            assert_eq!(at_start(&model, name), [turned[index]]);
        }
    }
}
