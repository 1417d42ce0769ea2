//! Minima of the potential within limits where gears and loops tie coordinates together: random limp scenes, each of which has one, for
//! its stops bound all its motions.

use super::potential;
use crate::common::Random;
use std::fmt::Write;
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, StabilityVerdict, equilibrium};

const SCENES: u64 = 60;

fn solved(text: &str) -> (Arc<Model>, Equilibrium) {
    let scenario = scenario::parse("scene.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
    let (model, _) = assemble(Model::build(&scenario.description).expect("a model")).expect("an assembly");
    let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
    (model, found)
}

/// What every answer has to be: within the limits, on stops that push, and no saddle.
fn assert_rests(model: &Model, found: &Equilibrium, case: &str) {
    assert!(found.converged, "{case}: {:?}", found.notes);
    let verdict = found.stability.as_ref().expect("a verdict").verdict;
    assert!(verdict != StabilityVerdict::Unstable, "{case}");
    for stop in &model.stops {
        let value = found.position[stop.position];
        assert!(stop.range[0] - 1e-9 <= value && value <= stop.range[1] + 1e-9, "{case}: {value} of {:?}", stop.range);
    }
}

struct Geared {
    text: String,
    /// The tied coordinates: second, first, ratio.
    gears: Vec<(usize, usize, f64)>,
    ranges: Vec<[f64; 2]>,
}

/// A limp tree whose turns all have limits, some of them tied by gears.
fn geared(seed: u64) -> Geared {
    let random = &mut Random::new(seed);
    let (count, mut text, mut ranges) = (2 + random.below(8), String::new(), Vec::new());
    for index in 0..count {
        let parent = match (index, random.below(4)) {
            (0, _) => "ground".to_owned(),
            (_, 0) => format!("b{}", random.below(index)),
            _ => format!("b{}", index - 1),
        };
        let range = [-random.between(0.05, 2.0), random.between(0.05, 2.0)];
        let numbers = |random: &mut Random, size: f64| <[f64; 3]>::from(random.vector(size));
        let (center, at, axis) = (numbers(random, 0.15), numbers(random, 0.3), <[f64; 3]>::from(random.unit()));
        let mass = 10_f64.powf(random.between(-2.0, 1.0));
        let inertia = [0.001 * mass, 0.0011 * mass, 0.0012 * mass];
        let _ = write!(
            text,
            "[[body]]\nname = \"b{index}\"\nmass = {mass:?}\ncenter = {center:?}\ninertia = {inertia:?}\n\
             hinge = {{ type = \"revolute\", parent = \"{parent}\", at = {at:?}, axis = {axis:?}, position = 0.0, limits = {range:?} }}\n"
        );
        ranges.push(range);
    }
    let mut free: Vec<usize> = (0..count).collect();
    let mut gears = Vec::new();
    for _ in 0..1 + random.below(count / 2) {
        let [one, other] = [0; 2].map(|_| free.swap_remove(random.below(free.len())));
        let ratio = [-1.0, 1.0, 0.5, -2.0][random.below(4)];
        let _ = writeln!(text, "[[gear]]\ntype = \"ratio\"\nbetween = [\"b{one}\", \"b{other}\"]\nratio = {ratio:?}");
        gears.push((one, other, ratio));
    }
    Geared { text, gears, ranges }
}

#[test]
fn limp_trees_with_gears_rest_at_a_minimum_within_their_limits() {
    for seed in 0..SCENES {
        let Geared { text, gears, ranges } = geared(seed);
        let (model, found) = solved(&text);
        assert_rests(&model, &found, &format!("seed {seed}\n{text}"));
        // Nothing beside it, gears kept, is lower by more than round-off.
        let at: Vec<usize> = (0..ranges.len()).map(|index| model.links[model.bodies[index].link].position).collect();
        let (random, lowest) = (&mut Random::new(seed), potential(&model, &found.position));
        for _ in 0..200 {
            let mut q = found.position.clone();
            at.iter().for_each(|at| q[*at] += random.between(-1e-3, 1e-3));
            gears.iter().for_each(|(one, other, ratio)| q[at[*one]] = ratio * q[at[*other]]);
            let within = at.iter().zip(&ranges).all(|(at, [low, high])| *low <= q[*at] && q[*at] <= *high);
            assert!(!within || potential(&model, &q) > lowest - 1e-9, "seed {seed}: lower at {q:?}\n{text}");
        }
    }
}

/// A limp parallelogram under gravity in any direction, with a chain that hangs from it.
fn linkage(seed: u64) -> String {
    let random = &mut Random::new(seed);
    let pose = random.between(-1.2, 1.2);
    let gravity = [random.between(-20.0, 20.0), 0.0, random.between(-20.0, 20.0)];
    let mut text = format!("gravity = {gravity:?}\n");
    let mut body = |random: &mut Random, name: &str, length: f64, pose: f64, place: &str, limits: Option<[f64; 2]>| {
        let mass = 10_f64.powf(random.between(-1.0, 1.0));
        let limits = limits.map_or(String::new(), |limits| format!(", limits = {limits:?}"));
        let _ = write!(
            text,
            "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ncenter = [0, 0, {:?}]\ninertia = [{i:?}, {i:?}, {i:?}]\n\
             markers = {{ t = [0, 0, {:?}] }}\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], position = {pose:?}, {place}{limits} }}\n",
            -0.5 * length,
            -length,
            i = 0.01 * mass
        );
    };
    let range = |random: &mut Random, pose: f64| [pose - random.between(0.05, 1.0), pose + random.between(0.05, 1.0)];
    let limits = range(random, pose);
    body(random, "a", 1.0, pose, "parent = \"ground\"", Some(limits));
    let limits = (random.below(2) == 0).then(|| range(random, pose));
    body(random, "b", 1.0, pose, "parent = \"ground\", at = [1, 0, 0]", limits);
    let mut parent = ["a", "b"][random.below(2)].to_owned();
    for index in 0..random.below(4) {
        let (name, pose) = (format!("c{index}"), random.between(-1.0, 1.0));
        let limits = range(random, pose);
        body(random, &name, 0.4, pose, &format!("parent = \"{parent}\", at = \"t\""), Some(limits));
        parent = name;
    }
    text + "[[loop]]\ntype = \"rod\"\nbetween = [\"a.t\", \"b.t\"]\nlength = 1.0\n"
}

#[test]
fn limp_parallelograms_rest_on_their_stops() {
    for seed in 0..SCENES {
        let text = linkage(seed);
        let (model, found) = solved(&text);
        assert_rests(&model, &found, &format!("seed {seed}\n{text}"));
    }
}
