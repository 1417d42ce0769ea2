//! The methods of statics against each other: each one's claim is checked apart from it, and their answers agree.

use crate::common::{Options, build, random_scene};
use crate::scenarios::{file, shipped};
use assert_cmd::Command;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::description::*;
use stillpoint::model::{Description, Model};
use stillpoint::statics::{Equilibrium, Method, Settings, StabilityVerdict, Want, equilibrium};

const BASELINES: [Method; 2] = [Method::Relaxation, Method::Lagrange];

fn by(method: Method, model: &Arc<Model>, start: &[f64]) -> Equilibrium {
    equilibrium(model, &Settings { method, want: Want::Stable, ..Settings::default() }, start).expect("statics")
}

/// Rods of 0.1 kg and 0.1 m, one below the other, each bent against the one before.
fn chain(links: usize, bend: f64) -> Description {
    let rod = |index: usize| {
        let mut hinge = HingeDescription::new(HingeKind::Revolute { axis: Vector3::y() });
        hinge.position = vec![bend];
        hinge.parent = if index == 0 { GROUND.to_owned() } else { format!("rod{}", index - 1) };
        hinge.at = Point::At(Vector3::new(if index == 0 { 0.0 } else { 0.1 }, 0.0, 0.0));
        let inertia = Matrix3::from_diagonal(&Vector3::new(1e-6, 8.4e-5, 8.4e-5));
        let mass = MassProperties { mass: 0.1, center: Vector3::new(0.05, 0.0, 0.0), inertia };
        BodyDescription { name: format!("rod{index}"), mass, markers: Vec::new(), shapes: Vec::new(), hinge }
    };
    Description { bodies: (0..links).map(rod).collect(), ..Description::default() }
}

/// Largest distance of a root marker, and largest angle between bodies.
fn apart(a: &Equilibrium, b: &Equilibrium) -> f64 {
    let pairs = a.poses.iter().zip(&b.poses);
    pairs
        .map(|(a, b)| (a.translation.vector - b.translation.vector).norm().max(a.rotation.angle_to(&b.rotation)))
        .fold(0.0, f64::max)
}

/// The largest force (N, N m) that an answer leaves unbalanced where it may move, in the words of the equations of
/// motion.
fn unbalanced(model: &Arc<Model>, q: &[f64]) -> f64 {
    let rest = vec![0.0; model.velocity_count()];
    let mut residual = rest.clone();
    System::new(model).at(0.0, q, &rest).residual(&rest, &mut residual).expect("a residual");
    let free = residual.iter().zip(&model.coordinates).filter(|(_, coordinate)| !coordinate.lock);
    free.map(|(r, _)| r.abs()).fold(0.0, f64::max)
}

fn assert_agree(name: &str, model: &Arc<Model>, methods: &[Method], tolerance: f64) {
    let start = &model.start_position;
    let cascade = by(Method::Auto, model, start);
    assert!(cascade.converged, "{name}: {:?}", cascade.notes);
    let weight = model.total_mass() * 9.80665 + 100.0;
    for method in methods {
        let found = by(*method, model, start);
        assert!(found.converged, "{name} by {method:?}: {:?}", found.notes);
        assert_eq!(found.method, method.name());
        // Balanced means 1e-10 of the forces that cancel; the scenes are a few metres large.
        assert!(unbalanced(model, &found.position) < 1e-9 * weight, "{name} by {method:?}");
        let distance = apart(&cascade, &found);
        assert!(distance < tolerance, "{name} by {method:?}: {distance:e} apart");
    }
}

#[test]
fn the_three_methods_agree_on_shipped_scenes() {
    let all = [Method::Newton, Method::Relaxation, Method::Lagrange];
    for name in ["fan_pendulum", "caster_table", "machine_on_mounts", "spring_arm"] {
        // 1e-10 of the forces, over stiffnesses that are a few hundredths of them per unit at least.
        assert_agree(name, &shipped(name, &[]).1, &all, 1e-8);
    }
    // Here the guess is too far for Newton alone.
    for name in ["calder_mobile", "double_pendulum"] {
        assert_agree(name, &shipped(name, &[]).1, &BASELINES, 1e-6);
    }
}

#[test]
fn the_baselines_agree_on_bent_chains() {
    for links in [5, 20, 50] {
        let model = build(&chain(links, 0.1));
        // Each link turns by 1e-10 at most; what hangs on it adds up over the links, twice for the place.
        assert_agree("chain", &model, &BASELINES, 1e-10 * (links * links) as f64);
    }
}

#[test]
fn lagrange_has_the_exact_tangent_of_every_hinge_and_force() {
    let mut tried = 0;
    for seed in 0..60 {
        let options = Options { bodies: 4, springs: true, welds: true };
        let model = build(&random_scene(seed, &options));
        let any = |method| Settings { method, want: Want::Any, ..Settings::default() };
        let Ok(near) = equilibrium(&model, &any(Method::Auto), &model.start_position) else { continue };
        if !near.balanced || near.stability.as_ref().is_none_or(|s| s.verdict == StabilityVerdict::Neutral) {
            continue;
        }
        let mut start = near.position.clone();
        let step: Vec<f64> = (0..model.velocity_count()).map(|i| 1e-4 * (1.0 + (i % 3) as f64)).collect();
        System::displace(&model, &mut start, &step);
        let found = equilibrium(&model, &any(Method::Lagrange), &start).expect("statics");
        assert!(found.balanced && found.stage == "newton", "seed {seed}: {:?}", found.notes);
        // From 1e-4 two doublings of the digits are enough; one more for scenes that bend strongly, and the looks.
        assert!(found.iterations <= 5, "seed {seed}: {} steps", found.iterations);
        assert_multipliers(&model, &found);
        tried += 1;
    }
    assert!(tried >= 15, "{tried}");
}

/// The multipliers against what the tree's own balance says.
fn assert_multipliers(model: &Model, found: &Equilibrium) {
    assert_eq!(found.multiplier_reactions.len(), model.bodies.len());
    let size = found.reactions.iter().map(|w| w.force.norm().max(w.moment.norm())).fold(1.0, f64::max);
    for (index, body) in model.bodies.iter().enumerate() {
        let welded = body.link == 0 || model.links[body.link].body != index;
        if welded {
            continue;
        }
        let (own, other) = (found.multiplier_reactions[index], found.reactions[index]);
        let off = (own.force - other.force).norm().max((own.moment - other.moment).norm());
        // Both are balanced to about 1e-10 of forces of this size.
        assert!(off < 1e-8 * size, "{}: {own:?} instead of {other:?}", body.name);
    }
}

#[test]
fn the_multipliers_are_the_reactions() {
    for name in ["spring_arm", "calder_mobile", "caster_table", "machine_on_mounts"] {
        let (_, model) = shipped(name, &[]);
        let found = by(Method::Lagrange, &model, &model.start_position);
        assert!(found.converged, "{name}: {:?}", found.notes);
        assert_multipliers(&model, &found);
    }
    assert!(by(Method::Relaxation, &build(&chain(3, 0.1)), &[0.1; 3]).multiplier_reactions.is_empty());
}

#[test]
fn locked_hinges_stay_and_hold_the_same_force() {
    let mut description = chain(6, 0.3);
    description.bodies[2].hinge.lock = true;
    let model = build(&description);
    let cascade = by(Method::Auto, &model, &model.start_position);
    for method in BASELINES {
        let found = by(method, &model, &model.start_position);
        assert!(found.converged, "{method:?}: {:?}", found.notes);
        assert_eq!(found.position[2], 0.3);
        assert!(apart(&cascade, &found) < 1e-8, "{method:?}");
        // The weights below the lock are 3 N at 0.3 m.
        assert!((found.holding[0].1 - cascade.holding[0].1).abs() < 1e-8, "{method:?}: {:?}", found.holding);
    }
}

#[test]
fn without_an_equilibrium_each_method_says_so() {
    let mut description = chain(1, 0.1);
    description.bodies[0].hinge = HingeDescription::new(HingeKind::Free);
    description.bodies[0].hinge.parent = GROUND.to_owned();
    let model = build(&description);
    for method in Method::ALL {
        let found = by(method, &model, &model.start_position);
        assert!(!found.converged && !found.balanced && found.stability.is_none(), "{method:?}");
        let notes = found.notes.join("; ");
        assert!(notes.contains("nothing holds `rod0` against gravity"), "{method:?}: {notes}");
    }
}

#[test]
fn a_balanced_start_costs_the_baselines_no_step() {
    let model = build(&chain(4, 0.0));
    let start = [std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0];
    for method in BASELINES {
        let found = by(method, &model, &start);
        assert!(found.converged && found.iterations == 0 && found.position == start, "{method:?}");
    }
}

#[test]
fn compare_prints_and_writes_one_line_per_method() {
    let folder = tempfile::tempdir().expect("a folder");
    let call = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stillpoint"));
        let output = command.current_dir(folder.path()).args(arguments).output().expect("the program starts");
        assert!(output.stderr.is_empty(), "{output:?}");
        (output.status.code(), String::from_utf8(output.stdout).expect("text"))
    };
    let scene = file("double_pendulum");
    let scene = scene.to_str().expect("a path");
    let (code, text) = call(&["statics", "--compare", scene, "--out", "table"]);
    assert_eq!(code, Some(0));
    for method in Method::ALL {
        assert!(text.lines().any(|line| line.trim_start().starts_with(method.name())), "{text}");
    }
    // What failed is there, with its reason.
    assert!(text.contains("newton     failed: nothing balances"), "{text}");
    let csv = std::fs::read_to_string(folder.path().join("table.csv")).expect("a table");
    assert_eq!(csv.lines().count(), 1 + Method::ALL.len());
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("table.json")).expect("a table"))
            .expect("JSON");
    let plot = std::fs::read_to_string(folder.path().join("table.svg")).expect("a plot");
    assert!(plot.contains("residual against iteration") && plot.contains("lagrange"), "residuals are drawn");
    // A name with one of the endings stands for all three.
    call(&["statics", "--compare", scene, "--out", "again.svg"]);
    assert!(["csv", "svg", "json"].iter().all(|ending| folder.path().join("again").with_extension(ending).exists()));
    let (_, printed) = call(&["statics", "--compare", scene, "--json"]);
    let printed: serde_json::Value = serde_json::from_str(&printed).expect("JSON");
    assert_eq!(printed["methods"].as_array().map(Vec::len), Some(Method::ALL.len()));
    for key in ["method", "iterations", "force_evaluations", "factorizations", "relative_residual", "outcome"] {
        assert_eq!(printed["methods"][2][key], json["methods"][2][key], "{key}");
    }
    let (code, one) = call(&["statics", scene, "--method", "lagrange", "--json"]);
    let one: serde_json::Value = serde_json::from_str(&one).expect("JSON");
    assert_eq!((code, one["method"].as_str()), (Some(0), Some("lagrange")));
}

/// Over several values: one table, and times against the size of the scene.
#[test]
fn compare_goes_over_the_values_of_a_number() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = file("hanging_chain");
    let mut command = Command::new(env!("CARGO_BIN_EXE_stillpoint"));
    command.current_dir(folder.path()).args(["statics", "--compare", "--json", "--out", "chains"]);
    command.args(["--set", "link.position=0.1", "--over", "link.repeat=2,5"]).arg(scene);
    let output = command.output().expect("the program starts");
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let sizes: Vec<_> =
        found["runs"].as_array().expect("runs").iter().map(|run| run["degrees_of_freedom"].as_u64()).collect();
    assert_eq!((found["over"].as_str(), sizes), (Some("link.repeat"), vec![Some(2), Some(5)]));
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a file");
    let table = read("chains.csv");
    assert_eq!(table.lines().count(), 1 + 2 * Method::ALL.len());
    assert!(
        table.starts_with("value,degrees_of_freedom,method,") && table.contains("\n\"5\",5,\"lagrange\","),
        "{table}"
    );
    let plot = read("chains.svg");
    assert!(plot.contains("degrees of freedom") && plot.contains("relaxation"), "times are drawn");
}
