//! Large trees whose branches are computed by two threads.

use crate::common::{Random, build, position_of, take_inertia};
use std::sync::Arc;
use stillpoint::dynamics::{Fault, System};
use stillpoint::model::description::{BodyDescription, Description, HingeDescription, HingeKind};
use stillpoint::model::{Body, Joint, Model};

/// A free trunk of three bodies with five long branches of hinges of all kinds, with twigs, and one more at its root.
fn tree() -> Description {
    let mut random = Random::new(11);
    let mut description = Description::new("a large tree");
    let mut add = |name: String, parent: &str, kind: HingeKind| {
        let at = random.vector(0.3);
        let position = position_of(&mut random, &kind);
        let velocity = random.list(kind.counts().1, -1.0, 1.0);
        let hinge =
            HingeDescription { position, velocity, ..HingeDescription::new(kind) }.on(parent, [at.x, at.y, at.z]);
        let inertia = [0.02, 0.025, 0.03];
        let body = BodyDescription::new(&name, hinge).mass(random.between(0.5, 2.0)).inertia(inertia);
        description.bodies.push(body.center(random.vector(0.1)));
    };
    let revolute = |axis: [f64; 3]| HingeDescription::revolute(axis).kind;
    add("trunk0".into(), "ground", HingeKind::Free);
    add("side".into(), "trunk0", revolute([0.0, 1.0, 0.0]));
    add("trunk1".into(), "trunk0", HingeKind::Spherical);
    add("trunk2".into(), "trunk1", revolute([1.0, 0.0, 0.0]));
    for branch in 0..5 {
        for i in 0..600 {
            let parent = match i {
                0 => "trunk2".to_owned(),
                // Every sixth is a twig: the next one grows past it.
                _ if i % 6 == 1 && i > 1 => format!("b{branch}_{}", i - 2),
                _ => format!("b{branch}_{}", i - 1),
            };
            let kind = match i % 9 {
                4 => HingeKind::Spherical,
                7 => HingeDescription::prismatic([0.6, 0.0, 0.8]).kind,
                8 => HingeDescription::universal([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).kind,
                _ => revolute([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0]][i % 2]),
            };
            add(format!("b{branch}_{i}"), &parent, kind);
        }
    }
    description
}

fn accelerations(model: &Arc<Model>) -> Vec<f64> {
    let mut system = System::new(model);
    let mut a = vec![0.0; model.velocity_count()];
    system.at(0.0, &model.start_position, &model.start_velocity).accelerations(&mut a).expect("accelerations");
    a
}

/// One thread, two threads: the same bits. And the same as the tree in one piece, but for the order of the sums where its halves
/// meet.
#[test]
fn two_threads_give_the_bits_of_one() {
    let mut model = build(&tree());
    let halves = model.halves.clone().expect("a large tree has halves");
    assert!(halves.links.iter().all(|half| half.len() > 1000) && halves.hub > 6, "{halves:?}");
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| accelerations(&model))
    };
    let (one, two) = (with(1), with(2));
    assert!(one.iter().zip(&two).all(|(x, y)| x.to_bits() == y.to_bits()));
    Arc::make_mut(&mut model).halves = None;
    let whole = accelerations(&model);
    let largest = whole.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let apart = whole.iter().zip(&one).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    // Sums of five branches in another order, through some ten links: round-off.
    assert!(apart <= 1e-12 * largest, "{apart:e} of {largest:e}");
    assert!(largest > 1.0);
}

/// A hinge that nothing resists is named in whatever half it is.
#[test]
fn a_singular_hinge_in_a_half_is_named() {
    let model = build(&tree());
    let halves = model.halves.clone().expect("halves");
    for half in &halves.links {
        let is_last = |body: &Body| {
            let link = &model.links[body.link];
            half.contains(&body.link) && link.joint == Joint::Turn && link.subtree_end == body.link + 1
        };
        let name = &model.bodies.iter().find(|body| is_last(body)).expect("a last body that turns").name;
        let mut model = model.clone();
        take_inertia(&mut model, name);
        let mut a = vec![0.0; model.velocity_count()];
        let mut system = System::new(&model);
        let fault = system.at(0.0, &model.start_position, &model.start_velocity).accelerations(&mut a).map(|_| ());
        assert_eq!(fault, Err(Fault::Singular { body: name.clone(), pivot: 0.0 }));
    }
}
