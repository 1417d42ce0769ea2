//! Linkages whose motion is known: exact straight lines, and loops that turn although a count of conditions forbids it.

use super::{coordinate, read};
use nalgebra::{Isometry3, Point3};
use std::f64::consts::PI;
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening, OwnedSample};
use stillpoint::simulate::{self, Integrator, Settings, State, Summary};

fn recorded(model: &Arc<Model>, duration: f64) -> (Summary, Vec<OwnedSample>) {
    let settings = Settings {
        duration,
        integrator: Integrator::Method(Method::Dop853),
        tolerance: 1e-11,
        absolute_tolerance: 1e-11,
        ..Settings::default()
    };
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    let summary = simulate::run(model, &settings, 100.0, &start, &mut memory, &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{error}"));
    (summary, memory.samples)
}

fn bar(name: &str, length: [f64; 3], hinge: &str) -> String {
    format!(
        "[[body]]\nname = \"{name}\"\nmass = 1.0\ncenter = {:?}\ninertia = [0.02, 0.03, 0.025]\n\
         markers = {{ tip = {length:?}, tail = {:?} }}\nhinge = {{ {hinge} }}\n",
        length.map(|x| 0.5 * x),
        length.map(|x| -x)
    )
}

/// Scott Russell's linkage twice: the point beyond the pin of a coupler as long as its crank, whose other end slides
/// through the crank's centre, moves on a straight line across. That point is the slide of a second one, whose point
/// moves on a straight line again.
#[test]
fn a_double_scott_russell_draws_straight_lines() {
    let (a, b, height, first) = (0.5, 0.6, 1.0, 0.8_f64);
    let second = ((2.0 * a * first.cos() - height) / (2.0 * b)).acos();
    let y = "type = \"revolute\", axis = [0, 1, 0]";
    let text = [
        "gravity = [0, 0, 0]\n".to_owned(),
        bar("crank", [0.0, 0.0, a], &format!("{y}, position = {first:?}, velocity = 0.4")),
        bar(
            "coupler",
            [0.0, 0.0, a],
            &format!("{y}, parent = \"crank\", at = \"tip\", position = {:?}", PI - 2.0 * first),
        ),
        bar(
            "slide",
            [0.1, 0.0, 0.0],
            &format!("type = \"prismatic\", axis = [1, 0, 0], position = {:?}", 2.0 * a * first.sin()),
        ),
        bar("upper crank", [0.0, 0.0, b], &format!("{y}, at = [0, 0, {height:?}], position = {second:?}")),
        bar(
            "upper coupler",
            [0.0, 0.0, b],
            &format!("{y}, parent = \"upper crank\", at = \"tip\", position = {:?}", -2.0 * second),
        ),
        "[[loop]]\ntype = \"revolute\"\naxis = [0, 1, 0]\nbetween = [\"coupler.tip\", \"slide\"]\n".to_owned(),
        "[[loop]]\ntype = \"revolute\"\naxis = [0, 1, 0]\nbetween = [\"upper coupler.tip\", \"coupler.tail\"]\n"
            .to_owned(),
    ]
    .concat();
    let (_, model) = read(&text);
    assert_eq!(model.degrees_of_freedom(), 1);
    let (summary, samples) = recorded(&model, 1.5);
    let point = |sample: &OwnedSample, body: &str, z: f64| {
        let pose: &Isometry3<f64> = &sample.bodies[model.body(body).expect("a body")];
        pose * Point3::new(0.0, 0.0, z)
    };
    let mut reach = [f64::MAX, f64::MIN, f64::MAX, f64::MIN];
    for sample in &samples {
        let [lower, upper] = [point(sample, "coupler", -a), point(sample, "upper coupler", -b)];
        // Round-off: loops are closed to some 1e-15 m, along the lines and across.
        assert!(lower.x.abs() < 1e-13 && lower.y.abs() < 1e-13, "{lower} at {} s", sample.time);
        assert!((upper.z - height).abs() < 1e-13 && upper.y.abs() < 1e-13, "{upper} at {} s", sample.time);
        reach = [reach[0].min(lower.z), reach[1].max(lower.z), reach[2].min(upper.x), reach[3].max(upper.x)];
    }
    assert!(reach[1] - reach[0] > 0.3 && reach[3] - reach[2] > 0.1, "{reach:?}");
    assert!(summary.energy_drift < 1e-10, "{:e}", summary.energy_drift);
}

/// Bennett's loop of four skew hinges: five conditions on three coordinates, and yet it turns, round and round, with
/// `tan(θ₁/2) tan(θ₂/2)` the same all the way.
#[test]
fn a_bennett_linkage_turns() {
    let (a, b, alpha) = (1.0_f64, 0.6, 0.7_f64);
    let beta = (b / a * alpha.sin()).asin();
    let ratio = (0.5 * (alpha + beta)).sin() / (0.5 * (beta - alpha)).sin();
    let first = 1.0_f64;
    let second = 2.0 * (ratio / (0.5 * first).tan()).atan();
    let hinge = |parent: &str, twist: f64, position: f64| {
        format!("type = \"revolute\", axis = [0, 0, 1], rpy = [{twist:?}, 0, 0], position = {position:?}{parent}")
    };
    let text = [
        "gravity = [0, 0, 0]\n".to_owned(),
        bar("one", [a, 0.0, 0.0], &hinge(", velocity = 2.0", 0.0, first)),
        bar("two", [b, 0.0, 0.0], &hinge(", parent = \"one\", at = \"tip\"", alpha, second)),
        bar("three", [a, 0.0, 0.0], &hinge(", parent = \"two\", at = \"tip\"", beta, -first)),
        format!(
            "[[loop]]\nname = \"last\"\ntype = \"revolute\"\naxis = [0, 0, 1]\nrpy = [{alpha:?}, 0, 0]\n\
             rpy_second = [{:?}, 0, 0]\nbetween = [\"three.tip\", {{ body = \"ground\", at = [{:?}, 0, 0] }}]\n",
            -beta, -b
        ),
    ]
    .concat();
    let (scenario, model) = read(&text);
    let (_, assembly) = assemble(Model::build(&scenario.description).expect("a model")).expect("an assembly");
    assert_eq!((assembly.degrees_of_freedom, assembly.redundant), (1, vec![("loop `last`".to_owned(), 3, 5)]));
    let (summary, samples) = recorded(&model, 10.0);
    for sample in &samples {
        let [one, two, three] = ["one", "two", "three"].map(|body| coordinate(&model, &sample.positions, body));
        // sin sin / cos cos without its poles.
        let [(s1, c1), (s2, c2)] = [(0.5 * one).sin_cos(), (0.5 * two).sin_cos()];
        assert!((s1 * s2 - ratio * c1 * c2).abs() < 1e-12, "{one} {two} at {} s", sample.time);
        let turn = (one + three) / (2.0 * PI);
        assert!((turn - turn.round()).abs() < 1e-13, "{one} {three} at {} s", sample.time);
    }
    let turned = coordinate(&model, &summary.state.position, "one") - first;
    assert!(turned.abs() > 2.0 * PI, "{turned}");
    // Some 200 steps of a tolerance of 1e-11.
    assert!(summary.constraint_error < 1e-12 && summary.energy_drift < 1e-8, "{summary:?}");
}

/// Axes that are parallel to five digits count as parallel, and the rows that follow from that are left out. Where the
/// mechanism feels the sixth, a run ends and says which loop it is: it does not jump.
#[test]
fn rows_that_become_independent_end_a_run() {
    let askew = super::FOUR_BAR
        .replace("at = [0.4, 0.0, 0.0], axis = [0.0, 1.0, 0.0]", "at = [0.4, 0.0, 0.0], axis = [0.000003, 1.0, 0.0]");
    let (_, model) = read(&askew);
    assert_eq!(model.degrees_of_freedom(), 1);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let settings = Settings { duration: 3.0, ..Settings::default() };
    let scene = simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    let said = simulate::run(&model, &settings, 10.0, &start, &mut memory, &mut |_, _| true).expect_err("an end");
    let said = said.to_string();
    for part in ["loop `coupler-rocker`", "depended on others at the start", "given with few digits"] {
        assert!(said.contains(part), "no `{part}` in: {said}");
    }
}
