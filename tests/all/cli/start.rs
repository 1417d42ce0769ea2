//! `--save` and `--start`: the equilibrium goes into a file, and other commands begin there.

use super::{Bench, shipped};

#[test]
fn a_run_from_the_saved_start_is_the_run_from_the_equilibrium() {
    let bench = Bench::new();
    let mount = shipped("machine_on_mounts");
    bench.call(&["statics", &mount, "--quiet", "--save", "start.toml"]).code(0);
    let short = ["--json", "--set", "simulate.duration=0.5"];
    let direct = bench.call(&[&["run", &mount, "--out", "a.mcap"], &short[..]].concat()).code(0).json();
    let from = ["run", &mount, "--out", "b.mcap", "--start", "start.toml"];
    let saved = bench.call(&[&from[..], &short[..]].concat()).code(0).json();
    assert_eq!((&saved["start"], &saved["start_file"]), (&"given".into(), &"start.toml".into()));
    assert_eq!(direct["final"], saved["final"], "bit for bit");
    let inspected = bench.call(&["inspect", &mount, "--json", "--start", "start.toml"]).code(0).json();
    let found = bench.call(&["statics", &mount, "--json", "--start", "start.toml"]).code(0).json();
    assert_eq!((&found["stage"], &found["iterations"]), (&"start".into(), &0.into()));
    assert_eq!(inspected["positions"], found["positions"]);
    bench.call(&["rest", &mount, "--quiet", "--start", "start.toml", "--set", "simulate.duration=0.5"]).code(0);
}

#[test]
fn a_start_that_belongs_to_another_scene_is_a_wrong_call() {
    let bench = Bench::new();
    bench.call(&["statics", &shipped("pendulum"), "--quiet", "--save", "start.toml"]).code(0);
    let answer = bench.call(&["run", &shipped("double_pendulum"), "--start", "start.toml"]).code(2);
    assert!(answer.err.contains("start.toml:") && answer.err.contains("is missing"), "{}", answer.err);
    let answer = bench.call(&["run", &shipped("pendulum"), "--start", "star.toml"]).code(2);
    assert!(answer.err.contains("did you mean `start.toml`"), "{}", answer.err);
    bench.write("moving.toml", "[positions]\nrod = [3.0]\n[velocities]\nrod = [1.0]\n");
    let answer = bench.call(&["rest", &shipped("pendulum"), "--start", "moving.toml"]).code(2);
    assert!(answer.err.contains("not at rest"), "{}", answer.err);
}

/// Inputs of the file take the place of the scenario's, and that is said.
#[test]
fn inputs_of_the_start_are_applied_and_said() {
    let bench = Bench::new();
    bench.write("start.toml", "[positions]\nrod = [1.5707963267948966]\n[inputs]\n\"rod.force\" = 2.5\n");
    let answer = bench.call(&["inspect", &shipped("pendulum"), "--json", "--start", "start.toml"]).code(0);
    assert!(answer.err.contains("`rod.force` is 2.5 (the scenario says 0)"), "{}", answer.err);
    let free = bench.call(&["inspect", &shipped("pendulum"), "--json", "--set", "rod.position=1.5707963267948966"]);
    let a = |value: &serde_json::Value| value["accelerations"]["rod"][0].as_f64().expect("a number");
    assert!((a(&answer.json()) - a(&free.json())).abs() > 1.0, "a motor of 2.5 N m is felt");
}

/// A steady motion is saved with its velocities and with what its loops and drives push, and comes back bit for bit.
#[test]
fn a_start_of_loops_is_checked_against_the_scene() {
    let bench = Bench::new();
    let governor = shipped("flyball_governor");
    bench.call(&["statics", &governor, "--quiet", "--save", "start.toml"]).code(0);
    let written = std::fs::read_to_string(bench.folder.path().join("start.toml")).expect("a start");
    assert!(written.contains("\"shaft\" = [12.0]") && written.contains("\"loop left link\" = ["), "{written}");
    let again = bench.call(&["statics", &governor, "--json", "--start", "start.toml"]).code(0);
    assert_eq!(again.json()["stage"].as_str(), Some("start"));
    assert!(!again.err.contains("start.toml"), "{}", again.err);
    let heavier =
        ["run", &governor, "--start", "start.toml", "--set", "sleeve.mass=3", "--set", "simulate.duration=0.1"];
    let answer = bench.call(&heavier).code(0);
    assert!(answer.err.contains("the start does not hold itself: "), "{}", answer.err);
    assert!(answer.err.contains("the scene is not the one that it was written for"), "{}", answer.err);
    bench.write("other.toml", written.replace("loop left link", "loop left lnk"));
    let answer = bench.call(&["run", &governor, "--start", "other.toml"]).code(2);
    assert!(
        answer.err.contains("the scene has no loop left lnk") && answer.err.contains("did you mean"),
        "{}",
        answer.err
    );
    bench.write("short.toml", written.replace("\"drive engine\" = [", "\"drive engine\" = [1.0, "));
    let answer = bench.call(&["run", &governor, "--start", "short.toml"]).code(2);
    assert!(answer.err.contains("drive `engine` has 1 row, not 2"), "{}", answer.err);
}

#[test]
fn a_start_that_does_not_hold_itself_is_said() {
    let bench = Bench::new();
    bench.write("start.toml", "[positions]\nrod = [1.0]\n");
    let answer = bench.call(&["run", &shipped("pendulum"), "--start", "start.toml", "--set", "simulate.duration=0.1"]);
    assert!(answer.code(0).err.contains("the start does not hold itself"), "a swinging start is said to swing");
}

/// What is asked for and cannot be written is not left out in silence.
#[test]
fn files_that_are_not_written_are_told() {
    let bench = Bench::new();
    bench.write(
        "rock.toml",
        "[[body]]\nname = \"rock\"\nmass = 2\nhinge = { type = \"prismatic\", axis = [0, 0, 1] }\n",
    );
    let answer =
        bench.call(&["statics", "rock.toml", "--quiet", "--save", "start.toml", "--modes", "modes.mcap"]).code(1);
    let told = ["`start.toml` is not written", "no modes to record in `modes.mcap`: there is no equilibrium"];
    assert!(told.iter().all(|words| answer.err.contains(words)), "{}", answer.err);
    assert!(["start.toml", "modes.mcap"].iter().all(|name| !bench.path().join(name).exists()));
    let held = ["--set", "rock.lock=true", "--modes", "modes.mcap"];
    let answer = bench.call(&[&["statics", "rock.toml", "--quiet"], &held[..]].concat()).code(0);
    assert!(answer.err.contains("nothing is free to move"), "{}", answer.err);
}
