//! Free bars held by springs alone: prestress makes what the springs' first-order stiffness leaves soft.

use super::case::case;
use super::scene::{Scene, head};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::f64::consts::PI;

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
    let found = scene.search();
    println!(
        "{} {} {:?} it {} res {:e} {:e}",
        found.converged, found.balanced, found.notes, found.iterations, found.relative_residual, found.residual_force
    );
    let s = found.stability.as_ref().map(|s| {
        (
            s.verdict,
            s.unstable_directions,
            s.neutral_directions,
            s.modes.iter().map(|m| m.frequency_hz).collect::<Vec<_>>(),
        )
    });
    println!("{s:?}");
    let (reference, tolerance) = (case.at("reference"), case.tolerance("rel"));
    let end = |i: usize, z: f64| found.poses[i] * Point3::new(0.0, 0.0, z);
    let energy = stillpoint::dynamics::System::new(&scene.model)
        .energies(&found.position, &vec![0.0; scene.model.velocity_count()])
        .potential;
    reference.at("energy").check_relative(energy, tolerance);
    reference.at("L_horizontal").check_relative((end(0, 0.0) - end(1, 0.0)).norm(), tolerance);
    reference.at("L_saddle").check_relative((end(0, 0.0) - end(2, bar)).norm(), tolerance);
}
