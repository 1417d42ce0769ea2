//! The program as people and scripts call it: what it prints where, what it leaves behind, how it ends.

mod answers;
#[cfg(feature = "friction")]
mod arches;
mod beside_contact;
#[cfg(all(feature = "parquet", target_os = "linux"))]
mod clusters;
#[cfg(feature = "friction")]
mod contact_outputs;
mod curve_ends;
mod damage;
#[cfg(feature = "parquet")]
mod datasets;
#[cfg(feature = "friction")]
mod discs;
mod drawings;
#[cfg(feature = "friction")]
mod edges;
mod guided_contact;
#[cfg(feature = "friction")]
mod held_by_friction;
mod interrupt;
mod keys;
mod models;
mod output;
mod outputs;
mod over_edges;
mod path;
mod pictures;
mod poses;
mod precision;
mod python;
mod recordings;
mod rubbing_captured;
mod seen;
mod shell;
#[cfg(feature = "friction")]
mod standing;
mod start;
#[cfg(feature = "parquet")]
mod studies;
mod sweep;
mod told;
mod truths;
mod walkers;
mod wobbling;
mod words;

use crate::scenarios::file;
use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// A body that nothing holds.
const BRICK: &str = "[[body]]\nname = \"brick\"\nmass = 2.0\ninertia = [0.1, 0.1, 0.1]\nhinge = { type = \"free\" }\n";

/// A weight on a spring: more than the spring can carry has no equilibrium.
const SCALE: &str = "
[[body]]
name = \"pan\"
mass = 1.0
hinge = { type = \"prismatic\", axis = [0.0, 0.0, 1.0], stiffness = 100.0 }
";

/// A folder of its own for one test, and the program called in it.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder") }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path().join(name), bytes).expect("a file");
    }

    /// Names in the folder, in order.
    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path()).expect("the folder");
        let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("an entry").file_name();
        let mut names: Vec<String> = entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stillpoint"));
        command.current_dir(self.path()).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").args(arguments);
        command
    }

    fn call(&self, arguments: &[&str]) -> Answer {
        Answer::of(&mut self.command(arguments))
    }
}

/// What the shell sees.
#[derive(Debug)]
struct Answer {
    code: i32,
    out: String,
    err: String,
}

impl Answer {
    fn of(command: &mut Command) -> Self {
        let output = command.output().expect("the program starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
        let answer =
            Self { code: output.status.code().unwrap_or(-1), out: text(output.stdout), err: text(output.stderr) };
        assert!(!answer.err.contains("panicked"), "{}", answer.err);
        assert!(!answer.out.contains('\u{1b}') && !answer.err.contains('\u{1b}'), "colours without a terminal");
        answer
    }

    #[track_caller]
    fn code(self, code: i32) -> Self {
        assert_eq!(self.code, code, "{self:#?}");
        self
    }

    /// Standard output as exactly one line with one JSON object.
    #[track_caller]
    fn json(&self) -> Value {
        assert_eq!(self.out.lines().count(), 1, "{self:#?}");
        let value: Value = serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("{error}: {self:#?}"));
        assert!(value.is_object());
        value
    }
}

fn shipped(name: &str) -> String {
    file(name).display().to_string()
}
