//! Slips of the unit: what is warned of, with which conversion, and what is not.

use crate::common::Random;
use crate::scenarios;
use stillpoint::scenario::{load, parse};

/// The warnings of a scene.
fn warnings(text: &str) -> String {
    parse("scene.toml", text, &[])
        .unwrap_or_else(|problems| panic!("{text}\n{}", problems.render(false)))
        .warnings
        .render(false)
}

/// A body on a hinge with these keys beside its type.
fn hinge(kind: &str, keys: &str) -> String {
    let axis = match kind {
        "universal" => "axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]",
        _ => "axis = [0.0, 1.0, 0.0]",
    };
    let pitch = if kind == "screw" { ", pitch = 0.01" } else { "" };
    format!(
        "[[body]]\nname = \"arm\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\ncenter = [0.0, 0.0, -0.5]\n\
         hinge = {{ type = \"{kind}\", {axis}{pitch}, {keys} }}\n"
    )
}

#[test]
fn degrees_in_the_place_of_radians_are_told_with_their_conversion() {
    let random = &mut Random::new(1);
    for _ in 0..60 {
        let degrees = random.between(6.3, 360.0) * [1.0, -1.0][random.below(2)];
        let kind = ["revolute", "screw"][random.below(2)];
        let (low, high) = if degrees < 0.0 { (degrees, 1.0) } else { (-1.0, degrees) };
        let keys = [
            format!("position = {degrees}"),
            format!("rest = {degrees}, stiffness = 1.0"),
            format!("limits = [{low}, {high}]"),
            format!("rpy = [0.0, {degrees}, 0.1]"),
        ];
        let keys = &keys[random.below(4)];
        let said = warnings(&hinge(kind, keys));
        assert_eq!(said.matches("warning:").count(), 1, "{keys}: {said}");
        let conversion = format!("{degrees}° are {:.6}; write \"{degrees} deg\"", degrees.to_radians());
        assert!(said.contains("is more than a turn") && said.contains(&conversion), "{keys}: {said}");
        assert!(said.contains("scene.toml:6:"), "{said}");
        // What it proposes is silent, and so are radians within a turn and lengths of any size.
        let meant = keys.replace(&degrees.to_string(), &format!("\"{degrees} deg\""));
        assert_eq!(warnings(&hinge(kind, &meant)), "", "{meant}");
        let within = keys.replace(&degrees.to_string(), &degrees.to_radians().to_string());
        assert_eq!(warnings(&hinge(kind, &within)), "", "{within}");
        assert_eq!(warnings(&hinge("prismatic", &format!("position = {degrees}"))), "");
    }
}

#[test]
fn gravity_upward_or_in_millimetres_is_told() {
    let scene = |gravity: &str| format!("gravity = {gravity}\n{}", hinge("revolute", "position = 0.1"));
    let up = warnings(&scene("[0.0, 0.0, 9.81]"));
    assert!(up.contains("gravity points upward") && up.contains("write [0, 0, -9.81]"), "{up}");
    let large = warnings(&scene("[0.0, 0.0, -9806.65]"));
    assert!(large.contains("1000 times that of the earth") && large.contains("write [0, 0, -9.80665]"), "{large}");
    for fine in ["[0.0, 0.0, -9.81]", "[0.0, -9.81, 0.0]", "[0.0, 0.0, 0.0]", "[0.0, 9.81, 0.1]", "[0.0, 0.0, -24.8]"] {
        assert_eq!(warnings(&scene(fine)), "", "{fine}");
    }
}

#[test]
fn one_length_in_millimetres_among_metres_is_told() {
    let random = &mut Random::new(2);
    for _ in 0..40 {
        let count = 4 + random.below(5);
        let size = 10f64.powf(random.between(-2.0, 1.0));
        let slip = random.below(count);
        let scene = |as_metres: bool| {
            let mut random = Random::new(3);
            let body = |k: usize| {
                let length = size * random.between(0.7, 1.4);
                let written = if k == slip && !as_metres { 1000.0 * length } else { length };
                let parent = if k == 0 { "ground".to_owned() } else { format!("b{}", k - 1) };
                format!(
                    "[[body]]\nname = \"b{k}\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
                     hinge = {{ type = \"revolute\", parent = \"{parent}\", axis = [0, 1, 0], at = [0.0, 0.0, {written}] }}\n"
                )
            };
            (0..count).map(body).collect::<String>()
        };
        let said = warnings(&scene(false));
        assert_eq!(said.matches("warning:").count(), 1, "{said}");
        assert!(said.contains("times the median") && said.contains(&format!("scene.toml:{}:", 5 * slip + 5)), "{said}");
        assert_eq!(warnings(&scene(true)), "");
    }
}

/// A row of bodies a metre apart leads hundreds of metres away, step by step.
#[test]
fn a_row_that_leads_far_away_is_as_it_is_meant() {
    let body = |k: usize| {
        let far = k + 1;
        format!(
            "[[body]]\nname = \"b{k}\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], at = [{far}.0, 0.0, 1.0] }}\n"
        )
    };
    // Of four hundred, each with a height of 1 m, half of the lengths are 1 m.
    assert_eq!(warnings(&(0..400).map(body).collect::<String>()), "");
}

/// A body on a slide along z, 0.1 m to 1 m from the ground, on a spring that lets it sink by a hundredth of that.
fn slide(random: &mut Random) -> (f64, f64, f64) {
    let (mass, length) = (10f64.powf(random.between(-1.0, 3.0)), random.between(0.1, 1.0));
    (mass, length, 100.0 * mass * 9.80665 / length)
}

fn on_a_slide(mass: f64, length: f64, stiffness: &str, rest: &str) -> String {
    format!(
        "[[body]]\nname = \"table\"\nmass = {mass}\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = {{ type = \"prismatic\", axis = [0, 0, 1], at = [0, 0, {length}], stiffness = {stiffness}, rest = {rest} }}\n"
    )
}

#[test]
fn a_rest_in_millimetres_is_told_by_the_force_of_the_spring() {
    let random = &mut Random::new(4);
    for _ in 0..40 {
        let (mass, length, stiffness) = slide(random);
        let rest = random.between(0.2, 0.9) * length;
        let scene = |rest: &str| on_a_slide(mass, length, &stiffness.to_string(), rest);
        let millimetres = 1000.0 * rest;
        let said = warnings(&scene(&millimetres.to_string()));
        assert_eq!(said.matches("warning:").count(), 1, "{said}");
        assert!(said.contains("times the weight") && said.contains(&format!("write \"{millimetres} mm\"")), "{said}");
        assert!(said.contains("scene.toml:5:"), "{said}");
        assert_eq!(warnings(&scene(&format!("\"{millimetres} mm\""))), "");
        assert_eq!(warnings(&scene(&rest.to_string())), "");
    }
}

#[test]
fn a_stiffness_in_newtons_per_millimetre_is_told_by_how_far_the_body_sinks() {
    let random = &mut Random::new(5);
    for _ in 0..40 {
        let (mass, length, stiffness) = slide(random);
        // The sag of 1 % becomes 10 lengths: beyond that it is told.
        let stiffness = stiffness * random.between(0.1, 0.9);
        let scene = |stiffness: &str| on_a_slide(mass, length, stiffness, "0.0");
        let slip = stiffness / 1000.0;
        let said = warnings(&scene(&slip.to_string()));
        assert_eq!(said.matches("warning:").count(), 1, "{said}");
        assert!(said.contains("under its own weight") && said.contains(&format!("write \"{slip} N/mm\"")), "{said}");
        assert_eq!(warnings(&scene(&format!("\"{slip} N/mm\""))), "");
        assert_eq!(warnings(&scene(&stiffness.to_string())), "");
        // Level slides bear no weight.
        assert_eq!(warnings(&scene(&slip.to_string()).replace("axis = [0, 0, 1]", "axis = [1, 0, 0]")), "");
    }
}

/// A stage whose time lies behind the end of the run is told where it is written, and one at its end is not.
#[test]
fn a_stage_after_the_end_is_told() {
    let scene = |time: f64| {
        format!(
            "simulate = {{ start = \"given\", duration = 2.0 }}\n{}[[stage]]\nname = \"late\"\nwhen = {{ time = {time:?} }}\nlock = [\"arm\"]\n",
            hinge("revolute", "position = 0.1")
        )
    };
    let late = warnings(&scene(2.5));
    assert!(late.contains("after the end of the run at 2 s") && late.contains("scene.toml:10:"), "{late}");
    assert_eq!(warnings(&scene(1.5)), "");
}

/// Nothing that is shipped is meant otherwise than it is written.
#[test]
fn shipped_scenes_are_not_suspected() {
    for name in scenarios::names() {
        let path = scenarios::file(&name);
        let said = load(&path).expect("a scene").warnings.render(false);
        for words in [
            "more than a turn",
            "gravity points",
            "that of the earth",
            "times the median",
            "times the weight",
            "own weight",
            "after the end of the run",
        ] {
            assert!(!said.contains(words), "{}: {said}", path.display());
        }
    }
}
