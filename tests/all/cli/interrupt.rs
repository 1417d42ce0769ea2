//! Runs that do not reach their end.

use super::{Bench, shipped};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use stillpoint::record::{OwnedSample, Recording};

/// A run that takes far longer than the test: the chain falls from the horizontal for a thousand seconds.
fn long_run(bench: &Bench) -> Child {
    Command::new(env!("CARGO_BIN_EXE_stillpoint"))
        .args(["run", &shipped("hanging_chain"), "--out", "run.mcap", "--json"])
        .args(["--set", "simulate.start=given", "--set", "simulate.duration=1000", "--set", "record.rate=1000"])
        .current_dir(bench.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

fn samples(recording: &Recording) -> Vec<OwnedSample> {
    recording.samples().expect("samples").map(|sample| sample.expect("a sample")).collect()
}

/// Waits until the file holds more than its description.
fn wait_for_samples(path: &Path) {
    let begun = Instant::now();
    while Recording::open(path).map_or(0, |recording| samples(&recording).len()) == 0 {
        assert!(begun.elapsed() < Duration::from_secs(30), "nothing was flushed");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_run_in_good_order() {
    let bench = Bench::new();
    let child = long_run(&bench);
    wait_for_samples(&bench.path().join("run.mcap.partial"));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(sent.success());
    let output = child.wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(130));
    let run: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(run["interrupted"], true);
    assert_eq!(bench.names(), ["run.mcap"]);
    let recording = Recording::open(&bench.path().join("run.mcap")).expect("a recording");
    assert!(recording.complete);
    let last = samples(&recording).last().expect("samples").time;
    let end = run["end_time"].as_f64().expect("a time");
    // All samples that were due are there: the next one is due after the end.
    assert!(last <= end && end < last + 2e-3, "{last} {end}");
}

#[cfg(unix)]
#[test]
fn a_killed_run_leaves_all_but_about_its_last_second() {
    let bench = Bench::new();
    let mut child = long_run(&bench);
    let partial = bench.path().join("run.mcap.partial");
    wait_for_samples(&partial);
    std::thread::sleep(Duration::from_millis(700));
    child.kill().expect("killed");
    child.wait().expect("an end");
    let flushed = std::fs::metadata(&partial).and_then(|file| file.modified()).expect("a time");
    // A chunk is flushed every half second; twice that for a busy machine.
    assert!(flushed.elapsed().expect("a time") < Duration::from_millis(1500));
    assert_eq!(bench.names(), ["run.mcap.partial"]);
    let recording = Recording::open(&partial).expect("readable");
    assert!(!recording.complete && recording.outcome.is_none());
    let kept = samples(&recording);
    assert!(kept.len() > 10);
    for (index, sample) in kept.iter().enumerate() {
        assert!((sample.time - index as f64 / 1000.0).abs() < 1e-12, "no gap: {} at {index}", sample.time);
    }
    // The next run takes the name, says what is there, and leaves it.
    let left = std::fs::read(&partial).expect("read");
    let said = bench.call(&["run", &shipped("pencil"), "--out", "run.mcap"]).code(0).err;
    assert!(said.contains("stillpoint recover run.mcap.partial"), "{said}");
    assert_eq!(bench.names(), ["run.mcap", "run.mcap.partial"]);
    assert_eq!(std::fs::read(&partial).expect("read"), left);
}

#[test]
fn a_cut_recording_is_shown_as_far_as_it_goes() {
    let bench = Bench::new();
    bench.call(&["run", &shipped("double_pendulum"), "--quiet", "--out", "whole.mcap"]).code(0);
    let bytes = std::fs::read(bench.path().join("whole.mcap")).expect("a recording");
    bench.write("cut.mcap", &bytes[..bytes.len() - bytes.len() / 10]);
    let answer = bench.call(&["view", "cut.mcap", "--save", "cut.rrd"]);
    if cfg!(feature = "view") {
        let answer = answer.code(0);
        assert!(answer.err.contains("was not finished"), "{answer:#?}");
        assert_eq!(bench.names(), ["cut.mcap", "cut.rrd", "whole.mcap"]);
    } else {
        let answer = answer.code(2);
        assert!(answer.err.contains("built without the `view` feature"), "{answer:#?}");
    }
    let kept = Recording::open(&bench.path().join("cut.mcap")).expect("readable");
    assert!(!kept.complete);
}

/// Ends a command that waits for what nobody writes; how long that took.
#[cfg(unix)]
fn ended(mut child: Child) -> Duration {
    std::thread::sleep(Duration::from_millis(150));
    assert!(child.try_wait().expect("asked").is_none(), "it was to wait");
    let before = Instant::now();
    Command::new("kill").args(["-TERM", &child.id().to_string()]).status().expect("kill");
    child.wait().expect("an end");
    before.elapsed()
}

#[cfg(unix)]
#[test]
fn what_waits_for_a_pipe_ends_when_it_is_told_to() {
    let bench = Bench::new();
    Command::new("mkfifo").arg(bench.path().join("pipe")).status().expect("mkfifo");
    std::fs::copy(shipped("pendulum"), bench.path().join("s.toml")).expect("copied");
    let waiting: [&[&str]; 9] = [
        &["run", "pipe"],
        &["run", "-"],
        &["run", "s.toml", "--start", "pipe"],
        &["rest", "pipe"],
        &["statics", "pipe"],
        &["precision", "pipe"],
        &["report", "pipe", "-o", "x.html"],
        &["sweep", "s.toml", "--vary", "rod.mass=normal(1, 0.1)", "--cases", "4", "--correlate", "pipe"],
        &["convert", "pipe"],
    ];
    for arguments in waiting {
        let child = Command::new(env!("CARGO_BIN_EXE_stillpoint"))
            .args(arguments)
            .current_dir(bench.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let took = ended(child.expect("the program starts"));
        assert!(took < Duration::from_secs(1), "{arguments:?} took {took:?} to end");
    }
    // What is written into a pipe is read; what another file names, or what is watched, is no pipe.
    let (text, pipe) = (std::fs::read(shipped("pendulum")).expect("text"), bench.path().join("pipe"));
    let writer = std::thread::spawn(move || std::fs::write(pipe, text));
    bench.call(&["statics", "pipe"]).code(0);
    writer.join().expect("a thread").expect("written");
    bench.write("m.toml", "model = \"pipe\"\n");
    for arguments in [&["check", "m.toml"][..], &["watch", "pipe", "--times", "1"]] {
        let answer = bench.call(arguments).code(2);
        assert!(answer.err.contains("a device or a pipe"), "{answer:#?}");
    }
}

/// A ball that gives back all of its speed: fifty thousand blows in 4.6 s, each of them followed.
#[test]
fn blows_without_end_are_told_while_they_come() {
    let bench = Bench::new();
    let text = "simulate = { start = \"given\", duration = 4.7, integrator = \"dop853\" }\n[[body]]\nname = \"ball\"\nmass = 1.0\n\
                hinge = { type = \"prismatic\", axis = [0, 0, 1], position = 1e-8, limits = { low = 0.0, restitution = 1.0 } }\n";
    bench.write("ball.toml", text);
    let answer = bench.call(&["run", "ball.toml"]).code(0);
    assert!(answer.err.contains("there were 50000 events, the last of `ball`"), "{}", answer.err);
    assert!(answer.err.contains("strikes for ever"), "{}", answer.err);
}
