//! Loops that repeat what the tree allows already: they hold nothing more, whichever way the scene is turned.

use super::read;
use crate::common::Random;
use nalgebra::{UnitQuaternion, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::statics::{Equilibrium, Settings, StabilityVerdict, equilibrium};

fn list(v: &Vector3<f64>) -> String {
    format!("[{:e}, {:e}, {:e}]", v.x, v.y, v.z)
}

/// Bodies that hang on each other by these hinges, the first turned by `turn`; they are sprung.
fn chain(random: &mut Random, turn: &UnitQuaternion<f64>, size: f64, hinges: &[&str]) -> String {
    let (roll, pitch, yaw) = turn.euler_angles();
    let body = |(i, hinge): (usize, &&str)| {
        let parent = match i {
            0 => format!("rpy = [{roll:e}, {pitch:e}, {yaw:e}]"),
            _ => format!("parent = \"bar{}\", at = {}", i - 1, list(&(size * random.vector(0.6)))),
        };
        let inertia = random.list(3, 0.05, 0.08).iter().map(|x| x * size * size).collect::<Vec<_>>();
        let (slide, turn) = (90.0 / size, 90.0 * size);
        let stiffness = match hinge {
            _ if hinge.contains("prismatic") => format!("{slide:e}"),
            _ if hinge.contains("cylindrical") => format!("[{slide:e}, {turn:e}]"),
            _ if hinge.contains("planar") => format!("[{slide:e}, {slide:e}, {turn:e}]"),
            _ => format!("{turn:e}"),
        };
        format!(
            "[[body]]\nname = \"bar{i}\"\nmass = 1.2\ninertia = {inertia:?}\ncenter = {}\nhinge = {{ {hinge}, {parent}, \
             stiffness = {stiffness} }}\n",
            list(&(size * random.vector(0.3))),
        )
    };
    hinges.iter().enumerate().map(body).collect()
}

/// A chain, and a loop that repeats it between the ground and its last body.
fn scene(random: &mut Random) -> (String, String) {
    let turn = random.turn();
    let size = 10.0_f64.powf(random.between(-3.0, 3.0));
    let (roll, pitch, yaw) = turn.euler_angles();
    let rpy = format!("rpy = [{roll:e}, {pitch:e}, {yaw:e}]");
    let revolute = "type = \"revolute\", axis = [0, 0, 1]";
    let screw = format!("type = \"screw\", axis = [0, 0, 1], pitch = {:e}", 0.01 * size);
    let screw_loop = format!("type = \"screw\"\naxis = [0, 0, 1]\npitch = {:e}\n{rpy}", 0.01 * size);
    let of_axis = |kind: &str| format!("type = \"{kind}\"\naxis = [0, 0, 1]\n{rpy}");
    let universal = "type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]]";
    let (on_axis, anywhere) = (Vector3::z() * random.between(-size, size), size * random.vector(1.0));
    let kind = random.below(11);
    let (hinges, closure, point): (Vec<&str>, String, Vector3<f64>) = match kind {
        0 => (vec![revolute], of_axis("revolute"), on_axis),
        1 => (vec![revolute], of_axis("cylindrical"), on_axis),
        2 => (vec!["type = \"cylindrical\", axis = [0, 0, 1]"], of_axis("cylindrical"), on_axis),
        3 => (vec!["type = \"prismatic\", axis = [0, 0, 1]"], of_axis("prismatic"), anywhere),
        4 => (vec![revolute; 1 + random.below(3)], format!("type = \"planar\"\n{rpy}"), anywhere),
        5 => (
            vec!["type = \"prismatic\", axis = [1, 0, 0]", "type = \"prismatic\", axis = [0.6, 0.8, 0]"],
            format!("type = \"planar\"\n{rpy}"),
            anywhere,
        ),
        6 => (vec!["type = \"spherical\""], "type = \"spherical\"".to_owned(), Vector3::zeros()),
        7 => (vec![universal], format!("type = \"universal\"\naxes = [[1, 0, 0], [0, 1, 0]]\n{rpy}"), Vector3::zeros()),
        8 => (vec![revolute], String::new(), on_axis),
        9 => (vec![&screw], screw_loop, on_axis),
        _ => (vec!["type = \"planar\""], format!("type = \"planar\"\n{rpy}"), anywhere),
    };
    let bodies = chain(random, &turn, size, &hinges);
    let last = format!("bar{}", hinges.len() - 1);
    let (_, model) = read(&bodies);
    let mut poses = Vec::new();
    System::new(&model).at(0.0, &model.start_position, &model.start_velocity).poses(&mut poses);
    let place = poses[model.body(&last).expect("the last body")].transform_point(&point.into()).coords;
    let (place, closure) = match kind {
        8 => {
            let place = place + turn * anywhere;
            (place, format!("type = \"rod\"\nlength = {:e}", anywhere.norm()))
        }
        _ => (place, closure),
    };
    let ends = format!(
        "between = [{{ body = \"ground\", at = {} }}, {{ body = \"{last}\", at = {} }}]",
        list(&place),
        list(&point)
    );
    (bodies, format!("[[loop]]\nname = \"repeat\"\n{closure}\n{ends}\n"))
}

/// At the start, with hinge velocities up to `speed`.
fn accelerations(model: &Arc<Model>, speed: f64) -> Vec<f64> {
    let v = Random::new(7).list(model.velocity_count(), -speed, speed);
    let mut a = vec![0.0; v.len()];
    System::new(model).at(0.0, &model.start_position, &v).accelerations(&mut a).expect("accelerations");
    a
}

fn verdict(found: &Equilibrium) -> Option<StabilityVerdict> {
    found.stability.as_ref().map(|stability| stability.verdict)
}

/// The same degrees of freedom, accelerations and equilibrium with the loop as without it.
#[test]
fn a_loop_that_repeats_the_tree_changes_nothing() {
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let (bodies, closure) = scene(&mut random);
        let text = format!("{bodies}{closure}");
        let ((_, free), (_, closed)) = (read(&bodies), read(&text));
        let rows = closed.independent_rows.as_ref().expect("decided");
        assert!(rows.iter().all(|row| !row), "seed {seed}: {rows:?}\n{text}");
        let (a, b) = (accelerations(&free, 1.0), accelerations(&closed, 1.0));
        let size = a.iter().fold(1.0_f64, |m, a| m.max(a.abs()));
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart <= 1e-9 * size, "seed {seed}: {a:?} {b:?}\n{text}");
        let settings = Settings::default();
        let [one, other] =
            [&free, &closed].map(|model| equilibrium(model, &settings, &model.start_position).expect("numbers"));
        assert!(one.converged && other.converged, "seed {seed}\n{text}");
        let apart = one.position.iter().zip(&other.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let size = one.position.iter().fold(1.0_f64, |m, q| m.max(q.abs()));
        assert!(apart <= 1e-8 * size, "seed {seed}: {:?} {:?}\n{text}", one.position, other.position);
        assert_eq!(verdict(&one), verdict(&other), "seed {seed}\n{text}");
    }
}

/// A planar linkage, closed by a loop that the plane makes redundant in part, turned as a whole.
fn linkage(random: &mut Random, turn: &UnitQuaternion<f64>) -> String {
    let size = 10.0_f64.powf(random.between(-3.0, 3.0));
    let kinds = ["type = \"revolute\", axis = [0, 0, 1]", "type = \"prismatic\", axis = [1, 0, 0]"];
    let hinges: Vec<&str> = (0..1 + random.below(4)).map(|_| kinds[usize::from(random.below(3) == 0)]).collect();
    let bodies = chain(random, turn, size, &hinges);
    let last = format!("bar{}", hinges.len() - 1);
    let (_, model) = read(&bodies);
    let mut poses = Vec::new();
    System::new(&model).at(0.0, &model.start_position, &model.start_velocity).poses(&mut poses);
    let point = size * random.vector(1.0);
    let place = poses[model.body(&last).expect("the last body")].transform_point(&point.into()).coords;
    let (roll, pitch, yaw) = turn.euler_angles();
    let kind = match random.below(6) {
        0 => "type = \"revolute\"\naxis = [0, 0, 1]",
        1 => "type = \"cylindrical\"\naxis = [0, 0, 1]",
        2 => "type = \"prismatic\"\naxis = [1, 0, 0]",
        3 => "type = \"universal\"\naxes = [[0, 0, 1], [1, 0, 0]]",
        4 => "type = \"spherical\"",
        _ => "type = \"planar\"",
    };
    let rpy = if kind.contains("spherical") { String::new() } else { format!("rpy = [{roll:e}, {pitch:e}, {yaw:e}]") };
    let gravity = list(&(turn * Vector3::new(3.0, -8.0, 4.0)));
    format!(
        "gravity = {gravity}\n{bodies}[[loop]]\nname = \"closure\"\n{kind}\n{rpy}\nbetween = [{{ body = \"ground\", at = {} }}, \
         {{ body = \"{last}\", at = {} }}]\n",
        list(&place),
        list(&point)
    )
}

/// As many rows count, and the accelerations are the same, whichever way a scene is turned.
#[test]
fn turning_a_scene_as_a_whole_changes_nothing() {
    let (mut redundant, mut moving) = (0, 0);
    for seed in 0..300 {
        let [upright, turned] = [false, true].map(|turns| {
            let mut random = Random::new(seed);
            let turn = random.turn();
            let text = linkage(&mut random, &if turns { turn } else { UnitQuaternion::identity() });
            read(&text).1
        });
        let count =
            |model: &Model| model.independent_rows.as_ref().expect("decided").iter().filter(|row| **row).count();
        assert_eq!(count(&upright), count(&turned), "seed {seed}");
        let (a, b) = (accelerations(&upright, 0.0), accelerations(&turned, 0.0));
        let size = a.iter().fold(1.0_f64, |m, a| m.max(a.abs()));
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart <= 1e-7 * size, "seed {seed}: {a:?} {b:?}");
        redundant += usize::from(count(&upright) < upright.independent_rows.as_ref().map_or(0, Vec::len));
        moving += usize::from(count(&upright) < upright.velocity_count());
    }
    assert!(redundant > 200 && moving > 100, "{redundant} {moving}");
}
