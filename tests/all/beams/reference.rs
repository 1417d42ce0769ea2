//! The shipped scenes of beams against answers from outside: closed forms, shooting, Ritz, roots of characteristic equations.

use super::statics::{case, expected, order};
use crate::scenarios::shipped;
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::record::{Fanout, Memory, Opening};
use stillpoint::scenario::Scenario;
use stillpoint::simulate::{State, run};
use stillpoint::statics::path::{EventKind, PathPoint, follow};
use stillpoint::statics::{Equilibrium, StabilityVerdict, equilibrium, outputs};

fn solved(name: &str, changes: &[&str]) -> (Scenario, Arc<Model>, Equilibrium) {
    let (scenario, model) = shipped(name, changes);
    let (model, _) = stillpoint::constraint::assemble(model).expect("it closes");
    let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("no fault");
    assert!(found.converged, "{name} {changes:?}: {:?}", found.notes);
    (scenario, model, found)
}

/// The numbers of an output at the equilibrium.
fn output(name: &str, changes: &[&str], of: &str) -> Vec<f64> {
    let (_, model, found) = solved(name, changes);
    let all = outputs(&model, &found).expect("finite");
    all[model.outputs.iter().find(|output| output.name == of).expect("an output of that name").range()].to_vec()
}

/// Frequencies of what swings (rad/s), ascending.
fn frequencies(name: &str, changes: &[&str]) -> Vec<f64> {
    let (_, _, found) = solved(name, changes);
    found.stability.as_ref().expect("a verdict").frequencies().map(|hz| hz * TAU).collect()
}

/// The events of one kind along the path of a scene.
fn events(name: &str, changes: &[&str], kind: EventKind) -> Vec<PathPoint> {
    let (scenario, _) = shipped(name, changes);
    let settings = scenario.path.as_ref().expect("a path");
    let path = follow(&scenario.description, &scenario.statics, settings, &mut |_| true).expect("a path");
    let events = path.events().filter(|(_, point)| point.event.as_ref().is_some_and(|event| event.kind == kind));
    events.map(|(_, point)| point.clone()).collect()
}

/// The load under which Lee's frame snaps, and how far it has gone down there.
#[test]
fn lee_frame() {
    let case = case("lee_frame");
    let folds = events("beams/lee_frame", &["statics.path.to=-19000.0", "statics.path.step=0.05"], EventKind::Fold);
    let (load, tolerance) = expected(&case, 0);
    assert!((-folds[0].parameter - load[0]).abs() < tolerance, "{} and not {load:?}", folds[0].parameter);
    let (down, tolerance) = expected(&case, 1);
    assert!((120.0 - folds[0].outputs[0] - down[0]).abs() < tolerance, "{:?} and not {down:?}", folds[0].outputs);
}

/// Where Beck's column flutters: the error of the load falls with the fourth power of the number of elements.
#[test]
fn beck_column() {
    let (load, _) = expected(&case("beck_follower"), 0);
    let error = |elements: usize| {
        let (elements, range) =
            (format!("column.elements={elements}"), ["statics.path.from=-19.8", "statics.path.to=-20.3"]);
        let found = events("beams/beck_column", &[&elements, range[0], range[1]], EventKind::Flutter);
        (-found[0].parameter / load[0] - 1.0).abs()
    };
    let errors = [error(4), error(8)];
    assert!(errors[1] < 3.1e-4 && order(&errors) > 3.5, "{errors:?}");
}

/// A helical spring's stiffness, and its rise under a load that pulls it out by a third.
#[test]
fn helical_spring() {
    let case = case("helical_spring");
    let height =
        |load: f64| output("beams/helical_spring", &[&format!("pull.force=[0.0, 0.0, {load:?}]")], "height")[0];
    let (stiffness, tolerance) = expected(&case, 0);
    let found = 20.0 / (height(10.0) - height(-10.0));
    assert!((found - stiffness[0]).abs() < tolerance, "{found} and not {stiffness:?}");
    let (rise, tolerance) = expected(&case, 2);
    let found = height(1000.0) - 0.15;
    assert!((found - rise[0]).abs() < tolerance, "{found} and not {rise:?}");
}

/// A blade that turns: what Ritz finds, to a millionth with elements of degree 2.
#[test]
fn turning_blade() {
    let case = case("rotating_beam");
    let flap = |index: usize, changes: &[&str], lag: bool| {
        let found = frequencies("beams/blade", &[changes, &["blade.degree=2"]].concat());
        let (value, _) = expected(&case, index);
        for (k, value) in value.iter().enumerate() {
            // Lead-lag is below flap by Ω².
            let found = found[2 * k + usize::from(!lag)];
            assert!((found / value - 1.0).abs() < 1e-6, "{changes:?}: {found} and not {value}");
        }
    };
    flap(1, &["motor.rate=2.0"], false);
    flap(2, &["motor.rate=6.0"], false);
    flap(3, &[], false);
    flap(4, &["blade.hinge.at=[1.0, 0.0, 0.0]"], false);
    flap(5, &[], true);
}

/// A cable without bending stiffness that hangs from a pin. With degree 1 frequencies err with the fourth power of the elements' length; with
/// degree 2 eight elements have more digits than sixteen.
#[test]
fn hanging_cable() {
    let (value, _) = expected(&case("hanging_cable_modes"), 0);
    let errors = |elements: usize| {
        let found = frequencies("beams/hanging_cable", &[&format!("cable.elements={elements}")]);
        value.iter().enumerate().map(|(k, value)| (found[2 * k] / value - 1.0).abs()).collect::<Vec<_>>()
    };
    let (coarse, fine) = (errors(8), errors(16));
    assert!(fine[0] < 1e-8 && fine[1] < 1e-6 && fine[2] < 2e-5 && fine[3] < 2e-4, "{fine:?}");
    assert!((0..4).all(|k| order(&[coarse[k], fine[k]]) > 3.5), "{coarse:?} {fine:?}");
    let found = frequencies("beams/hanging_cable", &["cable.elements=8", "cable.degree=2"]);
    for (k, off) in [1e-11, 1e-9, 1e-7, 1e-5].into_iter().enumerate() {
        assert!((found[2 * k] / value[k] - 1.0).abs() < off, "{k}: {} and not {}", found[2 * k], value[k]);
    }
}

/// A straight column that is held at both ends: the load at which it buckles.
#[test]
fn columns_that_are_held_at_both_ends() {
    let case = case("euler_columns");
    let pinned = ["column.hinge.type=revolute", "column.hinge.axis=[0.0, 1.0, 0.0]"];
    for (index, changes, range) in [(2, &pinned[..], [-20.0, -20.4]), (3, &[], [-39.2, -39.7])] {
        let range = [format!("statics.path.from={:?}", range[0]), format!("statics.path.to={:?}", range[1])];
        let changes = [changes, &[&range[0], &range[1], "statics.path.branches=false"]].concat();
        let (load, _) = expected(&case, index);
        let found = events("beams/held_column", &changes, EventKind::Bifurcation);
        assert!((-found[0].parameter / load[0] - 1.0).abs() < 3e-6, "{} and not {load:?}", found[0].parameter);
    }
}

/// A thin strip on edge: Prandtl's and Michell's number in the limit of one that is rigid on edge, where it bears more by as much as
/// it is less stiff flat.
#[test]
fn strip_on_edge() {
    for edge in [1e3, 1e4] {
        let stiffness = format!("strip.section.stiffness=[1e6, 1e6, 1e6, 1.0, {edge:?}, 1.0]");
        let range = ["statics.path.from=-3.95", "statics.path.to=-4.1", "statics.path.branches=false"];
        let changes = [&[stiffness.as_str()], &range[..]].concat();
        let found = events("beams/strip_buckles_sideways", &changes, EventKind::Bifurcation);
        let more = -found[0].parameter / 4.012_599_3 - 1.0;
        // The mesh alone makes 5e-5 of it.
        assert!(more > 0.0 && more < 1.5 / edge + 5e-5, "{more:e} of a strip with {edge}");
    }
}

/// A moment rolls a rod up, an arc is bent out of its plane: places known to more digits than eight elements have.
#[test]
fn circle_and_bend() {
    let (_, _, found) = solved("beams/rolled_into_a_circle", &[]);
    assert_eq!(found.iterations, 1, "one Newton step");
    let tip = output("beams/bathe_bend", &[], "tip");
    let (value, _) = expected(&case("bathe_bolourchi_45"), 2);
    assert!((Vector3::from_column_slice(&tip) - Vector3::from_column_slice(&value)).norm() < 5e-4, "{tip:?}");
}

/// The elastica of rigid links, and of elements: order two against four, and what that means.
#[test]
fn links_or_elements() {
    let (value, _) = expected(&case("elastica_tip_force"), 3);
    let off = |name: &str, changes: &[&str]| {
        let tip = output(name, changes, "tip");
        (tip[0] - 1.0 + value[0]).hypot(tip[2] + value[1])
    };
    let links = |n: usize| {
        let last = format!("link[{}].end", n - 1);
        let counts = [format!("parameters.n={n}"), format!("link.repeat={n}")];
        let ends = [format!("pull.on=\"{last}\""), format!("tip.of=\"{last}\"")];
        off("beams/elastica_of_links", &[&counts[0], &counts[1], &ends[0], &ends[1]])
    };
    let elements = |n: usize| off("beams/elastica", &[&format!("rod.elements={n}")]);
    let of_links = [8, 16, 32].map(links);
    let of_elements = [2, 4, 8].map(elements);
    assert!((order(&of_links) - 2.0).abs() < 0.2, "{of_links:?}");
    assert!((order(&of_elements) - 4.0).abs() < 0.4, "{of_elements:?}");
    // Eight coordinates each: 4 elements of two in the plane, 8 links.
    assert!(of_elements[1] < of_links[0] / 50.0, "{of_elements:?} {of_links:?}");
}

/// A rod that is kicked and flies on: its centre of mass is where that of a point would be, whatever it does about it, and its ends
/// are near those that another program extrapolates.
#[test]
fn flying_rod() {
    let case = case("flying_rod");
    let (scenario, model) = shipped("beams/flying_rod", &["simulate.duration=2.5"]);
    let start = State { position: model.start_position.clone(), velocity: vec![0.0; model.velocity_count()] };
    let summary = run(&model, &scenario.simulate, 10.0, &start, &mut Fanout::new(), &mut |_, _| true).expect("a run");
    let end = |name: &str| {
        let range = model.outputs.iter().find(|output| output.name == name).expect("an output").range();
        Vector3::from_column_slice(&summary.outputs[range])
    };
    for (index, name) in [(2, "lower"), (3, "upper")] {
        let (value, _) = expected(&case, index);
        let off = end(name) - Vector3::new(value[0], value[1], 0.0);
        // Eight elements against the extrapolation, which has no second source.
        assert!(off.norm() < 8e-3, "{name}: off by {off:?}");
    }
    assert!(summary.energy_drift < 1e-5 * summary.work.abs(), "{:e} of {}", summary.energy_drift, summary.work);
}

/// A beam that is spun up lags behind its hub, comes back, and is drawn out by what a bar in closed form is.
#[test]
fn spun_up() {
    let case = case("spin_up");
    let (scenario, model) = shipped("beams/spin_up", &["record.rate=20.0"]);
    let start = State { position: model.start_position.clone(), velocity: vec![0.0; model.velocity_count()] };
    let scene = stillpoint::simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: &scenario.text, statics: None });
    let summary = run(&model, &scenario.simulate, 20.0, &start, &mut memory, &mut |_, _| true).expect("a run");
    let range = |name: &str| model.outputs.iter().find(|output| output.name == name).expect("an output").range();
    let all = |name: &str| {
        memory.samples.iter().map(move |sample| (sample.time, sample.outputs[range(name).start])).collect::<Vec<_>>()
    };
    let (lag, extension) = (all("lag"), all("extension"));
    let most = *lag.iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("samples");
    let (value, tolerance) = expected(&case, 1);
    assert!((most.1 - value[0]).abs() < tolerance, "{most:?} and not {value:?}");
    let (value, tolerance) = expected(&case, 2);
    assert!((most.0 - value[0]).abs() < tolerance, "{most:?} and not at {value:?}");
    let (value, tolerance) = expected(&case, 3);
    let there = lag.iter().position(|(time, _)| (time - 7.5).abs() < 1e-9).expect("a sample");
    let off = [extension[there].1 - value[0], lag[there].1 - value[1]];
    assert!(off.iter().all(|off| off.abs() < tolerance), "{off:?}");
    let (value, tolerance) = expected(&case, 0);
    assert!((summary.outputs[range("extension").start] - value[0]).abs() < tolerance);
}

/// What stands on beams is stable.
#[test]
fn structures_stand() {
    for name in ["crane_boom", "compliant_arm", "mooring_line", "footbridge"] {
        let (_, _, found) = solved(&format!("beams/{name}"), &[]);
        assert_eq!(
            found.stability.as_ref().map(|stability| stability.verdict),
            Some(StabilityVerdict::Stable),
            "{name}"
        );
    }
}

/// Every scene of this folder loads without a warning and tells its claim.
#[test]
fn scenes_load() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/beams");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the folder") {
        let path = entry.expect("an entry").path();
        let (scenario, model) = shipped(&format!("beams/{}", path.file_stem().expect("a name").to_string_lossy()), &[]);
        assert!(scenario.warnings.is_empty(), "{}: {}", path.display(), scenario.warnings);
        assert!(!model.title.is_empty() && scenario.text.starts_with("# "), "{}: no title or no story", path.display());
        count += 1;
    }
    assert!(count >= 15, "{count} scenes");
}
