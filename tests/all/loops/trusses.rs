//! Bodies that rods hold altogether: what the rods carry is statics.

use super::read;
use crate::common::Random;
use nalgebra::{DMatrix, DVector, Vector3, Vector6};
use std::fmt::Write;
use stillpoint::statics::{Settings, StabilityVerdict, equilibrium};

const G: f64 = 9.80665;

struct Platform {
    text: String,
    /// What a unit pull of each rod applies about the world's origin: force and moment.
    pulls: DMatrix<f64>,
    weight: Vector6<f64>,
}

/// A free body on so many rods between random points, and its balance about the world's origin.
fn platform(random: &mut Random, rods: usize) -> Platform {
    let (at, turn, center) = (Vector3::new(0.0, 0.0, 1.0) + random.vector(0.3), random.turn(), random.vector(0.2));
    let mass = random.between(1.0, 50.0);
    let list = |v: &Vector3<f64>| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    let mut text = format!(
        "[[body]]\nname = \"plate\"\nmass = {mass:?}\ncenter = {}\ninertia = [1.0, 1.2, 2.0]\n\
         hinge = {{ type = \"free\", position = [{:?}, {:?}, {:?}, {:?}, {:?}, {:?}, {:?}] }}\n",
        list(&center),
        at.x,
        at.y,
        at.z,
        turn.w,
        turn.i,
        turn.j,
        turn.k
    );
    let mut pulls = DMatrix::zeros(6, rods);
    for rod in 0..rods {
        let (ground, plate) = (random.vector(1.0), random.vector(0.7));
        let end = at + turn * plate;
        let _ = write!(
            text,
            "[[loop]]\nname = \"rod{rod}\"\ntype = \"rod\"\nlength = {:?}\n\
             between = [{{ body = \"ground\", at = {} }}, {{ body = \"plate\", at = {} }}]\n",
            (end - ground).norm(),
            list(&ground),
            list(&plate)
        );
        let force = (ground - end).normalize();
        pulls.column_mut(rod).rows_mut(0, 3).copy_from(&force);
        pulls.column_mut(rod).rows_mut(3, 3).copy_from(&end.cross(&force));
    }
    let force = Vector3::new(0.0, 0.0, -mass * G);
    let moment = (at + turn * center).cross(&force);
    Platform { text, pulls, weight: Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z) }
}

/// Six rods: the only forces that balance. More: the least sum of squares of those that do, and said not to be unique.
#[test]
fn rods_of_platforms_carry_what_balances() {
    let mut tried = 0;
    for seed in 0..120 {
        let mut random = Random::new(4000 + seed);
        let rods = 6 + random.below(4);
        let Platform { text, pulls, weight } = platform(&mut random, rods);
        let values = pulls.clone().svd(false, false).singular_values;
        let condition = values[0] / values[5];
        if condition > 1e4 {
            continue;
        }
        tried += 1;
        let (scenario, model) = read(&text);
        assert_eq!(model.degrees_of_freedom(), 0, "seed {seed}");
        let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
        assert!(found.converged, "seed {seed}: {:?}", found.notes);
        let stability = found.stability.as_ref().expect("an equilibrium");
        assert_eq!(stability.verdict, StabilityVerdict::Stable);
        assert!(stability.modes.is_empty() && stability.damped.is_empty());
        let carried = DVector::from_iterator(rods, found.loops.iter().map(|rod| rod.pull.expect("a rod's pull")));
        let load = DVector::from_column_slice(weight.as_slice());
        let left = (&pulls * &carried + &load).amax();
        let least = pulls.clone().svd(true, true).solve(&-load, 1e-12).expect("a solution");
        let apart = (&carried - &least).amax() / least.amax();
        assert!(left < 1e-12 * condition * weight.amax(), "seed {seed}: {left:e} unbalanced");
        // Both are known to round-off times the condition of the rods; closing a pose leaves some.
        assert!(apart < 1e-11 * condition, "seed {seed}: {apart:e} from the least forces, condition {condition:e}");
        assert!(found.loops.iter().all(|rod| rod.unique == (rods == 6)), "seed {seed}");
        assert_eq!(found.redundant.iter().map(|(_, left_out, _)| left_out).sum::<usize>(), rods - 6);
        assert_eq!(scenario.description.loops.len(), rods);
    }
    println!("{tried} platforms");
    assert!(tried > 60);
}

/// A run of it stays where it is.
#[test]
fn a_platform_on_six_rods_stays() {
    let Platform { text, .. } = platform(&mut Random::new(4001), 6);
    let (_, model) = read(&text);
    let end = super::run(&model, &super::Settings { duration: 0.2, ..super::Settings::default() });
    let apart = end.state.position.iter().zip(&model.start_position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-12, "{apart:e}");
}
