//! The energy ledger beside stiff motions, and beside drives that turn far within a step.

use crate::common::{Random, build};
use std::path::Path;
use stillpoint::integrate::Method;
use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::{Override, Scenario, load_with, parse};
use stillpoint::simulate::{self, State, Summary, run};

fn ran(scenario: &Scenario, rate: f64) -> Summary {
    let model = build(&scenario.description);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: &scenario.text, statics: None });
    run(&model, &scenario.simulate, rate, &start, &mut memory, &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{error}"))
}

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
        let summary = ran(&scenario, 2.0);
        // A tenth of the tolerance of the file: the ends of steps are that much better than their estimate.
        assert!(
            summary.energy_drift < 1e-7 * summary.work,
            "{method}: {:e} J of {} J",
            summary.energy_drift,
            summary.work
        );
    }
}

/// Eccentric rotors at a steady rate, one on the shaft of a gear: no position is ever wrong, so that steps take hundreds of turns, and all that
/// the drives put in is what the weights are lifted by, `Σ m g c (1 − cos ωt)`.
#[test]
fn the_work_of_drives_is_accounted_for_however_far_they_turn_in_a_step() {
    let mut random = Random::new(61);
    for case in 0..27 {
        let method = Method::ALL[case % Method::ALL.len()];
        let (rate, ratio) = (10.0_f64.powf(random.between(0.0, 3.0)), random.between(0.3, 1.0));
        let [masses, arms] = [0.2, 0.1].map(|least| random.list(2, least, 5.0 * least));
        let mut text = format!(
            "[simulate]\nstart = \"given\"\nduration = 2.0\ntolerance = 1e-9\nintegrator = \"{}\"\n\
             [[drive]]\nname = \"d\"\nhinge = \"r0\"\ntype = \"rate\"\nrate = {rate}\n\
             [[gear]]\ntype = \"ratio\"\nbetween = [\"r1\", \"r0\"]\nratio = {ratio}\n",
            method.name()
        );
        for (rotor, (mass, arm)) in masses.iter().zip(&arms).enumerate() {
            text += &format!(
                "[[body]]\nname = \"r{rotor}\"\nmass = {mass}\ncenter = [0, 0, -{arm}]\ninertia = [0.1, 0.1, 0.1]\n\
                 hinge = {{ type = \"revolute\", axis = [0, 1, 0], at = [{rotor}, 0, 0], velocity = {} }}\n",
                [rate, ratio * rate][rotor]
            );
        }
        // Beside what moves by itself, whose errors are those of the tolerance.
        let is_alone = case % 2 == 0;
        if !is_alone {
            text += "[[body]]\nname = \"p\"\nmass = 1.0\ncenter = [0, 0, -1]\n\
                     hinge = { type = \"revolute\", axis = [0, 1, 0], at = [3, 0, 0], position = 0.5 }\n";
        }
        let scenario = parse("scene.toml", &text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
        let found = ran(&scenario, [1.0, 100.0][case % 2]);
        let lifted = |rotor: usize| {
            let turn = 2.0 * rate * [1.0, ratio][rotor];
            masses[rotor] * 9.80665 * arms[rotor] * (1.0 - turn.cos())
        };
        let through = found.energy_largest;
        let (expected, bound) = (lifted(0) + lifted(1), if is_alone { 1e-9 } else { 1e-6 });
        let (work, drift) = (found.work, found.energy_drift);
        assert!(
            drift < bound * through,
            "{case}, {method:?} at {rate} rad/s: {drift:e} of {through} J unaccounted for"
        );
        assert!((work - expected).abs() < bound * through, "{case}, {method:?}: {work} J put in, not {expected}");
    }
}
