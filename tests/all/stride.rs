//! What begins and ends somewhere is not stepped over where nothing else keeps steps short: wheels that coast, slides without forces.

use crate::common::Random;
use crate::contact_in_motion::{go, read};
use std::f64::consts::TAU;
use stillpoint::integrate::Method;

const METHODS: [Method; 4] = [Method::Dopri5, Method::Dop853, Method::Adams, Method::Radau9];

/// A wheel with a ball on its rim coasts; another ball slides through its path. The first time at which they meet, by looking at them every
/// hundredth of what they move in.
#[test]
fn what_is_on_the_rim_of_a_wheel_that_coasts_strikes_what_is_in_its_way() {
    let mut random = Random::new(41);
    for case in 0..8 {
        let (rate, height) = (random.between(8.0, 40.0), random.between(-0.9, -0.3));
        let (small, other) = (random.between(0.015, 0.05), random.between(0.015, 0.05));
        let (from, speed) = (random.between(2.0, 3.5), random.between(-0.6, -0.3));
        let text = format!(
            "gravity = [0, 0, 0]\n[[body]]\nname = \"wheel\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
             shape = {{ sphere = {small:?}, at = [1.0, 0, 0] }}\n\
             hinge = {{ type = \"revolute\", axis = [0, -1, 0], velocity = {rate:?} }}\n\
             [[body]]\nname = \"ball\"\nmass = 0.2\ninertia = [1e-3, 1e-3, 1e-3]\nshape = {{ sphere = {other:?} }}\n\
             hinge = {{ type = \"prismatic\", axis = [1, 0, 0], at = [0, 0, {height:?}], position = {from:?}, velocity = {speed:?} }}\n\
             [[contact]]\nbetween = [\"wheel\", \"ball\"]\nrestitution = 0.5\n"
        );
        let gap = |t: f64| {
            let (x, z) = ((rate * t).cos() - from - speed * t, (rate * t).sin() - height);
            x.hypot(z) - small - other
        };
        let look = 0.01 * (small + other) / rate;
        let end = 1.2 * (from + 1.0) / speed.abs();
        let Some(first) = (1..).map(|k| f64::from(k) * look).take_while(|t| *t < end).find(|t| gap(*t) <= 0.0) else {
            continue;
        };
        let (mut before, mut after) = (first - look, first);
        for _ in 0..60 {
            let middle = 0.5 * (before + after);
            if gap(middle) <= 0.0 { after = middle } else { before = middle }
        }
        let model = read(&text);
        for method in METHODS {
            let summary = go(&model, first + 0.01, 1e-8, method);
            let time = summary.events.first().map_or(f64::NAN, |event| event.time);
            assert!((time - after).abs() < 1e-6, "case {case}, {method:?}: {time} for {after}\n{text}");
        }
    }
}

/// A marker of an arm that coasts crosses a plane twice in every turn.
#[test]
fn every_crossing_of_a_marker_is_told() {
    let text = "gravity = [0, 0, 0]\n[[body]]\nname = \"arm\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\n\
                markers = { p = [1.0, 0, 0] }\nhinge = { type = \"revolute\", axis = [0, 1, 0], velocity = 40.0 }\n\
                [[event]]\nname = \"passes\"\non = \"arm.p\"\naxis = [0, 0, 1]\nvalue = 0.5\n";
    let model = read(text);
    for method in METHODS {
        let summary = go(&model, 10.0, 1e-6, method);
        // −sin φ = ½ at 7 and 11 twelfths of every turn.
        let turns = 400.0 / TAU;
        let expected: Vec<f64> = (0..=turns as u32)
            .flat_map(|turn| [7.0, 11.0].map(|twelfths| (f64::from(turn) + twelfths / 12.0) * TAU / 40.0))
            .filter(|time| *time < 10.0)
            .collect();
        let found: Vec<f64> = summary.events.iter().map(|event| event.time).collect();
        assert_eq!(found.len(), expected.len(), "{method:?}");
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-7), "{method:?}: {found:?}");
    }
}

/// A slide runs into a spring by a table that is there for two tenths of a metre only, and holds more than it has: it comes back as it came.
#[test]
fn a_bump_of_a_table_turns_back_what_cannot_pass_it() {
    let text = "gravity = [0, 0, 0]\n[[body]]\nname = \"sled\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [1, 0, 0], velocity = 10.0, \
                spring = { curve = [[0, 0.0], [37.2, 0.0], [37.3, 4000.0], [37.4, 0.0], [60, 0.0]] } }\n";
    let model = read(text);
    for method in METHODS {
        let summary = go(&model, 5.0, 1e-8, method);
        assert!((summary.state.velocity[0] + 10.0).abs() < 1e-4, "{method:?}: {:?}", summary.state);
        assert!(summary.energy_drift < 1e-3, "{method:?}: {}", summary.energy_drift);
    }
}

/// A wheel is braked in a sector of half a radian by a formula: it stops in it.
#[test]
fn a_formula_of_an_angle_acts_wherever_it_is() {
    let text = "gravity = [0, 0, 0]\n[[body]]\nname = \"wheel\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\n\
                hinge = { type = \"revolute\", axis = [0, -1, 0], velocity = 15.5 }\n\
                [[motor]]\nname = \"brake\"\ntype = \"expression\"\nhinge = \"wheel\"\nexpression = \"if(cos(q) < -0.97, -2*v, 0)\"\n";
    let model = read(text);
    // In every sector dv/dq = −2: it slows down by twice the sector's width.
    let slower = 2.0 * 2.0 * 0.97_f64.acos();
    let passes = (15.5 / slower).floor();
    for method in METHODS {
        let summary = go(&model, 60.0, 1e-8, method);
        let q = summary.state.position[0];
        let turns = ((q - std::f64::consts::PI) / TAU).round();
        assert_eq!(turns, passes, "{method:?}: {q}");
        assert!(summary.state.velocity[0].abs() < 0.1, "{method:?}: {:?}", summary.state);
    }
}

/// A train whose resistance changes at a place far away takes steps by its own motion, not by its own length: under a force of pieces, and
/// under one that changes slowly along the track.
#[test]
fn a_formula_of_a_place_holds_steps_up_by_what_changes_in_it() {
    let base = "min(60000, 1000000/max(v, 1)) - 5*v*abs(v)";
    for (grade, most) in [("500", 1000), ("(1500 if q > 5000 else 500)", 1000), ("500*cos(q/2000)", 1000)] {
        let text = format!(
            "[[body]]\nname = \"train\"\nmass = 40000\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], velocity = 0.1 }}\n\
             [[motor]]\nhinge = \"train\"\ntype = \"expression\"\nexpression = \"{base} - {grade}\"\n"
        );
        let summary = go(&read(&text), 600.0, 1e-8, Method::Dop853);
        assert!(summary.statistics.steps < most, "{grade}: {} steps", summary.statistics.steps);
        let exact = go(&read(&text), 600.0, 1e-11, Method::Radau9);
        let off = (summary.state.position[0] / exact.state.position[0] - 1.0).abs();
        assert!(off < 1e-6, "{grade}: {off}");
    }
}
