//! Robots of the world beside Pinocchio: Python with the packages `pin`, `example-robot-data` and `mpmath`.

use std::process::Command;

#[test]
#[ignore = "needs Python with pin, example-robot-data and mpmath (tests/python/requirements.txt)"]
fn accelerations_of_imported_robots_are_pinocchios() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/compare_urdf.py");
    let output = Command::new("python3").arg(script).arg(env!("CARGO_BIN_EXE_stillpoint")).output().expect("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let robots = found.as_object().expect("robots");
    assert_eq!(robots.len(), 12, "six robots, fixed and free");
    for (robot, result) in robots {
        let [difference, condition] = ["difference", "condition"].map(|key| result[key].as_f64().expect("a number"));
        assert!(difference < 1e-9, "{robot}: {difference:e}");
        assert!(condition < 1e6 || robot.starts_with("icub"), "{robot}: {condition:e}");
    }
    // Its head is a point mass, which resists no turn about the line from its neck, and is thrown about with 6e9 rad/s². At
    // one of the states Pinocchio's own rounding is 9e-10: there both are compared with accelerations of fifty digits.
    let [ours, theirs] = ["difference", "theirs"].map(|key| robots["icub fixed"][key].as_f64().expect("a number"));
    assert!(ours < 0.1 * theirs, "{ours:e} from the exact accelerations, Pinocchio {theirs:e}");
    assert!(robots["panda fixed"]["mimics"] == 1, "a mimic is compared too");
}
