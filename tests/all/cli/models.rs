//! Files of other programs in the place of a scenario.

use super::{Answer, Bench};
use crate::common::Random;

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

/// A model is never replaced by what is made of it, under whatever name it is asked for.
#[test]
fn a_model_is_not_converted_onto_itself() {
    let bench = Bench::new();
    let (arm, _) = ARM.split_once("  <joint name=\"grip\"").expect("a finger");
    let arm = format!("{arm}</robot>\n");
    bench.write("arm.urdf", &arm);
    bench.write("part.xml", "<mujocoinclude><body name=\"b\"><geom size=\"1\"/></body></mujocoinclude>");
    bench.write("whole.xml", "<mujoco><worldbody><include file=\"part.xml\"/></worldbody></mujoco>");
    let before = bench.names();
    for (model, out) in [("arm.urdf", "arm.urdf"), ("arm.urdf", "./arm.urdf"), ("whole.xml", "part.xml")] {
        let error = bench.call(&["convert", model, "-o", out]).code(2).err;
        assert!(error.contains("is not written: it would replace"), "{error}");
    }
    assert_eq!(bench.names(), before);
    assert_eq!(std::fs::read_to_string(bench.path().join("arm.urdf")).expect("a file"), arm);
}

/// `effort` is the limit of a motor that a scenario adds, unless it has one.
#[test]
fn efforts_bound_motors() {
    let bench = Bench::new();
    let (arm, _) = ARM.split_once("  <joint name=\"grip\"").expect("a finger");
    let limit = "<axis xyz=\"0 1 0\"/><limit effort=\"3.5\" velocity=\"1\"/></joint>\n  <link name=\"arm\">";
    let arm = arm.replace("<axis xyz=\"0 1 0\"/></joint>\n  <link name=\"arm\">", limit);
    bench.write("arm.urdf", format!("{arm}</robot>\n"));
    let pushes = |model: &str, hinge: &str, more: &str| {
        let motor = "type = \"pd\"\nstiffness = 1000\ntarget = 1.0\n";
        let text = format!("model = {model}\n[[motor]]\nname = \"servo\"\nhinge = \"{hinge}\"\n{motor}{more}\n");
        bench.write("scene.toml", text);
        bench.call(&["inspect", "scene.toml", "--json"]).code(0).json()["motors"]["servo"].as_f64().expect("a torque")
    };
    assert_eq!(pushes("\"arm.urdf\"", "arm", ""), 3.5);
    assert_eq!(pushes("\"arm.urdf\"", "arm", "limit = 20"), 20.0);
    assert_eq!(pushes("{ file = \"arm.urdf\", prefix = \"left/\" }", "left/arm", ""), 3.5);
}

/// Links of random lightness: those that make accelerations without meaning are named, others are not.
#[test]
fn light_links_that_carry_heavy_ones_are_named() {
    let bench = Bench::new();
    let mut random = Random::new(9);
    for case in 0..14 {
        let light = 10.0_f64.powf(random.between(-13.0, -10.0));
        let (before, after) = (random.below(3), 1 + random.below(2));
        let mut text = String::new();
        let count = before + 1 + after;
        for link in 0..count {
            let (mass, inertia, tip) = if link == before { (0.0, light, 0.0) } else { (1.0, 0.1, 0.4) };
            let parent = if link == 0 { String::new() } else { format!(", parent = \"l{}\", at = \"tip\"", link - 1) };
            let unphysical = if link == before { "unphysical = true\n" } else { "" };
            text += &format!(
                "[[body]]\nname = \"l{link}\"\nmass = {mass}\n{unphysical}center = [{}, 0, 0]\n\
                 inertia = [{inertia:e}, {inertia:e}, {inertia:e}]\nmarkers = {{ tip = [{tip}, 0, 0] }}\n\
                 hinge = {{ type = \"revolute\", axis = [0, 1, 0], damping = 0.1, velocity = {}{parent} }}\n",
                0.5 * tip,
                random.between(0.5, 2.0)
            );
        }
        bench.write("chain.toml", &text);
        for command in [&["check", "chain.toml"][..], &["inspect", "chain.toml"]] {
            let said = bench.call(command).code(0).err;
            assert!(said.contains(&format!("`l{before}`")) && said.contains("means nothing"), "{case}: {said}");
        }
        let found = bench.call(&["inspect", "chain.toml", "--json"]).code(0).json()["ill_conditioned"].clone();
        assert!(found[0]["ratio"].as_f64().expect("a ratio") < 1e-6, "{found}");
        let heavy = text.replace(&format!("{light:e}"), "1e-3");
        bench.write("heavy.toml", heavy);
        assert_eq!(bench.call(&["check", "heavy.toml"]).code(0).err, "");
    }
}
