//! Inputs whose answer is zero: next to it all that is left of the forces is round-off of the values that it came from.

use crate::common::Random;
use std::fmt::Write;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::hold;

const SCENES: u64 = 400;

/// A tree whose hinge springs are relaxed in the pose, with one thing that disturbs it: the weight, a load, or a motor.
fn scene(seed: u64) -> (String, &'static str) {
    let mut random = Random::new(seed);
    let unknown = ["gravity[2]", "push.force[0]", "b0.force"][random.below(3)];
    let weight = if unknown == "gravity[2]" { -random.between(1.0, 20.0) } else { 0.0 };
    let mut text = format!("gravity = [0, 0, {weight:?}]\n[statics]\nunknown = [\"{unknown}\"]\n");
    let count = 1 + random.below(5);
    for index in 0..count {
        let kind =
            ["revolute\", axis = [0.1, 1, 0.2]", "revolute\", axis = [1, 0, 0]", "prismatic\", axis = [0.2, 0, 1]"];
        let (kind, position) = (kind[random.below(3)], random.between(-1.0, 1.0));
        let spring =
            if random.below(2) == 0 { format!(", stiffness = 4.0, rest = {position:?}") } else { String::new() };
        let motor = match (unknown, index) {
            ("b0.force", 0) => format!(", force = {:?}", random.between(-30.0, 30.0)),
            _ => String::new(),
        };
        let on = match index {
            0 => String::new(),
            _ => format!(", parent = \"b{}\", at = {:?}", random.below(index), random.list(3, -1.0, 1.0)),
        };
        let (mass, center) = (10_f64.powf(random.between(-1.0, 3.0)), random.list(3, -0.5, 0.5));
        let _ = write!(
            text,
            "[[body]]\nname = \"b{index}\"\nmass = {mass:?}\ncenter = {center:?}\ninertia = [0.1, 0.1, 0.1]\n\
             hinge = {{ type = \"{kind}, position = {position:?}{spring}{motor}{on} }}\n"
        );
    }
    if unknown == "push.force[0]" {
        let (last, push) = (count - 1, random.between(-30.0, 30.0));
        let _ =
            write!(text, "[[force]]\nname = \"push\"\ntype = \"load\"\non = \"b{last}\"\nforce = [{push:?}, 0, 0]\n");
    }
    (text, unknown)
}

#[test]
fn what_has_to_vanish_for_balance_does() {
    let mut found_by_kind = [0; 3];
    for seed in 0..SCENES {
        let (text, unknown) = scene(seed);
        let scenario = scenario::parse("zero.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let pose = Model::build(&scenario.description).expect("a model").start_position.clone();
        let held = hold(&scenario.description, &scenario.unknown, &pose, &scenario.statics).expect("finite numbers");
        if held.found.notes.iter().any(|note| note.contains("cannot influence the pose")) {
            continue;
        }
        assert!(held.found.converged, "seed {seed}: {:?}\n{text}", held.found.notes);
        assert_eq!(held.found.unknowns[0].1, 0.0, "seed {seed}");
        found_by_kind[["gravity[2]", "push.force[0]", "b0.force"].iter().position(|one| *one == unknown).unwrap()] += 1;
    }
    assert!(found_by_kind.iter().all(|count| *count > 50), "{found_by_kind:?}");
}

/// A small answer beside a large guess is no round-off: a weight of 1 N held by a motor that was set to 10¹⁰ N m.
#[test]
fn a_small_answer_from_a_large_guess_is_kept() {
    for guess in [1e6, 1e8, 1e10] {
        let text = format!(
            "gravity = [0, 0, -1]\n[statics]\nunknown = [\"arm.force\"]\n[[body]]\nname = \"arm\"\nmass = 1\ncenter = [1, 0, 0]\n\
             hinge = {{ type = \"revolute\", axis = [0, -1, 0], force = {guess:?} }}\n"
        );
        let scenario = scenario::parse("arm.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
        let pose = Model::build(&scenario.description).expect("a model").start_position.clone();
        let held = hold(&scenario.description, &scenario.unknown, &pose, &scenario.statics).expect("finite numbers");
        assert!(held.found.converged, "{guess}: {:?}", held.found.notes);
        assert!((held.found.unknowns[0].1 - 1.0).abs() < 1e-12, "{guess}: {:?}", held.found.unknowns);
    }
}
