//! Free bars held by springs alone: prestress makes what the springs' first-order stiffness leaves soft.

use super::case::case;
use super::scene::{Scene, head};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use stillpoint::dynamics::System;

#[test]
fn b14_tensegrity_t3() {
    let case = case("B14_tensegrity_t3");
    let [bar, kh, kv, lh, lv, mass] = ["Lb", "kh", "kv", "lh", "lv", "bar_mass"].map(|key| case.parameter(key));
    // The case's own guess: radius, height and twist.
    let (radius, height, twist) = (0.4, 1.2, 140.0 * PI / 180.0);
    let node = |i: usize, turn: f64, z: f64| {
        let angle = 2.0 * PI * i as f64 / 3.0 + turn;
        Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    let inertia = mass * bar * bar / 12.0;
    let mut text = head([0.0; 3], "dopri5", 1e-8);
    for i in 0..3 {
        let (bottom, top) = (node(i, 0.0, 0.0), node(i, twist, height));
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &(top - bottom)).expect("bars are not upside down");
        text += &format!(
            "[[body]]\nname = \"bar{i}\"\nmass = {mass:?}\ncenter = {:?}\ninertia = {:?}\n\
             markers = {{ b = [0, 0, 0], t = {:?} }}\nhinge = {{ type = \"free\", position = {:?} }}\n",
            [0.0, 0.0, 0.5 * bar],
            // A little about the axis: a bar without thickness could not turn about itself.
            [inertia, inertia, 1e-3 * inertia],
            [0.0, 0.0, bar],
            [bottom.x, bottom.y, bottom.z, turn.w, turn.i, turn.j, turn.k],
        );
    }
    let spring = |a: String, b: String, k: f64, length: f64| {
        format!("[[force]]\ntype = \"spring\"\nbetween = [\"{a}\", \"{b}\"]\nstiffness = {k:?}\nlength = {length:?}\n")
    };
    for i in 0..3 {
        let next = (i + 1) % 3;
        for end in ["b", "t"] {
            text += &spring(format!("bar{i}.{end}"), format!("bar{next}.{end}"), kh, lh);
        }
        text += &spring(format!("bar{i}.b"), format!("bar{}.t", (i + 2) % 3), kv, lv);
    }
    let scene = Scene::read(&text);
    let found = scene.rest();
    // The whole thing may move (6), and every bar may turn about itself (3); all else is stiff by prestress alone.
    let stability = found.stability.as_ref().expect("an equilibrium");
    assert_eq!((stability.unstable_directions, stability.neutral_directions), (0, 9));
    let (reference, tolerance) = (case.at("reference"), case.tolerance("rel"));
    let end = |i: usize, z: f64| found.poses[i] * Point3::new(0.0, 0.0, z);
    let (bottom, top) = ([0, 1, 2].map(|i| end(i, 0.0)), [0, 1, 2].map(|i| end(i, bar)));
    let center = |ends: &[Point3<f64>; 3]| (ends[0].coords + ends[1].coords + ends[2].coords) / 3.0;
    let axis = center(&top) - center(&bottom);
    reference.at("h").check_relative(axis.norm(), tolerance);
    for i in 0..3 {
        let next = (i + 1) % 3;
        for ends in [&bottom, &top] {
            let length = (ends[i] - ends[next]).norm();
            reference.at("L_horizontal").check_relative(length, tolerance);
            reference.at("T_horizontal").check_relative(kh * (length - lh), tolerance);
            reference.at("R").check_relative((ends[i].coords - center(ends)).norm(), tolerance);
        }
        let saddle = (bottom[i] - top[(i + 2) % 3]).norm();
        reference.at("L_saddle").check_relative(saddle, tolerance);
        reference.at("T_saddle").check_relative(kv * (saddle - lv), tolerance);
        let (from, to) = (bottom[i].coords - center(&bottom), top[i].coords - center(&top));
        reference.at("twist_deg").check_relative(from.angle(&to) * 180.0 / PI, tolerance);
    }
    let rest = vec![0.0; scene.model.velocity_count()];
    let energy = System::new(&scene.model).at(0.0, &found.position, &rest).energies().potential;
    reference.at("energy").check_relative(energy, tolerance);
}
