//! Random models of one feature each, as MuJoCo compiles them.

use std::path::Path;
use std::process::Command;

/// Per feature.
const CASES: usize = 6;

#[test]
fn features_are_those_of_mujoco() {
    let python = || Command::new("python3");
    let there = python().args(["-c", "import mujoco, numpy"]).output();
    if !there.is_ok_and(|output| output.status.success()) {
        assert!(std::env::var_os("CI").is_none(), "python3 with mujoco-core must be there");
        eprintln!("skipped: python3 with the package mujoco-core is not there");
        return;
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/mjcf_features.py");
    // MuJoCo leaves a log where it runs.
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = python();
    command.arg(script).arg(env!("CARGO_BIN_EXE_stillpoint")).args(["--cases", &CASES.to_string()]);
    let output = command.current_dir(folder.path()).output().expect("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let features = read.as_object().expect("features");
    assert!(features.len() > 15, "{features:?}");
    for (feature, found) in features {
        assert_eq!(found["wrong"].as_array().map(Vec::len), Some(0), "{feature}: {found:#}");
        let number = |key: &str| found[key].as_f64().unwrap_or_else(|| panic!("{feature}: {found}"));
        assert!(number("cases") > 2.0 * number("mujoco_refused"), "{feature}: MuJoCo refuses most: {found}");
    }
}
