//! Arches of stones without mortar: the least thickness at which they stand is that of limit analysis, whatever their friction.

use super::Bench;
use std::f64::consts::PI;
use std::fmt::Write;

/// A semicircular arch on a floor: its mean radius 1, its stones with radial joints, masses and centres of exact sectors. Files `stone.obj` and
/// `arch.toml`.
fn arch(bench: &Bench, count: usize, thickness: f64, friction: f64) {
    let (inner, outer) = (1.0 - 0.5 * thickness, 1.0 + 0.5 * thickness);
    let half = PI / (2 * count) as f64;
    let mut mesh = String::new();
    for radius in [inner, outer] {
        for side in [-1.0, 1.0] {
            for y in [-0.15, 0.15] {
                let (x, z) = (radius * (side * half).sin(), radius * (side * half).cos());
                writeln!(mesh, "v {x:?} {y:?} {z:?}").unwrap();
            }
        }
    }
    mesh += "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
    bench.write("stone.obj", &mesh);
    let section = outer.powi(2) - inner.powi(2);
    let center = 2.0 / 3.0 * (outer.powi(3) - inner.powi(3)) / section * half.sin() / half;
    let mass = 2000.0 * 0.3 * section * half;
    let mut text = String::from(
        "[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n[[contact]]\nbetween = [\"*\", \"*\"]\n",
    );
    writeln!(text, "friction = {friction:?}").unwrap();
    for stone in 0..count {
        let (sin, cos) = (0.5 * ((2 * stone + 1) as f64 * half - 0.5 * PI)).sin_cos();
        writeln!(
            text,
            "[[body]]\nname = \"stone[{stone}]\"\nmass = {mass:?}\ncenter = [0, 0, {center:?}]\ninertia = [1, 1, 1]\n\
             shape = {{ mesh = \"stone.obj\" }}\nhinge = {{ type = \"free\", position = [0, 0, 0, {cos:?}, 0, {sin:?}, 0] }}"
        )
        .unwrap();
    }
    bench.write("arch.toml", &text);
}

/// Least thicknesses that an independent linear program finds (SciPy's HiGHS, one force per edge of a joint, no sliding).
#[test]
fn arches_stand_from_their_least_thickness_on() {
    let bench = Bench::new();
    for (count, least) in [(9, 0.102_134_287_4), (15, 0.106_265_824_2), (16, 0.107_237_298_8)] {
        for (thickness, friction, code, verdict) in [
            (least + 1e-7, 0.9, 0, "stands"),
            (least + 1e-7, 100.0, 0, "stands"),
            (least - 1e-7, 0.9, 1, "falls"),
            (least - 1e-7, 100.0, 1, "falls"),
        ] {
            arch(&bench, count, thickness, friction);
            let answer = bench.call(&["statics", "arch.toml", "--json"]).code(code).json();
            assert_eq!(answer["standing"]["verdict"], verdict, "{count} {thickness} {friction}");
        }
    }
}

/// However thin an arch and however rough its joints: that it falls is proved, not left open.
#[test]
fn arches_that_are_far_too_thin_fall() {
    let bench = Bench::new();
    for friction in [0.4, 10.0, 1000.0] {
        for thickness in [0.01, 0.03, 0.05, 0.07, 0.09, 0.1] {
            arch(&bench, 15, thickness, friction);
            let answer = bench.call(&["statics", "arch.toml", "--json"]).code(1).json();
            let standing = &answer["standing"];
            assert_eq!(standing["verdict"], "falls", "{thickness} {friction}: {standing}");
            assert!(standing["friction_margin"].is_null(), "{thickness} {friction}: {standing}");
            assert!(!standing["mechanism"]["opens"].as_array().unwrap().is_empty(), "{thickness} {friction}");
        }
    }
}
