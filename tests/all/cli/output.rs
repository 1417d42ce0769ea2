//! What goes where: standard output, standard error, files, devices.

use super::{Answer, Bench, shipped};
use stillpoint::record::Recording;

#[test]
fn quiet_says_nothing_when_all_is_well() {
    let bench = Bench::new();
    let pencil = shipped("pencil");
    for (command, code) in [("run", 0), ("statics", 0), ("check", 0), ("rest", 1)] {
        let answer = bench.call(&[command, &pencil, "--quiet"]).code(code);
        assert!(answer.out.is_empty() && answer.err.is_empty(), "{command}: {answer:#?}");
    }
    assert!(!bench.call(&["run", "nothing.toml", "--quiet"]).code(2).err.is_empty(), "errors are said all the same");
}

/// What a sum of energies is known to is no energy; JSON has it all the same.
#[test]
fn energies_below_their_round_off_are_zero() {
    let bench = Bench::new();
    let rod = |torque: &str| {
        format!(
            "simulate = {{ duration = 0.5, integrator = \"dopri5\", start = \"given\" }}\n[[body]]\nname = \"rod\"\nmass = 2.0\n\
             center = [0, 0, -1]\ninertia = [1, 1, 0.1]\nhinge = {{ type = \"revolute\", axis = [0, 1, 0], velocity = {torque} }}\n"
        )
    };
    bench.write("still.toml", rod("1e-3"));
    let still = bench.call(&["run", "still.toml"]).code(0).out;
    // Of 2 kg · g · 1 m.
    assert!(still.contains("unaccounted for 0 J at most (0: below the round-off of 2.0e-11 J)"), "{still}");
    let drift = bench.call(&["run", "still.toml", "--json"]).code(0).json()["energy_drift"].clone();
    assert!(drift.as_f64().is_some_and(|drift| drift > 0.0 && drift < 2e-11), "{drift}");
}

#[test]
fn the_recording_goes_where_it_is_sent() {
    let bench = Bench::new();
    let answer = bench.call(&["run", &shipped("pendulum"), "--out", "a.mcap"]).code(0);
    assert!(answer.out.contains("stillpoint view a.mcap"), "{answer:#?}");
    assert_eq!(bench.names(), ["a.mcap"]);
    let recording = Recording::open(&bench.path().join("a.mcap")).expect("a recording");
    assert!(recording.complete && recording.scenario.contains("Rod pendulum"));
    assert_eq!(recording.samples().expect("samples").count(), 1001);
}

#[test]
fn values_are_changed_from_the_command_line() {
    let bench = Bench::new();
    let changes = ["--set", "rod.position=0", "--set", "simulate.duration=1", "--set", "record.rate=10"];
    let run = bench.call(&[&["run", &shipped("pendulum"), "--json"], &changes[..]].concat()).code(0).json();
    assert_eq!((&run["end_time"], &run["samples"]), (&1.0.into(), &11.into()));
    assert_eq!(run["final"]["positions"]["rod"][0], 0.0);
}

#[test]
fn loops_drives_gears_and_events_are_changed_too_and_checked_like_the_file() {
    let bench = Bench::new();
    let governor = shipped("flyball_governor");
    let said = |change: &str| bench.call(&["inspect", &governor, "--set", change]).code(2).err;
    // The caret stands under the argument.
    let wrong = said("engine.rate=fast");
    assert!(wrong.contains("command line:1:19") && wrong.contains("--set engine.rate=fast"), "{wrong}");
    assert!(said("engine.rat=1").contains("did you mean `rate`?"));
    assert!(said("engin.rate=1").contains("did you mean `engine`?"));
    bench.call(&["inspect", &governor, "--set", "engine.rate=3"]).code(0);
    let nameless = "[[force]]\ntype = \"load\"\non = \"brick\"\nforce = [0, 0, 1]\n";
    bench.write("load.toml", format!("{}{nameless}", super::BRICK));
    bench.call(&["inspect", "load.toml", "--set", "force[0].force=[0,0,2]"]).code(0);
    assert!(bench.call(&["inspect", "load.toml", "--set", "force[0].stiffness=1"]).code(2).err.contains("stiffness"));
}

#[test]
fn a_scenario_may_come_from_standard_input() {
    let bench = Bench::new();
    let text = std::fs::read_to_string(shipped("pencil")).expect("a scenario");
    let answer = Answer::of(bench.command(&["run", "-", "--json"]).write_stdin(text)).code(0);
    assert_eq!(answer.json()["recording"], "recording.mcap");
    assert_eq!(bench.names(), ["recording.mcap"]);
    let wrong = Answer::of(bench.command(&["statics", "-"]).write_stdin("[[body]]\nname = 3\n")).code(2);
    assert!(wrong.err.contains(":2:8"), "{wrong:#?}");
}

#[test]
fn an_unwritable_place_is_said_before_anything_is_computed_and_nothing_is_left() {
    let bench = Bench::new();
    bench.write("file", "not a folder");
    for out in ["file/run.mcap", "nowhere/run.mcap", "."] {
        for command in ["run", "rest"] {
            let answer = bench.call(&[command, &shipped("pendulum"), "--out", out]).code(2);
            assert!(answer.out.is_empty() && answer.err.contains("cannot create the recording"), "{answer:#?}");
            assert_eq!(answer.err.matches("os error").count().max(1), 1, "the cause is said once: {answer:#?}");
        }
    }
    let answer = bench.call(&["statics", &shipped("pendulum"), "--out", "file/found.json"]).code(2);
    assert!(answer.err.contains("cannot write `file/found.json`"), "{answer:#?}");
    assert_eq!(bench.names(), ["file"]);
}

/// Through links, so that a program that replaces its target replaces the link and not the device.
#[cfg(target_os = "linux")]
#[test]
fn devices_are_written_as_they_stand() {
    let bench = Bench::new();
    for device in ["full", "null"] {
        std::os::unix::fs::symlink(format!("/dev/{device}"), bench.path().join(device)).expect("a link");
    }
    let full = bench.call(&["run", &shipped("pendulum"), "--quiet", "--out", "full"]).code(2);
    assert!(full.err.contains("No space left on device"), "{full:#?}");
    bench.call(&["run", &shipped("pendulum"), "--quiet", "--out", "null"]).code(0);
    assert_eq!(bench.names(), ["full", "null"]);
    for device in ["full", "null"] {
        assert!(bench.path().join(device).is_symlink(), "{device} was replaced");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_is_full_is_an_error() {
    let bench = Bench::new();
    for (arguments, left) in [
        (&["statics", "--json"][..], vec![]),
        (&["inspect", "--json"], vec![]),
        // A report that nobody can read costs no run.
        (&["run"], vec!["pencil.mcap".to_owned()]),
        (&["run", "--json"], vec!["pencil.mcap".to_owned()]),
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("the device");
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_stillpoint"))
            .args(arguments)
            .arg(shipped("pencil"))
            .current_dir(bench.path())
            .stdout(full)
            .output()
            .expect("the program starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("cannot write to standard output"), "{said}");
        assert_eq!(bench.names(), left);
    }
}
