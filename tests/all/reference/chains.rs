//! Chains of many links in the x-y plane.

use super::case::{Node, case};
use super::scene::{Scene, frequencies, growth_rates, head};
use std::f64::consts::PI;
use stillpoint::dynamics::System;

/// `count` links called `link`, along −y of the first hinge's frame or, with `along` x, along +x.
struct Chain {
    count: usize,
    length: f64,
    along: [f64; 3],
    mass: f64,
    /// Centre of mass as a part of the length.
    center: f64,
    /// About the centre, across.
    inertia: f64,
    positions: Vec<f64>,
    stiffness: Vec<f64>,
}

impl Chain {
    fn uniform_rods(count: usize, length: f64, mass: f64) -> Self {
        Self {
            count,
            length,
            along: [0.0, -1.0, 0.0],
            mass,
            center: 0.5,
            inertia: mass * length * length / 12.0,
            positions: vec![0.0; count],
            stiffness: vec![0.0; count],
        }
    }

    fn text(&self) -> String {
        let point = |part: f64| self.along.map(|x| x * part * self.length);
        let inertia = self.along.map(|x| self.inertia * (1.0 - x.abs()));
        format!(
            "[[body]]\nname = \"link\"\nrepeat = {}\nmass = {:?}\ncenter = {:?}\ninertia = {inertia:?}\n\
             markers = {{ tip = {:?} }}\nnext = \"tip\"\n\
             hinge = {{ type = \"revolute\", axis = [0, 0, 1], position = {:?}, stiffness = {:?} }}\n",
            self.count,
            self.mass,
            point(self.center),
            point(1.0),
            self.positions,
            self.stiffness,
        )
    }
}

#[test]
fn c04_chain_initial_accelerations() {
    let case = case("C04_chain_1000_initial_acc");
    let (reference, g) = (case.at("reference"), case.parameter("g"));
    for key in reference.keys() {
        let (expected, count) = (reference.at(&key), key.trim_start_matches("n=").parse::<usize>().expect("a count"));
        let length = case.parameter("total_length") / count as f64;
        let mass = case.parameter("total_mass") / count as f64;
        let chain = Chain { along: [1.0, 0.0, 0.0], ..Chain::uniform_rods(count, length, mass) };
        let scene = Scene::read(&(head([0.0, -g, 0.0], "dopri5", 1e-8) + &chain.text()));
        let a = scene.accelerations();
        let absolute: Vec<f64> = a
            .iter()
            .scan(0.0, |sum, a| {
                *sum += a;
                Some(*sum)
            })
            .collect();
        let tolerance = case.tolerance("rel") * a.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        for (name, list) in [("qdd_relative", &a), ("alpha_abs", &absolute)] {
            let expected = expected.at(name);
            for link in expected.keys() {
                expected.at(&link).check(list[link.parse::<usize>().expect("a link") - 1], tolerance);
            }
        }
        let tip = absolute.iter().sum::<f64>() * length;
        expected.at("tip_acceleration_y").check_relative(tip, case.tolerance("rel"));
        expected.at("support_force_y").check_relative(support_force(&scene, &a), case.tolerance("rel"));
    }
}

/// What the ground carries, upwards, with the chain let go.
fn support_force(scene: &Scene, a: &[f64]) -> f64 {
    let (mut system, model) = (System::new(&scene.model), &scene.model);
    let (mut residual, mut reactions) = (vec![0.0; a.len()], Vec::new());
    let mut at = system.at(0.0, &model.start_position, &model.start_velocity);
    at.residual(a, &mut residual).expect("finite numbers").reactions(&mut reactions);
    reactions[model.body("link[0]").expect("the first link")].force.y
}

/// Hanging straight is found from the horizontal, and swings at the roots of Laguerre's polynomials.
#[test]
fn c03_hanging_chain_modes() {
    let case = case("C03_hanging_chain_modes");
    let reference = case.at("reference");
    for key in reference.keys().iter().filter(|key| key.starts_with("point masses")) {
        let count: usize = key.split(['=', ' ']).find_map(|part| part.parse().ok()).expect("a count");
        let length = case.parameter("L") / count as f64;
        let chain = Chain { center: 1.0, inertia: 0.0, ..Chain::uniform_rods(count, length, 1.0) };
        let scene = Scene::read(&(head([0.0, -case.parameter("g"), 0.0], "dopri5", 1e-8) + &chain.text()));
        check_frequencies(&reference.at(key), &frequencies(&scene.rest()), case.tolerance("rel"));
    }
}

fn check_frequencies(expected: &Node, found: &[f64], tolerance: f64) {
    assert_eq!(expected.items().len(), found.len());
    for (expected, found) in expected.items().iter().zip(found) {
        expected.check_relative(*found, tolerance);
    }
}

#[test]
fn c01b_heavy_tip_chain_modes() {
    let case = case("C01b_heavy_tip_chain_modes");
    let (count, length) = (case.parameter("n") as usize, case.parameter("l"));
    let chain = Chain::uniform_rods(count, length, case.parameter("m_rod"));
    let text = head([0.0, -case.parameter("g"), 0.0], "dopri5", 1e-8)
        + &chain.text()
        + &format!(
            "[[body]]\nname = \"bob\"\nmass = {:?}\nhinge = {{ type = \"fixed\", parent = \"link[{}]\", at = \"tip\" }}\n",
            case.parameter("m_tip"),
            count - 1
        );
    let found = Scene::read(&text).rest();
    let expected = case.at("reference").at("omega");
    check_frequencies(&expected, &frequencies(&found), case.tolerance("rel"));
}

/// Uniform rods, each straight up or down: angles from the rod above.
fn straight(case: &Node, up: &[bool], push: f64, want: &str) -> Scene {
    let chain = Chain::uniform_rods(up.len(), case.parameter("l"), case.parameter("m"));
    let absolute = |i: usize| if up[i] { PI } else { 0.0 };
    let positions = (0..up.len()).map(|i| absolute(i) - if i > 0 { absolute(i - 1) } else { -push }).collect();
    let text = head([0.0, -case.parameter("g"), 0.0], "dopri5", 1e-8)
        + &format!("[statics]\nwant = \"{want}\"\n")
        + &Chain { positions, ..chain }.text();
    Scene::read(&text)
}

#[test]
fn b10_chain_straight_equilibria() {
    let case = case("B10_chain_straight_equilibria");
    let (reference, tolerance) = (case.at("reference"), case.tolerance("rel"));
    for n in [2, 5] {
        let hanging = reference.at(&format!("hanging n={n} omega"));
        let upright = straight(&case, &vec![true; n], 0.0, "any").rest();
        let stability = upright.stability.as_ref().expect("an equilibrium");
        assert_eq!(stability.unstable_directions, n);
        let key = format!("upright n={n} growth rates (all unstable)");
        check_frequencies(&reference.at(&key), &growth_rates(&upright), tolerance);
        // From the exact top, next to it and from the horizontal the stable one is found.
        for push in [0.0, 1e-8, 0.5 * PI] {
            let found = straight(&case, &vec![true; n], push, "stable").rest();
            check_frequencies(&hanging, &frequencies(&found), tolerance);
        }
    }
    for (name, up) in [("(down,up)", [false, true]), ("(up,down)", [true, false])] {
        let found = straight(&case, &up, 0.0, "any").rest();
        assert_eq!(found.stability.as_ref().map(|s| s.unstable_directions), Some(1));
        let expected = reference.at(&format!("n=2 {name} lambda^2 = -omega^2"));
        let squares = [-frequencies(&found)[0].powi(2), growth_rates(&found)[0].powi(2)];
        for expected in expected.items() {
            let same_sign = if expected.number() < 0.0 { squares[0] } else { squares[1] };
            expected.check_relative(same_sign, tolerance);
        }
    }
}

#[test]
fn b05_elastica_links() {
    let case = case("B05_elastica_links");
    let (reference, tolerance) = (case.at("reference"), case.tolerance("rel"));
    let (total, bending) = (case.parameter("L"), case.parameter("EI"));
    for key in reference.keys().iter().filter(|key| key.starts_with("discrete")) {
        let number = |name: &str| -> f64 {
            key.split(' ').find_map(|part| part.strip_prefix(name)).expect("a number").parse().expect("a number")
        };
        let (count, load) = (number("n="), number("PL2/EI=") * bending / (total * total));
        let stiffness = count * bending / total;
        let n = count as usize;
        // Massless links would leave nothing to compare hinge forces with: a mass without gravity does no harm.
        let mut chain = Chain { along: [1.0, 0.0, 0.0], ..Chain::uniform_rods(n, total / count, 1.0 / count) };
        chain.stiffness = vec![stiffness; n];
        chain.stiffness[0] = 2.0 * stiffness;
        let text = head([0.0; 3], "dopri5", 1e-8)
            + &chain.text()
            + &format!("[[force]]\ntype = \"load\"\non = \"link[{}].tip\"\nforce = {:?}\n", n - 1, [0.0, load, 0.0]);
        let scene = Scene::read(&text);
        let found = scene.rest();
        let tip = &found.poses[scene.model.body(&format!("link[{}]", n - 1)).expect("the last link")];
        let end = tip * nalgebra::Point3::new(total / count, 0.0, 0.0);
        let expected = reference.at(key);
        expected.at("first_link_angle").check_relative(found.position[0], tolerance);
        expected.at("tip_link_angle").check_relative(found.position.iter().sum(), tolerance);
        expected.at("tip_deflection").check_relative(end.y, tolerance);
        expected.at("axial_shortening").check_relative(total - end.x, tolerance);
    }
}
