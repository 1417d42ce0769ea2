//! Outputs: never onto an input, never in the place of a link, and nothing of an earlier run is lost.

use super::{Answer, Bench};
use stillpoint::record::Recording;

/// A rod that hangs.
const ROD: &str = "[[body]]\nname = \"brick\"\nmass = 2.0\ninertia = [0.1, 0.1, 0.1]\ncenter = [0.0, 0.0, -1.0]\n\
                   hinge = { type = \"revolute\", axis = [0.0, 1.0, 0.0] }\n";

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("s.toml", ROD);
    bench.call(&["run", "s.toml", "--quiet", "--set", "simulate.duration=0.1", "--out", "s.mcap"]).code(0);
    bench
}

fn read(bench: &Bench, name: &str) -> Vec<u8> {
    std::fs::read(bench.path().join(name)).expect("a file")
}

#[cfg(unix)]
#[test]
fn no_command_replaces_what_it_reads_by_whatever_name() {
    let bench = bench();
    let (scenario, recording) = (read(&bench, "s.toml"), read(&bench, "s.mcap"));
    let link = |from: &str, to: &str| std::os::unix::fs::symlink(from, bench.path().join(to)).expect("a link");
    link("s.toml", "link.toml");
    link("s.mcap", "link.svg");
    link("s.mcap", "link.csv");
    link("s.mcap", "link.rrd");
    std::fs::hard_link(bench.path().join("s.mcap"), bench.path().join("hard.csv")).expect("a link");
    std::fs::hard_link(bench.path().join("s.mcap"), bench.path().join("hard.glb")).expect("a link");
    std::fs::hard_link(bench.path().join("s.toml"), bench.path().join("hard.toml")).expect("a link");
    for arguments in [
        &["plot", "s.mcap", "kinetic", "-o", "s.mcap"][..],
        &["plot", "s.mcap", "kinetic", "-o", "link.svg"],
        &["export", "s.mcap", "--csv", "link.csv"],
        &["export", "s.mcap", "--csv", "hard.csv"],
        &["view", "s.mcap", "--save", "link.rrd"],
        &["view", "s.mcap", "--save", "./hard.glb"],
        &["run", "s.toml", "--out", "s.toml"],
        &["run", "s.toml", "--out", "link.toml"],
        &["run", "link.toml", "--out", "hard.toml"],
        &["rest", "s.toml", "--out", "s.toml"],
        &["statics", "s.toml", "--save", "s.toml"],
        &["statics", "s.toml", "--out", "link.toml"],
        &["statics", "s.toml", "--modes", "hard.toml"],
        &["statics", "s.toml", "--iterates", "s.toml"],
        &["run", "s.toml", "--rrd", "s.toml"],
    ] {
        let answer = bench.call(arguments).code(2);
        assert!(answer.err.contains("which this command reads"), "{arguments:?}: {answer:#?}");
        assert_eq!((&read(&bench, "s.toml"), &read(&bench, "s.mcap")), (&scenario, &recording), "{arguments:?}");
    }
    // Nor what is no recording at all.
    bench.write("notes.txt", "mine");
    let answer = bench.call(&["run", "s.toml", "--out", "notes.txt"]).code(2);
    assert!(answer.err.contains("no recording"), "{answer:#?}");
    assert_eq!(read(&bench, "notes.txt"), b"mine");
}

#[cfg(target_os = "linux")]
#[test]
fn a_link_is_followed_and_stays_and_open_files_are_refused() {
    let bench = bench();
    std::fs::create_dir(bench.path().join("disk")).expect("a folder");
    for (name, target) in [("x.mcap", "disk/x.mcap"), ("x.csv", "disk/x.csv"), ("x.svg", "disk/x.svg")] {
        std::os::unix::fs::symlink(target, bench.path().join(name)).expect("a link");
    }
    for _ in 0..2 {
        bench.call(&["run", "s.toml", "--quiet", "--set", "simulate.duration=0.1", "--out", "x.mcap"]).code(0);
        bench.call(&["export", "s.mcap", "--quiet", "--csv", "x.csv"]).code(0);
        bench.call(&["plot", "s.mcap", "kinetic", "--quiet", "-o", "x.svg"]).code(0);
    }
    for name in ["x.mcap", "x.csv", "x.svg"] {
        assert!(bench.path().join(name).is_symlink(), "{name} was replaced");
        assert!(bench.path().join("disk").join(name).is_file(), "{name} went elsewhere");
    }
    assert_eq!(std::fs::read_dir(bench.path().join("disk")).expect("a folder").count(), 3, "nothing else is left");
    for name in ["/dev/stdout", "/proc/self/fd/1", "/dev/fd/1"] {
        let answer = bench.call(&["run", "s.toml", "--quiet", "--out", name]).code(2);
        assert!(answer.err.contains("open already"), "{answer:#?}");
    }
    std::process::Command::new("mkfifo").arg(bench.path().join("pipe")).status().expect("mkfifo");
    for arguments in [&["run", "s.toml", "--out", "pipe"][..], &["plot", "s.mcap", "kinetic", "-o", "pipe"]] {
        assert!(bench.call(arguments).code(2).err.contains("a pipe"), "{arguments:?}");
    }
    assert!(bench.call(&["info", "pipe"]).code(2).err.contains("a pipe"));
}

#[test]
fn what_a_killed_run_left_is_kept_and_said() {
    let bench = bench();
    let whole = read(&bench, "s.mcap");
    let left = &whole[..whole.len() - 100];
    bench.write("r.mcap.partial", left);
    // A run that records nothing deletes nothing.
    bench.call(&["run", "nosuch.toml", "--out", "r.mcap"]).code(2);
    bench.write("brick.toml", super::BRICK);
    let answer = bench.call(&["run", "brick.toml", "--out", "r.mcap"]).code(1);
    std::fs::remove_file(bench.path().join("brick.toml")).expect("removed");
    assert!(answer.err.contains("stillpoint recover r.mcap.partial"), "{answer:#?}");
    for _ in 0..2 {
        bench.call(&["run", "s.toml", "--quiet", "--set", "simulate.duration=0.1", "--out", "r.mcap"]).code(0);
        assert_eq!(read(&bench, "r.mcap.partial"), left);
    }
    assert_eq!(bench.names(), ["r.mcap", "r.mcap.partial", "s.mcap", "s.toml"]);
}

#[cfg(unix)]
#[test]
fn an_unfinished_file_that_is_a_link_is_not_followed() {
    let bench = bench();
    bench.write("victim", "mine");
    std::os::unix::fs::symlink("victim", bench.path().join("r.mcap.partial")).expect("a link");
    bench.call(&["run", "s.toml", "--quiet", "--set", "simulate.duration=0.1", "--out", "r.mcap"]).code(0);
    assert_eq!(read(&bench, "victim"), b"mine");
    assert!(bench.path().join("r.mcap.partial").is_symlink());
}

#[test]
fn runs_of_one_output_at_once_leave_one_whole_recording() {
    let bench = bench();
    for _ in 0..5 {
        let start = |rate: &str| {
            let more = ["--set", "simulate.duration=1", "--set", rate, "--out", "race.mcap", "--quiet"];
            let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_stillpoint"));
            command.args(["run", "s.toml"]).args(more).current_dir(bench.path());
            command.stderr(std::process::Stdio::piped()).spawn().expect("started")
        };
        let runs: Vec<_> = (1..=6).map(|k| start(&format!("record.rate={}", 100 * k))).collect();
        let ends: Vec<_> = runs.into_iter().map(|run| run.wait_with_output().expect("ended")).collect();
        let fine = ends.iter().filter(|end| end.status.success()).count();
        assert!(fine > 0, "{ends:?}");
        for end in ends.iter().filter(|end| !end.status.success()) {
            let said = String::from_utf8_lossy(&end.stderr);
            assert!(end.status.code() == Some(2) && said.contains("being written by another run"), "{said}");
        }
        let recording = Recording::open(&bench.path().join("race.mcap")).expect("a recording");
        assert!(recording.complete);
        let samples = recording.samples().expect("opened").inspect(|sample| assert!(sample.is_ok())).count();
        assert!((1..=6).any(|k| samples == 100 * k + 1), "{samples} samples");
        assert_eq!(bench.names(), ["race.mcap", "s.mcap", "s.toml"]);
    }
}

#[test]
fn what_a_terminal_would_obey_is_not_printed() {
    let bench = Bench::new();
    let named = ROD.replace("brick", "\\u001b]0;x\\u0007\\u009bk\\u202e");
    assert_ne!(named, ROD);
    bench.write("s.toml", format!("title = \"\\u001b[2J\"\n{named}"));
    for arguments in [&["check", "s.toml"][..], &["inspect", "s.toml"], &["run", "s.toml"], &["info", "s.mcap"]] {
        let Answer { out, err, .. } = bench.call(arguments);
        for text in [out, err] {
            let obeyed = |c: char| c.is_control() && c != '\n' && c != '\t' || c == '\u{202e}';
            assert!(!text.contains(obeyed), "{arguments:?}: {text:?}");
        }
    }
}
