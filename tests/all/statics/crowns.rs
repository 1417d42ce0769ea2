//! Symmetric lattices of springs: whatever symmetric pose the search comes through, it ends in a stable one.

use crate::common::{Random, build};
use nalgebra::{Matrix3, Vector3};
use stillpoint::model::description::*;
use stillpoint::statics::{Settings, Verdict, equilibrium};

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
/// the whole of it n-fold symmetric, pressed down by its weight.
fn crown(n: usize, stiffness: [f64; 3], height: f64, mass: f64) -> Description {
    let (mut bodies, mut forces) = (Vec::new(), Vec::new());
    let around = |i: usize, radius: f64, half: f64, z: f64| {
        let angle = std::f64::consts::TAU * (i as f64 + half) / n as f64;
        Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    point("top", Vector3::new(0.0, 0.0, 2.0 * height), mass, &mut bodies);
    (0..n).for_each(|i| point(&format!("n{i}_"), around(i, 0.5, 0.0, height), mass, &mut bodies));
    let node = |i: usize| Attachment { body: format!("n{}_2", i % n), point: Point::At(Vector3::zeros()) };
    let top = || Attachment { body: "top2".to_owned(), point: Point::At(Vector3::zeros()) };
    for i in 0..n {
        let here = around(i, 0.5, 0.0, height);
        let next = around(i + 1, 0.5, 0.0, height);
        spring([top(), node(i)], stiffness[0], (here - Vector3::new(0.0, 0.0, 2.0 * height)).norm(), &mut forces);
        spring([node(i), node(i + 1)], stiffness[1], (here - next).norm(), &mut forces);
        for half in [-0.5, 0.5] {
            let foot = around(i, 1.0, half, 0.0);
            let ground = Attachment { body: GROUND.to_owned(), point: Point::At(foot) };
            spring([ground, node(i)], stiffness[2], (foot - here).norm(), &mut forces);
        }
    }
    Description { bodies, forces, ..Description::default() }
}

#[test]
fn symmetric_crowns_end_stable() {
    let mut random = Random::new(3);
    let (mut failed, mut left, mut cases) = (Vec::new(), 0, 0);
    for n in 3..=8 {
        for case in 0..8 {
            let stiffness = [0, 1, 2].map(|_| 10_f64.powf(random.between(1.0, 3.5)));
            let (height, mass) = (random.between(0.03, 0.2), 10_f64.powf(random.between(-1.5, 1.0)));
            let model = build(&crown(n, stiffness, height, mass));
            let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
            let verdict = found.stability.as_ref().map(|stability| stability.verdict);
            if !(found.converged && verdict.is_some_and(|verdict| verdict != Verdict::Unstable)) {
                failed.push(format!("n = {n}, case {case}: {verdict:?} {} {:?}", found.relative_residual, found.notes));
            }
            left += usize::from(found.notes.iter().any(|note| note.starts_with("left an unstable")));
            cases += 1;
        }
    }
    assert!(failed.is_empty(), "{} of {cases}:\n{}", failed.len(), failed.join("\n"));
    assert!(left >= cases / 8, "{left} of {cases} came through a saddle: the scenes ask for nothing");
}
