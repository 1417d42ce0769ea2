//! Scenes in which a constant force finds nothing that holds it: told at once, and only of such scenes.

use crate::common::{Options, Random, build, random_scene};
use nalgebra::{Matrix3, Vector3};
use std::time::Instant;
use stillpoint::model::description::*;
use stillpoint::statics::{Method, Settings, Want, equilibrium};

fn body(name: String, hinge: HingeDescription, random: &mut Random) -> BodyDescription {
    let inertia = 10_f64.powf(random.between(-3.0, 6.0)) * Matrix3::identity();
    let mass = MassProperties { mass: 10_f64.powf(random.between(-2.0, 3.0)), center: random.vector(0.2), inertia };
    BodyDescription { name, mass, markers: Vec::new(), shapes: Vec::new(), hinge }
}

fn at(body: &str, point: Vector3<f64>) -> Attachment {
    Attachment { body: body.to_owned(), point: Point::At(point) }
}

fn spring(random: &mut Random, between: [Attachment; 2]) -> ForceDescription {
    let stiffness = 10_f64.powf(random.between(1.0, 5.0));
    let kind = ForceKind::Spring(Spring { between, stiffness, length: random.between(0.0, 1.0), damping: 0.0 });
    ForceDescription { name: format!("spring{}", random.below(usize::MAX)), kind }
}

/// Free bodies with limbs in a chain of springs that ends at the ground, or that a load keeps up, when `held`.
fn floating(random: &mut Random, held: bool) -> Description {
    let count = 1 + random.below(4);
    let (mut bodies, mut forces) = (Vec::new(), Vec::new());
    for index in 0..count {
        let mut hinge = HingeDescription::new(HingeKind::Free);
        let place = random.vector(1.0);
        hinge.position = vec![place.x, place.y, place.z, 1.0, 0.0, 0.0, 0.0];
        bodies.push(body(format!("b{index}"), hinge, random));
        if random.below(2) == 0 {
            let mut hinge = HingeDescription::new(HingeKind::Revolute { axis: random.unit() });
            hinge.parent = format!("b{index}");
            hinge.stiffness = vec![random.between(0.0, 50.0)];
            bodies.push(body(format!("limb{index}"), hinge, random));
        }
        if index > 0 {
            let ends = [index - 1, index].map(|i| at(&format!("b{i}"), random.vector(0.3)));
            forces.push(spring(random, ends));
        }
    }
    if held {
        let ends = [at(GROUND, random.vector(1.0)), at("b0", random.vector(0.3))];
        forces.push(spring(random, ends));
    } else {
        // A load that keeps up half of the weight does not hold it.
        let weight: f64 = bodies.iter().map(|body| 9.80665 * body.mass.mass).sum();
        let load = Vector3::new(0.0, 0.0, 0.5 * weight * random.between(0.0, 1.0));
        forces.push(ForceDescription::load("lift", at("b0", Vector3::zeros()), load));
    }
    Description { bodies, forces, ..Description::default() }
}

fn says_so(notes: &[String]) -> bool {
    notes.iter().any(|note| note.ends_with(": no position is an equilibrium"))
}

#[test]
fn what_nothing_holds_is_told_at_once() {
    for seed in 0..60 {
        let model = build(&floating(&mut Random::new(seed), false));
        let before = Instant::now();
        let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
        assert!(!found.balanced && says_so(&found.notes), "{seed}: {:?}", found.notes);
        assert!(found.iterations == 0 && before.elapsed().as_secs_f64() < 1.0, "{seed}: {} steps", found.iterations);
    }
}

/// One spring to the ground holds the whole chain: it hangs.
#[test]
fn what_a_spring_holds_is_searched_for() {
    for seed in 0..60 {
        let model = build(&floating(&mut Random::new(seed), true));
        let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
        assert!(!says_so(&found.notes), "{seed}: {:?}", found.notes);
    }
}

/// Whatever is in a scene: where the certificate is given, Newton's method, which does not ask for it, finds no equilibrium.
#[test]
fn the_certificate_is_given_only_without_an_equilibrium() {
    let mut told = 0;
    for seed in 0..120 {
        let options = Options { bodies: 1 + seed as usize % 4, springs: seed % 3 > 0, welds: true };
        let mut scene = random_scene(seed, &options);
        for (index, body) in scene.bodies.iter_mut().enumerate() {
            // Motors and springs of hinges may hold it.
            body.hinge.force.clear();
            if index % 2 == 0 {
                body.hinge.stiffness.clear();
            }
        }
        let model = build(&scene);
        let settings = Settings { time_limit: 0.1, ..Settings::default() };
        let found = equilibrium(&model, &settings, &model.start_position).expect("statics");
        if says_so(&found.notes) {
            told += 1;
            let newton = Settings { want: Want::Any, method: Method::Newton, ..settings };
            let other = equilibrium(&model, &newton, &model.start_position).expect("statics");
            // Newton's steps may run away so far that the force is below the round-off of the positions there.
            let is_near = other.position.iter().all(|q| q.abs() < 1e6);
            assert!(!(other.balanced && is_near), "{seed}: {:?}, but at {:?}", found.notes, other.position);
        }
    }
    assert!(told > 10, "{told} of 120: the scenes ask for nothing");
}
