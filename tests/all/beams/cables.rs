//! Cables against the closed form of the elastic catenary, what beams bear as outputs, and what is no cable.

use super::statics::{case, expected, order, solve};
use crate::common::Random;
use nalgebra::Vector3;
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::model::description::{
    BeamDescription, BodyDescription, Description, GROUND, HingeDescription, OutputDescription, QuantityDescription,
};
use stillpoint::statics::{Equilibrium, StabilityVerdict};

/// Without bending stiffness.
fn cable(name: &str, [from, to]: [Vector3<f64>; 2], stiffness: f64, mass: f64) -> BeamDescription {
    let ends = [from, to].map(|at| (GROUND, [at.x, at.y, at.z]));
    let mut cable = BeamDescription::cable(name, ends[0], ends[1]);
    cable.bending = Some(0.0);
    cable.stiffness([stiffness, 1.0, 1.0, 1.0, 1.0, 1.0]).mass_per_length(mass)
}

fn is_stable(found: &Equilibrium) -> bool {
    found.stability.as_ref().is_some_and(|stability| stability.verdict == StabilityVerdict::Stable)
}

/// What the ground passes to the root of the first cable.
fn pull(description: &Description) -> Vector3<f64> {
    let (model, found) = solve(description);
    assert!(is_stable(&found));
    found.reactions[model.body(&description.beams[0].name).expect("its root")].force
}

#[test]
fn catenaries_have_the_closed_form_with_order_four() {
    let case = case("elastic_catenary");
    for (index, stiffness, below) in [(0, 1e6, 0.0), (1, 1e4, 20.0)] {
        let (values, _) = expected(&case, index);
        let errors = [4, 8, 16].map(|elements| {
            let line = cable("line", [Vector3::zeros(), Vector3::new(100.0, 0.0, -below)], stiffness, 50.0 / 9.81);
            let scene = Description::new("Line").gravity([0.0, 0.0, -9.81]).beam(line.length(110.0).elements(elements));
            // The ground holds against the tension.
            let pull = pull(&scene);
            (pull + Vector3::new(values[0], 0.0, -values[1])).norm() / values[0]
        });
        assert!(errors[2] < 1e-6, "{index}: {errors:?}");
        // Of two halvings.
        assert!(order(&[errors[0], errors[2]]) > 2.0 * 3.7, "{index}: {errors:?}");
    }
}

/// Anywhere, under any weight, taut and slack: both parts of the tension at the start satisfy the closed form of the way from
/// end to end. Some hang nearly straight down and up again: sixteen elements do not follow so sharp a bottom, twice as many do.
#[test]
fn random_cables_hang_as_catenaries() {
    for seed in 0..40 {
        let mut random = Random::new(500 + seed);
        let (from, to) = (random.vector(20.0), random.vector(20.0));
        let (chord, gravity) = (to - from, random.vector(12.0));
        let down = gravity.normalize();
        let ratio = random.between(0.995, 1.3);
        let (length, mass) = (ratio * chord.norm(), random.between(0.5, 5.0));
        let weight = mass * gravity.norm();
        // Ten to ten thousand times its own weight.
        let stiffness = weight * length * 10_f64.powf(random.between(1.0, 4.0));
        let off = |elements: usize| {
            let line = cable("line", [from, to], stiffness, mass).length(length).elements(elements);
            let (model, found) = solve(&Description::new("Line").gravity(gravity).beam(line));
            assert!(is_stable(&found), "seed {seed}, {ratio}");
            assert!(found.iterations < 40, "seed {seed}: {} steps", found.iterations);
            let tension = -found.reactions[model.body("line").expect("its root")].force;
            let (v, h) = (tension.dot(&down), (tension - tension.dot(&down) * down).norm());
            let far = v - weight * length;
            let across = h * length / stiffness + h / weight * ((v / h).asinh() - (far / h).asinh());
            let along = length / stiffness * (v - 0.5 * weight * length) + (h.hypot(v) - h.hypot(far)) / weight;
            let way = chord.dot(&down);
            (across - (chord - way * down).norm()).hypot(along - way) / length
        };
        let coarse = off(16);
        let fine = if coarse < 1e-5 { 0.0 } else { off(32) };
        assert!(fine < 3e-4 && fine < coarse, "seed {seed}, {ratio}: {coarse:.1e} {fine:.1e}");
    }
}

#[test]
fn a_pretension_is_the_tension_at_the_first_end() {
    let mut line = cable("line", [Vector3::zeros(), Vector3::new(9.0, 2.0, 12.0)], 1e6, 0.9);
    line.far.iter_mut().for_each(|far| far.pretension = Some(4000.0));
    let tension = pull(&Description::new("Stay").beam(line)).norm();
    assert!((tension - 4000.0).abs() < 1e-5 * 4000.0, "{tension}");
}

/// A weightless cantilever with a load at its tip, bent by little: the moment falls linearly to the tip, the shear is the
/// load, and between stations as much as at them.
#[test]
fn sections_are_told_anywhere() {
    let beam = BeamDescription::new("beam", HingeDescription::fixed())
        .length(2.0)
        .stiffness([1e8, 1e8, 1e8, 1e6, 1e6, 1e6])
        .mass_per_length(1.5)
        .elements(3);
    let mut scene = Description::new("Cantilever").gravity([0.0, 0.0, -9.81]).beam(beam);
    let places = [0.0, 0.11, 0.5, 1.0, 1.37, 2.0];
    for (index, s) in places.into_iter().enumerate() {
        let of = QuantityDescription::Section { of: "beam".to_owned(), s, component: None };
        scene = scene.output(OutputDescription::new(&format!("at {index}"), of));
    }
    let (model, found) = solve(&scene);
    let values = stillpoint::statics::outputs(&model, &found).expect("numbers");
    for (output, s) in model.outputs.iter().zip(places) {
        let six = &values[output.range()];
        let beyond = 2.0 - s;
        let (shear, moment) = (-1.5 * 9.81 * beyond, 0.5 * 1.5 * 9.81 * beyond * beyond);
        assert!((six[2] - shear).abs() < 1e-6 * 30.0, "s = {s}: {six:?}, {shear}");
        assert!((six[4] - moment).abs() < 1e-6 * 30.0, "s = {s}: {six:?}, {moment}");
    }
}

#[test]
fn what_cannot_be_a_cable_is_said() {
    let between = [Vector3::zeros(), Vector3::new(3.0, 0.0, 4.0)];
    let refused = |line: BeamDescription| {
        let problems =
            Model::build(&Description::new("Line").beam(line)).map(|_: Arc<Model>| ()).expect_err("no cable");
        problems.iter().map(|problem| problem.message.clone()).collect::<Vec<_>>().join("\n")
    };
    let mut stiff = cable("line", between, 1e6, 1.0).length(4.9);
    stiff.free.stretch = false;
    assert_eq!(refused(stiff), "`line` is 4.9 m long and its ends are 5 m apart");
    let mut light = cable("line", between, 1e6, 1.0);
    light.far.iter_mut().for_each(|far| far.pretension = Some(1.0));
    assert_eq!(refused(light), "`line` cannot have a tension of 1 N between its ends");
    assert_eq!(refused(cable("line", between, 1e6, 1.0).length(-1.0)), "the length of `line` is -1");
    let mut tapered = cable("line", between, 1e6, 1.0);
    tapered.far.iter_mut().for_each(|far| far.pretension = Some(1e3));
    tapered.sections.push((1.0, tapered.sections[0].1));
    assert_eq!(refused(tapered), "`line` has several sections and a pretension");
    let far = |body: &str| BeamDescription::cable("line", (GROUND, [0.0; 3]), (body, [0.0; 3])).length(9.0);
    let unknown = refused(far("nobody").stiffness([1e6; 6]).mass_per_length(1.0));
    assert_eq!(unknown, "there is no body `nobody`");
}

/// Two cables share a load: what their roots bear is the weight of all.
#[test]
fn a_load_on_two_cables_is_borne_by_both() {
    let load = HingeDescription::free().position([0.0, 0.0, -3.0, 1.0, 0.0, 0.0, 0.0]);
    let body = BodyDescription::new("load", load).mass(50.0).center([0.1, 0.0, -0.3]).inertia([1.0, 1.0, 1.0]);
    let line = |name: &str, x: f64| {
        let mut line = BeamDescription::cable(name, (GROUND, [x, 0.0, 0.0]), ("load", [0.1 * x, 0.0, 0.0]));
        line.bending = Some(0.0);
        line.length(3.6).stiffness([1e5, 1.0, 1.0, 1.0, 1.0, 1.0]).mass_per_length(0.05).elements(2)
    };
    let scene = Description::new("Two lines").body(body).beam(line("left", -2.0)).beam(line("right", 2.0));
    let (model, found) = solve(&scene);
    assert!(is_stable(&found));
    let [left, right] = ["left", "right"].map(|name| found.reactions[model.body(name).expect("its root")].force);
    let weight = 9.80665 * (50.0 + 2.0 * 3.6 * 0.05);
    assert!((left + right - Vector3::new(0.0, 0.0, weight)).norm() < 1e-9 * weight, "{left} {right}");
    assert!(right.z > left.z && left.x < 0.0, "the load hangs to the right: {left} {right}");
}
