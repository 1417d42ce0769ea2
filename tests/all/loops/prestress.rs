//! Rods whose lines meet in a point, or are parallel: a motion of first order and none of second.

use super::read;
use crate::common::Random;
use std::fmt::Write;
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, Settings, StabilityVerdict, equilibrium};

/// A planar body on bars, as rods or as springs of this stiffness. Weight and bars meet in one point: what balances is a line.
fn scene(seed: u64, stiffness: Option<f64>) -> String {
    let mut random = Random::new(seed);
    let bars = 3 + random.below(2);
    let parallel = random.below(3) == 0;
    let (x, z) = (random.between(-0.5, 0.5), random.between(-1.0, 1.0));
    let center = random.between(-0.4, 0.4);
    let mut text = format!(
        "[[body]]\nname = \"p\"\nmass = 1.0\ncenter = [{x:?}, {center:?}, 0]\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = {{ type = \"planar\", rpy = [1.5707963267948966, 0, 0] }}\n"
    );
    for bar in 0..bars {
        // The last one stands under the weight, so that bars push and pull.
        let angle = if parallel { 0.0 } else { random.between(-1.2, 1.2) + if bar % 2 == 0 { 0.0 } else { 3.1 } };
        let (sin, cos) = f64::sin_cos(angle);
        let (near, length) = (random.between(0.1, 0.6), random.between(0.3, 1.5));
        let sign = if parallel && bar % 2 == 1 { -1.0 } else { 1.0 };
        let place = |from: f64| match parallel {
            true => (x + [-0.6, 0.2, 0.5, 0.9][bar], sign * from),
            false => (x + from * sin, z + from * cos),
        };
        let ((ax, az), (bx, bz)) = (place(near + length), place(near));
        let length = (ax - bx).hypot(az - bz);
        let kind = match stiffness {
            None => "[[loop]]\ntype = \"rod\"\n".to_owned(),
            Some(stiffness) => format!("[[force]]\ntype = \"spring\"\nstiffness = {stiffness:?}\n"),
        };
        let _ = write!(
            text,
            "{kind}length = {length:?}\n\
             between = [{{ body = \"ground\", at = [{ax:?}, 0, {az:?}] }}, {{ body = \"p\", at = [{bx:?}, {bz:?}, 0] }}]\n"
        );
    }
    text
}

fn statics(model: &Arc<Model>) -> Equilibrium {
    equilibrium(model, &Settings::default(), &model.start_position).expect("statics")
}

#[test]
fn concurrent_and_parallel_bars_agree_with_stiff_springs() {
    let (mut frequencies, mut certified) = (0, 0);
    for seed in 0..60 {
        let (_, model) = read(&scene(seed, None));
        let rigid = statics(&model);
        assert!(rigid.converged, "seed {seed}: {:?}", rigid.notes);
        let stability = rigid.stability.as_ref().expect("an equilibrium");
        assert_eq!(stability.verdict, StabilityVerdict::Stable, "seed {seed}: {:?}", rigid.notes);
        assert!(rigid.notes.iter().any(|note| note.contains("of first order and none of second")), "seed {seed}");
        // Towards the limit of large stiffness; beyond 1e8 N/m the stiffness of the motion is round-off beside them.
        let springs = [1e6, 1e7].map(|stiffness| {
            let scene = scenario::parse("scene.toml", &scene(seed, Some(stiffness)), &[]).expect("a scene");
            statics(&Model::build(&scene.description).expect("a model"))
        });
        let near = |found: &Equilibrium| {
            found.position.iter().zip(&rigid.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        match stability.modes.first() {
            Some(mode) => {
                let is_stable = |found: &Equilibrium| {
                    found.stability.as_ref().is_some_and(|it| it.verdict == StabilityVerdict::Stable)
                };
                if !springs.iter().all(is_stable) {
                    // Next to buckling the stiffness of the motion is round-off beside the springs.
                    assert!(mode.frequency_hz < 0.1, "seed {seed}: {}", mode.frequency_hz);
                    continue;
                }
                let lowest = springs.each_ref().map(|found| {
                    assert!(found.converged && near(found) < 1e-3, "seed {seed}: {:?}", found.notes);
                    found.stability.as_ref().expect("an equilibrium").modes[0].frequency_hz
                });
                // Springs are not rigid: the difference is a multiple of their compliance, and its square.
                let limit = ((10.0 * lowest[1].powi(2) - lowest[0].powi(2)) / 9.0).max(0.0).sqrt();
                let apart = (limit / mode.frequency_hz - 1.0).abs();
                assert!(apart < 1e-4, "seed {seed}: {} and {lowest:?} Hz, {limit}", mode.frequency_hz);
                frequencies += 1;
            }
            None => {
                // They give way to a neighbouring pose, the nearer the stiffer they are: as the root of the compliance.
                let gone = springs.each_ref().map(near);
                assert!(gone[1] < 0.5 * gone[0] && gone[1] > 1e-6, "seed {seed}: {gone:?}");
                certified += 1;
            }
        }
    }
    println!("{frequencies} with frequencies, {certified} that rigid rows alone make stable");
    assert!(frequencies > 10 && certified > 10);
}

/// What rods pull with balances the weight, wherever it is told.
#[test]
fn pulls_of_concurrent_and_parallel_bars_balance() {
    for seed in 0..60 {
        let mut text = scene(seed, None);
        let rods = text.matches("[[loop]]").count();
        for rod in 0..rods {
            text = text.replacen("[[loop]]\ntype", &format!("[[loop]]\nname = \"rod {rod}\"\ntype"), 1);
            let _ = write!(text, "[[output]]\nname = \"pull {rod}\"\ntype = \"force\"\nof = \"rod {rod}\"\n");
        }
        let (_, model) = read(&text);
        let found = statics(&model);
        let told = stillpoint::statics::outputs(&model, &found).expect("outputs");
        let sum: nalgebra::Vector3<f64> = found.loops.iter().map(|one| one.force).sum();
        let weight = nalgebra::Vector3::new(0.0, 0.0, 9.80665);
        assert!((sum - weight).norm() < 1e-9, "seed {seed}: {sum:?}");
        for (one, told) in found.loops.iter().zip(told) {
            let pull = one.pull.expect("a rod");
            assert!((pull - told).abs() < 1e-9 * (1.0 + pull.abs()), "seed {seed}: {pull} and {told}");
        }
    }
}

/// Near a point where three rods meet there may be another way to assemble them, where they are independent and hold everything: no
/// path leads there, and the motion of first order is held by prestress alone.
#[test]
fn another_way_to_assemble_bars_is_no_motion() {
    let bars = [
        ([-1.5286165271472443, -1.950826166611857], [-0.8682838144562738, -0.5538536907242276]),
        ([-0.621015580656456, 0.5095135810642686], [-0.9881099276764057, -0.9628950277805284]),
        ([-0.9122036603405539, -1.3704772121850426], [-0.9085241998541713, -0.9301110436622568]),
    ];
    let scene = |kind: &str| {
        let mut text =
            "[[body]]\nname = \"p\"\nmass = 2.75089539631866\ncenter = [-0.906047933653727, -1.432401250873115, 0]\n\
             inertia = [0.2433638929747789, 0.2433638929747789, 0.2433638929747789]\n\
             hinge = { type = \"planar\", rpy = [1.5707963267948966, 0, 0] }\n"
                .to_owned();
        for ([ax, az], [bx, bz]) in bars {
            let length = f64::hypot(ax - bx, az - bz);
            let _ = write!(
                text,
                "{kind}length = {length:?}\n\
                 between = [{{ body = \"ground\", at = [{ax:?}, 0, {az:?}] }}, {{ body = \"p\", at = [{bx:?}, {bz:?}, 0] }}]\n"
            );
        }
        text
    };
    let (_, model) = read(&scene("[[loop]]\ntype = \"rod\"\n"));
    let rigid = statics(&model);
    let first = |found: &Equilibrium| found.stability.as_ref().expect("an equilibrium").modes[0].frequency_hz;
    let springs = [1e7, 1e8].map(|stiffness: f64| {
        let text = scene(&format!("[[force]]\ntype = \"spring\"\nstiffness = {stiffness:?}\n"));
        let scene = scenario::parse("scene.toml", &text, &[]).expect("a scene");
        first(&statics(&Model::build(&scene.description).expect("a model")))
    });
    let limit = ((10.0 * springs[1].powi(2) - springs[0].powi(2)) / 9.0).sqrt();
    // What is left of the springs' compliance is its square; 0.55 % was what the other way to assemble them made.
    assert!((limit / first(&rigid) - 1.0).abs() < 1e-5, "{} and {springs:?} Hz", first(&rigid));
    assert!(rigid.notes.iter().any(|note| note.contains("of first order and none of second")), "{:?}", rigid.notes);
    assert!(!rigid.notes.iter().any(|note| note.contains("singular")), "{:?}", rigid.notes);
}

/// Parallel bars of one length move on a circle: a finite motion, and an ordinary one.
#[test]
fn parallel_bars_of_one_length_swing() {
    let mut text = "[[body]]\nname = \"p\"\nmass = 2.0\ninertia = [0.1, 0.1, 0.1]\n\
                    hinge = { type = \"planar\", rpy = [1.5707963267948966, 0, 0] }\n"
        .to_owned();
    for x in [-0.5, 0.1, 0.7] {
        let _ = write!(
            text,
            "[[loop]]\ntype = \"rod\"\nlength = 0.8\n\
             between = [{{ body = \"ground\", at = [{x:?}, 0, 0.8] }}, {{ body = \"p\", at = [{x:?}, 0, 0] }}]\n"
        );
    }
    let (_, model) = read(&text);
    let found = statics(&model);
    let modes = &found.stability.as_ref().expect("an equilibrium").modes;
    let expected = (9.80665_f64 / 0.8).sqrt() / std::f64::consts::TAU;
    assert!(modes.len() == 1 && (modes[0].frequency_hz - expected).abs() < 1e-9, "{modes:?} {expected}");
    assert!(!found.notes.iter().any(|note| note.contains("of first order")), "{:?}", found.notes);
}

/// Beside a long chain the rows border a sweep. What dependent rows do is the same.
#[test]
fn bars_beside_a_long_chain_are_as_stiff_as_alone() {
    let chain: String = (0..70)
        .map(|link| {
            let on = if link == 0 {
                "at = [5, 0, 5]".to_owned()
            } else {
                format!("parent = \"c{}\", at = [0, 0, -0.1]", link - 1)
            };
            format!(
                "[[body]]\nname = \"c{link}\"\nmass = 1.0\ncenter = [0, 0, -0.05]\ninertia = [0.001, 0.001, 0.001]\n\
                 hinge = {{ type = \"revolute\", {on}, axis = [0, 1, 0], position = 0.01 }}\n"
            )
        })
        .collect();
    let mut compared = 0;
    for seed in 0..30 {
        let (_, alone) = read(&scene(seed, None));
        let alone = statics(&alone);
        let mut text = scene(seed, None);
        text.insert_str(text.find("[[loop]]").expect("bars"), &chain);
        let (_, model) = read(&text);
        let beside = statics(&model);
        let of = |found: &Equilibrium| {
            let stability = found.stability.as_ref().expect("an equilibrium");
            let own = stability.modes.iter().find(|mode| mode.shares.first().is_some_and(|(body, _)| body == "p"));
            (stability.verdict, own.map(|mode| mode.frequency_hz))
        };
        assert!(beside.converged, "seed {seed}: {:?}", beside.notes);
        assert!(beside.notes.iter().any(|note| note.contains("of first order and none of second")), "seed {seed}");
        let ((verdict, own), (expected, frequency)) = (of(&beside), of(&alone));
        assert_eq!(verdict, expected, "seed {seed}: {:?}", beside.notes);
        if let (Some(own), Some(frequency)) = (own, frequency) {
            assert!((own / frequency - 1.0).abs() < 1e-6, "seed {seed}: {own} Hz instead of {frequency}");
            compared += 1;
        }
        let follow =
            format!("[statics]\npath = {{ parameter = \"p.mass\", from = 1.0, to = 1.5, step = 0.5 }}\n{text}");
        let (scenario, _) = read(&follow);
        let path = scenario.path.expect("a path");
        let path = stillpoint::statics::path::follow(&scenario.description, &scenario.statics, &path, &mut |_| true);
        let path = path.unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert!(path.branches[0].points.iter().all(|point| point.verdict == expected), "seed {seed}");
    }
    assert!(compared > 5, "{compared}");
}
