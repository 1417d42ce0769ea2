//! Loads across rods that are in one line: said at once, with their names.

use crate::common::{Random, build};
use stillpoint::constraint;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, StabilityVerdict, equilibrium};

fn search(text: &str) -> Equilibrium {
    let scenario = scenario::parse("taut.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let (model, _) = constraint::assemble(build(&scenario.description)).expect("rods that fit");
    equilibrium(&model, &scenario.statics, &model.start_position).expect("numbers")
}

fn knot(name: &str, mass: f64, at: [f64; 2]) -> String {
    format!(
        "[[body]]\nname = \"{name}.x\"\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], position = {:?} }}\n\
         [[body]]\nname = \"{name}\"\nmass = {mass:?}\nhinge = {{ type = \"prismatic\", parent = \"{name}.x\", axis = [0, 0, 1], position = {:?} }}\n",
        at[0], at[1]
    )
}

fn rod(name: &str, from: [f64; 2], to: &str, end: [f64; 2]) -> String {
    let length = (from[0] - end[0]).hypot(from[1] - end[1]);
    format!(
        "[[loop]]\nname = \"{name}\"\ntype = \"rod\"\nbetween = [{{ body = \"ground\", at = [{:?}, 0, {:?}] }}, \"{to}\"]\nlength = {length:?}\n",
        from[0], from[1]
    )
}

/// A knot on two rods along one line of any direction, on one side of both or between them: along the line it is held, across it rods bear
/// nothing, so m g cos φ is left (closed form).
#[test]
fn a_knot_on_two_rods_in_line_bears_nothing_across_them() {
    for seed in 0..30 {
        let random = &mut Random::new(seed);
        // Whole numbers: the circles touch to the last digit.
        let (p, q) = [(1.0, 0.0), (3.0, 4.0), (5.0, 12.0), (-4.0, 3.0)][random.below(4)];
        let mass = random.between(0.5, 20.0);
        let [near, far] = [random.between(0.2, 0.8), if seed % 2 == 0 { 2.0 } else { -1.0 }];
        let text = knot("n", mass, [p, q])
            + &rod("first", [near * p, near * q], "n", [p, q])
            + &rod("second", [far * p, far * q], "n", [p, q]);
        let found = search(&text);
        assert!(!found.balanced, "seed {seed}");
        assert!(found.iterations < 50, "seed {seed}: {} steps", found.iterations);
        let note = found.notes.join("; ");
        assert!(note.contains("`first`") && note.contains("`second`"), "seed {seed}: {note}");
        let across = mass * 9.80665 * (p / p.hypot(q)).abs();
        let left = found.residual_force * if q == 0.0 { 1.0 } else { p.hypot(q) / p.abs().max(q.abs()) };
        // What is told is the larger component of the force across the line.
        assert!((left / across - 1.0).abs() < 1e-6, "seed {seed}: {left} for {across}");
    }
}

/// The same with a third rod across the line: it bears all of it.
#[test]
fn a_rod_across_the_line_bears_the_load() {
    let text = knot("n", 2.0, [1.0, 0.0])
        + &rod("first", [0.0, 0.0], "n", [1.0, 0.0])
        + &rod("second", [3.0, 0.0], "n", [1.0, 0.0])
        + &rod("third", [1.0, 2.0], "n", [1.0, 0.0]);
    let found = search(&text);
    assert!(found.converged, "{:?}", found.notes);
    let (_, third) = found.carried.iter().find(|(name, _)| name.contains("third")).expect("a third rod");
    assert!((third[0].abs() - 2.0 * 9.80665).abs() < 1e-9, "{third:?}");
}

/// A weight on two rods in one line, and from it a pendulum that is not at its rest: what is not borne is the weight.
#[test]
fn what_rods_in_line_do_not_bear_is_named_whatever_hangs_beside_it() {
    for seed in 0..20 {
        let random = &mut Random::new(seed);
        let (mass, hangs) = (random.between(0.5, 5.0), random.between(0.1, 5.0));
        let turn = random.between(0.2, 1.4);
        let text = knot("k", mass, [0.0, 0.0])
            + &rod("left", [-1.0, 0.0], "k", [0.0, 0.0])
            + &rod("right", [1.0, 0.0], "k", [0.0, 0.0])
            + &knot("p", hangs, [turn.sin(), -turn.cos()])
            + "[[loop]]\nname = \"string\"\ntype = \"rod\"\nbetween = [\"k\", \"p\"]\nlength = 1.0\n";
        let found = search(&text);
        assert!(!found.balanced, "seed {seed}");
        let note = found.notes.join("; ");
        assert!(note.contains(" in `k`") && note.contains("`left`"), "seed {seed}: {note}");
    }
}

/// Two masses on a rod, one in a spring at its length and the other on a rope at its length, without weight: the potential is a sum of squares
/// and zero, so that nothing falls, whatever rounding leaves in the rod.
#[test]
fn what_is_just_relaxed_and_just_taut_does_not_fall() {
    for seed in 0..60 {
        let random = &mut Random::new(0x7a07 + seed);
        let mut text = "gravity = [0, 0, 0]\n".to_owned();
        let points: Vec<[f64; 3]> = (0..4).map(|_| random.vector(3.0).into()).collect();
        let [a, b, spring, rope] = [points[0], points[1], points[2], points[3]];
        for (name, at, mass) in [("a", a, 1.0), ("b", b, 0.7)] {
            let slide = |body: &str, parent: &str, axis: &str, at: f64, rest: &str| {
                format!(
                    "[[body]]\nname = \"{body}\"\n{rest}hinge = {{ type = \"prismatic\"{parent}, axis = {axis}, position = {at:?} }}\n"
                )
            };
            text += &slide(&format!("{name}x"), "", "[1, 0, 0]", at[0], "");
            text += &slide(&format!("{name}y"), &format!(", parent = \"{name}x\""), "[0, 1, 0]", at[1], "");
            let mass = format!("mass = {mass:?}\n");
            text += &slide(name, &format!(", parent = \"{name}y\""), "[0, 0, 1]", at[2], &mass);
        }
        let apart = |p: [f64; 3], q: [f64; 3]| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
        text += &format!(
            "[[force]]\ntype = \"spring\"\nbetween = [\"a\", {{ body = \"ground\", at = {spring:?} }}]\nstiffness = 200.0\nlength = {:?}\n\
             [[force]]\ntype = \"rope\"\nthrough = [\"b\", {{ body = \"ground\", at = {rope:?} }}]\nstiffness = 80.0\nlength = {:?}\n\
             [[loop]]\ntype = \"rod\"\nbetween = [\"a\", \"b\"]\nlength = {:?}\n",
            apart(a, spring),
            apart(b, rope),
            apart(a, b)
        );
        let found = search(&text);
        assert!(found.converged, "seed {seed}: {:?}\n{text}", found.notes);
        let verdict = found.stability.expect("an equilibrium").verdict;
        assert_eq!(verdict, StabilityVerdict::Neutral, "seed {seed}\n{text}");
    }
}
