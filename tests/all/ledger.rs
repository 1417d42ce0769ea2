//! The energy ledger beside stiff motions.

use crate::common::build;
use std::path::Path;
use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::{Override, load_with};
use stillpoint::simulate::{self, State, run};

/// A drive that brings an undamped, axially stiff blade up to speed: its work is kinetic energy and strain, whatever the method. At
/// interpolated states the stiff strain is off by less than the tolerance, and the drive's force by 2.5·10⁻⁶ of the work.
#[test]
fn the_work_of_a_drive_beside_stiff_strains_is_as_exact_as_the_run() {
    for method in ["radau5", "sdirk4"] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/beams/spin_up.toml");
        let method = format!("simulate.integrator={method}");
        let changes = [&method, "simulate.duration=5", "blade.damping=0"];
        let changes: Vec<Override> = changes.iter().map(|text| Override::parse(text).expect("a change")).collect();
        let scenario = load_with(&file, &changes).unwrap_or_else(|error| panic!("{error}"));
        let model = build(&scenario.description);
        let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let scene = simulate::scene(&model);
        let mut memory = Memory::new(&Opening { scene: &scene, scenario: &scenario.text, statics: None });
        let summary = run(&model, &scenario.simulate, 2.0, &start, &mut memory, &mut |_, _| true)
            .unwrap_or_else(|error| panic!("{error}"));
        // A tenth of the tolerance of the file: the ends of steps are that much better than their estimate.
        assert!(
            summary.energy_drift < 1e-7 * summary.work,
            "{method}: {:e} J of {} J",
            summary.energy_drift,
            summary.work
        );
    }
}
