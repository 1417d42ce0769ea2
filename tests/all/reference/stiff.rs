//! Scenes with rates far apart, for the implicit method.

use super::case::{Node, case};
use super::scene::{Scene, head};
use super::survey;
use std::f64::consts::PI;

/// A mass that slides on a massless arm, held by a spring and a damper.
fn radial(case: &Node, integrator: &str, tolerance: f64) -> Scene {
    let [m, k, c, rest, g] = ["m", "k", "c", "l0", "g"].map(|key| case.parameter(key));
    let text = head([0.0, -g, 0.0], integrator, tolerance)
        + &format!(
            "[[body]]\nname = \"arm\"\nhinge = {{ type = \"revolute\", axis = [0, 0, 1], position = {:?}, \
             velocity = {:?} }}\n\
             [[body]]\nname = \"mass\"\nmass = {m:?}\nhinge = {{ type = \"prismatic\", parent = \"arm\", \
             axis = [0, -1, 0], position = {:?}, velocity = {:?}, stiffness = {k:?}, damping = {c:?}, rest = {rest:?} }}\n",
            case.initial("theta"),
            case.initial("thetadot"),
            case.initial("r"),
            case.initial("rdot"),
        );
    Scene::read(&text)
}

fn check_radial(id: &str, integrator: &str, local: f64) {
    let case = case(id);
    let tolerance = case.tolerance("abs_theta");
    let scene = radial(&case, integrator, local);
    let mut run = scene.run();
    for (time, state) in case.states() {
        run.until(time);
        state.at("theta").check(run.coordinate("arm"), tolerance);
        state.at("thetadot").check(run.speed("arm"), tolerance);
        state.at("r").check(run.coordinate("mass"), tolerance);
    }
}

#[test]
pub(super) fn c02_stiff_spring_1e8_damped() {
    check_radial("C02_stiff_spring_1e8_damped", "sdirk4", 1e-8);
}

#[test]
pub(super) fn c02_stiff_spring_1e8_undamped() {
    check_radial("C02_stiff_spring_1e8_undamped", "sdirk4", 1e-8);
}

#[test]
pub(super) fn c15_overdamped_creep() {
    let case = case("C15_overdamped_creep");
    let [m, l, g, c] = ["m", "l", "g", "c"].map(|key| case.parameter(key));
    let text = head([0.0, -g, 0.0], "sdirk4", 1e-8)
        + &format!(
            "[[body]]\nname = \"arm\"\nmass = {m:?}\ncenter = {:?}\nhinge = {{ type = \"revolute\", axis = [0, 0, 1], \
             damping = {c:?}, position = {:?}, velocity = {:?} }}\n",
            [0.0, -l, 0.0],
            case.initial("theta"),
            case.initial("thetadot")
        );
    let scene = Scene::read(&text);
    let mut run = scene.run();
    for (time, state) in case.states() {
        let before = (run.time(), run.steps);
        run.until(time);
        let (span, steps) = (time - before.0, run.steps - before.1);
        // What the case expects of a method that damps the fast rate: steps of 10 s and more once the start is over.
        assert!(survey::is_on() || before.0 < 100.0 || span >= 10.0 * steps as f64, "{steps} steps in {span} s");
        state.at("theta").check(run.coordinate("arm"), case.tolerance("abs"));
        if state.keys().contains(&"thetadot".to_owned()) {
            state.at("thetadot").check(run.speed("arm"), case.tolerance("abs"));
        }
    }
}

/// A block on a belt, with a friction that falls with the speed of sliding and turns over within a millimetre per second:
/// a motor that pushes by a formula in the speed.
#[test]
fn c09_stick_slip_smooth() {
    let case = case("C09_stick_slip");
    let [m, k, n, most, least, belt, turn, fall] =
        ["m", "k", "N", "mu_s", "mu_d", "vb", "vs", "vst"].map(|key| case.parameter(key));
    let slide = format!("({belt:?} - v)");
    let friction =
        format!("{n:?}*tanh({slide}/{turn:?})*({least:?} + {:?}*exp(-(({slide}/{fall:?})^2)))", most - least);
    for (integrator, tolerance) in [("radau9", 1e-10), ("dop853", 1e-11)] {
        let text = head([0.0; 3], integrator, tolerance)
            + &format!(
                "[[body]]\nname = \"block\"\nmass = {m:?}\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], \
                 stiffness = {k:?}, position = {:?}, velocity = {:?} }}\n\
                 [[motor]]\nhinge = \"block\"\ntype = \"expression\"\nexpression = \"{friction}\"\n",
                case.initial("x"),
                case.initial("v"),
            );
        let scene = Scene::read(&text);
        let mut run = scene.run();
        for (time, state) in case.at("reference").at("b_smooth").at_times() {
            run.until(time);
            state.at("x").check(run.coordinate("block"), case.tolerance("abs"));
            state.at("v").check(run.speed("block"), case.tolerance("abs"));
        }
    }
}

/// Nothing is left to follow once it hangs: all methods for stiff systems take steps of any length there.
#[test]
fn c15_the_end_of_the_creep_costs_nothing() {
    let case = case("C15_overdamped_creep");
    let [m, l, g, c] = ["m", "l", "g", "c"].map(|key| case.parameter(key));
    for integrator in ["sdirk4", "radau5", "radau9"] {
        let text = head([0.0, -g, 0.0], integrator, 1e-8)
            + &format!(
                "[[body]]\nname = \"arm\"\nmass = {m:?}\ncenter = [0, {:?}, 0]\nhinge = {{ type = \"revolute\", \
                 axis = [0, 0, 1], damping = {:?}, position = 2 }}\n",
                -l,
                0.1 * c,
            );
        let scene = Scene::read(&text);
        let mut run = scene.run();
        run.until(2000.0);
        let before = run.steps;
        run.until(10000.0);
        assert!(run.coordinate("arm").abs() < 1e-8 && run.steps - before < 30, "{integrator}: {}", run.steps - before);
    }
}

/// Shaft, slider, two rods with balls, and the springs between slider and rods.
fn governor(case: &Node, integrator: &str, tolerance: f64) -> Scene {
    let p = |key: &str| case.parameter(key);
    let (half, angle) = (p("x_hinge"), case.initial("rod_angle_deg") * PI / 180.0);
    let across = p("I_rod_transverse");
    let mut text = head([0.0, 0.0, -p("g")], integrator, tolerance)
        + &format!(
            "[[body]]\nname = \"shaft\"\nmass = {:?}\ncenter = [0, 0, 0.5]\ninertia = {:?}\n\
             hinge = {{ type = \"revolute\", axis = [0, 0, 1], velocity = {:?} }}\n\
             [[body]]\nname = \"slider\"\nmass = {:?}\ninertia = {:?}\n\
             hinge = {{ type = \"prismatic\", parent = \"shaft\", axis = [0, 0, 1], position = {:?} }}\n",
            p("m_shaft"),
            [across, across, p("I_shaft_axial")],
            case.initial("shaft_rate"),
            p("m_slider"),
            [p("I_slider"); 3],
            case.initial("s"),
        );
    for (side, sign) in [("right", 1.0), ("left", -1.0)] {
        text += &format!(
            "[[body]]\nname = \"{side}\"\nmass = {:?}\ncenter = {middle:?}\ninertia = {:?}\n\
             hinge = {{ type = \"revolute\", parent = \"shaft\", at = {:?}, axis = [0, {sign:?}, 0], position = {angle:?} }}\n\
             [[body]]\nname = \"{side} ball\"\nmass = {:?}\n\
             hinge = {{ type = \"fixed\", parent = \"{side}\", at = {:?} }}\n\
             [[force]]\ntype = \"spring\"\nstiffness = {:?}\ndamping = {:?}\nlength = {:?}\n\
             between = [{{ body = \"slider\", at = {:?} }}, {{ body = \"{side}\", at = {middle:?} }}]\n",
            p("m_rod"),
            [p("I_rod_axial"), across, across],
            [sign * half, 0.0, 1.0],
            p("m_point"),
            [sign, 0.0, 0.0],
            p("k"),
            p("c"),
            p("l0"),
            [sign * half, 0.0, 0.0],
            middle = [0.5 * sign, 0.0, 0.0],
        );
    }
    Scene::read(&text)
}

#[test]
pub(super) fn a05_flyball_governor() {
    let case = case("A05_flyball_governor");
    let tolerance = case.tolerance("abs");
    let scene = governor(&case, "sdirk4", 1e-8);
    let mut run = scene.run();
    for (time, state) in case.states() {
        run.until(time);
        state.at("s").check(run.coordinate("slider"), tolerance);
        state.at("sdot").check(run.speed("slider"), tolerance);
        state.at("shaft_angle").check(run.coordinate("shaft"), tolerance);
        state.at("shaft_rate").check(run.speed("shaft"), tolerance);
        for side in ["right", "left"] {
            state.at("rod_angle_below_horizontal").check(run.coordinate(side), tolerance);
            state.at("rod_rate").check(run.speed(side), tolerance);
        }
    }
}
