//! Scenes of one structure with other numbers in each.

use crate::common::{Options, Random, build, preload, random_scene};
use std::sync::Arc;
use stillpoint::dynamics::ensemble::WIDTH;
use stillpoint::model::Model;
use stillpoint::model::description::*;

/// A random tree with every kind of hinge and force, and as many like it as an ensemble has: masses, inertias, centres, stiffnesses,
/// states and gravity are each one's own. `None` for one that nothing moves in.
pub(crate) fn varied(seed: u64) -> Option<[Arc<Model>; WIDTH]> {
    let options =
        Options { bodies: 1 + seed as usize % 25, springs: !seed.is_multiple_of(4), welds: !seed.is_multiple_of(3) };
    let mut description = random_scene(seed + 90_000, &options);
    if seed % 2 == 1 {
        preload(&mut description);
    }
    let models = std::array::from_fn(|lane| build(&with_other_numbers(&description, seed * 100 + lane as u64)));
    let first: &Arc<Model> = &models[0];
    (first.velocity_count() > 0).then_some(models)
}

fn with_other_numbers(description: &Description, seed: u64) -> Description {
    let mut random = Random::new(seed);
    let mut other = description.clone();
    let mut scale = || random.between(0.8, 1.25);
    other.gravity *= scale();
    for body in &mut other.bodies {
        let part = scale();
        body.mass.mass *= part;
        body.mass.inertia *= part * scale();
        body.mass.center *= scale();
        let hinge = &mut body.hinge;
        let numbers =
            [&mut hinge.velocity, &mut hinge.stiffness, &mut hinge.damping, &mut hinge.force, &mut hinge.armature];
        numbers.into_iter().flatten().for_each(|number| *number *= scale());
        let (positions, velocities) = hinge.kind.counts();
        // The numbers of a quaternion stay a unit one.
        let plain = if positions == velocities { positions } else { positions - 4 };
        hinge.position[..plain].iter_mut().for_each(|number| *number *= scale());
        if let Point::At(at) = &mut hinge.at {
            *at *= scale();
        }
    }
    for force in &mut other.forces {
        match &mut force.kind {
            ForceKind::Spring(spring) => {
                spring.stiffness *= scale();
                spring.length *= scale();
                spring.damping *= scale();
            }
            ForceKind::Bushing(bushing) => bushing.stiffness.iter_mut().for_each(|number| *number *= scale()),
            ForceKind::Load(load) => load.force *= scale(),
            _ => {}
        }
    }
    other
}

/// An arm of revolute hinges whose axes take turns, or a tree of them in which every body carries two, with general inertias.
pub(crate) fn arm(count: usize, branches: bool, seed: usize) -> Arc<Model> {
    let mut random = Random::new(1000 + seed as u64);
    let mut description = Description::new("arm");
    for index in 0..count {
        let axis = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.3, 0.0]][index % 3];
        let mut hinge = HingeDescription::revolute(axis)
            .position([random.between(-0.8, 0.8)])
            .velocity([random.between(-1.0, 1.0)])
            .damping([0.1]);
        hinge.armature = vec![0.01];
        if index > 0 {
            let parent = if branches { (index - 1) / 2 } else { index - 1 };
            hinge = hinge.on(&format!("link{parent}"), [0.3, 0.02, 0.05]);
        }
        hinge.frame = Random::new(index as u64).turn();
        let mass = random.between(0.7, 1.3);
        description = description.body(
            BodyDescription::new(&format!("link{index}"), hinge)
                .mass(mass)
                .center([0.15, 0.02 * random.between(-1.0, 1.0), 0.02])
                .inertia([0.004 * mass, 0.009 * mass, 0.008 * mass]),
        );
    }
    build(&description)
}

/// The states of all, one number of each side by side.
pub(crate) fn state(models: &[Arc<Model>; WIDTH]) -> (Vec<[f64; WIDTH]>, Vec<[f64; WIDTH]>) {
    let beside = |count: usize, of: &dyn Fn(&Model, usize) -> f64| {
        (0..count).map(|i| std::array::from_fn(|lane| of(&models[lane], i))).collect()
    };
    let q = beside(models[0].position_count(), &|model, i| model.start_position[i]);
    (q, beside(models[0].velocity_count(), &|model, i| model.start_velocity[i]))
}
