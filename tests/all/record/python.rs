//! The recording as others read it: Python, with the `mcap` and `mcap-protobuf-support` packages, and JavaScript, with
//! those that Foxglove and Lichtblick are made of.

use super::fixture::{Motion, record};
use std::process::Command;

#[test]
#[ignore = "needs Python with mcap and mcap-protobuf-support (tests/python/requirements.txt)"]
fn python_reads_the_same_numbers() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/read_recording.py");
    is_read_back(Command::new("python3").arg(script));
}

#[test]
#[ignore = "needs Node with the packages of tests/javascript"]
fn javascript_reads_the_same_numbers() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/javascript/read_recording.js");
    let read = is_read_back(Command::new("node").arg(script));
    // The scene once, and six channels with every sample.
    assert_eq!(read["messages"], 1 + 6 * 101);
}

/// Gives a recording to a program that prints what it finds, and compares that with what was recorded.
fn is_read_back(program: &mut Command) -> serde_json::Value {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swing.mcap");
    let motion = Motion::double_link();
    record(&path, &motion, 1.0);
    let output = program.arg(&path).output().expect("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");

    assert_eq!(read["scenario"], super::SCENARIO);
    assert_eq!(read["statics"], super::STATICS);
    assert_eq!(read["run"], super::OUTCOME);
    assert_eq!(read["units"]["positions.rod_0_quaternion_w"], "rod[0].quaternion w [1]");
    assert_eq!(read["entities"], serde_json::json!(["upper", "lower", "box", "rod[0]"]));
    let samples = read["samples"].as_array().expect("samples");
    assert_eq!(samples.len(), 101);
    for (sample, time) in samples.iter().zip(Motion::times(1.0)) {
        let expected = motion.at(time);
        let number = |name: &str| f64::from_bits(sample[name].as_str().expect(name).parse().expect(name));
        assert_eq!(sample["log_time"], (time * 1e9).round() as u64);
        assert_eq!(number("time").to_bits(), time.to_bits());
        assert_eq!(number("upper_angle").to_bits(), expected.positions[0].to_bits());
        assert_eq!(number("box_z_rate").to_bits(), expected.velocities[4].to_bits());
        assert_eq!(number("lower_acceleration").to_bits(), expected.accelerations[1].to_bits());
        assert_eq!(number("potential").to_bits(), expected.energy.potential.to_bits());
        assert_eq!(number("rod_force_z").to_bits(), expected.reactions[3].force.z.to_bits());
        assert_eq!(number("box_height").to_bits(), expected.bodies[2].translation.z.to_bits());
        assert_eq!(sample["parents"], serde_json::json!(["world"]));
    }
    read
}
