//! Statics with one equilibrium, several, or as many as there are angles.

use super::case::case;
use super::scene::{Scene, frequencies, head};
use std::f64::consts::PI;
use stillpoint::dynamics::System;
use stillpoint::statics::{Equilibrium, StabilityVerdict};

/// A point mass on a massless rod along `along` of a hinge about z, with a spring in it; gravity along −y.
struct Pendulum {
    mass: f64,
    along: [f64; 3],
    gravity: f64,
    stiffness: f64,
    rest: f64,
}

impl Pendulum {
    fn scene(&self, guess: f64, want: &str) -> Scene {
        let text = head([0.0, -self.gravity, 0.0], "dopri5", 1e-8)
            + &format!(
                "[statics]\nwant = \"{want}\"\n[[body]]\nname = \"arm\"\nmass = {:?}\ncenter = {:?}\nhinge = {{ \
                 type = \"revolute\", axis = [0, 0, 1], stiffness = {:?}, rest = {:?}, position = {guess:?} }}\n",
                self.mass, self.along, self.stiffness, self.rest
            );
        Scene::read(&text)
    }
}

/// The stiffness of a scene with one coordinate.
fn stiffness(scene: &Scene, position: &[f64]) -> f64 {
    System::new(&scene.model).at(0.0, position, &vec![0.0; position.len()]).stiffness().expect("finite numbers")[(0, 0)]
}

fn verdict(found: &Equilibrium) -> StabilityVerdict {
    found.stability.as_ref().expect("an equilibrium").verdict
}

#[test]
fn b01_pendulum_torsion_spring() {
    let case = case("B01_pendulum_torsion_spring");
    let (reference, tolerance) = (case.at("reference"), case.tolerance("abs"));
    let pendulum = Pendulum {
        mass: case.parameter("m"),
        along: [0.0, -case.parameter("l"), 0.0],
        gravity: case.parameter("g"),
        stiffness: case.parameter("k"),
        rest: case.parameter("theta0"),
    };
    // The spring counts turns, so the only equilibrium is found from any number of them.
    for guess in [0.0, 2.0, 1e6, -1e6, 2e6] {
        let scene = pendulum.scene(guess, "stable");
        let found = scene.rest();
        reference.at("theta").check(found.position[0], tolerance);
        reference.at("tangent_stiffness").check_relative(stiffness(&scene, &found.position), tolerance);
        reference.at("small_oscillation_omega_point_mass").check_relative(frequencies(&found)[0], tolerance);
    }
}

#[test]
fn b02_inverted_pendulum_pitchfork() {
    let case = case("B02_inverted_pendulum_pitchfork");
    let reference = case.at("reference");
    let weight = case.parameter("mgl");
    for key in reference.keys() {
        let ratio: f64 = key.trim_start_matches("k_over_mgl=").parse().expect("a number");
        let expected = reference.at(&key);
        let pendulum = Pendulum {
            mass: case.parameter("m"),
            along: [0.0, case.parameter("l"), 0.0],
            gravity: case.parameter("g"),
            stiffness: ratio * weight,
            rest: 0.0,
        };
        // The case's own allowance where the pitchfork is near: half the digits are lost.
        let tolerance = if (1.0 - ratio).abs() < 1e-5 { 1e-6 } else { case.tolerance("abs") };
        let upright = pendulum.scene(0.0, "any");
        let found = upright.rest();
        assert_eq!(found.position, [0.0]);
        let zero = stiffness(&upright, &found.position) / weight;
        // A difference of numbers near one.
        expected.at("stiffness_over_mgl_at_zero").check(zero, 1e-15);
        let buckles = ratio < 1.0;
        assert_eq!(verdict(&found), if buckles { StabilityVerdict::Unstable } else { StabilityVerdict::Stable });
        let name = if buckles { "theta_stable_plus_minus" } else { "theta_stable" };
        for guess in case.at("initial_state").at("guess").numbers() {
            for guess in [guess, -guess] {
                let scene = pendulum.scene(guess, "stable");
                let found = scene.rest();
                assert_eq!(verdict(&found), StabilityVerdict::Stable);
                let angle = found.position[0];
                expected.at(name).check(if buckles { angle.abs() } else { angle }, tolerance);
                if buckles {
                    let found = stiffness(&scene, &found.position) / weight;
                    expected.at("stiffness_over_mgl_at_stable").check(found, tolerance);
                }
            }
        }
    }
}

/// A mass on a slide between two springs.
fn truss(case: &super::case::Node, mass: f64, guess: f64, want: &str) -> Scene {
    let side = |at: f64| {
        format!(
            "[[force]]\ntype = \"spring\"\nbetween = [\"mass\", {{ body = \"ground\", at = {:?} }}]\nstiffness = {:?}\n\
             length = {:?}\n",
            [at, 0.0, 0.0],
            case.parameter("k"),
            case.parameter("L0"),
        )
    };
    let a = case.parameter("a");
    let text = head([0.0, -case.parameter("g"), 0.0], "dopri5", 1e-8)
        + &format!(
            "[statics]\nwant = \"{want}\"\n[[body]]\nname = \"mass\"\nmass = {mass:?}\n\
             hinge = {{ type = \"prismatic\", axis = [0, 1, 0], position = {guess:?} }}\n"
        )
        + &side(a)
        + &side(-a);
    Scene::read(&text)
}

#[test]
fn b04_von_mises_truss() {
    let case = case("B04_von_mises_truss");
    let (reference, tolerance) = (case.at("reference"), case.tolerance("abs"));
    let equilibria = reference.at("equilibria").items();
    let nearest = |y: f64| {
        let distance = |place: &super::case::Node| (place.at("y").number() - y).abs();
        equilibria.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("equilibria")
    };
    let [high, _, low] = case.at("initial_state").at("guess").array();
    for (guess, sign) in [(high, 1.0), (0.0, -1.0), (low, -1.0)] {
        let scene = truss(&case, case.parameter("mass"), guess, "stable");
        let found = scene.rest();
        let y = found.position[0];
        assert_eq!((verdict(&found), y.signum()), (StabilityVerdict::Stable, sign));
        nearest(y).at("y").check(y, tolerance);
        // The stiffness changes by some 1e3 N/m per metre.
        nearest(y).at("stiffness").check(stiffness(&scene, &found.position), 1e3 * tolerance);
    }
    // Between them is one that no digits are given for: it is unstable, and it is the nearest from the middle.
    let between = truss(&case, case.parameter("mass"), 0.5 * high * 0.5, "any").rest();
    assert_eq!(verdict(&between), StabilityVerdict::Unstable);
    assert!(0.0 < between.position[0] && between.position[0] < reference.at("limit_height").number());
}

/// Just below the limit load the truss still stands, next to the limit height; just above it snaps through.
#[test]
fn b04_von_mises_truss_at_its_limit() {
    const PART: f64 = 1e-9;
    let case = case("B04_von_mises_truss");
    let reference = case.at("reference");
    let mass = reference.at("limit_load").number() / case.parameter("g");
    let height = reference.at("limit_height").number();
    let below = truss(&case, mass * (1.0 - PART), 0.3, "stable").rest();
    // The load falls with the square of the distance from the limit height: 1e-9 of it is some 1e-5 m.
    assert!((below.position[0] - height).abs() < 2e-5, "{}", below.position[0] - height);
    assert!(below.position[0] > height);
    let above = truss(&case, mass * (1.0 + PART), 0.3, "stable").rest();
    assert!(above.position[0] < 0.0);
    assert_eq!(verdict(&above), StabilityVerdict::Stable);
}

#[test]
fn b13_gravity_balanced_arm() {
    let case = case("B13_gravity_balanced_arm");
    let (reference, residual) = (case.at("reference"), case.tolerance("residual"));
    let [m, l, g, h, a, k] = ["m", "l", "g", "h", "a", "k"].map(|key| case.parameter(key));
    for step in 0..16 {
        let angle = -3.0 + 0.4 * f64::from(step);
        let text = head([0.0, -g, 0.0], "dopri5", 1e-8)
            + &format!(
                "[[body]]\nname = \"arm\"\nmass = {m:?}\ncenter = {:?}\n\
                 hinge = {{ type = \"revolute\", axis = [0, 0, 1], position = {angle:?} }}\n\
                 [[force]]\ntype = \"spring\"\nstiffness = {k:?}\nlength = 0.0\n\
                 between = [{{ body = \"arm\", at = {:?} }}, {{ body = \"ground\", at = {:?} }}]\n",
                [0.0, l, 0.0],
                [0.0, a, 0.0],
                [0.0, h, 0.0],
            );
        let scene = Scene::read(&text);
        let found = scene.rest();
        assert_eq!((found.position[0], verdict(&found)), (angle, StabilityVerdict::Neutral));
        reference.at("residual").check(found.residual_force, residual);
        reference.at("tangent_stiffness").check(stiffness(&scene, &found.position), residual);
        let potential = System::new(&scene.model).at(0.0, &found.position, &[0.0]).energies().potential;
        let expected = reference.at("potential_a");
        // Sixteen digits of 20 J.
        expected.check(potential, 1e-13);
    }
}

/// Bodies hinged at their centres, and a pendulum that may twist.
#[test]
fn b13_bodies_free_to_turn() {
    let case = case("B13_gravity_balanced_arm");
    let [m, l, g] = ["m", "l", "g"].map(|key| case.parameter(key));
    let scene = |hinge: &str, center: f64| {
        let text = head([0.0, 0.0, -g], "dopri5", 1e-8)
            + &format!(
                "[[body]]\nname = \"body\"\nmass = {m:?}\ncenter = {:?}\ninertia = [0.3, 0.3, 0.1]\n\
                 hinge = {{ {hinge} }}\n",
                [0.0, 0.0, center]
            );
        Scene::read(&text)
    };
    let turned = "type = \"spherical\", position = [0.5, 0.5, -0.5, 0.5]";
    for hinge in ["type = \"revolute\", axis = [0, 1, 0], position = 0.7", turned] {
        let scene = scene(hinge, 0.0);
        let found = scene.rest();
        assert_eq!((&found.position, verdict(&found)), (&scene.model.start_position, StabilityVerdict::Neutral));
        case.at("reference").at("residual").check(found.residual_force, case.tolerance("residual"));
    }
    for angle in [0.0, 1.0, 3.0, PI] {
        let position = [f64::cos(0.5 * angle), f64::sin(0.5 * angle), 0.0, 0.0];
        let found = scene(&format!("type = \"spherical\", position = {position:?}"), -l).rest();
        let axis = found.poses[0].rotation * nalgebra::Vector3::z();
        // Half the digits of the residual's tolerance would do for a potential; the forces' zero is as sharp as they.
        case.at("reference").at("c_angle_from_vertical").check(axis.x.hypot(axis.y), case.tolerance("residual"));
        assert!(axis.z > 0.0);
        let stability = found.stability.as_ref().expect("an equilibrium");
        assert_eq!((stability.unstable_directions, stability.neutral_directions), (0, 1));
    }
}
