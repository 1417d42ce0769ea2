//! Beams as they are written in files, and beside what they cannot be combined with.

use crate::common::build;
use std::f64::consts::PI;
use stillpoint::record::Fanout;
use stillpoint::scenario::{self, Scenario};
use stillpoint::simulate::{Start, State, run};

fn read(text: &str) -> Scenario {
    scenario::parse("beam.toml", text, &[]).unwrap_or_else(|found| panic!("{found}"))
}

/// A rod that widens from 10 to 30 mm over a millimetre: its mass is that of two cylinders and a frustum, however many elements.
#[test]
fn elements_end_where_the_section_changes() {
    let cone = 0.001 * (0.01_f64.powi(2) + 0.01 * 0.03 + 0.03_f64.powi(2)) / 3.0;
    let expected = 2700.0 * PI * (0.4 * 0.01_f64.powi(2) + cone + 0.599 * 0.03_f64.powi(2));
    for elements in [1, 8, 13] {
        let text = format!(
            "[[beam]]\nname = \"b\"\nhinge = {{ type = \"fixed\" }}\nlength = 1.0\nelements = {elements}\n\
             section = [{{ s = 0.0, circle = 0.01 }}, {{ s = 0.4, circle = 0.01 }}, {{ s = 0.401, circle = 0.03 }}, \
             {{ s = 1.0, circle = 0.03 }}]\nmaterial = {{ young = 70e9, density = 2700.0 }}\n"
        );
        let mass = build(&read(&text).description).total_mass();
        // Lobatto's rule is exact for squares of linear laws.
        assert!((mass / expected - 1.0).abs() < 1e-12, "{elements} elements: {mass} kg and not {expected}");
    }
}

/// What Kelvin–Voigt damping takes out is in the account of the energy.
#[test]
fn damping_is_accounted_for() {
    let text = "[simulate]\nstart = \"given\"\nduration = 0.3\ntolerance = 1e-8\n[[beam]]\nname = \"b\"\nhinge = { type = \"fixed\" }\n\
                section = { stiffness = [1e4, 1e4, 1e4, 1.0, 1.0, 1.0] }\nmass_per_length = 1.0\nlength = 1.0\nelements = 3\n\
                free = [\"bend\"]\ndamping = 0.02\n";
    let scenario = read(text);
    let model = build(&scenario.description);
    let start = State { position: model.start_position.clone(), velocity: vec![0.0; model.velocity_count()] };
    assert_eq!(scenario.simulate.start, Start::Given);
    let summary = run(&model, &scenario.simulate, 10.0, &start, &mut Fanout::new(), &mut |_, _| true).expect("a run");
    assert!(summary.dissipated > 1e-3, "{} J dissipated", summary.dissipated);
    assert!(summary.energy_drift < 1e-4 * summary.dissipated, "{:e} J unaccounted for", summary.energy_drift);
}
