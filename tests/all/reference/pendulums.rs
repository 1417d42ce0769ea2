//! Pendulums in the x-y plane, gravity along −y, angles from straight down.

use super::case::{Node, case};
use super::scene::{Run, Scene, head};
use super::survey;
use std::f64::consts::FRAC_PI_2;

/// A rod along −y with a point mass at its end; `angle` from the parent's rod.
fn rod(name: &str, parent: &str, at: f64, length: f64, mass: f64, angle: f64) -> String {
    let tip = [0.0, -length, 0.0];
    format!(
        "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ncenter = {tip:?}\nhinge = {{ type = \"revolute\", \
         parent = \"{parent}\", at = {:?}, axis = [0, 0, 1], position = {angle:?} }}\n",
        [0.0, -at, 0.0]
    )
}

#[test]
pub(super) fn a01_simple_pendulum() {
    let case = case("A01_simple_pendulum");
    let (length, g) = (case.parameter("length"), case.parameter("g"));
    assert_eq!((case.initial("x"), case.initial("y")), (-length, 0.0));
    let text =
        head([0.0, -g, 0.0], "dopri5", 1e-12) + &rod("rod", "ground", 0.0, length, case.parameter("mass"), -FRAC_PI_2);
    let (scene, tolerance) = (Scene::read(&text), case.tolerance("abs"));
    let mut run = scene.run();
    for (time, state) in case.states() {
        run.until(time);
        let bob = run.point("rod", [0.0, -length, 0.0]);
        state.at("x").check(bob.x, tolerance);
        state.at("y").check(bob.y, tolerance);
        state.at("theta_from_down").check(run.coordinate("rod"), tolerance);
        state.at("thetadot").check(run.speed("rod"), tolerance);
    }
    assert!(survey::is_on() || run.drift < tolerance, "energy drift {:e}", run.drift);
}

/// Two rods, the lower one's absolute angle given as the upper one's.
fn double(head: &str, lengths: [f64; 2], masses: [f64; 2], angles: [f64; 2]) -> Scene {
    let upper = rod("upper", "ground", 0.0, lengths[0], masses[0], angles[0]);
    let lower = rod("lower", "upper", lengths[0], lengths[1], masses[1], angles[1] - angles[0]);
    Scene::read(&format!("{head}{upper}{lower}"))
}

/// Absolute angles and rates.
fn check_double(run: &Run<'_>, state: &Node, tolerance: f64, rate_tolerance: f64) {
    let (upper, lower) = (run.coordinate("upper"), run.coordinate("lower"));
    let (upper_rate, lower_rate) = (run.speed("upper"), run.speed("lower"));
    state.at("theta1").check(upper, tolerance);
    state.at("theta2").check(upper + lower, tolerance);
    state.at("omega1").check(upper_rate, rate_tolerance);
    state.at("omega2").check(upper_rate + lower_rate, rate_tolerance);
}

/// As long as an error of the integrator's tolerance, amplified as the case says, leaves two digits. After that only
/// energy can be asked for.
#[test]
pub(super) fn c08_chaotic_double_pendulum() {
    let tolerance = survey::asked("dopri5", 1e-13).1;
    let case = case("C08_chaotic_double_pendulum");
    let [lengths, masses] = [["l1", "l2"], ["m1", "m2"]].map(|keys| keys.map(|key| case.parameter(key)));
    let angles = ["theta1", "theta2"].map(|key| case.initial(key));
    let head = head([0.0, -case.parameter("g"), 0.0], "dopri5", tolerance);
    let scene = double(&head, lengths, masses, angles);
    let mut run = scene.run();
    for (time, state) in case.states() {
        run.until(time);
        let allowed = state.at("error_amplification").number() * tolerance;
        if allowed < 0.05 {
            check_double(&run, &state, allowed, allowed);
        }
    }
    let energy = case.at("reference").at("energy");
    // Energy errors of the steps add up; some 15 000 of them, each within the tolerance of the energy of 16 J.
    energy.check(run.energy(), 1e-11);
}

#[test]
pub(super) fn c12_unit_scaling() {
    let case = case("C12_unit_scaling");
    let angles = ["theta1", "theta2"].map(|key| case.initial(key));
    let head = head([0.0, -case.parameter("g"), 0.0], "dopri5", 1e-12);
    let reference = case.at("reference");
    for key in reference.keys() {
        let scale = |name: &str| -> f64 {
            let part = key.split(',').find_map(|part| part.strip_prefix(name)).expect("a scale");
            part.trim_start_matches('=').parse().expect("a number")
        };
        let length = scale("length_scale") * case.parameter("l");
        let mass = scale("mass_scale") * case.parameter("m");
        let (scene, state) = (double(&head, [length; 2], [mass; 2], angles), reference.at(&key));
        let mut run = scene.run();
        let time = state.at("time").number();
        run.until(time);
        // Rates are those of the unit pendulum over the square root of the length.
        check_double(&run, &state, case.tolerance("abs_angle"), case.tolerance("abs_angle") * 5.0 / time);
        state.at("energy").check_relative(run.energy(), 1e-11);
    }
}

#[test]
pub(super) fn c01_mass_ratio_1e6() {
    for id in ["C01_mass_ratio_1e6_light_lower", "C01_mass_ratio_1e6_light_upper"] {
        let case = case(id);
        let [lengths, masses] = [["l1", "l2"], ["m1", "m2"]].map(|keys| keys.map(|key| case.parameter(key)));
        let angles = ["theta1", "theta2"].map(|key| case.initial(key));
        // What a step is wrong by grows seven thousand times until t = 1 s.
        let head = head([0.0, -case.parameter("g"), 0.0], "dopri5", 2e-14);
        let scene = double(&head, lengths, masses, angles);
        let mut run = scene.run();
        for (time, state) in case.states() {
            run.until(time);
            check_double(&run, &state, case.tolerance("abs"), case.tolerance("abs"));
        }
    }
}

#[test]
pub(super) fn c13_massless_link() {
    let case = case("C13_massless_link");
    assert_eq!((case.parameter("m1"), case.parameter("I1")), (0.0, 0.0));
    let (length, inertia) = (case.parameter("l2"), case.parameter("I2_com"));
    let angles = ["theta1_abs", "theta2_abs"].map(|key| case.initial(key));
    let text = head([0.0, -case.parameter("g"), 0.0], "dopri5", 1e-12)
        + &rod("upper", "ground", 0.0, case.parameter("l1"), 0.0, angles[0])
        + &format!(
            "[[body]]\nname = \"lower\"\nmass = {:?}\ncenter = {:?}\ninertia = {:?}\nhinge = {{ type = \"revolute\", \
             parent = \"upper\", at = {:?}, axis = [0, 0, 1], position = {:?} }}\n",
            case.parameter("m2"),
            [0.0, -0.5 * length, 0.0],
            [inertia, 0.0, inertia],
            [0.0, -case.parameter("l1"), 0.0],
            angles[1] - angles[0],
        );
    let scene = Scene::read(&text);
    let mut run = scene.run();
    for (time, state) in case.states() {
        run.until(time);
        check_double(&run, &state, case.tolerance("abs"), case.tolerance("abs"));
    }
}
