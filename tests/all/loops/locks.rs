//! Locked hinges stay where they are given while loops are closed around them.

use super::read;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::{Settings, equilibrium};

/// A base on a hinge of every type, a two-bar chain on it, and a rod that does not reach to the ground from where the
/// chain is given: something has to move.
fn scene(kind: &str, extra: &str, lock: bool) -> String {
    let lock = if lock { ", lock = true" } else { "" };
    format!(
        "[[body]]\nname = \"base\"\nmass = 0.5\ninertia = [0.01, 0.01, 0.01]\nmarkers = {{ top = [0.1, 0, 0.5] }}\n\
         hinge = {{ type = \"{kind}\", rpy = [0.2, 0.1, -0.3]{extra}{lock} }}\n\
         [[body]]\nname = \"upper\"\nmass = 1.0\ncenter = [0, 0, -0.2]\ninertia = [0.02, 0.02, 0.002]\n\
         markers = {{ tip = [0, 0, -0.4] }}\n\
         hinge = {{ type = \"spherical\", parent = \"base\", at = \"top\", position = [0.8, 0.0, 0.6, 0.0] }}\n\
         [[body]]\nname = \"lower\"\nmass = 1.0\ncenter = [0, 0, -0.2]\ninertia = [0.02, 0.02, 0.002]\n\
         markers = {{ tip = [0, 0, -0.4] }}\n\
         hinge = {{ type = \"revolute\", parent = \"upper\", at = \"tip\", axis = [0, 1, 0], position = 0.7 }}\n\
         [[loop]]\nname = \"tie\"\ntype = \"rod\"\nlength = 0.3\n\
         between = [\"lower.tip\", {{ body = \"ground\", at = [0.2, 0.1, 0.0] }}]\n"
    )
}

const KINDS: [(&str, &str); 7] = [
    ("revolute", ", axis = [0.2, -0.5, 1.0], position = 0.3"),
    ("prismatic", ", axis = [0.2, -0.5, 1.0], position = 0.3"),
    ("cylindrical", ", axis = [0.2, -0.5, 1.0], position = [0.1, 0.3]"),
    ("universal", ", axes = [[1.0, 0.2, 0.0], [0.0, 1.0, 0.5]], position = [0.2, -0.3]"),
    ("planar", ", position = [0.1, -0.1, 0.2]"),
    ("spherical", ", position = [0.7, 0.1, -0.5, 0.5]"),
    ("free", ", position = [0.1, 0.0, -0.1, 0.7, 0.1, -0.5, 0.5]"),
];

/// How far the base's hinge coordinates are from where they are given.
fn moved(model: &Model, position: &[f64], given: &[f64]) -> f64 {
    let hinge = &model.bodies[model.body("base").expect("the base")].hinge;
    let range = hinge.position..hinge.position + hinge.kind.counts().0;
    position[range.clone()].iter().zip(&given[range]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn loops_are_closed_around_locked_hinges_of_every_type() {
    for (kind, extra) in KINDS {
        for lock in [false, true] {
            let text = scene(kind, extra, lock);
            let given =
                scenario::parse("scene.toml", &text, &[]).unwrap_or_else(|e| panic!("{kind}: {}", e.render(false)));
            let model = Model::build(&given.description).expect("a model");
            let before = model.start_position.clone();
            let (model, assembly) = assemble(model).expect("an assembly");
            assert!(assembly.given_gap > 0.1 && assembly.gap < 1e-14, "{kind}: {assembly:?}");
            let by = moved(&model, &model.start_position, &before);
            // Rounding of a dozen steps; without the lock the base gives way.
            assert!(if lock { by < 1e-13 } else { by > 1e-3 }, "{kind}, lock = {lock}: moved by {by:e}");
        }
    }
}

/// The search for equilibrium closes the loop again after every step: a locked ball still stands where it is given.
#[test]
fn statics_holds_a_locked_ball_beside_a_loop() {
    for (kind, extra) in [KINDS[5], KINDS[6]] {
        let (_, model) = read(&scene(kind, extra, true));
        let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("a search");
        assert!(found.converged && found.iterations > 0, "{kind}: {:?}", found.notes);
        let by = moved(&model, &found.position, &model.start_position);
        assert!(by < 1e-12, "{kind}: moved by {by:e}");
    }
}
