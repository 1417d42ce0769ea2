//! Rigid bodies turning freely about a fixed point or about their centre.

use super::case::{Node, case};
use super::scene::{Run, Scene, head};
use super::survey;
use nalgebra::{Matrix3, Vector3};

/// One body on a spherical or free hinge at the origin.
struct Top {
    gravity: f64,
    hinge: &'static str,
    mass: f64,
    center: [f64; 3],
    inertia: [f64; 3],
    quaternion: [f64; 4],
    rates: [f64; 3],
}

impl Top {
    fn scene(&self, integrator: &str, tolerance: f64) -> Scene {
        let zeros: &[f64] = if self.hinge == "free" { &[0.0; 3] } else { &[] };
        let text = head([0.0, 0.0, -self.gravity], integrator, tolerance)
            + &format!(
                "[[body]]\nname = \"top\"\nmass = {:?}\ncenter = {:?}\ninertia = {:?}\n\
                 hinge = {{ type = \"{}\", position = {:?}, velocity = {:?} }}\n",
                self.mass,
                self.center,
                self.inertia,
                self.hinge,
                [zeros, &self.quaternion].concat(),
                [zeros, &self.rates].concat(),
            );
        Scene::read(&text)
    }
}

/// The quaternion, whichever of the two that mean the same turn.
fn check_quaternion(state: &Node, run: &Run<'_>, tolerance: f64) {
    let expected: [f64; 4] = state.at("quat_wxyz").array();
    let found = run.positions("top");
    let found = &found[found.len() - 4..];
    let same: f64 = expected.iter().zip(found).map(|(a, b)| a * b).sum();
    let found: Vec<f64> = found.iter().map(|x| x * same.signum()).collect();
    state.at("quat_wxyz").check_list(&found, tolerance);
}

fn rates<'a>(run: &'a Run<'_>) -> &'a [f64] {
    let rates = run.velocities("top");
    &rates[rates.len() - 3..]
}

#[test]
pub(super) fn a08_heavy_top() {
    let case = case("A08_heavy_top");
    let (parameters, tolerance) = (case.at("parameters"), case.tolerance("abs"));
    let top = Top {
        gravity: case.parameter("g"),
        hinge: "spherical",
        mass: case.parameter("m"),
        center: parameters.at("X").array(),
        inertia: parameters.at("J_com").array(),
        quaternion: case.at("initial_state").at("quat").array(),
        rates: case.at("initial_state").at("omega_body").array(),
    };
    let scene = top.scene("dopri5", 1e-12);
    let mut run = scene.run();
    for (time, state) in case.states() {
        run.until(time);
        state.at("com").check_list(run.point("top", top.center).as_slice(), tolerance);
        check_quaternion(&state, &run, tolerance);
        // The spin of 150 rad/s is exact, the others turn with it: an angle's error times the spin.
        state.at("omega_body").check_list(rates(&run), top.rates[1] * tolerance);
    }
}

/// A thin rod: the moment of inertia about its own axis is 1e-11 of the others.
#[test]
pub(super) fn c16_needle_inertia() {
    let case = case("C16_needle_inertia");
    let (parameters, tolerance) = (case.at("parameters"), case.tolerance("abs"));
    let top = Top {
        gravity: case.parameter("g"),
        hinge: "spherical",
        mass: case.parameter("m"),
        center: [0.0, 0.0, 0.5 * case.parameter("l")],
        inertia: parameters.at("I_com").array(),
        quaternion: case.at("initial_state").at("quat").array(),
        rates: case.at("initial_state").at("omega_body").array(),
    };
    let scene = top.scene("dopri5", 1e-12);
    let mut run = scene.run();
    for (time, state) in case.states() {
        run.until(time);
        state.at("com").check_list(run.point("top", top.center).as_slice(), tolerance);
        check_quaternion(&state, &run, tolerance);
        // The spin is constant exactly, whatever its tiny inertia.
        assert!(survey::is_on() || rates(&run)[2] == top.rates[2]);
    }
}

/// A free top's states up to `until`, and the sign changes of the rate about the middle axis.
fn check_free_top(id: &str, until: f64) {
    let case = case(id);
    let (reference, tolerance) = (case.at("reference"), case.tolerance("abs"));
    let top = Top {
        gravity: 0.0,
        hinge: "free",
        mass: case.parameter("m"),
        center: [0.0; 3],
        inertia: case.at("parameters").at("I").array(),
        quaternion: case.at("initial_state").at("quat").array(),
        rates: case.at("initial_state").at("omega_body").array(),
    };
    let scene = top.scene("dopri5", 1e-13);
    let mut run = scene.run();
    for (time, state) in case.states().into_iter().filter(|(time, _)| *time <= until) {
        run.until(time);
        check_quaternion(&state, &run, tolerance);
        state.at("omega_body").check_list(rates(&run), tolerance);
        // Rounding of some thousand steps on top of a step error of 1e-13 each.
        reference.at("L_world").check_list(angular_momentum(&run, &top).as_slice(), 1e-10);
    }
    let mut run = scene.run();
    let first = reference.at("first_zero_of_w2").number();
    run.until(first);
    reference.at("first_zero_of_w2").check_against(rates(&run)[1], 0.0, tolerance);
    let second = first + reference.at("flip_interval").number();
    if second <= until {
        run.until(second);
        reference.at("flip_interval").check_against(rates(&run)[1], 0.0, tolerance);
    }
}

#[test]
pub(super) fn a10_free_top() {
    check_free_top("A10_free_top", f64::INFINITY);
}

/// Up to the second passage of the unstable axis: the time spent there hangs on a difference of energies of one part in
/// 5e13, which rounding decides in double precision.
#[test]
pub(super) fn a10_free_top_separatrix() {
    check_free_top("A10_free_top_separatrix", 10.0);
}

fn angular_momentum(run: &Run<'_>, top: &Top) -> Vector3<f64> {
    let inertia = Matrix3::from_diagonal(&Vector3::from(top.inertia));
    run.pose("top").rotation * (inertia * Vector3::from_column_slice(rates(run)))
}

fn gyro() -> (Node, Top) {
    let case = case("C06_fast_gyro_1e5");
    let top = Top {
        gravity: case.parameter("g"),
        hinge: "spherical",
        mass: case.parameter("m"),
        center: [0.0, 0.0, case.parameter("l")],
        inertia: case.at("parameters").at("I_com").array(),
        quaternion: case.at("initial_state").at("quat").array(),
        rates: case.at("initial_state").at("omega_body").array(),
    };
    (case, top)
}

fn check_gyro(until: f64) {
    let (case, top) = gyro();
    let tolerance = case.tolerance("abs_axis");
    let scene = top.scene("dopri5", 1e-13);
    let mut run = scene.run();
    for (time, state) in case.states().into_iter().filter(|(time, _)| *time <= until) {
        run.until(time);
        let axis = run.pose("top").rotation * Vector3::z();
        state.at("axis_world").check_list(axis.as_slice(), tolerance);
        if state.keys().contains(&"quat_wxyz".to_owned()) {
            check_quaternion(&state, &run, tolerance);
        }
    }
}

#[test]
pub(super) fn c06_fast_gyro_1e5() {
    check_gyro(0.01);
}

#[test]
// 16 000 turns in small steps: only an optimised build (`cargo test --release`) has this test.
#[cfg(not(debug_assertions))]
fn c06_fast_gyro_1e5_for_a_second() {
    check_gyro(1.0);
}

/// Attitude up to `until`, and the largest relative change of the angular momentum.
fn check_drift(until: f64) -> f64 {
    let case = case("C07_quaternion_drift");
    let top = Top {
        gravity: 0.0,
        hinge: "free",
        mass: 1.0,
        center: [0.0; 3],
        inertia: case.at("parameters").at("I").array(),
        quaternion: case.at("initial_state").at("quat").array(),
        rates: case.at("initial_state").at("omega_body").array(),
    };
    let scene = top.scene("dopri5", 1e-13);
    let mut run = scene.run();
    let at_start = Matrix3::from_diagonal(&Vector3::from(top.inertia)) * Vector3::from(top.rates);
    let mut change = 0.0_f64;
    for (time, state) in case.states().into_iter().filter(|(time, _)| *time <= until) {
        run.until(time);
        change = change.max((angular_momentum(&run, &top) - at_start).norm() / at_start.norm());
        let norm = run.positions("top")[3..].iter().map(|x| x * x).sum::<f64>().sqrt();
        // A few roundings: the quaternion is normalised after every step.
        assert!((norm - 1.0).abs() < 1e-15, "{norm}");
        check_quaternion(&state, &run, case.tolerance("abs"));
    }
    change
}

#[test]
pub(super) fn c07_quaternion_drift() {
    let change = check_drift(10.0);
    // The case's suggestion.
    assert!(survey::is_on() || change < 1e-12, "{change:e}");
}

#[test]
// ten million evaluations: only an optimised build (`cargo test --release`) has this test.
#[cfg(not(debug_assertions))]
pub(super) fn c07_quaternion_drift_for_ten_thousand_seconds() {
    check_drift(1e4);
}

/// The free top carried by three turns with massless rings between them.
#[test]
pub(super) fn c11_gimbal_lock() {
    let case = case("C11_gimbal_lock");
    let (tolerance, inertia) = (case.tolerance("abs"), case.at("parameters").at("I").array::<3>());
    let start: [f64; 3] = case.at("initial_state").at("omega_body").array();
    let angle = case.initial("angles");
    let turn = |name: &str, parent: &str, axis: [f64; 3], rate: f64, mass: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\n{mass}hinge = {{ type = \"revolute\", parent = \"{parent}\", axis = {axis:?}, \
             position = {angle:?}, velocity = {rate:?} }}\n"
        )
    };
    let text = head([0.0; 3], "dopri5", 1e-12)
        + &turn("outer", "ground", [1.0, 0.0, 0.0], start[0], "")
        + &turn("inner", "outer", [0.0, 1.0, 0.0], start[1], "")
        + &turn("top", "inner", [0.0, 0.0, 1.0], start[2], &format!("mass = 1.0\ninertia = {inertia:?}\n"));
    let scene = Scene::read(&text);
    let mut run = scene.run();
    let closest = case.at("reference").at("closest_approach");
    run.until(closest.at("time").number());
    // The case gives this time to four digits.
    if !survey::is_on() {
        closest.at("cos_beta").check(run.coordinate("inner").cos().abs(), tolerance);
    }
    for (time, state) in case.states() {
        run.until(time);
        let found = run.pose("top").rotation.to_rotation_matrix();
        for (row, expected) in state.at("R_row_major").items().iter().enumerate() {
            let found: Vec<f64> = (0..3).map(|column| found[(row, column)]).collect();
            expected.check_list(&found, tolerance);
        }
    }
}
