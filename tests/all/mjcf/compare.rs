//! Accelerations beside MuJoCo's own, through its Python package.

use std::process::Command;

/// Models of ours, and the most by which accelerations may differ, relative to the largest of the state.
///
/// Both agree to round-off: below 2e-14 measured. 1e-12 leaves room for the conditioning of chains, and with constraints for
/// that of `J M⁻¹ Jᵀ`, of which redundant rows are a part.
const MODELS: [(&str, f64); 7] = [
    ("tests/models/mjcf/joints.xml", 1e-12),
    ("tests/models/mjcf/geoms.xml", 1e-12),
    ("tests/models/mjcf/defaults.xml", 1e-12),
    ("tests/models/mjcf/springs.xml", 1e-12),
    ("tests/models/mjcf/actuators.xml", 1e-12),
    ("tests/models/mjcf/loops.xml", 1e-12),
    ("scenarios/robots/gripper.xml", 1e-12),
];

#[test]
#[ignore = "needs Python with mujoco-core (tests/python/requirements.txt)"]
fn accelerations_are_those_of_mujoco() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut command = Command::new("python3");
    command.arg(root.join("tests/python/compare_mjcf.py")).arg(env!("CARGO_BIN_EXE_stillpoint"));
    // MuJoCo leaves a log where it runs.
    let folder = tempfile::tempdir().expect("a folder");
    let output = command
        .args(MODELS.iter().map(|(model, _)| root.join(model)))
        .current_dir(folder.path())
        .output()
        .expect("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    for (model, allowed) in MODELS {
        let result = &read[root.join(model).to_str().expect("text")];
        let number = |key: &str| result[key].as_f64().unwrap_or_else(|| panic!("{model}: {result}"));
        assert!(number("states") >= 5.0 && number("velocities") >= 3.0, "{model}: {result}");
        assert!(number("difference") <= allowed, "{model}: {} > {allowed}", number("difference"));
        // Sums of a few masses.
        assert!(number("mass") < 1e-14, "{model}: {result}");
        // MuJoCo finds our closed positions closed: the tolerance of the assembly.
        assert!(number("gap") < 1e-10, "{model}: {result}");
    }
}
