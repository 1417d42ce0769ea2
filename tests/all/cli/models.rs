//! Files of other programs in the place of a scenario.

use super::{Answer, Bench};

/// An arm whose finger has no mass.
const ARM: &str = r#"<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint>
  <link name="arm">
    <inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
      <inertia ixx="0.2" iyy="0.2" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="grip" type="continuous"><parent link="arm"/><child link="finger"/><axis xyz="0 1 0"/></joint>
  <link name="finger"/>
</robot>
"#;

/// What the message proposes is what works.
#[test]
fn a_robot_is_a_scenario_of_its_own() {
    let bench = Bench::new();
    bench.write("arm.urdf", ARM);
    let refused = bench.call(&["statics", "arm.urdf"]).code(2).err;
    let (_, proposed) = refused.split_once("as with `--set ").expect("a way out");
    let (change, _) = proposed.split_once('`').expect("its end");
    bench.call(&["check", "arm.urdf", "--set", change]).code(0);
    // Its two hinges swing freely, the second one without weight.
    let answer = bench.call(&["statics", "arm.urdf", "--set", change, "--set", "arm.stiffness=3", "--json"]).code(0);
    let modes = answer.json()["frequencies_hz"].clone();
    let expected = ((3.0 + 2.0 * 9.80665 * 0.5) / (0.2 + 2.0 * 0.25_f64)).sqrt() / std::f64::consts::TAU;
    let found: Vec<f64> = modes.as_array().expect("modes").iter().filter_map(serde_json::Value::as_f64).collect();
    // The armature alone is what the finger's hinge moves; it carries nothing.
    assert!(found.iter().any(|hz| (hz - expected).abs() < 1e-9 * expected), "{found:?}, not {expected}");
    bench.call(&["run", "arm.urdf", "--set", change, "--set", "simulate.duration=0.1", "--quiet"]).code(0);
    assert_eq!(bench.names(), ["arm.mcap", "arm.urdf"]);
}

/// Whoever converts again after going on from the file finds what was there; what stands there already is no other file.
#[test]
fn converting_again_keeps_what_was_there() {
    let bench = Bench::new();
    let (arm, _) = ARM.split_once("  <joint name=\"grip\"").expect("a finger");
    bench.write("arm.urdf", format!("{arm}</robot>\n"));
    let convert = |out: &str| bench.call(&["convert", "arm.urdf", "-o", out]).code(0);
    let text = || std::fs::read_to_string(bench.path().join("my.toml")).expect("a file");
    convert("my.toml");
    let written = text();
    assert!(!convert("my.toml").err.contains('~'), "the same again");
    assert_eq!(bench.names(), ["arm.urdf", "my.toml"]);
    bench.write("my.toml", "# mine\n");
    let answer = convert("my.toml");
    assert!(answer.err.contains("`my.toml` was there already, and is kept as `my.toml~`"), "{answer:#?}");
    assert_eq!(std::fs::read_to_string(bench.path().join("my.toml~")).expect("a file"), "# mine\n");
    assert_eq!(text(), written);
    // An empty file, as one that was made for a name, is nothing to keep.
    bench.write("empty.toml", "");
    convert("empty.toml");
    assert_eq!(convert("-").out, written, "standard output");
    assert_eq!(bench.names(), ["arm.urdf", "empty.toml", "my.toml", "my.toml~"]);
    if cfg!(unix) {
        bench.write("my.toml", "# mine again\n");
        std::fs::remove_file(bench.path().join("my.toml~")).expect("removed");
        std::fs::create_dir(bench.path().join("my.toml~")).expect("a folder");
        let refused = bench.call(&["convert", "arm.urdf", "-o", "my.toml"]).code(2);
        assert!(refused.err.contains("cannot be kept as `my.toml~`: it is left as it is"), "{refused:#?}");
        assert_eq!(text(), "# mine again\n");
    }
}

/// Meshes of a model are found from its folder, and standard input has none.
#[test]
fn a_model_from_standard_input_is_told_in_one_message() {
    let bench = Bench::new();
    let answer = Answer::of(bench.command(&["check", "-"]).write_stdin(ARM)).code(2);
    assert!(answer.err.contains("this is XML, and a scenario is TOML"), "{answer:#?}");
    assert!(answer.err.ends_with("standard input: 1 error\n"), "{answer:#?}");
}

#[test]
fn a_recording_is_no_scenario() {
    let bench = Bench::new();
    bench.write("run.mcap", b"\x89MCAP0\r\n");
    assert!(bench.call(&["statics", "run.mcap"]).code(2).err.contains("it is a recording"));
}
