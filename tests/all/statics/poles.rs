//! Trees that stand on their poles, at the edges of their stops: symmetric in every way, with motions without stiffness among
//! them. Whatever saddle they start from or come through, the search ends in something that does not run away.

use crate::common::{Random, build};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use stillpoint::scenario;
use stillpoint::statics::{Settings, StabilityVerdict, equilibrium};

const SCENES: u64 = 2000;

/// Up to eight rods on each other, upright, hanging or balanced, about axes that may be parallel to them; each hinge within its
/// limits, at one of them, or with one exactly where it stands.
fn scene(seed: u64) -> String {
    let mut random = Random::new(seed);
    let mut text = String::new();
    for index in 0..1 + random.below(8) {
        let reach = [0.5, 1.0, 2.0, 3.0][random.below(4)];
        let mut limits = || [[0.0, reach], [-reach, 0.0], [-reach, reach], [0.0, TAU], [-PI, PI]][random.below(5)];
        let limits = [limits(), limits()];
        let mut place = |[low, high]: [f64; 2]| [0.0, 0.0, 0.0, 0.0, low, high][random.below(6)];
        let positions = limits.map(&mut place);
        let hinge = match random.below(3) {
            0 => format!(
                "type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]], position = {positions:?}, limits = {limits:?}"
            ),
            _ => {
                let axis = ["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"][random.below(3)];
                format!("type = \"revolute\", axis = {axis}, position = {:?}, limits = {:?}", positions[0], limits[0])
            }
        };
        let parent = if random.below(5) < 2 { random.below(index.max(1)) } else { index.saturating_sub(1) };
        let at = [1.0, 0.5][random.below(2)];
        let on = if index == 0 { String::new() } else { format!(", parent = \"b{parent}\", at = [0, 0, {at:?}]") };
        let (mass, center) = ([1.0, 2.0, 0.5][random.below(3)], [0.5, 0.5, -0.5, 0.0][random.below(4)]);
        let _ = write!(
            text,
            "[[body]]\nname = \"b{index}\"\nmass = {mass:?}\ncenter = [0, 0, {center:?}]\ninertia = [0.1, 0.1, 0.1]\n\
             hinge = {{ {hinge}{on} }}\n"
        );
    }
    text
}

#[test]
fn every_saddle_of_rods_on_their_poles_is_left() {
    let (mut failed, mut left) = (Vec::new(), 0);
    for seed in 0..SCENES {
        let text = scene(seed);
        let scenario =
            scenario::parse("poles.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let model = build(&scenario.description);
        let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
        let stands = found.stability.as_ref().is_some_and(|stability| stability.verdict != StabilityVerdict::Unstable);
        if !(found.converged && stands) {
            failed.push(format!("{seed}: {:?}", found.notes));
        }
        left += usize::from(found.notes.iter().any(|note| note.contains("left an unstable equilibrium")));
    }
    assert!(failed.is_empty(), "{} of {SCENES}:\n{}", failed.len(), failed.join("\n"));
    assert!(left > SCENES as usize / 4, "{left} saddles were left: the scenes ask for nothing");
}
