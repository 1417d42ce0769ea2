//! Friction and contact at rest, as the program answers: closed forms, the edge of the cone, and what is refused.

use super::Bench;
use crate::common::Random;
use serde_json::Value;
use std::path::Path;

const G: f64 = 9.80665;

/// The answer of `statics` and its exit code.
fn statics(bench: &Bench, text: &str, code: i32) -> Value {
    bench.write("scene.toml", text);
    bench.call(&["statics", "scene.toml", "--json"]).code(code).json()
}

fn shipped(name: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/standing").join(format!("{name}.toml"));
    std::fs::read_to_string(file).expect("a scenario")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// A box of these edges on a plane through its lower face, gravity turned by `slope` about y and then by `heading` about z.
fn on_a_slope(edges: [f64; 3], friction: f64, slope: f64, heading: f64) -> String {
    let down = [G * slope.sin() * heading.cos(), G * slope.sin() * heading.sin(), -G * slope.cos()];
    format!(
        "gravity = {down:?}\n[statics]\nmargin = [\"friction\", \"tilt\"]\n[[body]]\nname = \"floor\"\n\
         shape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n[[body]]\nname = \"box\"\ndensity = 500\n\
         shape = {{ box = {edges:?} }}\nhinge = {{ type = \"free\", position = [0, 0, {}, 1, 0, 0, 0] }}\n\
         [[contact]]\nbetween = [\"box\", \"floor\"]\nfriction = {friction}\n",
        0.5 * edges[2]
    )
}

#[test]
fn a_box_on_a_slope_stands_up_to_its_cone_in_every_heading() {
    let bench = Bench::new();
    let mut random = Random::new(3);
    for _ in 0..20 {
        let (friction, heading) = (random.between(0.1, 0.6), random.between(-3.1, 3.1));
        for (factor, code, verdict) in [(0.999, 0, "stands"), (1.0 - 1e-6, 0, "stands"), (1.0 + 1e-6, 1, "falls")] {
            let text = on_a_slope([0.6, 0.6, 0.1], friction, (friction * factor).atan(), heading);
            let answer = statics(&bench, &text, code);
            let standing = &answer["standing"];
            assert_eq!(standing["verdict"], verdict, "{factor} {text}");
            assert!((number(&standing["friction_margin"]) - factor).abs() < 1e-8, "{standing}");
            assert_eq!((&standing["contacts"], &standing["self_stresses"]), (&4.into(), &6.into()));
            // The pose is kept, bit for bit.
            assert_eq!(answer["positions"]["box"].as_array().unwrap()[2], 0.05);
            if verdict == "falls" {
                assert_eq!(standing["mechanism"]["slides"][0]["between"][1], "box", "{standing}");
            } else {
                assert_eq!(answer["stability"], "stable");
                // The floor carries the weight: on the second body, inertial axes.
                let sum: f64 = standing["forces"].as_array().unwrap().iter().map(|one| number(&one["force"][2])).sum();
                let weight = 500.0 * 0.6 * 0.6 * 0.1 * G * (friction * factor).atan().cos();
                assert!((sum + weight).abs() < 1e-9 * weight, "{sum} {weight}");
            }
        }
    }
}

#[test]
fn a_tall_box_tips_before_it_slides() {
    let bench = Bench::new();
    let text = on_a_slope([0.1, 0.3, 0.5], 0.9, 0.0, 0.0);
    let tilt = statics(&bench, &text, 0)["standing"]["margins"]["tilt"].clone();
    for (towards, expected) in [("+x", 0.2), ("-x", 0.2), ("+y", 0.6), ("-y", 0.6)] {
        assert!((number(&tilt[towards]) - expected).abs() < 1e-8, "{towards}: {tilt}");
    }
}

#[test]
fn the_range_of_payloads_is_that_of_both_hinges_together() {
    let bench = Bench::new();
    let answer = statics(&bench, &shipped("arm_with_friction"), 0);
    let range = &answer["inputs"]["payload.force[2]"];
    assert!((number(&range[0]) + 14.350780555555557).abs() < 1e-9, "{range}");
    assert!((number(&range[1]) + 13.94335).abs() < 1e-9, "{range}");
    assert_eq!(answer["standing"]["verdict"], "stands");
    // Both hinges hold what their motors lack; nothing moves.
    let hinges = answer["standing"]["hinges"].as_array().unwrap();
    let held: Vec<f64> = hinges.iter().map(|one| number(&one["force"][0])).collect();
    assert!(held[0].abs() <= 4.0 && held[1].abs() <= 1.5, "{held:?}");
}

#[test]
fn a_wheel_on_a_spring_rests_anywhere_in_its_dead_band() {
    let bench = Bench::new();
    let wheel = |position: f64| {
        format!(
            "[[body]]\nname = \"wheel\"\nmass = 1\ninertia = [0.01, 0.01, 0.02]\nhinge = {{ type = \"revolute\", \
             axis = [0, 0, 1], position = {position}, stiffness = 2, friction = 0.15 }}\n"
        )
    };
    for (position, stands) in [(0.0, true), (0.0749999, true), (-0.0749999, true), (0.0750001, false), (1.0, false)] {
        let answer = statics(&bench, &wheel(position), 0);
        assert_eq!(answer["standing"]["verdict"], if stands { "stands" } else { "falls" }, "{position}");
        // What friction does not hold goes to where nothing has to be held.
        let expected = if stands { position } else { 0.0 };
        assert!((number(&answer["positions"]["wheel"][0]) - expected).abs() < 1e-12, "{position}");
        assert_eq!(answer["stability"], "stable");
    }
}

#[test]
fn piles_need_the_friction_of_their_closed_forms() {
    let bench = Bench::new();
    let balls = statics(&bench, &shipped("four_balls"), 0);
    let needed = (3.0_f64.sqrt() - 2.0_f64.sqrt()) / 0.33;
    assert!((number(&balls["standing"]["friction_margin"]) - needed).abs() < 1e-7, "{}", balls["standing"]);
    let wall = statics(&bench, &shipped("brick_wall"), 0);
    let tilt = &wall["standing"]["margins"]["tilt"];
    assert_eq!(wall["standing"]["verdict"], "stands");
    // Along the wall every course slides at μ; across, it tips over its foot at d/h.
    assert!((number(&tilt["+x"]) - 0.6).abs() < 1e-7, "{tilt}");
    assert!((number(&tilt["-y"]) - 0.12 / 0.7).abs() < 1e-7, "{tilt}");
}

#[test]
fn a_rocking_stone_rocks_at_its_frequency_until_its_centre_is_too_high() {
    let bench = Bench::new();
    let stone = shipped("rocking_stone");
    let answer = statics(&bench, &stone, 0);
    let fastest = number(answer["frequencies_hz"].as_array().unwrap().last().unwrap());
    assert!((fastest * std::f64::consts::TAU - 5.348151939377438).abs() < 1e-6, "{fastest}");
    // Nothing turns it about its own axis, and nothing holds it there.
    assert_eq!((&answer["stability"], &answer["neutral_directions"]), (&"neutral".into(), &1.into()));
    for (height, unstable) in [(0.1874, 0), (0.1876, 2)] {
        let text = stone.replace("center = [0.0, 0.0, 0.1]", &format!("center = [0.0, 0.0, {height}]"));
        let answer = statics(&bench, &text, i32::from(unstable > 0));
        assert_eq!(answer["unstable_directions"], unstable, "{height}");
    }
}

#[test]
fn a_box_in_a_slot_is_wedged() {
    let bench = Bench::new();
    let text = "[[body]]\nname = \"walls\"\nshape = [{ plane = [1, 0, 0], at = [-0.1, 0, 0] }, { plane = [-1, 0, 0], at = [0.1, 0, 0] }]\n\
         hinge = { type = \"fixed\" }\n[[body]]\nname = \"box\"\nmass = 1\ninertia = [0.01, 0.01, 0.01]\n\
         shape = { box = [0.2, 0.1, 0.1] }\nhinge = { type = \"free\" }\n[[contact]]\nbetween = [\"box\", \"walls\"]\nfriction = 0.2\n";
    let answer = statics(&bench, text, 1);
    assert_eq!((&answer["standing"]["verdict"], &answer["converged"]), (&"wedged".into(), &false.into()));
    assert!((number(&answer["standing"]["squeeze"]) - G / 0.4).abs() < 1e-6);
}

#[test]
fn the_ladder_holds_the_person_as_far_as_the_moments_say() {
    let bench = Bench::new();
    let answer = statics(&bench, &shipped("ladder"), 0);
    let low = number(&answer["standing"]["margins"]["person.force[2]"]["low"]);
    // About the feet: the wall's N₂ (l sin θ + μ l cos θ) carries the moments, N₂ = μ N₁ at the limit, N₁ + μ N₂ = W + P.
    let (mu, theta, own) = (0.35, 1.1_f64, 25.0 * G);
    let share = mu / (1.0 + mu * mu) * 4.0 * (theta.sin() + mu * theta.cos());
    // (W + P) share = (W 2 + P 3.2) cos θ
    let expected = own * (share - 2.0 * theta.cos()) / (3.2 * theta.cos() - share);
    assert!(expected > 650.0 && (low + expected).abs() < 1e-6 * expected, "{low} {expected}");
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    let bench = Bench::new();
    let scene = on_a_slope([0.2, 0.2, 0.2], 0.5, 0.1, 0.0);
    for (from, to, said) in [
        ("friction = 0.5", "friction = -0.5", "allowed: ≥ 0"),
        ("friction = 0.5", "friction = { stick = 0.3, slide = 0.5 }", "0 ≤ `slide` ≤ `stick`"),
        ("[\"box\", \"floor\"]", "[\"bx\", \"floor\"]", "did you mean `box`?"),
        ("[\"box\", \"floor\"]", "[\"box\", \"box\"]", "itself"),
        ("shape = { plane = [0, 0, 1] }", "shape = { plane = [0, 0, 0] }", "has no direction"),
        ("shape = { plane = [0, 0, 1] }", "shape = { plane = [0, 0, 1], contact = false }", "can touch anything"),
    ] {
        bench.write("scene.toml", scene.replace(from, to));
        let answer = bench.call(&["check", "scene.toml"]).code(2);
        assert!(answer.err.contains(said), "{to}: {}", answer.err);
    }
    // Sunk into the floor: how deep, which, and where.
    bench.write("scene.toml", scene.replace("position = [0, 0, 0.1,", "position = [0, 0, 0.09,"));
    let answer = bench.call(&["statics", "scene.toml"]);
    assert!(answer.err.contains("overlap by 0.01 m"), "{answer:#?}");
}

/// A box on a slope that an unknown push holds: without contact no push does, so its own value is clamped into what friction holds.
#[test]
fn an_unknown_input_is_within_its_range() {
    let bench = Bench::new();
    let mut random = Random::new(8);
    for _ in 0..20 {
        let (friction, slope) = (random.between(0.1, 0.5), random.between(0.2, 0.7));
        let (mass, given) = (random.between(1.0, 30.0), random.between(-400.0, 200.0));
        let (normal, half) = ([slope.sin(), 0.0, slope.cos()], 0.5 * slope);
        let text = format!(
            "[statics]\nunknown = [\"push.force[0]\"]\n[[body]]\nname = \"floor\"\nshape = {{ plane = {normal:?} }}\n\
             hinge = {{ type = \"fixed\" }}\n[[body]]\nname = \"box\"\nmass = {mass:?}\ninertia = [0.3, 0.3, 0.6]\n\
             shape = {{ box = [0.6, 0.6, 0.1] }}\nhinge = {{ type = \"free\", position = [{:?}, 0, {:?}, {:?}, 0, {:?}, 0] }}\n\
             [[contact]]\nbetween = [\"box\", \"floor\"]\nfriction = {friction:?}\n\
             [[force]]\nname = \"push\"\ntype = \"load\"\non = \"box\"\nforce = [{given:?}, 0, 0]\n",
            0.05 * normal[0],
            0.05 * normal[2],
            half.cos(),
            half.sin()
        );
        let answer = statics(&bench, &text, 0);
        let value = number(&answer["unknowns"]["push.force[0]"]);
        // Up the slope against friction, and down it with friction.
        let [low, high] = [1.0, -1.0].map(|sign| -mass * G * (slope + sign * friction.atan()).tan());
        // Without contact no push holds the box; where none at all is within the range it may be told as the least.
        let is = |expected: f64| (value - expected).abs() <= 1e-3 * (high - low);
        let none = (low..=high).contains(&0.0) && is(0.0);
        assert!(value >= low && value <= high && (none || is(given.clamp(low, high))), "{text}: {value}");
        assert_eq!(answer["standing"]["verdict"], "stands", "{text}");
    }
}

#[test]
fn what_knows_no_contact_is_refused_where_it_is_asked() {
    let bench = Bench::new();
    let text = on_a_slope([0.6, 0.6, 0.1], 0.5, 0.1, 0.0);
    bench.write("scene.toml", &text);
    for flag in [&["--method", "newton"][..], &["--compare"]] {
        let answer = bench.call(&[&["statics", "scene.toml"], flag].concat()).code(2);
        assert!(answer.err.contains("neither contact nor dry friction"), "{}", answer.err);
    }
    for key in ["method = \"relaxation\"", "path = { parameter = \"gravity[0]\", to = 1.0 }"] {
        bench.write("other.toml", text.replace("[statics]\n", &format!("[statics]\n{key}\n")));
        let answer = bench.call(&["check", "other.toml"]).code(2);
        assert!(answer.err.contains("neither contact nor dry friction") && answer.err.contains("^"), "{}", answer.err);
    }
    // Neither is a recording begun.
    bench.write("other.toml", text.replace("friction = 0.5", "stiffness = 1e6"));
    let answer = bench.call(&["run", "other.toml"]).code(2);
    assert!(answer.err.contains("is compliant, and statics knows rigid contact alone"), "{}", answer.err);
    assert_eq!(bench.names(), ["other.toml", "scene.toml"]);
    // It stands: the run keeps it there, and so does a second one of another method.
    let answer = bench.call(&["run", "scene.toml", "--verify", "--json"]).code(0).json();
    assert_eq!((&answer["steps"], &answer["integrator"]), (&1.into(), &"".into()), "{answer}");
    let answer = bench.call(&["precision", "scene.toml"]);
    assert!(answer.err.contains("no method has anything to do"), "{}", answer.err);
}

#[test]
fn margins_of_a_scene_without_supports_are_refused() {
    let bench = Bench::new();
    bench.write("brick.toml", format!("[statics]\nmargin = [\"tilt\"]\n{}", super::BRICK));
    let answer = bench.call(&["statics", "brick.toml"]).code(2);
    assert!(answer.err.contains("`margin` asks") && answer.err.contains("brick.toml:2:1"), "{}", answer.err);
}

/// Copies of a repeat hang on each other, and a pattern does not join a body and the one that it hangs on.
#[test]
fn neighbours_that_a_pattern_leaves_out_are_named() {
    let bench = Bench::new();
    let scene = |contacts: &str| {
        format!(
            "[[body]]\nname = \"crate\"\nrepeat = 3\nmass = 10\ninertia = [0.3, 0.3, 0.6]\nshape = {{ box = [0.6, 0.6, 0.1] }}\n\
             hinge = {{ type = \"free\", position = [0, 0, 0.1, 1, 0, 0, 0] }}\n{contacts}"
        )
    };
    let contact = |one: &str, other: &str| format!("[[contact]]\nbetween = [\"{one}\", \"{other}\"]\nfriction = 0.3\n");
    for (contacts, pairs) in [
        (contact("crate[*]", "crate[*]"), &["`crate[0]` and `crate[1]`", "`crate[1]` and `crate[2]`"][..]),
        (contact("crate[*]", "crate[2]"), &["`crate[1]` and `crate[2]`"]),
        (contact("crate[*]", "crate[*]") + &contact("crate[1]", "crate[0]"), &["`crate[1]` and `crate[2]`"]),
        (contact("crate[0]", "crate[1]"), &[]),
        (contact("*", "*"), &[]),
    ] {
        bench.write("pile.toml", scene(&contacts));
        let said = bench.call(&["check", "pile.toml"]).err;
        assert_eq!(said.matches(" and `crate[").count(), pairs.len(), "{contacts}: {said}");
        assert!(pairs.iter().all(|pair| said.contains(pair)), "{contacts}: {said}");
    }
}

/// Two boxes on each other, tied by a rod that may squeeze them: forces hold the upper one up to μ N − L₁ whatever the present load, and
/// from 13.8 N on only what a squeeze loads does.
#[test]
fn a_range_ends_where_its_motion_says_whatever_the_present_value() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        "statics = { margin = [\"push.force[0]\"] }\n\
         [[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n\
         [[body]]\nname = \"lower\"\nmass = 2.3284\ninertia = [0.02, 0.04, 0.05]\nshape = { box = [0.4242, 0.3278, 0.1188] }\n\
         hinge = { type = \"free\", position = [0, 0, 0.0594, 1, 0, 0, 0] }\n\
         [[body]]\nname = \"upper\"\nmass = 6.264\ninertia = [0.08, 0.07, 0.09]\nshape = { box = [0.2892, 0.3157, 0.2272] }\n\
         hinge = { type = \"free\", position = [0.0387, 0, 0.2324, 1, 0, 0, 0] }\n\
         [[force]]\nname = \"push\"\ntype = \"load\"\non = { body = \"upper\", at = [0.0649, 0, -0.034] }\nforce = [13.0, 0, -0.0135]\n\
         [[force]]\nname = \"pull\"\ntype = \"load\"\non = { body = \"upper\", at = [0.028, 0, -0.0794] }\nforce = [-12.0437, 0, -19.0553]\n\
         [[loop]]\ntype = \"rod\"\nbetween = [{ body = \"upper\", at = [0.1094, 0, 0.0197] }, { body = \"lower\", at = [0.1553, 0, -0.0065] }]\n\
         length = 0.19933007801132271\n\
         [[contact]]\nbetween = [\"floor\", \"lower\"]\nfriction = 0.375\n[[contact]]\nbetween = [\"lower\", \"upper\"]\nfriction = 0.3145\n",
    );
    // What slides on the floor at last: its friction with all that presses.
    let most = 0.375 * ((2.3284 + 6.264) * 9.80665 + 0.0135 + 19.0553) + 12.0437;
    for value in ["-25", "-20", "-5", "5", "13"] {
        let told =
            bench.call(&["statics", "scene.toml", "--json", "--set", &format!("push.force[0]={value}")]).code(0).json();
        let high = told["standing"]["margins"]["push.force[0]"]["high"].as_f64().expect("an end");
        assert!((high - most).abs() < 1e-6 * most, "{value}: {high} {most}");
        let notes = told["notes"].as_array().expect("notes");
        let says =
            |note: &serde_json::Value| note.as_str().is_some_and(|note| note.contains("only if it has been squeezed"));
        assert!(notes.iter().any(says), "{value}: {notes:?}");
    }
    let told = bench.call(&["statics", "scene.toml", "--json", "--set", "push.force[0]=30"]).json();
    assert_eq!(told["standing"]["verdict"], "wedged", "{told}");
}
