//! A load that turns with the body it acts on: no potential, stability by the eigenvalues of the motion.

use super::case::{Node, case};
use super::scene::{Scene, head};
use faer::{Mat, linalg::solvers::Solve};
use stillpoint::dynamics::System;
use stillpoint::statics::StabilityVerdict;

/// Ziegler's double pendulum with a push `load` along its upper link and dampers in both hinges.
fn ziegler(case: &Node, load: f64, damping: f64) -> Scene {
    let (length, stiffness) = (case.parameter("l"), case.parameter("k"));
    let link = |name: &str, parent: &str, at: f64, mass: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ncenter = {:?}\nhinge = {{ type = \"revolute\", \
             parent = \"{parent}\", at = {:?}, axis = [0, 0, 1], stiffness = {stiffness:?}, damping = {damping:?} }}\n",
            [0.0, length, 0.0],
            [0.0, at, 0.0],
        )
    };
    let text = head([0.0; 3], "dopri5", 1e-8)
        + &link("lower", "ground", 0.0, case.parameter("m1"))
        + &link("upper", "lower", length, case.parameter("m2"))
        + &format!(
            "[[force]]\ntype = \"load\"\non = {{ body = \"upper\", at = {:?} }}\nforce = {:?}\naxes = \"body\"\n",
            [0.0, length, 0.0],
            [0.0, -load, 0.0]
        );
    Scene::read(&text)
}

/// Eigenvalues of `M ẍ + C ẋ + K x = 0` about the straight position: real and imaginary part.
fn eigenvalues(scene: &Scene) -> Vec<[f64; 2]> {
    let rest = vec![0.0; scene.model.velocity_count()];
    let linear = System::new(&scene.model).at(0.0, &rest, &rest).linearize(&rest).expect("finite numbers");
    let n = rest.len();
    let lu = linear.mass.partial_piv_lu();
    let (k, c) = (lu.solve(&linear.stiffness), lu.solve(&linear.damping));
    let first_order = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => f64::from(u8::from(i + n == j)),
        (false, true) => -k[(i - n, j)],
        (false, false) => -c[(i - n, j - n)],
    });
    first_order.eigenvalues().expect("eigenvalues").iter().map(|z| [z.re, z.im]).collect()
}

/// Largest growth rate.
fn growth(scene: &Scene) -> f64 {
    eigenvalues(scene).iter().fold(f64::MIN, |m, z| m.max(z[0]))
}

/// The load at which `grows` turns true, by halving.
fn critical(grows: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (1.0, 2.5);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if grows(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

#[test]
fn a13_ziegler_eigenvalues() {
    let case = case("A13_ziegler_follower");
    let (reference, tolerance) = (case.at("reference"), case.tolerance("rel"));
    for key in reference.keys().iter().filter(|key| key.starts_with("eigenvalues")) {
        let number = |name: &str| -> f64 {
            key.split(' ').find_map(|part| part.strip_prefix(name)).expect("a number").parse().expect("a number")
        };
        let found = eigenvalues(&ziegler(&case, number("P="), number("c=")));
        for expected in reference.at(key).items() {
            let [re, im] = expected.array::<2>();
            let distance = |z: &&[f64; 2]| (z[0] - re).hypot(z[1] - im);
            let nearest = found.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("eigenvalues");
            expected.check_against(distance(&nearest), 0.0, tolerance * re.hypot(im));
        }
    }
}

#[test]
fn a13_ziegler_critical_loads() {
    let case = case("A13_ziegler_follower");
    let (reference, tolerance) = (case.at("reference"), case.tolerance("rel"));
    // Without damping the verdict of statics: growth sets in with the square root of the load's excess.
    let verdict = |load: f64| ziegler(&case, load, 0.0).rest_or_not().expect("an equilibrium").verdict;
    let found = critical(|load| verdict(load) == StabilityVerdict::Unstable);
    reference.at("P_flutter_undamped").check_relative(found, tolerance);
    for (name, damping) in [("P_flutter c=0.001", 1e-3), ("P_flutter c=0.1", 0.1)] {
        let found = critical(|load| growth(&ziegler(&case, load, damping)) > 0.0);
        reference.at(name).check_relative(found, tolerance);
        for (part, expected) in [(0.999, StabilityVerdict::Stable), (1.001, StabilityVerdict::Unstable)] {
            let stability = ziegler(&case, part * found, damping).rest_or_not().expect("an equilibrium");
            assert_eq!(stability.verdict, expected, "{name}");
        }
    }
    // Damping that vanishes does not give the undamped load: c²/2 above the limit, which is within the tolerance here.
    let found = critical(|load| growth(&ziegler(&case, load, 1e-5)) > 0.0);
    reference.at("P_flutter_vanishing_equal_damping").check_relative(found, tolerance);
}
