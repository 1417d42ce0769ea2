//! Slips of the unit, and strains that beams leave out: what is warned of, with which conversion, and what is not.

use crate::common::Random;
use crate::scenarios;
use stillpoint::model::problem::rounded;
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
        let conversion = format!("{degrees}° are {}; write \"{degrees} deg\"", rounded(degrees.to_radians()));
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

/// One warning, with these words.
#[track_caller]
fn told_once(scene: &str, words: &[&str]) {
    let said = warnings(scene);
    assert_eq!(said.matches("warning:").count(), 1, "{scene}\n{said}");
    for word in words {
        assert!(said.contains(word), "no {word}:\n{scene}\n{said}");
    }
}

/// Every coordinate that is an angle counts, wherever it stands, and none that is a distance.
#[test]
fn degrees_are_told_in_every_hinge_that_turns() {
    let body = "[[body]]\nname = \"arm\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n";
    let curve = "curve = { straight = 60.0 }";
    let angles = [
        format!("{body}hinge = {{ type = \"cylindrical\", axis = [0, 1, 0], position = [45, 20] }}\n"),
        format!("{body}hinge = {{ type = \"planar\", position = [45, 45, 20] }}\n"),
        format!("{body}hinge = {{ type = \"along\", turn = \"free\", {curve}, position = [45, 20] }}\n"),
        hinge("revolute", "limits = { low = -1.0, high = 20 }"),
        hinge("revolute", "limits = [{ high = 20, stiffness = 10.0 }]"),
        hinge("universal", "limits = [{ coordinate = 1, high = 20 }]"),
        format!(
            "{body}shape = [{{ sphere = 0.1 }}, {{ box = [0.1, 0.1, 0.1], rpy = [0, 20, 0] }}]\nhinge = {{ type = \"free\" }}\n"
        ),
        "[[beam]]\nname = \"beam\"\nlength = 1.0\nsection = { circle = 0.01 }\nmaterial = { young = 2e11, density = 7800.0 }\n\
         hinge = { type = \"revolute\", axis = [0, 1, 0], position = 20 }\n"
            .to_owned(),
    ];
    for scene in angles {
        told_once(&scene, &["20 rad is more than a turn", "20° are 0.3491", "write \"20 deg\""]);
        assert_eq!(warnings(&scene.replace("20", "0.2")), "", "{scene}");
    }
}

/// Where the floor is, is down; a scene whose y points down is as it is meant.
#[test]
fn gravity_that_leads_off_the_floor_is_told() {
    let scene = |gravity: &str, floor: &str| {
        format!(
            "gravity = {gravity}\n[[body]]\nname = \"floor\"\nshape = {{ plane = {floor} }}\nhinge = {{ type = \"fixed\" }}\n\
             [[body]]\nname = \"ball\"\nmass = 1.0\nshape = {{ sphere = 0.1 }}\ninertia = [0.004, 0.004, 0.004]\n\
             hinge = {{ type = \"free\", position = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], at = [1.0, 1.0, 1.0] }}\n\
             [[contact]]\nbetween = [\"floor\", \"ball\"]\nfriction = 0.4\n"
        )
    };
    told_once(
        &scene("[0.0, 9.81, 0.0]", "[0.0, 1.0, 0.0]"),
        &["away from the plane of `floor`", "write [0, -9.81, 0]"],
    );
    for (gravity, floor) in [
        ("[0.0, -9.81, 0.0]", "[0.0, 1.0, 0.0]"),
        ("[0.0, 9.81, 0.0]", "[0.0, -1.0, 0.0]"),
        ("[0.0, 9.81, 0.0]", "[1.0, 0.0, 0.0]"),
        ("[0.0, 0.0, -9.81]", "[0.0, 0.0, -1.0]"),
    ] {
        assert_eq!(warnings(&scene(gravity, floor)), "", "{gravity} {floor}");
    }
}

/// A box of 0.3 m with this point on it, and another body.
fn with_a_marker(marker: &str) -> String {
    format!(
        "[[body]]\nname = \"a\"\nmass = 1.0\ncenter = [0.15, 0, 0]\ninertia = [0.1, 0.1, 0.1]\nmarkers = {{ tip = {marker} }}\n\
         shape = {{ box = [0.3, 0.1, 0.1], at = [0.15, 0, 0] }}\nhinge = {{ type = \"revolute\", axis = [0, 1, 0] }}\n"
    )
}

#[test]
fn millimetres_in_markers_and_shapes_are_told() {
    told_once(&with_a_marker("[300, 0, 0]"), &["300 m is", "write \"300 mm\"", "scene.toml:6:"]);
    let size = with_a_marker("[0.3, 0, 0]").replace("box = [0.3,", "box = [300,");
    told_once(&size, &["300 m is", "300 mm are 0.3"]);
    assert_eq!(warnings(&with_a_marker("[0.3, 0, 0]")), "");
    assert_eq!(warnings(&with_a_marker("[\"300 mm\", 0, 0]")), "");
    // A hinge a metre above the ground hides it no more.
    let above = with_a_marker("[0.3, 0, 0]").replace("center = [0.15, 0, 0]", "center = [150, 0, 0]");
    let above = above.replace("shape = { box = [0.3, 0.1, 0.1], at = [0.15, 0, 0] }\n", "");
    told_once(&above.replace("axis = [0, 1, 0]", "axis = [0, 1, 0], at = [0, 0, 1]"), &["150 m is", "150 mm are 0.15"]);
    // Two lengths are enough if one of them is of a body.
    let two = "[[body]]\nname = \"a\"\nmass = 1.0\ncenter = [0.15, 0, 0]\ninertia = [0.1, 0.1, 0.1]\nmarkers = { tip = [300, 0, 0] }\n\
               hinge = { type = \"revolute\", axis = [0, 1, 0] }\n";
    told_once(two, &["300 m is 2000 times the other length"]);
}

/// A weight on a vertical slide with a spring to the ground.
fn hung(mass: f64, stiffness: &str, length: &str) -> String {
    format!(
        "[[body]]\nname = \"a\"\nmass = {mass}\nhinge = {{ type = \"prismatic\", axis = [0, 0, 1], position = 0.3 }}\n\
         [[force]]\ntype = \"spring\"\nbetween = [\"ground\", \"a\"]\nstiffness = {stiffness}\nlength = {length}\n"
    )
}

#[test]
fn springs_between_points_are_judged_as_those_of_slides() {
    told_once(
        &hung(10.0, "1e4", "300"),
        &["`length`: the spring has 2.997e6 N at the start", "times the weight", "write \"300 mm\""],
    );
    told_once(&hung(10.0, "5", "0.3"), &["`stiffness`: 5 N/m let `a` sink by 19.61 m", "write \"5 N/mm\""]);
    assert_eq!(warnings(&hung(10.0, "1e4", "0.3")), "");
    assert_eq!(warnings(&hung(10.0, "\"5 N/m\"", "0.3")), "");
    // A second spring may carry it.
    let second = "[[force]]\ntype = \"spring\"\nbetween = [\"ground\", \"a\"]\nstiffness = 1e4\nlength = 0.3\n";
    assert_eq!(warnings(&(hung(10.0, "5", "0.3") + second)), "");
}

#[test]
fn a_soft_slide_is_told_in_a_scene_without_lengths_too() {
    let slide = |stiffness: f64| {
        format!(
            "[[body]]\nname = \"a\"\nmass = 10.0\nhinge = {{ type = \"prismatic\", axis = [0, 0, 1], stiffness = {stiffness} }}\n"
        )
    };
    told_once(&slide(5.0), &["5 N/m let `a` sink by 19.61 m", "5 N/mm are 5000"]);
    assert_eq!(warnings(&slide(100.0)), "");
    // Lying slides, and what statics finds, bear nothing.
    assert_eq!(warnings(&slide(5.0).replace("[0, 0, 1]", "[1, 0, 0]")), "");
    assert_eq!(warnings(&slide(5.0).replace("stiffness", "rpy = [0, 1.5707963, 0], stiffness")), "");
}

/// Scenes in which large and small are both meant.
#[test]
fn ordinary_scenes_of_many_sizes_are_not_suspected() {
    let inertia = "mass = 1.0\ninertia = [1.0, 1.0, 1.0]\n";
    let valve = "[[body]]\nname = \"valve\"\nmass = 0.05\n\
                 hinge = { type = \"prismatic\", axis = [0, 0, 1], stiffness = 3e4, rest = 0.04, limits = [0.0, 0.01] }\n";
    let dropped = format!(
        "[[body]]\nname = \"ball\"\n{inertia}shape = {{ sphere = 0.1 }}\nmarkers = {{ top = [0, 0, 0.1] }}\n\
         hinge = {{ type = \"free\", position = [0, 0, 100, 1, 0, 0, 0] }}\n"
    );
    let boom = format!(
        "[[body]]\nname = \"boom\"\n{inertia}center = [20, 0, 0]\nmarkers = {{ tip = [40, 0, 0] }}\nshape = {{ box = [40, 1, 1], at = [20, 0, 0] }}\n\
         hinge = {{ type = \"revolute\", axis = [0, 1, 0] }}\n\
         [[body]]\nname = \"hook\"\n{inertia}center = [0, 0, -0.2]\nshape = [{{ sphere = 0.1 }}, {{ box = [0.2, 0.1, 0.1] }}, {{ sphere = 0.15 }}]\n\
         hinge = {{ type = \"revolute\", parent = \"boom\", at = \"tip\", axis = [0, 1, 0] }}\n"
    );
    let floor = "[[body]]\nname = \"floor\"\nshape = { box = [200, 200, 1] }\nhinge = { type = \"fixed\" }\n"
        .to_owned()
        + &dropped;
    let jumper = "[[body]]\nname = \"jumper\"\nmass = 80.0\nshape = { sphere = 0.1 }\ninertia = [1, 1, 1]\nhinge = { type = \"free\" }\n\
                  [[force]]\ntype = \"spring\"\nbetween = [\"ground\", \"jumper\"]\nstiffness = 100.0\nlength = 25.0\n";
    for scene in [valve, &dropped, &boom, &floor, jumper] {
        assert_eq!(warnings(scene), "", "{scene}");
    }
}

/// A beam on the ground with these keys beside its length and its section.
fn beam(length: f64, young: f64, keys: &str) -> String {
    format!(
        "[[beam]]\nname = \"b\"\nlength = {length:?}\nsection = {{ circle = {:?} }}\n\
         material = {{ young = {young:e}, density = 1000.0 }}\n{keys}\n",
        0.01 * length
    )
}

/// A strain that a beam leaves out is told if its own weight, what it carries or what pulls at it would make much of it; and not if the
/// strain is free or the material stiff.
#[test]
fn strains_that_are_left_out_are_told_where_they_would_be_large() {
    let random = &mut Random::new(11);
    for _ in 0..20 {
        let (length, strain) = (10f64.powf(random.between(-1.0, 2.0)), 10f64.powf(random.between(-2.5, -1.0)));
        // ρ g L/E, or P/EA.
        let of_weight = 1000.0 * 9.80665 * length / strain;
        let area = std::f64::consts::PI * (0.01 * length).powi(2);
        let load = |strain: f64| {
            let force = 1e11 * area * strain;
            format!("[[force]]\ntype = \"load\"\non = \"b.tip\"\nforce = [0.0, 0.0, {force:e}]\n")
        };
        let fixed = "hinge = { type = \"fixed\" }";
        let stretches = "hinge = { type = \"fixed\" }\nfree = [\"bend\", \"stretch\"]";
        for (young, keys, more) in [(of_weight, fixed, String::new()), (1e11, fixed, load(strain))] {
            let said = warnings(&(beam(length, young, keys) + &more));
            assert!(said.contains("leaves out stretch") && said.contains("\"stretch\"]"), "{strain}: {said}");
            assert_eq!(warnings(&(beam(length, young, stretches) + &more)), "");
        }
        assert_eq!(warnings(&(beam(length, 1e11, fixed) + &load(1e-4))), "");
    }
    // A block that shears.
    let block = "[[beam]]\nname = \"b\"\nlength = 0.2\nsection = { rectangle = [0.1, 0.1] }\n\
                 material = { young = 1e6, density = 1000.0 }\nhinge = { type = \"fixed\" }\nfree = [\"bend\", \"stretch\"]\n\
                 [[force]]\ntype = \"load\"\non = \"b.tip\"\nforce = [0.0, 0.0, -50.0]\n";
    told_once(block, &["leaves out shear", "`free = [\"bend\", \"stretch\", \"shear\"]`", "scene.toml:7:"]);
}

/// Both ends clamped and no twist: of beams whose tips a fixed loop holds, and of cables.
#[test]
fn twist_that_is_locked_between_clamped_ends_is_told() {
    let closed = "[[loop]]\ntype = \"fixed\"\nbetween = [\"b.tip\", { body = \"ground\", at = [1.0, 0.0, 0.0] }]\n";
    let clamped = |free: &str| beam(1.0, 1e11, &format!("hinge = {{ type = \"fixed\" }}\nfree = {free}"));
    told_once(
        &(clamped("[\"bend\"]") + closed),
        &["does not twist", "`free = [\"bend\", \"twist\"]`", "scene.toml:7:8"],
    );
    assert_eq!(warnings(&(clamped("[\"bend\", \"twist\"]") + closed)), "");
    assert_eq!(warnings(&(clamped("[\"bend\"]") + &closed.replace("fixed", "spherical"))), "");
    let swings = beam(1.0, 1e11, "hinge = { type = \"spherical\" }\nfree = [\"bend\"]");
    assert_eq!(warnings(&(swings + closed)), "");
    let cable = |ends: &str, free: &str| {
        format!(
            "[[cable]]\nname = \"c\"\nbetween = [\"ground\", {{ body = \"ground\", at = [1.0, 0.0, 0.0] }}]\nlength = 1.02\n\
             ends = {ends}\n{free}section = {{ circle = 0.005 }}\nmaterial = {{ young = 1e11, density = 7800.0 }}\n"
        )
    };
    let both = "[\"fixed\", \"fixed\"]";
    told_once(&cable(both, ""), &["`c` is clamped at both ends", "\"twist\"", "scene.toml:5:8"]);
    assert_eq!(warnings(&cable(both, "free = [\"bend\", \"twist\", \"stretch\"]\n")), "");
    assert_eq!(warnings(&cable("[\"fixed\", \"spherical\"]", "")), "");
}

/// A scene of four times as many springs, or slides in a row, or beams, takes four times as long to read, not sixteen times.
#[test]
fn the_time_of_a_check_is_proportional_to_the_scene() {
    let hub =
        "[[body]]\nname = \"hub\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\nhinge = { type = \"free\" }\n".to_owned();
    let springs = |count: usize| {
        let spring = |k: usize| {
            format!(
                "[[force]]\ntype = \"spring\"\nbetween = [\"hub\", {{ body = \"ground\", at = [{:?}, 1.0, 2.0] }}]\nstiffness = 1.0\nlength = 1.5\n",
                1.0 + k as f64 / count as f64
            )
        };
        hub.clone() + &(0..count).map(spring).collect::<String>()
    };
    let slides = |count: usize| {
        let slide = |k: usize| {
            let parent = if k == 0 { "ground".to_owned() } else { format!("s{}", k - 1) };
            format!(
                "[[body]]\nname = \"s{k}\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\n\
                 hinge = {{ type = \"prismatic\", parent = \"{parent}\", axis = [0, 0, 1], stiffness = 1e6 }}\n"
            )
        };
        (0..count).map(slide).collect::<String>()
    };
    let beams = |count: usize| {
        let one = |k: usize| {
            beam(1.0, 1e11, "elements = 1\nhinge = { type = \"fixed\" }").replace("\"b\"", &format!("\"b{k}\""))
                + &format!("[[force]]\ntype = \"load\"\non = \"b{k}.tip\"\nforce = [0, 0, 1]\n")
        };
        (0..count).map(one).collect::<String>()
    };
    let kinds: [(&dyn Fn(usize) -> String, usize); 3] = [(&springs, 4000), (&slides, 3000), (&beams, 2000)];
    for (scene, count) in kinds {
        let time = |count: usize| {
            let text = scene(count);
            let once = || {
                let begun = std::time::Instant::now();
                assert_eq!(warnings(&text), "");
                begun.elapsed().as_secs_f64()
            };
            (0..3).map(|_| once()).fold(f64::INFINITY, f64::min)
        };
        // What else the machine does may take most of one measurement, and not of all; what is quadratic takes 16 times in each.
        let measured: Vec<[f64; 2]> = (0..3).map(|_| [time(count), time(4 * count)]).collect();
        let is_proportional = measured.iter().any(|[small, large]| *large < 8.0 * small);
        assert!(is_proportional, "{count} and four times as many: {measured:?} s");
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
            "times the other length",
            "times the weight",
            "own weight",
            "after the end of the run",
            "leaves out",
            "does not twist",
            "never comes",
        ] {
            assert!(!said.contains(words), "{}: {said}", path.display());
        }
    }
}

/// Angles beyond a turn that motors, drives and events have of a hinge that turns, in numbers that nobody writes in radians.
#[test]
fn degrees_are_told_in_motors_drives_and_events() {
    let hinge = |kind: &str| hinge(kind, "position = 0.1");
    let motor = |target: &str| {
        format!("[[motor]]\nhinge = \"arm\"\ntype = \"pd\"\nstiffness = 10.0\ndamping = 1.0\ntarget = {target}\n")
    };
    let ramp = |to: &str| format!("[[drive]]\nhinge = \"arm\"\ntype = \"ramp\"\nto = {to}\nduration = 1.0\n");
    let sine = |amplitude: &str| {
        format!("[[drive]]\nhinge = \"arm\"\ntype = \"sine\"\namplitude = {amplitude}\nfrequency = 1.0\n")
    };
    let event = |value: &str| format!("[[event]]\nname = \"e\"\nhinge = \"arm\"\nvalue = {value}\n");
    let told: [(&str, String); 4] = [
        ("`target`", motor("90.0")),
        ("`to`", ramp("90.0")),
        ("`amplitude`", sine("30.0")),
        ("`value`", event("45.0")),
    ];
    for (key, table) in &told {
        told_once(&(hinge("revolute") + table), &[key, "is more than a turn", " deg\""]);
        // Of a distance they are lengths.
        assert_eq!(warnings(&(hinge("prismatic") + table)), "", "{table}");
    }
    // Units, whole quarters of a turn, less than a turn, and ends of motions that go round and round.
    let silent = [
        motor("\"90 deg\""),
        motor("6.0"),
        motor("12.566370614359172"),
        event("31.41592653589793"),
        ramp("62.83"),
        ramp("1000.0"),
        ramp("43.0"),
        sine("0.5"),
    ];
    for table in silent {
        assert_eq!(warnings(&(hinge("revolute") + &table)), "", "{table}");
    }
}

/// A spring with a thousand times the weight of the scene is told, whatever its length is; one that a stop may bear is not.
#[test]
fn a_preload_of_a_thousand_weights_is_told() {
    let between = |stiffness: &str| {
        hinge("revolute", "position = 0.0").replace("center", "markers = { m = [0.0, 0.0, -1.0] }\ncenter")
            + "[[force]]\ntype = \"spring\"\nbetween = [\"arm.m\", { body = \"ground\", at = [1.0, 0.0, 0.0] }]\nlength = 0.2\n"
            + &format!("stiffness = {stiffness}\n")
    };
    // √2 m apart: 1.214 m times 1e5 N/m, of 9.81 N.
    told_once(&between("1e5"), &["`length`: the spring has 1.214e5 N at the start, 12382 times the weight", "0.2 m"]);
    assert_eq!(warnings(&between("1e3")), "");
    let slide = |keys: &str| hinge("prismatic", &format!("stiffness = 1e4, {keys}"));
    told_once(&slide("rest = 5.0"), &["`hinge.rest`: the spring has 50000 N", "5 mm"]);
    assert_eq!(warnings(&slide("rest = 5.0, limits = [0.0, 0.01]")), "");
    assert_eq!(warnings(&slide("rest = 0.5")), "");
}

/// A distance is never negative: an event that waits for it to cross 0 waits for ever.
#[test]
fn an_event_that_no_distance_crosses_is_told() {
    let scene = |kind: &str, event: &str| {
        hinge("prismatic", "position = 0.5")
            + &format!("[[output]]\nname = \"gap\"\n{kind}\n[[event]]\nname = \"touch\"\noutput = \"gap\"\n{event}\n")
    };
    let distance = "type = \"distance\"\nbetween = [\"arm\", { body = \"ground\", at = [0.0, 3.0, 0.0] }]";
    let position = "type = \"position\"\nof = \"arm\"\naxis = [0.0, 1.0, 0.0]";
    for event in ["value = 0.0", "value = -0.1", ""] {
        told_once(&scene(distance, event), &["`touch` never comes", "`gap` is never negative", "a small gap above 0"]);
        assert_eq!(warnings(&scene(position, event)), "", "{event}");
    }
    assert_eq!(warnings(&scene(distance, "value = 0.001")), "");
}
