//! Symmetric lattices of springs: whatever symmetric pose the search comes through, it ends in a stable one.

use crate::common::{Random, build};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::description::*;
use stillpoint::model::{Model, Parameter};
use stillpoint::statics::path::EventKind;
use stillpoint::statics::{Equilibrium, Settings, StabilityVerdict, Want, equilibrium};

/// A point that may go anywhere, by three slides.
fn point(name: &str, at: Vector3<f64>, mass: f64, bodies: &mut Vec<BodyDescription>) {
    for (index, axis) in [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().enumerate() {
        let mut hinge = HingeDescription::new(HingeKind::Prismatic { axis });
        if index > 0 {
            hinge.parent = format!("{name}{}", index - 1);
        }
        hinge.position.push(at[index]);
        let mass = if index == 2 { mass } else { 0.0 };
        let mass = MassProperties { mass, center: Vector3::zeros(), inertia: Matrix3::zeros() };
        let name = format!("{name}{index}");
        bodies.push(BodyDescription { name, mass, markers: Vec::new(), shapes: Vec::new(), hinge });
    }
}

fn spring(between: [Attachment; 2], stiffness: f64, length: f64, forces: &mut Vec<ForceDescription>) {
    let kind = ForceKind::Spring(Spring { between, stiffness, length, damping: 0.0 });
    forces.push(ForceDescription { name: format!("spring{}", forces.len()), kind });
}

/// A shallow crown: a ring of `n` nodes and an apex over it, struts between all neighbours and to a wider ring on the ground,
/// the whole of it n-fold symmetric. Its struts are longer by `compressed` than the distances that they bridge, so that it snaps
/// up, down or to a side.
fn crown(n: usize, stiffness: [f64; 3], height: f64, mass: f64, compressed: f64) -> Description {
    let (mut bodies, mut forces) = (Vec::new(), Vec::new());
    let around = |i: usize, radius: f64, half: f64, z: f64| {
        let angle = std::f64::consts::TAU * (i as f64 + half) / n as f64;
        Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    let apex = Vector3::new(0.0, 0.0, 2.0 * height);
    point("top", apex, mass, &mut bodies);
    (0..n).for_each(|i| point(&format!("n{i}_"), around(i, 0.5, 0.0, height), mass, &mut bodies));
    let node = |i: usize| Attachment { body: format!("n{}_2", i % n), point: Point::At(Vector3::zeros()) };
    let top = || Attachment { body: "top2".to_owned(), point: Point::At(Vector3::zeros()) };
    let mut strut = |between: [Attachment; 2], stiffness: f64, bridged: Vector3<f64>| {
        spring(between, stiffness, (1.0 + compressed) * bridged.norm(), &mut forces);
    };
    for i in 0..n {
        let (here, next) = (around(i, 0.5, 0.0, height), around(i + 1, 0.5, 0.0, height));
        strut([top(), node(i)], stiffness[0], here - apex);
        strut([node(i), node(i + 1)], stiffness[1], here - next);
        for half in [-0.5, 0.5] {
            let foot = around(i, 1.0, half, 0.0);
            let ground = Attachment { body: GROUND.to_owned(), point: Point::At(foot) };
            strut([ground, node(i)], stiffness[2], foot - here);
        }
    }
    Description { bodies, forces, ..Description::default() }
}

fn random_crown(random: &mut Random, n: usize) -> Arc<Model> {
    let stiffness = [0, 1, 2].map(|_| 10_f64.powf(random.between(1.0, 3.5)));
    // Every other one is flat.
    let height = if random.below(2) == 0 { 0.0 } else { random.between(0.03, 0.2) };
    let mass = 10_f64.powf(random.between(-3.0, -0.5));
    build(&crown(n, stiffness, height, mass, random.between(0.0, 0.2)))
}

fn verdict(found: &Equilibrium) -> Option<StabilityVerdict> {
    found.stability.as_ref().map(|stability| stability.verdict)
}

fn ends_stable(found: &Equilibrium) -> bool {
    found.converged && verdict(found).is_some_and(|verdict| verdict != StabilityVerdict::Unstable)
}

fn potential(model: &Arc<Model>, q: &[f64]) -> f64 {
    let still = vec![0.0; model.velocity_count()];
    System::new(model).at(0.0, q, &still).energies_at_rest().potential
}

/// From the symmetric guess, and from the symmetric equilibrium nearest to it when that is unstable: no force there has a part
/// in the direction in which it is left.
#[test]
fn symmetric_crowns_end_stable() {
    let mut random = Random::new(3);
    let (mut failed, mut left, mut cases) = (Vec::new(), 0, 0);
    let any = Settings { want: Want::Any, ..Settings::default() };
    for n in 3..=8 {
        for case in 0..8 {
            let model = random_crown(&mut random, n);
            let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
            if !ends_stable(&found) {
                let residual = found.relative_residual;
                failed.push(format!("n = {n}, case {case}: {:?} {residual} {:?}", verdict(&found), found.notes));
            }
            cases += 1;
            let nearest = equilibrium(&model, &any, &model.start_position).expect("statics");
            if !(nearest.converged && verdict(&nearest) == Some(StabilityVerdict::Unstable)) {
                continue;
            }
            let found = equilibrium(&model, &Settings::default(), &nearest.position).expect("statics");
            let lower = potential(&model, &found.position) < potential(&model, &nearest.position);
            let told = found.notes.iter().any(|note| note.starts_with("left an unstable"));
            if !(ends_stable(&found) && lower && told) {
                failed.push(format!("n = {n}, case {case}, from its saddle: {:?} {:?}", verdict(&found), found.notes));
            }
            left += 1;
        }
    }
    assert!(failed.is_empty(), "{} of {cases}:\n{}", failed.len(), failed.join("\n"));
    assert!(left >= cases / 4, "{left} of {cases} have a saddle: the scenes ask for nothing");
}

/// Crowns that are pressed and pulled at the top have bifurcations close to each other, single and double. Every branch begins
/// within a step of the point that it leaves from, and within the range of the parameter.
#[test]
fn branches_begin_beside_their_bifurcations() {
    use stillpoint::statics::path::{PathSettings, follow};
    let mut random = Random::new(11);
    let (mut branches, mut notes) = (0, 0);
    for case in 0..4 {
        let n = 3 + case % 4;
        let stiffness = [0, 1, 2].map(|_| 10_f64.powf(random.between(2.0, 3.0)));
        let height = random.between(0.05, 0.2);
        let mut description = crown(n, stiffness, height, 1e-3, 0.0);
        let on = Attachment { body: "top2".to_owned(), point: Point::At(Vector3::zeros()) };
        description.forces.push(ForceDescription::load("push", on, Vector3::zeros()));
        let numbers = Parameter::find(&description, "push.force[2]").expect("a load");
        let (parameter, at, coordinate) = ("push.force[2]".to_owned(), Vec::new(), None);
        let most = 0.5 * stiffness[0] * height;
        let (from, to, step) = (most, -most, 0.05);
        let way = PathSettings { parameter, numbers, from, to, at, step, points: 60, branches: true, coordinate };
        let path = follow(&description, &Settings::default(), &way, &mut |_| true)
            .unwrap_or_else(|why| panic!("{case}: {why}"));
        for (index, branch) in path.branches.iter().enumerate() {
            let Some((parent, point)) = branch.parent else { continue };
            let (first, left) = (&branch.points[0], &path.branches[parent].points[point]);
            assert!(first.parameter.abs() <= most, "{case}: branch {index} begins at {} N", first.parameter);
            // Arclength: a step is that part of the scene's length, a metre at most, in all of 3 (n + 1) slides at once.
            let square: f64 = first.position.iter().zip(&left.position).map(|(a, b)| (a - b).powi(2)).sum();
            let most_away = 2.0 * step * (3.0 * (n as f64 + 1.0)).sqrt();
            assert!(square.sqrt() < most_away, "{case}: branch {index} begins {} m away", square.sqrt());
            branches += 1;
        }
        // What is not followed is named: how many directions, and where.
        let multiple = path.events().filter(|(_, point)| {
            point.event.as_ref().is_some_and(|event| event.kind == EventKind::Bifurcation && event.directions > 1)
        });
        let named = path.notes.iter().filter(|note| note.contains("its branches are not followed")).count();
        assert_eq!(multiple.count(), named, "{case}: {:?}", path.notes);
        notes += named;
    }
    assert!(branches + notes > 0, "{branches} branches, {notes} notes: the scenes ask for nothing");
}
