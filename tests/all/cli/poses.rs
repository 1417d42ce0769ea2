//! Mode shapes and the way of a search as recordings.

use super::{Bench, shipped};
use stillpoint::record::{OwnedSample, Recording};

fn samples(bench: &Bench, name: &str) -> Vec<OwnedSample> {
    let recording = Recording::open(&bench.path().join(name)).expect("a recording");
    assert!(recording.complete);
    recording.samples().expect("samples").map(|sample| sample.expect("a sample")).collect()
}

/// Two seconds of every mode, about the equilibrium, along its shape.
#[test]
fn mode_shapes_are_recorded_one_after_the_other() {
    let bench = Bench::new();
    let pendulum = shipped("double_pendulum");
    let stable = ["--set", "statics.want=stable"];
    let call = [&["statics", &pendulum, "--json", "--modes", "modes.mcap"], &stable[..]].concat();
    let found = bench.call(&call).code(0).json();
    let modes = found["frequencies_hz"].as_array().expect("frequencies").len();
    let samples = samples(&bench, "modes.mcap");
    assert_eq!((modes, samples.len()), (2, 200));
    let rest = &samples[0].positions;
    for (mode, frames) in samples.chunks(100).enumerate() {
        assert!((frames[0].time - 2.0 * mode as f64).abs() < 1e-12);
        let away = |sample: &OwnedSample| [0, 1].map(|i| sample.positions[i] - rest[i]);
        let farthest = frames.iter().flat_map(away).fold(0.0_f64, |m, x| m.max(x.abs()));
        // A quarter of a radian; fifty frames a second meet the peak of the swing to a part in a hundred.
        assert!((farthest - 0.25).abs() < 2.5e-3, "{farthest}");
        let peak = away(&frames[8]);
        // Both angles move together, in the first mode to the same side and in the second against each other.
        let together = peak[0] * peak[1];
        assert!(if mode == 0 { together > 0.0 } else { together < 0.0 }, "{peak:?}");
        for frame in frames {
            let [a, b] = away(frame);
            assert!((a * peak[1] - b * peak[0]).abs() < 1e-12, "along one line");
        }
    }
}

/// The recording begins at the guess and ends at the answer.
#[test]
fn the_way_of_a_search_is_recorded() {
    let bench = Bench::new();
    let chain = shipped("hanging_chain");
    for method in ["auto", "newton", "relaxation"] {
        let call =
            ["statics", &chain, "--json", "--set", "link.repeat=6", "--method", method, "--iterates", "way.mcap"];
        let answer = bench.call(&call);
        let found = answer.json();
        let samples = samples(&bench, "way.mcap");
        assert_eq!(found["iterates"].as_u64(), Some(samples.len() as u64));
        assert!(samples.len() > 1, "{method}");
        assert!(samples[0].positions.iter().all(|angle| *angle == 0.0), "guessed horizontal");
        let last = &samples[samples.len() - 1];
        let answer = found["positions"]["link[0]"][0].as_f64().expect("a number");
        assert!((last.positions[0] - answer).abs() < 1e-15, "{method}");
    }
}
