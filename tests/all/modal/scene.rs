//! Files of other programs, and the shipped scene.

use super::reduction::{frequencies, scene};
use std::path::{Path, PathBuf};
use stillpoint::fem::{ModalDamping, npz};
use stillpoint::model::Model;
use stillpoint::model::description::HingeDescription;
use stillpoint::record::Fanout;
use stillpoint::scenario;
use stillpoint::simulate::{State, run};
use stillpoint::statics;

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Matrices that CalculiX 2.20 stored of a bar of four bricks of 20 nodes, turned into a file by `python/tools/fem_calculix.py`:
/// with its root held the modes are those that CalculiX itself finds when the nodes of the root are supported.
#[test]
fn a_bar_of_calculix_has_its_frequencies() {
    let bytes = std::fs::read(repository("tests/all/modal/calculix_bar.npz")).expect("the file");
    let model = npz::read(&bytes).expect("a sound file");
    let modal = model.reduce(6, ModalDamping::None).expect("a sound body");
    assert!((modal.mass / (2700.0 * 0.8 * 0.05 * 0.03) - 1.0).abs() < 1e-9, "{} kg", modal.mass);
    let scene = scene(HingeDescription::fixed(), modal);
    let all: Vec<usize> = (0..6).collect();
    let found = frequencies(&scene, &[0.0; 6], &[0.0; 6], &all);
    for (found, expected) in found.iter().zip([254.0185, 418.1931, 1678.438, 2675.756, 5238.543, 5455.184]) {
        // Seven digits are printed.
        assert!((found / expected - 1.0).abs() < 2e-7, "{found} rad/s, CalculiX has {expected}");
    }
}

/// The boom sinks as the theory of beams has it; slewing, its energy is accounted for and it ends a quarter turn further, sunk by as
/// much and swinging about that.
#[test]
fn a_boom_sinks_slews_and_swings() {
    let scenario =
        scenario::load(&repository("scenarios/modal/slewing_boom.toml")).unwrap_or_else(|found| panic!("{found}"));
    let model = Model::build(&scenario.description).expect("a sound scene");
    let (model, _) = stillpoint::constraint::assemble(model).expect("a sound scene");
    let found = statics::equilibrium(&model, &scenario.statics, &model.start_position).expect("an equilibrium");
    assert!(found.converged, "{found:?}");
    let tip = model.body("boom/tip").expect("the tip");
    let bending = 70e9 * 0.06 * 0.02_f64.powi(3) / 12.0;
    let (g, weight) = (9.80665, 2700.0 * 0.06 * 0.02 * 9.80665);
    let shear = (0.5 * g * 2.0 + 2.0 * weight) / (5.0 / 6.0 * 0.06 * 0.02 * 70e9 / 2.66);
    let expected = 0.5 * g * 8.0 / (3.0 * bending) + weight * 16.0 / (8.0 * bending) + shear;
    let sunk = -found.poses[tip].translation.vector.z;
    // Four modes with the tip held carry the weight along the boom: none is missing at the tip.
    assert!((sunk / expected - 1.0).abs() < 1e-6, "{sunk} m and not {expected}");
    let start = State { position: found.position.clone(), velocity: vec![0.0; model.velocity_count()] };
    let settings = stillpoint::simulate::Settings { duration: 1.5, ..scenario.simulate };
    let summary = run(&model, &settings, 10.0, &start, &mut Fanout::new(), &mut |_, _| true).expect("a run");
    assert!(summary.energy_drift < 1e-5 * summary.work.abs(), "{:e} of {}", summary.energy_drift, summary.work);
    let pose = summary.poses[tip];
    let (at, angle) = (pose.translation.vector, pose.rotation.euler_angles().2);
    assert!((angle - std::f64::consts::FRAC_PI_2).abs() < 0.1 && at.x.abs() < 0.1, "{pose}");
    assert!((at.z + expected).abs() < 0.2 * expected, "{at}");
}
