//! Which rows are independent is a matter of the linkage alone: not of what stands beside it, of masses, or of units.

use super::read;
use crate::common::Random;
use nalgebra::Vector3;
use std::fmt::Write;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::spatial::Pose;

/// A linkage in `size` metres and `weight` kilograms: a chain from the ground, closed where it stands.
struct Linkage {
    bodies: String,
    closure: String,
    count: usize,
}

fn list(v: &Vector3<f64>) -> String {
    format!("[{:e}, {:e}, {:e}]", v.x, v.y, v.z)
}

/// The chain: bars on revolute hinges with parallel axes, on mixed hinges, or one free body.
fn chain(random: &mut Random, size: f64, weight: f64) -> (String, usize) {
    let (mut text, kind) = (String::new(), random.below(3));
    let count = if kind == 2 { 1 } else { 3 + random.below(2) };
    let axis = random.vector(1.0).normalize();
    for i in 0..count {
        let hinge = match (kind, i) {
            (0, _) => {
                format!("type = \"revolute\", axis = {}, position = {:e}", list(&axis), random.between(-1.0, 1.0))
            }
            (1, 0) => format!("type = \"revolute\", axis = {}, position = 0.3", list(&random.vector(1.0))),
            (1, 1) => format!("type = \"prismatic\", axis = {}, position = {:e}", list(&axis), 0.2 * size),
            (1, _) => "type = \"spherical\", position = [0.8, 0.6, 0.0, 0.0]".to_owned(),
            _ => format!("type = \"free\", position = [{:e}, 0, 0, 0.6, 0.0, 0.8, 0.0]", 0.1 * size),
        };
        let parent = if i == 0 { String::new() } else { format!("parent = \"bar{}\", at = \"tip\", ", i - 1) };
        let (mass, inertia) = (weight * random.between(0.5, 2.0), weight * size * size * 0.05);
        let _ = write!(
            text,
            "[[body]]\nname = \"bar{i}\"\nmass = {mass:e}\ninertia = [{inertia:e}, {inertia:e}, {inertia:e}]\n\
             center = {}\nmarkers = {{ tip = {} }}\nhinge = {{ {parent}{hinge} }}\n",
            list(&random.vector(0.3 * size)),
            list(&(size * (Vector3::x() * 0.6 + random.vector(0.4)))),
        );
    }
    (text, count)
}

fn linkage(random: &mut Random, size: f64, weight: f64) -> Linkage {
    let (bodies, count) = chain(random, size, weight);
    let scene = scenario::parse("scene.toml", &bodies, &[]).unwrap_or_else(|p| panic!("{}", p.render(false)));
    let model = Model::build(&scene.description).expect("a chain");
    let mut system = System::new(&model);
    let mut poses: Vec<Pose> = Vec::new();
    system.at(0.0, &model.start_position, &model.start_velocity).poses(&mut poses);
    let point = random.vector(0.3 * size);
    let at = poses[count - 1].transform_point(&point.into()).coords;
    let last = format!("bar{}", count - 1);
    let ends = format!(
        "between = [{{ body = \"ground\", at = {} }}, {{ body = \"{last}\", at = {} }}]",
        list(&at),
        list(&point)
    );
    let kind = match random.below(4) {
        0 => "type = \"fixed\"".to_owned(),
        1 => "type = \"spherical\"".to_owned(),
        2 => format!("type = \"revolute\"\naxis = {}", list(&random.vector(1.0))),
        _ => "type = \"planar\"".to_owned(),
    };
    Linkage { bodies, closure: format!("[[loop]]\nname = \"closure\"\n{kind}\n{ends}\n"), count }
}

/// Something that shares no hinge with it, of any mass and any size.
fn stranger(random: &mut Random) -> String {
    let any = |random: &mut Random, digits: f64| 10.0_f64.powf(random.between(-digits, digits));
    let (mass, size) = (any(random, 9.0), any(random, 3.0));
    let inertia = mass * size * size;
    let at = list(&(size * random.vector(3.0)));
    let body = format!(
        "[[body]]\nname = \"stranger\"\nmass = {mass:e}\ninertia = [{inertia:e}, {inertia:e}, {inertia:e}]\n\
         center = {}\nmarkers = {{ tip = [{size:e}, 0, 0] }}\n",
        list(&(size * random.vector(0.3)))
    );
    match random.below(3) {
        0 => format!("{body}hinge = {{ type = \"free\" }}\n"),
        1 => format!("{body}hinge = {{ type = \"spherical\", at = {at} }}\n"),
        _ => format!(
            "{body}hinge = {{ type = \"free\" }}\n[[loop]]\nname = \"other\"\ntype = \"revolute\"\naxis = [0, 0, 1]\n\
             between = [{{ body = \"ground\", at = [{size:e}, 0, 0] }}, \"stranger.tip\"]\n"
        ),
    }
}

/// The rows of `closure` and the accelerations of the bars.
fn solved(text: &str, count: usize) -> (Vec<bool>, Vec<f64>) {
    let (_, model) = read(text);
    let at = model.loops.iter().position(|one| one.name == "closure").expect("the loop");
    let rows = |kind: &str| match kind {
        "fixed" => 6,
        "spherical" | "planar" => 3,
        _ => 5,
    };
    // The stranger's loop stands before or after.
    let own =
        text.split("name = \"closure\"\ntype = \"").nth(1).and_then(|rest| rest.split('"').next()).expect("its kind");
    let first = if at == 0 { 0 } else { 5 };
    let independent = model.independent_rows.as_ref().expect("decided")[first..first + rows(own)].to_vec();
    let mut system = System::new(&model);
    let mut a = vec![0.0; model.velocity_count()];
    system.at(0.0, &model.start_position, &model.start_velocity).accelerations(&mut a).expect("accelerations");
    let bars = (0..count).flat_map(|i| {
        let hinge = &model.bodies[model.body(&format!("bar{i}")).expect("a bar")].hinge;
        hinge.velocity..hinge.velocity + hinge.kind.counts().1
    });
    (independent, bars.map(|i| a[i]).collect())
}

fn assert_same(name: &str, (rows, a): &(Vec<bool>, Vec<f64>), (other, b): &(Vec<bool>, Vec<f64>), scale: f64) {
    assert_eq!(rows, other, "{name}");
    let size = a.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
    let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart <= scale * size.max(1.0), "{name}: {apart:e} of {size:e}");
}

#[test]
fn strangers_and_masses_do_not_change_which_rows_are_independent() {
    let mut kinds = std::collections::BTreeMap::new();
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let size = 10.0_f64.powf(random.between(-3.0, 3.0));
        let Linkage { bodies, closure, count } = linkage(&mut random, size, 1.0);
        let alone = solved(&(bodies.clone() + &closure), count);
        let left_out = alone.0.iter().filter(|row| !**row).count();
        *kinds.entry((alone.0.len(), left_out)).or_insert(0) += 1;
        let beside = stranger(&mut random);
        let (before, after) = (format!("{beside}{bodies}{closure}"), format!("{bodies}{closure}{beside}"));
        let name = format!("seed {seed}");
        // Where other bodies stand in the tree changes round-off only; angles are 1, accelerations g over the size.
        let round_off = 1e-9;
        assert_same(&name, &alone, &solved(&before, count), round_off);
        assert_same(&name, &alone, &solved(&after, count), round_off);
        let mut again = Random::new(seed);
        again.between(-3.0, 3.0);
        let weight = 10.0_f64.powf(again.between(-9.0, 9.0));
        let mut again = Random::new(seed);
        again.between(-3.0, 3.0);
        let heavy = linkage(&mut again, size, weight);
        assert_same(&name, &alone, &solved(&(heavy.bodies + &heavy.closure), count), round_off);
    }
    println!("rows and those left out: {kinds:?}");
    assert!(kinds.keys().any(|(_, left_out)| *left_out > 0) && kinds.keys().any(|(_, left_out)| *left_out == 0));
}

/// A weld holds whatever the moments of inertia of what it holds, and whatever is elsewhere.
#[test]
fn a_weld_holds_a_body_of_any_inertia() {
    for seed in 0..50 {
        let mut random = Random::new(900 + seed);
        let any = |random: &mut Random| 10.0_f64.powf(random.between(-6.0, 6.0));
        let (mass, inertia) = (any(&mut random), any(&mut random));
        let held = format!(
            "[[body]]\nname = \"held\"\nmass = {mass:e}\ninertia = [{inertia:e}, {inertia:e}, {inertia:e}]\n\
             hinge = {{ type = \"free\" }}\n[[loop]]\nname = \"weld\"\ntype = \"fixed\"\nbetween = [\"ground\", \"held\"]\n"
        );
        let (_, model) = read(&(held + &stranger(&mut random)));
        assert_eq!(model.independent_rows.as_ref().expect("decided")[..6], [true; 6], "seed {seed}");
        let mut system = System::new(&model);
        let mut a = vec![0.0; model.velocity_count()];
        system.at(0.0, &model.start_position, &model.start_velocity).accelerations(&mut a).expect("accelerations");
        assert!(a[..6].iter().all(|a| a.abs() < 1e-13), "seed {seed}: {a:?}");
    }
}
