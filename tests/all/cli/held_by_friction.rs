//! What dry friction holds: mechanisms, blocks at the edge of its cone, balls in a heap. The shipped scenes with other numbers, against virtual
//! work and geometry.

use super::Bench;
use crate::common::Random;
use serde_json::Value;
use std::path::Path;

const G: f64 = 9.80665;

fn shipped(name: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(format!("{name}.toml"));
    std::fs::read_to_string(file).expect("a scenario")
}

fn standing(bench: &Bench, text: &str) -> Value {
    bench.write("scene.toml", text);
    bench.call(&["statics", "scene.toml", "--json"]).code(0).json()["standing"].clone()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// `M = W p c / √(L² − c²)` of the weight on the screw, half of what sits at the knees and twice an arm's with it.
#[test]
fn a_jack_holds_what_the_friction_of_its_screw_does() {
    let (bench, text, mut random) = (Bench::new(), shipped("standing/jack"), Random::new(11));
    for _ in 0..8 {
        let (car, turns) = (random.between(100.0, 500.0), random.between(1e-3, 5e-3));
        let weight = (car + 2.0 * 0.8 + 0.5 * 0.9) * G;
        let per_newton = turns / std::f64::consts::TAU * 0.16 / 0.12;
        let needed = random.between(0.1, 0.95);
        let friction = weight * per_newton / needed;
        let scene = text
            .replace("mass = 400.0", &format!("mass = {car:?}"))
            .replace(
                "\"4 mm/rev\", position = \"80 rev\"",
                &format!("{:?}, position = {:?}", turns / std::f64::consts::TAU, 0.32 * std::f64::consts::TAU / turns),
            )
            .replace("friction = 5.0", &format!("friction = {friction:?}"));
        let found = standing(&bench, &scene);
        assert!((number(&found["friction_margin"]) - needed).abs() < 1e-8, "{needed} {found}");
        let range = &found["margins"]["luggage.force[2]"];
        for (end, expected) in [("low", weight - friction / per_newton), ("high", weight + friction / per_newton)] {
            let value = number(&range[end]);
            assert!((value - expected).abs() < 1e-7 * weight, "{value} {expected} {found}");
        }
    }
}

/// Two pads hold μ N each; the bearing of the crank `N r sin(φ + ψ) / cos ψ`. What needs the larger part of its friction gives way first.
#[test]
fn a_clamp_lets_go_where_its_pads_or_its_crank_do_first() {
    let (bench, text, mut random) = (Bench::new(), shipped("standing/toggle_clamp"), Random::new(12));
    let (r, l, x) = (0.06_f64, 0.12_f64, 0.1795_f64);
    let crank = ((r * r + x * x - l * l) / (2.0 * r * x)).acos();
    let link = (r * crank.sin() / l).asin();
    let (mut pads, mut cranks) = (0, 0);
    for _ in 0..12 {
        let (press, pull) = (random.between(300.0, 2000.0), random.between(20.0, 170.0));
        let (friction, bearing) = (random.between(0.3, 0.6), press * random.between(0.02, 0.1));
        let of_pads = pull.hypot(3.0 * G) / (2.0 * friction * press);
        let of_crank = press * r * (crank + link).sin() / link.cos() / bearing;
        let scene = text
            .replace("\"50 kN/m\", rest = \"20 mm\"", &format!("{:?}, rest = 0.02", press / 0.02))
            .replace("friction = 0.25", &format!("friction = {friction:?}"))
            .replace("friction = 15.0", &format!("friction = {bearing:?}"))
            .replace("[0.0, 200.0, 0.0]", &format!("[0.0, {pull:?}, 0.0]"));
        let found = standing(&bench, &scene);
        assert!(
            (number(&found["friction_margin"]) - of_pads.max(of_crank)).abs() < 1e-7,
            "{of_pads} {of_crank} {found}"
        );
        let gives = found["mechanism"]["slides"].to_string();
        let most = number(&found["margins"]["pull.force[1]"]["high"]);
        let expected = ((2.0 * friction * press).powi(2) - (3.0 * G).powi(2)).sqrt();
        assert!((most - expected).abs() < 1e-6 * expected, "{most} {expected}");
        if of_pads > of_crank {
            pads += 1;
            assert!(gives.contains("anvil") && !gives.contains("crank"), "{gives}");
        } else {
            cranks += 1;
            assert!(gives.contains("crank") && !gives.contains("anvil"), "{gives}");
        }
    }
    assert!(pads > 0 && cranks > 0, "{pads} {cranks}");
}

/// One part in a thousand below its cone a block has not moved by a bit after 1000 s; as much above, it has gone `½ g (sin α − μ cos α) t²`.
#[test]
fn blocks_on_inclines_stay_and_slide() {
    let bench = Bench::new();
    bench.write("stays.toml", shipped("standing/incline"));
    let stays = bench.call(&["run", "stays.toml", "--json"]).code(0).json();
    assert_eq!(stays["final"]["bodies"]["block"]["position"], serde_json::json!([0.0, 0.0, 0.1]));
    assert_eq!(stays["end_time"], 1000.0);
    let found = standing(&bench, &shipped("standing/incline"));
    assert!((number(&found["friction_margin"]) - 0.999).abs() < 1e-9, "{found}");
    bench.write("slides.toml", shipped("contact/incline"));
    let slides = bench.call(&["run", "slides.toml", "--json"]).code(0).json();
    let angle = (0.5 * 1.001_f64).atan();
    let way = 0.5 * G * (angle.sin() - 0.5 * angle.cos()) * 100.0;
    let gone = number(&slides["final"]["bodies"]["block"]["position"][0]);
    assert!((gone - way).abs() < 1e-11, "{gone} {way}");
}

/// Balls that were poured into a bin lie still, beside each other and within its walls, with the energy of their heights alone.
#[test]
fn balls_in_a_bin_come_to_rest_beside_each_other() {
    let bench = Bench::new();
    bench.write("bin.toml", shipped("contact/balls_into_a_bin"));
    let run = bench.call(&["run", "bin.toml", "--json"]).code(0).json();
    let (radius, half) = (0.04, 0.1);
    let places: Vec<[f64; 3]> = (0..8)
        .map(|k| [0, 1, 2].map(|i| number(&run["final"]["bodies"][format!("ball {k}")]["position"][i])))
        .collect();
    // Where captured steps end, what touches is lifted to gaps of 1e-9 of a size and less.
    let sunk = 1e-8 * radius;
    for (k, at) in places.iter().enumerate() {
        let speeds = run["final"]["velocities"][format!("ball {k}")].as_array().unwrap();
        assert!(speeds.iter().all(|speed| number(speed) == 0.0), "{k}: {speeds:?}");
        assert!(at[2] > radius - sunk && at[0].abs().max(at[1].abs()) < half - radius + sunk, "{k}: {at:?}");
        for other in &places[..k] {
            let apart = (0..3).map(|i| (at[i] - other[i]).powi(2)).sum::<f64>().sqrt();
            assert!(apart > 2.0 * radius - sunk, "{k}: {apart}");
        }
    }
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let energy: f64 = places.iter().map(|at| mass * G * at[2]).sum();
    assert!((number(&run["energy_end"]) - energy).abs() < 1e-12 * energy, "{energy} {}", run["energy_end"]);
}
