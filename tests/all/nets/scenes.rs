//! The scenes of `scenarios/nets`, each with what it claims. Closed forms stand here; coordinates of the web were found by SciPy
//! (Newton's method on the same threads, residual 1e-15 N).

use crate::scenarios::{found, shipped};
use std::f64::consts::TAU;
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::statics::{Equilibrium, StabilityVerdict};

const G: f64 = 9.80665;

/// The equilibrium of a scene, which is stable.
fn rests(name: &str) -> (Arc<Model>, Equilibrium) {
    let (scenario, model) = shipped(&format!("nets/{name}"), &[]);
    assert!(scenario.warnings.is_empty(), "{name}: {}", scenario.warnings);
    let found = found(&scenario, &model);
    assert_eq!(found.stability.as_ref().map(|stability| stability.verdict), Some(StabilityVerdict::Stable), "{name}");
    (model, found)
}

/// Where a body's root marker is (m).
fn place(model: &Model, found: &Equilibrium, body: &str) -> [f64; 3] {
    let at = found.poses[model.body(body).expect("a body")].translation.vector;
    [at.x, at.y, at.z]
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected} within {tolerance:e}");
}

/// From flat: each corner carries a quarter of the weight, and the net hangs where SciPy says.
#[test]
fn a_net_let_down_from_flat_hangs_on_its_corners() {
    let (model, found) = rests("hanging_net");
    let (stiffness, length) = (400.0, 0.97 / 7.0);
    let mut carried = 0.0;
    for name in ["ball0_1", "ball1_0"] {
        let at = place(&model, &found, name);
        let distance = at.iter().map(|x| x * x).sum::<f64>().sqrt();
        carried -= stiffness * (distance - length) * at[2] / distance;
    }
    near(carried, 0.25 * 60.0 * 0.05 * G, 1e-10);
    for (name, expected) in [
        ("ball3_3", [0.42989185260866264, 0.42989185260866264, -0.39213801661871184]),
        ("ball1_0", [0.12951968355294038, 0.05159402906495023, -0.07450630866024925]),
    ] {
        place(&model, &found, name).iter().zip(expected).for_each(|(x, expected)| near(*x, expected, 1e-10));
    }
}

/// Newton's method in a book factorizes once a step: so does the search, and twice more to see that nothing leads down from where
/// it ends.
#[test]
fn a_net_takes_one_factorization_a_step() {
    let (_, found) = rests("hanging_net");
    assert!(found.factorizations <= found.iterations + 2, "{} in {}", found.factorizations, found.iterations);
}

/// With equal force densities the discrete surface z = a x² - b y² is in balance: Schek's force density method.
#[test]
fn a_cable_roof_takes_the_form_that_it_was_cut_for() {
    let (model, found) = rests("cable_roof");
    let (a, mass, density) = (0.05, 6.0, 2000.0);
    let b = a - 0.5 * mass * G / density;
    for i in 1..8 {
        for j in 1..8 {
            let [x, y, z] = place(&model, &found, &format!("knot{i}_{j}"));
            let at = [f64::from(i) - 4.0, f64::from(j) - 4.0];
            near(x, at[0], 1e-9);
            near(y, at[1], 1e-9);
            near(z, a * at[0] * at[0] - b * at[1] * at[1], 1e-9);
        }
    }
}

/// Ritter's section through every panel: the lower chord carries the moment about the upper knot over the height.
#[test]
fn bars_of_a_truss_carry_what_ritters_sections_say() {
    let (_, found) = rests("truss_bridge");
    // Nothing moves: no mode of round-off is listed.
    assert!(found.stability.as_ref().is_some_and(|stability| stability.modes.is_empty()));
    let (panels, panel, height, deck, knot) = (20, 2.0, 2.5, 1500.0, 40.0 * G);
    let inner = deck + knot;
    // Lower knots within the span and all upper ones; those above the banks go into the ground.
    let bank = 0.5 * (f64::from(panels - 1) * inner + f64::from(panels) * knot);
    let pull = |name: String| {
        let bar = found.loops.iter().find(|bar| bar.name == name).unwrap_or_else(|| panic!("no bar {name}"));
        bar.pull.expect("a rod")
    };
    for i in 0..panels {
        let upper = (f64::from(i) + 0.5) * panel;
        let lower = (1..=i).map(|k| inner * (upper - f64::from(k) * panel)).sum::<f64>();
        let above = (0..i).map(|k| knot * (upper - (f64::from(k) + 0.5) * panel)).sum::<f64>();
        let moment = bank * upper - lower - above;
        near(pull(format!("lower chord {i}")), moment / height, 1e-9 * bank);
        if i > 0 {
            // About the lower knot between two panels.
            let at = f64::from(i) * panel;
            let lower = (1..i).map(|k| inner * (at - f64::from(k) * panel)).sum::<f64>();
            let above = (0..i).map(|k| knot * (at - (f64::from(k) + 0.5) * panel)).sum::<f64>();
            near(pull(format!("upper chord {}", i - 1)), -(bank * at - lower - above) / height, 1e-9 * bank);
        }
    }
}

/// One angle, from `k (θ₀ − θ) = m g n² L cos θ` by bisection.
#[test]
fn a_scissor_mast_of_a_hundred_stages_leans_by_one_angle() {
    let (model, found) = rests("scissor_mast");
    let (stages, length, mass, spring, rest) = (100.0, 0.4, 0.1, 2e4, 0.9366);
    let moment = |angle: f64| spring * (rest - angle) - mass * G * stages * stages * length * angle.cos();
    let (mut low, mut high) = (0.5, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *if moment(middle) > 0.0 { &mut low } else { &mut high } = middle;
    }
    let tip = place(&model, &found, "left99");
    near(tip[2], 99.5 * length * low.sin(), 1e-9 * stages * length);
    near(place(&model, &found, "foot")[0], length * low.cos(), 1e-9);
}

/// Whatever the rings do, the ropes between two rows carry the weight of all rings below.
#[test]
fn ropes_between_two_rows_of_chain_mail_carry_what_hangs_below() {
    let (model, found) = rests("chain_mail");
    let (rows, ring, gap, stiffness) = (8_usize, 2e-3 * G, 2e-3, 1e4);
    let c = 0.01_f64 / 2.0_f64.sqrt();
    let corner = |row: usize, column: usize, [x, z]: [f64; 2]| {
        let body = model.body(&format!("ring{row}_{column}")).expect("a ring");
        (found.poses[body] * nalgebra::Point3::new(x * c, 0.0, z * c)).coords
    };
    let lift = |from: nalgebra::Vector3<f64>, to: nalgebra::Vector3<f64>| {
        let way = to - from;
        stiffness * (way.norm() - gap).max(0.0) * way.z / way.norm()
    };
    for row in 0..rows {
        let mut carried = 0.0;
        for column in 0..rows - row {
            let hook = |side: f64| nalgebra::Vector3::new((2.0 * column as f64 + side) * c, 0.0, 0.0);
            let [left, right] = match row {
                0 => [hook(-1.0), hook(1.0)],
                _ => [corner(row - 1, column, [1.0, -1.0]), corner(row - 1, column + 1, [-1.0, -1.0])],
            };
            carried += lift(corner(row, column, [-1.0, 1.0]), left) + lift(corner(row, column, [1.0, 1.0]), right);
        }
        let below = (rows - row) * (rows - row + 1) / 2;
        // What is unbalanced in the end is below 1e-12 N.
        near(carried, ring * below as f64, 1e-11);
    }
}

/// Stage by stage the twist that a strut of one length, three cables and the weight above make least work with.
#[test]
fn every_prism_of_a_tensegrity_tower_twists_as_its_load_says() {
    let (model, found) = rests("tensegrity_tower");
    let (stages, radius, strut, mass, stiffness, cable) = (20, 1.0_f64, 2.4_f64, 8.0, 1e5, 1.2);
    let chord = |angle: f64| 2.0 * radius * radius * (1.0 - angle.cos());
    let mut below = 0.0;
    for stage in 0..stages {
        let load = mass * G * f64::from(stages - stage);
        let height = |twist: f64| (strut * strut - chord(twist + TAU / 3.0)).sqrt();
        let energy = |twist: f64| {
            let stretched = (height(twist).powi(2) + chord(twist)).sqrt() - cable;
            1.5 * stiffness * stretched * stretched + load * height(twist)
        };
        // The derivative by central differences of a step whose error is its square; bisection of its sign.
        let slope = |twist: f64| (energy(twist + 1e-5) - energy(twist - 1e-5)) / 2e-5;
        let (mut low, mut high) = (0.1, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            *if slope(middle) < 0.0 { &mut low } else { &mut high } = middle;
        }
        let at = place(&model, &found, &format!("plate{stage}"))[2];
        // The differences are off by their step's square and by round-off, 1e-16 · 1e4 J / 1e-5 over a curvature of 1e5 J.
        near(at - below, height(low), 1e-9);
        below = at;
    }
}

/// Where the insect hangs, by SciPy.
#[test]
fn an_insect_hangs_in_a_web_where_scipy_says() {
    let (model, found) = rests("spider_web");
    for (name, expected) in [
        ("hub", [-0.00020230039057492937, 0.0, -0.00051666965423113]),
        ("knot3_5", [0.032253832757264456, 0.0, 0.17092594422862586]),
        ("knot3_4", [0.025187626018815624, 0.0, 0.13344693544741615]),
    ] {
        place(&model, &found, name).iter().zip(expected).for_each(|(x, expected)| near(*x, expected, 1e-11));
    }
}
