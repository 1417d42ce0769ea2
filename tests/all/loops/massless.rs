//! Driven bodies without mass: a motion that is given needs no inertia.

use super::read;
use crate::common::Random;
use std::fmt::Write;
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::integrate::{Method, Options, Start};
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::simulate::problem::Equations;
use stillpoint::statics::{Settings, equilibrium};

/// All begin where the hinges are given.
const MOTIONS: [&str; 4] = [
    "type = \"hold\"",
    "type = \"sine\"\namplitude = 0.2\nfrequency = 0.7",
    "type = \"table\"\ntimes = [0.0, 0.5, 1.0]\nvalues = [0.0, 0.1, 0.0]",
    "type = \"expression\"\nexpression = \"0.1*t^2+0.2*t\"",
];

/// Driven bodies of so much mass between and at the ends of a tree of others.
fn scene(seed: u64, mass: f64) -> (String, Vec<String>) {
    let mut random = Random::new(seed);
    let (mut text, mut drives, mut driven) = (String::new(), String::new(), Vec::new());
    let count = 2 + random.below(5);
    for i in 0..count {
        let parent = if i == 0 || random.below(5) == 0 { "ground".to_owned() } else { format!("b{}", random.below(i)) };
        let axis = ["[0, 0, 1]", "[1, 0, 0]", "[0, 1, 0]"][random.below(3)];
        let (kind, is_driven) = (["prismatic", "revolute"][random.below(2)], i == 0 || random.below(2) == 0);
        let motion = random.below(MOTIONS.len());
        let numbers = random.list(3, -0.5, 0.5);
        let own = random.between(0.5, 3.0);
        let body = match is_driven {
            true if mass == 0.0 => String::new(),
            true => format!("mass = {mass:?}\ninertia = [{0:?}, {0:?}, {0:?}]\n", 0.1 * mass),
            false => format!("mass = {own:?}\ninertia = [0.1, 0.2, 0.15]\ncenter = [{:?}, 0.1, 0.2]\n", numbers[0]),
        };
        let spring = if is_driven { "" } else { ", stiffness = 800.0, damping = 2.0" };
        let _ = write!(
            text,
            "[[body]]\nname = \"b{i}\"\n{body}\
             hinge = {{ type = \"{kind}\", parent = \"{parent}\", at = [{:?}, 0.3, {:?}], axis = {axis}{spring} }}\n",
            numbers[1], numbers[2]
        );
        if is_driven {
            let _ = write!(drives, "[[drive]]\nname = \"d{i}\"\nhinge = \"b{i}\"\n{}\n", MOTIONS[motion]);
            driven.push(format!("d{i}"));
        }
    }
    (text + &drives, driven)
}

/// Accelerations, forces of the drives and reactions at the start, and those of the equilibrium beside held drives.
fn answers(text: &str) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (_, model) = read(text);
    let (q, v) = (&model.start_position, &model.start_velocity);
    let mut system = System::new(&model);
    let mut a = vec![0.0; q.len()];
    system.at(0.0, q, v).accelerations(&mut a).expect("accelerations");
    let forces = system.constraints().expect("rows").drive_forces(&model, &a).map(|(_, force)| force).collect();
    let mut residual = a.clone();
    system.at(0.0, q, v).residual(&a, &mut residual).expect("a balance");
    assert!(residual.iter().all(|r| r.abs() < 1e-9), "{residual:?}");
    let energies = system.at(0.0, q, v).energies();
    (a, forces, vec![energies.kinetic, energies.potential])
}

/// Without mass everything is what it tends to as the masses of the driven bodies vanish: a line through two light ones leaves
/// the square of their mass.
#[test]
fn massless_driven_bodies_are_the_limit_of_light_ones() {
    const LIGHT: f64 = 1e-5;
    for seed in 0..200 {
        let [massless, once, twice] = [0.0, LIGHT, 2.0 * LIGHT].map(|mass| answers(&scene(seed, mass).0));
        let near = |what: &str, found: &[f64], once: &[f64], twice: &[f64]| {
            for ((found, once), twice) in found.iter().zip(once).zip(twice) {
                let expected = 2.0 * once - twice;
                let apart = (found - expected).abs();
                assert!(apart < 1e-7 * (1.0 + once.abs()), "seed {seed}: {what} {found} {expected}, {apart:e} apart");
            }
        };
        near("acceleration", &massless.0, &once.0, &twice.0);
        near("force of a drive", &massless.1, &once.1, &twice.1);
        near("energy", &massless.2, &once.2, &twice.2);
    }
}

/// Explicit and implicit runs end where those of light driven bodies do, and the equilibrium is the same.
#[test]
fn massless_driven_bodies_run_and_rest() {
    let end = |model: &Arc<Model>, method: Method| {
        let mut motion = Equations::new(model);
        let options = Options { relative: 1e-9, absolute: 1e-9, ..Options::default() };
        let start = Start { time: 0.0, position: &model.start_position, velocity: &model.start_velocity, end: 0.4 };
        let mut stepper = method.start(&mut motion, &options, start).expect("the run starts");
        while !stepper.finished() {
            stepper.step(&mut motion).expect("a step");
        }
        stepper.position().to_vec()
    };
    for seed in 0..12 {
        let [massless, light] = [0.0, 1e-8].map(|mass| read(&scene(seed, mass).0).1);
        let reference = end(&light, Method::Dop853);
        for method in [Method::Dopri5, Method::Radau9] {
            let apart = end(&massless, method).iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-6, "seed {seed} by {method:?}: {apart:e}");
        }
        let [one, other] = [&massless, &light]
            .map(|model| equilibrium(model, &Settings::default(), &model.start_position).expect("statics"));
        assert_eq!(one.converged, other.converged, "seed {seed}: {:?} {:?}", one.notes, other.notes);
        if one.converged {
            let apart = one.position.iter().zip(&other.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-7, "seed {seed}: {apart:e}");
        }
    }
}

/// A hinge that nothing drives still needs something with inertia.
#[test]
fn what_nothing_drives_is_refused() {
    let text = "[[body]]\nname = \"road\"\nhinge = { type = \"prismatic\", axis = [0, 0, 1] }\n\
                [[body]]\nname = \"arm\"\nhinge = { type = \"revolute\", parent = \"road\", axis = [0, 1, 0] }\n\
                [[drive]]\nhinge = \"road\"\ntype = \"hold\"\n";
    let shown = scenario::parse("scene.toml", text, &[]).expect_err("a refusal").render(false);
    assert!(shown.contains("neither `arm` nor anything it carries has mass") && !shown.contains("`road`"), "{shown}");
}
