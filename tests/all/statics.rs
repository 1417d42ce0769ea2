//! Statics that can be trusted: it finds the equilibrium, proves it, says what it is, or says why there is none.

mod adrift;
mod aim;
mod cascade;
mod crowns;
mod edges;
mod falling;
mod far;
mod fed;
mod inverse;
mod limits;
mod long_loops;
mod loops;
mod methods;
mod modes;
mod path;
mod poles;
mod ratios;
mod shared;
mod spinning;
mod start;
mod stiff_wires;
mod stops;
mod taut;
mod through;
mod tied_limits;
mod time;
mod unheld;
mod zero;

use crate::common::{Random, build};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::model::description::*;
use stillpoint::statics::{Equilibrium, Settings, StabilityVerdict, Want, equilibrium};

/// Links of 0.2 m and 1 kg; their own x axis points along them, so zero angles are horizontal.
fn chain(links: usize, kind: impl Fn(usize) -> HingeKind) -> Description {
    let body = |index: usize| {
        let mut hinge = HingeDescription::new(kind(index));
        if index > 0 {
            hinge.parent = format!("link{}", index - 1);
            hinge.at = Point::Marker("tip".to_owned());
        }
        BodyDescription {
            name: format!("link{index}"),
            mass: MassProperties {
                mass: 1.0,
                center: Vector3::new(0.1, 0.0, 0.0),
                inertia: Matrix3::from_diagonal(&Vector3::new(0.001_25, 0.003_9, 0.003_9)),
            },
            markers: vec![("tip".to_owned(), Vector3::new(0.2, 0.0, 0.0))],
            shapes: Vec::new(),
            hinge,
        }
    };
    Description { bodies: (0..links).map(body).collect(), ..Description::default() }
}

fn about_y(_: usize) -> HingeKind {
    HingeKind::Revolute { axis: Vector3::y() }
}

/// Turns about y and z by turns: a chain that can leave its plane.
fn crosswise(index: usize) -> HingeKind {
    HingeKind::Revolute { axis: if index.is_multiple_of(2) { Vector3::y() } else { Vector3::z() } }
}

fn find(model: &Arc<Model>, want: Want, start: &[f64]) -> Equilibrium {
    equilibrium(model, &Settings { want, ..Settings::default() }, start).expect("the guess can be evaluated")
}

fn potential(model: &Arc<Model>, q: &[f64]) -> f64 {
    System::new(model).at(0.0, q, &vec![0.0; model.velocity_count()]).energies().potential
}

/// Every link straight below the last: `−m g L Σ (i + ½)`.
fn lowest(links: usize) -> f64 {
    -9.80665 * 0.2 * (0..links).map(|i| i as f64 + 0.5).sum::<f64>()
}

fn assert_hangs(model: &Arc<Model>, found: &Equilibrium, links: usize, case: &str) {
    assert!(found.converged, "{case}: {:?}", found.notes);
    // Energy is quadratic about the minimum: an error of 1e-7 rad in every link would show as 1e-14.
    let error = potential(model, &found.position) / lowest(links) - 1.0;
    assert!(error.abs() < 1e-13, "{case}: {error:e}");
}

#[test]
fn chains_guessed_horizontal_hang_down() {
    for links in [1, 2, 5, 20, 100, 1000] {
        let model = build(&chain(links, about_y));
        let found = find(&model, Want::Stable, &model.start_position);
        assert_hangs(&model, &found, links, &format!("{links} links"));
        assert_eq!(found.stability.as_ref().unwrap().verdict, StabilityVerdict::Stable);
    }
}

/// A planar chain has no stable equilibrium but the hanging one: every guess must lead there.
#[test]
fn chains_of_twenty_hang_down_from_every_random_guess() {
    assert_hang_down(60);
}

#[test]
// A thousand searches: only an optimised build (`cargo test --release`) has this test.
#[cfg(not(debug_assertions))]
fn chains_of_twenty_hang_down_from_a_thousand_random_guesses() {
    assert_hang_down(1000);
}

fn assert_hang_down(guesses: u64) {
    let (planar, crossed) = (build(&chain(20, about_y)), build(&chain(20, crosswise)));
    for seed in 0..guesses {
        let mut random = Random::new(seed);
        let guess = random.list(20, -std::f64::consts::PI, std::f64::consts::PI);
        let model = if seed % 2 == 0 { &planar } else { &crossed };
        let found = find(model, Want::Stable, &guess);
        assert_hangs(model, &found, 20, &format!("seed {seed}"));
    }
}

#[test]
fn a_spherical_chain_hangs_down_and_is_neutral_about_its_own_axes() {
    let links = 12;
    let model = build(&chain(links, |_| HingeKind::Spherical));
    let found = find(&model, Want::Stable, &model.start_position);
    assert_hangs(&model, &found, links, "spherical");
    let stability = found.stability.unwrap();
    // Every link may turn about the vertical.
    assert_eq!((stability.verdict, stability.neutral_directions), (StabilityVerdict::Neutral, links));
}

/// Users complain that solvers move what is already balanced: the answer is the guess, bit for bit.
#[test]
fn a_balanced_stable_guess_comes_back_bit_for_bit() {
    let model = build(&chain(30, crosswise));
    let found = find(&model, Want::Stable, &model.start_position);
    let again = find(&model, Want::Stable, &found.position);
    assert_eq!(
        found.position.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
        again.position.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    );
    assert_eq!((again.stage, again.iterations), ("start", 0));
}

/// Upright is an equilibrium: kept bit for bit with `any` and called what it is, left with `stable`, and said so.
#[test]
fn an_upright_chain_is_kept_or_left_as_wanted() {
    let links = 6;
    let mut description = chain(links, about_y);
    description.gravity = Vector3::new(9.80665, 0.0, 0.0) * -1.0;
    let model = build(&description);
    let kept = find(&model, Want::Any, &model.start_position);
    assert!(kept.converged);
    assert_eq!(kept.position, model.start_position);
    let stability = kept.stability.unwrap();
    assert_eq!((stability.verdict, stability.unstable_directions), (StabilityVerdict::Unstable, links));
    let left = find(&model, Want::Stable, &model.start_position);
    assert_hangs(&model, &left, links, "from upright");
    assert!(left.notes.iter().any(|note| note.contains("left an unstable equilibrium")), "{:?}", left.notes);
}

#[test]
fn a_body_that_nothing_holds_is_named_with_its_unbalanced_weight() {
    let mut description = chain(2, about_y);
    let mut loose = description.bodies[0].clone();
    loose.name = "loose".to_owned();
    loose.hinge = HingeDescription::new(HingeKind::Free);
    description.bodies.push(loose);
    let model = build(&description);
    for want in [Want::Stable, Want::Any] {
        let found = find(&model, want, &model.start_position);
        assert!(!found.converged && !found.balanced);
        let note = found.notes.last().unwrap();
        assert!(note.contains("`loose`") && note.contains("9.8"), "{note}");
    }
}

#[test]
fn locked_hinges_stay_and_say_what_they_hold() {
    let mut description = chain(3, about_y);
    description.bodies[1].hinge.lock = true;
    description.bodies[1].hinge.position = vec![0.4];
    let model = build(&description);
    let found = find(&model, Want::Stable, &model.start_position);
    assert!(found.converged);
    assert_eq!(found.position[1], 0.4);
    let (name, held) = &found.holding[0];
    assert!(name.contains("link1"));
    // The lock carries the weights outboard of hinge 1: link1 at its angle, and link2 which hangs straight down from
    // its tip. Zero angles point along x, positive ones downwards (about y). Both agree to round-off of the balance.
    let angle: f64 = found.position[0] + found.position[1];
    let moment = 9.80665 * angle.cos() * (0.1 + 0.2);
    assert!((held.abs() - moment.abs()).abs() < 1e-10, "{held} {moment}");
}

/// A light and a heavy body, a soft and a stiff spring: residual to round-off, no tuning.
#[test]
fn stiffness_and_mass_ratios_do_not_spoil_the_answer() {
    let mut description = chain(8, about_y);
    for (index, body) in description.bodies.iter_mut().enumerate() {
        let scale = if index % 2 == 0 { 1.0 } else { 1e-6 };
        body.mass.mass *= scale;
        body.mass.inertia *= scale;
        body.hinge.stiffness = vec![if index % 3 == 0 { 1e6 } else { 1e-3 }];
    }
    let model = build(&description);
    let found = find(&model, Want::Stable, &model.start_position);
    assert!(found.converged, "{:?}", found.notes);
    // Springs of 1e6 N m/rad balance weights of some N m: a relative residual of 1e-10 is 1e-16 of the stiffness.
    assert!(found.relative_residual < 1e-10, "{}", found.relative_residual);
}
