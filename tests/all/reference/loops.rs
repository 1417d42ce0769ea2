//! Closed loops: chains of four-bars, Andrews' squeezer, Bricard's mechanism.

use super::case::case;
use super::scene::{Scene, head};
use std::f64::consts::PI;

/// `count` four-bars in a row; angles clockwise from upright.
pub(super) fn four_bars(count: usize, rate: f64, tolerance: f64) -> String {
    let case = case(&format!("A02_n_fourbar_N{count}"));
    let (m, l, inertia) = (case.parameter("m"), case.parameter("L"), case.parameter("I_com"));
    let mut text = head([0.0, -case.parameter("g"), 0.0], "dop853", tolerance);
    for i in 0..=count {
        let (at, rate) = (i as f64 * l, if i == 0 { rate } else { 0.0 });
        text += &format!(
            "[[body]]\nname = \"rod{i}\"\nmass = {m:?}\ncenter = [0, {:?}, 0]\ninertia = [{inertia:?}, 0, {inertia:?}]\n\
             markers = {{ tip = [0, {l:?}, 0] }}\n\
             hinge = {{ type = \"revolute\", at = [{at:?}, 0, 0], axis = [0, 0, -1], velocity = {rate:?} }}\n",
            0.5 * l
        );
    }
    for i in 0..count {
        text += &format!(
            "[[body]]\nname = \"bar{i}\"\nmass = {m:?}\ncenter = [{:?}, 0, 0]\ninertia = [0, {inertia:?}, {inertia:?}]\n\
             markers = {{ tip = [{l:?}, 0, 0] }}\n\
             hinge = {{ type = \"revolute\", parent = \"rod{i}\", at = \"tip\", axis = [0, 0, -1] }}\n\
             [[loop]]\ntype = \"revolute\"\nbetween = [\"bar{i}.tip\", \"rod{}.tip\"]\naxis = [0, 0, 1]\n",
            0.5 * l,
            i + 1
        );
    }
    text
}

/// Through every change point, where all bars lie in one line: the rods stay parallel, at every tolerance.
#[test]
fn a02_four_bars_pass_their_change_points() {
    for (count, tolerance, until) in [
        (1, 1e-8, 10.0),
        (1, 1e-10, 10.0),
        (1, 1e-12, 20.0),
        (2, 1e-8, 10.0),
        (2, 1e-10, 10.0),
        (2, 1e-12, 20.0),
        (40, 1e-8, 10.0),
        (40, 1e-12, 10.0),
    ] {
        let case = case(&format!("A02_n_fourbar_N{count}"));
        let scene = Scene::read(&four_bars(count, case.initial("thetadot"), tolerance));
        assert_eq!(scene.model.degrees_of_freedom(), 1);
        for (time, state) in case.states().into_iter().filter(|(time, _)| *time == until) {
            let mut run = scene.run();
            run.until(time);
            // Ten passages (twenty at 20 s), and each turn all of it slows down on its head: what a step errs grows there.
            // Each passage costs some 1e-10 of rounding.
            let most = (300.0 * tolerance).max(3e-9);
            for rod in 0..=count {
                state.at("theta_from_up_cw").check(run.coordinate(&format!("rod{rod}")), most);
            }
            let tip = run.point("rod0", [0.0, case.parameter("L"), 0.0]);
            state.at("B0_x").check(tip.x, most);
            state.at("B0_y").check(tip.y, most);
            assert!(run.gap < 1e-12, "{:e}", run.gap);
        }
    }
}

/// Seven bodies, three loops. Angles in the reference are relative as in the published equations.
pub(super) fn squeezer(integrator: &str, tolerance: f64) -> String {
    let case = case("A03_andrews_squeezer");
    let p = |key: &str| case.parameter(key);
    let body = |name: &str, number: usize, center: [f64; 2], markers: &str, hinge: String, angle: &str, force: f64| {
        let (mass, inertia) = (p(&format!("m{number}")), p(&format!("i{number}")));
        format!(
            "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ncenter = [{:?}, {:?}, 0]\n\
             inertia = [{inertia:?}, {inertia:?}, {inertia:?}]\nmarkers = {{ {markers} }}\n\
             hinge = {{ type = \"revolute\", {hinge}, axis = [0, 0, 1], position = {:?}, force = {force:?} }}\n",
            center[0],
            center[1],
            case.initial(angle)
        )
    };
    let ground = |x: &str, y: &str| format!("at = [{:?}, {:?}, 0]", p(x), p(y));
    let on = |parent: &str, at: &str| format!("parent = \"{parent}\", at = \"{at}\"");
    let marker = |name: &str, x: f64, y: f64| format!("{name} = [{x:?}, {y:?}, 0]");
    let mut text = head([0.0; 3], integrator, tolerance);
    text += &body("k1", 1, [p("ra"), 0.0], &marker("F", p("rr"), 0.0), "at = [0, 0, 0]".into(), "beta", p("mom"));
    text += &body("k2", 2, [-p("da"), 0.0], &marker("E", -p("d"), 0.0), on("k1", "F"), "theta", 0.0);
    let both = [marker("E", 0.0, -p("ss")), marker("D", p("sd"), -p("sc"))].join(", ");
    text += &body("k3", 3, [p("sb"), -p("sa")], &both, ground("xb", "yb"), "gamma", 0.0);
    text += &body("k5", 5, [p("ta"), p("tb")], &marker("G", p("zt"), 0.0), ground("xa", "ya"), "delta", 0.0);
    text += &body("k4", 4, [0.0, p("ea") - p("e")], &marker("E", 0.0, -p("e")), on("k5", "G"), "phi", 0.0);
    text += &body("k7", 7, [p("ub"), -p("ua")], &marker("H", 0.0, -p("u")), ground("xa", "ya"), "epsilon", 0.0);
    text += &body("k6", 6, [p("zf") - p("fa"), 0.0], &marker("E", p("zf"), 0.0), on("k7", "H"), "omega", 0.0);
    for bar in ["k2", "k4", "k6"] {
        text += &format!("[[loop]]\ntype = \"revolute\"\nbetween = [\"{bar}.E\", \"k3.E\"]\naxis = [0, 0, 1]\n");
    }
    text += &format!(
        "[[force]]\ntype = \"spring\"\nbetween = [\"k3.D\", {{ body = \"ground\", {} }}]\nstiffness = {:?}\nlength = {:?}\n",
        ground("xc", "yc"),
        p("c0"),
        p("l0")
    );
    text
}

pub(super) const ANGLES: [(&str, &str); 7] = [
    ("beta", "k1"),
    ("theta", "k2"),
    ("gamma", "k3"),
    ("phi", "k4"),
    ("delta", "k5"),
    ("omega", "k6"),
    ("epsilon", "k7"),
];

#[test]
fn a03_andrews_squeezer() {
    let case = case("A03_andrews_squeezer");
    let scene = Scene::read(&squeezer("dop853", 1e-13));
    assert_eq!(scene.model.degrees_of_freedom(), 1);
    for (time, state) in case.states() {
        let mut run = scene.run();
        run.until(time);
        for (angle, body) in ANGLES {
            // Some states of the reference are given modulo 2π.
            let expected = state.at(angle).number();
            let turns = ((run.coordinate(body) - expected) / (2.0 * PI)).round() * 2.0 * PI;
            state.at(angle).check(run.coordinate(body) - turns, 1e-10);
            state.at(&format!("{angle}_dot")).check(run.speed(body), 1e-8);
        }
        assert!(run.gap < 1e-13, "{:e}", run.gap);
    }
}

/// Six revolute hinges that by count could not move at all: one of their 30 rows is redundant, everywhere.
pub(super) fn bricard(start: &str, position: f64) -> String {
    let case = case("A04_bricard");
    let points: Vec<[f64; 3]> = case.at("parameters").at("P").items().iter().map(|point| point.array()).collect();
    let axes: Vec<[f64; 3]> = case.at("parameters").at("axes").items().iter().map(|axis| axis.array()).collect();
    let (axial, across) = (case.parameter("I_axial"), case.parameter("I_trans"));
    let mut text = head([0.0, -case.parameter("g"), 0.0], "dop853", 1e-11).replace("given", start);
    for i in 0..5 {
        let along: [f64; 3] = std::array::from_fn(|k| points[i + 1][k] - points[i][k]);
        let (parent, at) = match i {
            0 => ("ground".to_owned(), format!("{:?}", points[0])),
            _ => (format!("bar{}", i - 1), "\"tip\"".to_owned()),
        };
        text += &format!(
            "[[body]]\nname = \"bar{i}\"\nmass = {:?}\ncenter = {:?}\ninertia = {:?}\nmarkers = {{ tip = {along:?} }}\n\
             hinge = {{ type = \"revolute\", parent = \"{parent}\", at = {at}, axis = {:?}, position = {:?} }}\n",
            case.parameter("mass"),
            along.map(|x| 0.5 * x),
            along.map(|x| if x.abs() > 0.5 { axial } else { across }),
            axes[i],
            if i == 0 { position } else { 0.0 },
        );
    }
    text + &format!(
        "[[loop]]\nname = \"last\"\ntype = \"revolute\"\nbetween = [\"bar4.tip\", {{ body = \"ground\", at = {:?} }}]\naxis = {:?}\n",
        points[5], axes[5]
    )
}

#[test]
fn a04_bricard_moves() {
    let case = case("A04_bricard");
    let scene = Scene::read(&bricard("given", 0.0));
    assert_eq!(scene.model.degrees_of_freedom(), 1);
    for (time, state) in case.states() {
        let mut run = scene.run();
        run.until(time);
        state.at("joint0_angle_y").check(run.coordinate("bar0"), 1e-9);
        state.at("joint0_rate").check(run.speed("bar0"), 1e-9);
        let along = case.at("parameters").at("P").items();
        let (p2, p3): ([f64; 3], [f64; 3]) = (along[2].array(), along[3].array());
        let tip = run.point("bar2", std::array::from_fn(|k| p3[k] - p2[k]));
        state.at("P3").check_list(tip.as_slice(), 1e-9);
        assert!(run.gap < 1e-13 && run.drift < 1e-9, "{:e} {:e}", run.gap, run.drift);
    }
}
