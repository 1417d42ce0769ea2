//! Discs that stand on something tip over their rims, whatever the direction: verdicts a millionth before and behind the limit.

use super::Bench;
use crate::common::Random;
use std::f64::consts::TAU;

const G: f64 = 9.80665;

/// The verdict on a scene in which everything is pulled sideways by a part of its weight.
fn verdict(bench: &Bench, bodies: &str, part: f64, heading: f64) -> String {
    // More than what keeps it from sliding.
    let friction = 1.5 * part + 1.0;
    let [x, y] = [heading.cos(), heading.sin()].map(|side| side * part * G);
    let text = format!(
        "gravity = [{x:?}, {y:?}, {:?}]\n\
         [[body]]\nname = \"floor\"\nshape = {{ plane = [0.0, 0.0, 1.0] }}\nhinge = {{ type = \"fixed\" }}\n\
         {bodies}[[contact]]\nbetween = [\"*\", \"*\"]\nfriction = {friction:?}\n",
        -G
    );
    bench.write("scene.toml", &text);
    let told = bench.call(&["statics", "scene.toml", "--json"]);
    told.json()["standing"]["verdict"].as_str().unwrap_or_else(|| panic!("{text}")).to_owned()
}

fn drum(name: &str, radius: f64, height: f64, [x, y, z]: [f64; 3], turned: f64) -> String {
    format!(
        "[[body]]\nname = \"{name}\"\ndensity = 500\nshape = {{ cylinder = [{radius:?}, {height:?}] }}\n\
         hinge = {{ type = \"free\", position = [{x:?}, {y:?}, {z:?}, {:?}, 0, 0, {:?}] }}\n",
        (0.5 * turned).cos(),
        (0.5 * turned).sin(),
    )
}

fn on_both_sides(bench: &Bench, bodies: &str, limit: f64, heading: f64) {
    for (part, expected) in [(limit * (1.0 - 1e-6), "stands"), (limit * (1.0 + 1e-6), "falls")] {
        assert_eq!(verdict(bench, bodies, part, heading), expected, "{part} of {limit} along {heading}\n{bodies}");
    }
}

#[test]
fn a_drum_tips_over_its_rim_along_every_heading() {
    let (bench, mut random) = (Bench::new(), Random::new(31));
    for _ in 0..12 {
        let (radius, height) = (random.between(0.05, 0.5), random.between(0.1, 1.0));
        let (heading, turned) = (random.between(0.0, TAU), random.between(0.0, TAU));
        let bodies = drum("drum", radius, height, [0.3, -0.2, 0.5 * height], turned);
        on_both_sides(&bench, &bodies, 2.0 * radius / height, heading);
    }
}

/// The middle of the pressure leaves the rim of the lower drum, or that of the upper one.
#[test]
fn a_drum_on_a_smaller_or_shifted_one_tips_where_both_rims_end() {
    let (bench, mut random) = (Bench::new(), Random::new(32));
    let mut by = [0, 0];
    for _ in 0..12 {
        let (radius, height) = (random.between(0.1, 0.5), random.between(0.1, 0.4));
        let (under, shift, at) = (random.between(0.1, 0.5), random.between(0.0, 0.09), random.between(0.0, TAU));
        let heading = random.between(0.0, TAU);
        // From the axis of the upper one along the heading: to its own rim, and to that of the lower one.
        let along = -shift * (at - heading).cos();
        let across = shift * (at - heading).sin();
        let to_lower = along + (under * under - across * across).sqrt();
        let limit = radius.min(to_lower) / (0.5 * height);
        by[usize::from(to_lower < radius)] += 1;
        // The lower one is flat, so that it stands.
        let lower = drum("lower", under, 0.002, [0.0, 0.0, 0.001], 0.0).replace("density = 500", "density = 50000");
        let place = [shift * at.cos(), shift * at.sin(), 0.002 + 0.5 * height];
        let bodies = lower + &drum("upper", radius, height, place, 0.0);
        on_both_sides(&bench, &bodies, limit, heading);
    }
    assert!(by[0] > 1 && by[1] > 1, "{by:?}");
}

/// A drum whose disc hangs over the edges of a box: what they have in common is bounded by both.
#[test]
fn a_drum_over_the_edge_of_a_box_tips_over_that_or_over_its_rim() {
    let (bench, mut random) = (Bench::new(), Random::new(33));
    let mut by = [0, 0];
    for _ in 0..12 {
        let (radius, height) = (random.between(0.2, 0.5), random.between(0.2, 0.6));
        let (beyond, heading) = (random.between(0.02, 0.15), random.between(-1.5, 1.5));
        // The edge is `beyond` to the right of the axis, across x.
        let to_edge = beyond / heading.cos();
        let limit = radius.min(to_edge) / (0.5 * height);
        by[usize::from(to_edge < radius)] += 1;
        let table = format!(
            "[[body]]\nname = \"table\"\nshape = {{ box = [4.0, 4.0, 1.0], at = [{:?}, 0.0, 0.5] }}\nhinge = {{ type = \"fixed\" }}\n",
            beyond - 2.0
        );
        let bodies = table + &drum("drum", radius, height, [0.0, 0.0, 1.0 + 0.5 * height], 0.4);
        on_both_sides(&bench, &bodies, limit, heading);
    }
    assert!(by[0] > 0 && by[1] > 1, "{by:?}");
}

/// A stool on three round feet: the middle of the pressure leaves what is spanned by three discs.
#[test]
fn a_stool_tips_over_the_rims_of_two_feet_or_of_one() {
    let (bench, mut random) = (Bench::new(), Random::new(34));
    for _ in 0..8 {
        let (foot, far, height) = (random.between(0.02, 0.08), random.between(0.15, 0.3), random.between(0.3, 0.6));
        let turned = random.between(0.0, 2.0);
        let feet = [0, 1, 2].map(|k| turned + f64::from(k) * TAU / 3.0);
        let shapes: Vec<String> = feet
            .iter()
            .map(|angle| {
                let (x, y) = (far * angle.cos(), far * angle.sin());
                format!("{{ cylinder = [{foot:?}, 0.1], at = [{x:?}, {y:?}, 0.05] }}")
            })
            .collect();
        let bodies = format!(
            "[[body]]\nname = \"stool\"\nmass = 5.0\ncenter = [0.0, 0.0, {height:?}]\ninertia = [0.2, 0.2, 0.2]\nshape = [{}]\n\
             hinge = {{ type = \"free\", position = [0, 0, 0, 1, 0, 0, 0] }}\n",
            shapes.join(", ")
        );
        let heading = random.between(0.0, TAU);
        // How far the triangle of the middles, widened by the radius of the feet, goes along the heading.
        let goes = |reach: f64| {
            let point = [reach * heading.cos(), reach * heading.sin()];
            (0..3).any(|k| {
                let [from, to] = [feet[k], feet[(k + 1) % 3]].map(|angle| [far * angle.cos(), far * angle.sin()]);
                let [side, off] = [[to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]];
                let length = side[0].hypot(side[1]);
                let along = ((side[0] * off[0] + side[1] * off[1]) / (length * length)).clamp(0.0, 1.0);
                let beside = (off[0] - along * side[0]).hypot(off[1] - along * side[1]);
                let inside = side[0] * off[1] - side[1] * off[0] >= 0.0;
                !inside && beside > foot
            })
        };
        let (mut low, mut high) = (0.0, 2.0 * far);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if goes(middle) { high = middle } else { low = middle }
        }
        on_both_sides(&bench, &bodies, low / height, heading);
    }
}
