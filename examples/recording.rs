//! A run recorded into a file, and its numbers read back: `cargo run --example recording`

#![allow(clippy::print_stdout, clippy::unwrap_used)]

use stillpoint::record::{Opening, Outcome, Recorder, Recording, RecordingFile, Table};
use stillpoint::{model::Model, scenario, simulate};

const SCENARIO: &str = r#"
[simulate]
duration = 1.0

[[body]]
name = "bob"
mass = 1.0
center = [0.0, 0.0, -1.0]
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], position = 0.5 }
"#;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = scenario::parse("bob.toml", SCENARIO, &[])?;
    let model = Model::build(&scenario.description).map_err(|problems| format!("{problems:?}"))?;
    let path = std::env::temp_dir().join(format!("bob-{}.mcap", std::process::id()));

    let picture = simulate::scene(&model);
    let opening = Opening { scene: &picture, scenario: &scenario.text, statics: None };
    let mut file = RecordingFile::create(&path)?.begin(&opening)?;
    let start = simulate::State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let end = simulate::run(&model, &scenario.simulate, 10.0, &start, &mut file, &mut |_, _| true)?;
    file.finish(&Outcome { summary: format!(r#"{{"end_time":{}}}"#, end.end_time) })?;

    let recording = Recording::open(&path)?;
    let tables = Table::all(&recording.scene);
    let hinges = &tables[0];
    let mut row = Vec::new();
    for sample in recording.samples()? {
        let sample = sample?;
        hinges.fill(&sample, &mut row);
        println!("{:.1} s: {} = {:.6} {}", sample.time, hinges.columns[0].name, row[0], hinges.columns[0].unit);
    }
    std::fs::remove_file(&path)?;
    Ok(())
}
