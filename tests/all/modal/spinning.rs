//! Spin and loads along a modal body, with the geometric stiffness of its file and without.

use super::Strip;
use super::reduction::{frequencies, scene};
use stillpoint::fem::ModalDamping;
use stillpoint::model::Model;
use stillpoint::model::description::{BodyDescription, Description, ForceDescription, HingeDescription};
use stillpoint::statics;

/// The lowest frequency out of the plane of spin, at Ω = 12 in units of the beam: 13.1702 is tabulated (Wright and others, 1982), and
/// 13.17685112 is what a dense Craig–Bampton reduction of these elements has (SciPy, `eigh`). Without geometric stiffness it is that
/// of the beam at rest.
#[test]
fn spin_stiffens_a_body_whose_file_says_so() {
    for (stiffens, expected) in [(true, 13.176_851_12), (false, 3.516_034_42)] {
        let model = Strip::unit(20).model(&[0, 20], stiffens);
        let modal = model.reduce(8, ModalDamping::None).expect("sound");
        let scene = scene(HingeDescription::revolute([0.0, 0.0, 1.0]), modal);
        let n = scene.velocity_count();
        let mut v = vec![0.0; n];
        v[0] = 12.0;
        let of: Vec<usize> = (1..n).collect();
        let all = frequencies(&scene, &vec![0.0; n], &v, &of);
        // In the plane ω² is less by Ω²: the flap frequency is where that of the other plane, ω² + Ω², is found as well.
        let out = all.iter().find(|one| (*one / expected - 1.0).abs() < 0.02);
        let out = out.unwrap_or_else(|| panic!("none near {expected}: {all:?}"));
        // The digits of the dense solution.
        assert!((out / expected - 1.0).abs() < 2e-9, "{out} against {expected}");
    }
}

/// A column buckles where Euler says; without geometric stiffness it bears anything.
#[test]
fn a_column_buckles_under_a_dead_load() {
    let euler = std::f64::consts::PI.powi(2) / 4.0;
    for (stiffens, part, is_stable) in [(true, 0.999, true), (true, 1.001, false), (false, 3.0, true)] {
        let model = Strip::unit(16).model(&[0, 16], stiffens);
        let modal = model.reduce(6, ModalDamping::None).expect("sound");
        let load = ForceDescription::load("push", ("arm", "p1"), [-part * euler, 0.0, 0.0]);
        let description = Description::new("Column").gravity([0.0; 3]);
        let description =
            description.body(BodyDescription::new("arm", HingeDescription::fixed())).modal("arm", modal).force(load);
        let model = Model::build(&description).expect("sound");
        let n = model.velocity_count();
        let lowest = frequencies(&model, &model.start_position, &vec![0.0; n], &(0..n).collect::<Vec<_>>())[0];
        assert_eq!(lowest > 0.0, is_stable, "{part} of Euler's load: {lowest}");
    }
}

/// A column under its own weight falls at Greenhill's load; a modal body with weight along it has it from its file.
#[test]
fn a_column_falls_under_its_weight() {
    let greenhill = 7.837_347_439;
    for (part, is_stable) in [(0.998, true), (1.002, false)] {
        let model = Strip::unit(16).model(&[0, 16], true);
        let modal = model.reduce(6, ModalDamping::None).expect("sound");
        let description = Description::new("Column").gravity([-part * greenhill, 0.0, 0.0]);
        let description = description.body(BodyDescription::new("arm", HingeDescription::fixed())).modal("arm", modal);
        let model = Model::build(&description).expect("sound");
        let n = model.velocity_count();
        let lowest = frequencies(&model, &model.start_position, &vec![0.0; n], &(0..n).collect::<Vec<_>>())[0];
        assert_eq!(lowest > 0.0, is_stable, "{part} of Greenhill's weight: {lowest}");
    }
}

/// A cantilever with a load across its tip: P L³ / 3 E I, and the certificate of a stable equilibrium.
#[test]
fn a_loaded_cantilever_is_certified() {
    let model = Strip::unit(8).model(&[0, 8], false);
    let modal = model.reduce(4, ModalDamping::None).expect("sound");
    let load = ForceDescription::load("pull", ("arm", "p1"), [0.0, 0.0, -0.03]);
    let description = Description::new("Cantilever").gravity([0.0; 3]);
    let description =
        description.body(BodyDescription::new("arm", HingeDescription::fixed())).modal("arm", modal).force(load);
    let model = Model::build(&description).expect("sound");
    let found =
        statics::equilibrium(&model, &statics::Settings::default(), &model.start_position).expect("an equilibrium");
    assert!(found.converged && found.stability.as_ref().is_some_and(|s| s.unstable_directions == 0), "{found:?}");
    let sunk = found.poses[model.body("arm/p1").expect("the tip")].translation.vector.z;
    assert!((sunk + 0.01).abs() < 1e-9, "{sunk}");
}
