//! What loops cost, in instructions, counted by valgrind: trees nothing, chains of loops what their number says.

use super::FOUR_BAR;
use std::collections::HashMap;
use std::process::Command;
use tempfile::TempDir;

/// Sources in which loops are all there is to do.
const OF_LOOPS: [&str; 4] =
    ["src/constraint/", "src/dynamics/constrained.rs", "src/simulate/implicit/bordered.rs", "src/simulate/passage.rs"];

/// Instructions of a call of the program: all, and those of lines in [`OF_LOOPS`], inlined ones too.
fn count(folder: &TempDir, arguments: &[&str]) -> [f64; 2] {
    let out = folder.path().join("callgrind.out");
    let output = Command::new("valgrind")
        .args([
            "--tool=callgrind",
            &format!("--callgrind-out-file={}", out.display()),
            env!("CARGO_BIN_EXE_stillpoint"),
        ])
        .args(arguments)
        .current_dir(folder.path())
        .output()
        .expect("valgrind runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(&out).expect("counts");
    let mut files: HashMap<&str, bool> = HashMap::new();
    let (mut all, mut of_loops, mut inside, mut is_call) = (0.0, 0.0, false, false);
    for line in text.lines() {
        let names_file = ["fl=", "fi=", "fe=", "cfl=", "cfi="].iter().find_map(|key| line.strip_prefix(key));
        if let Some(name) = names_file {
            // "(7) path" the first time, "(7)" from then on; those of calls are not where costs stand.
            let (number, path) = name.split_once(' ').unwrap_or((name, ""));
            if !path.is_empty() {
                files.insert(number, OF_LOOPS.iter().any(|part| path.contains(part)));
            }
            if !line.starts_with('c') {
                inside = files.get(number).copied().unwrap_or(false);
            }
        } else if line.starts_with("calls=") {
            is_call = true;
        } else if line.starts_with(|c: char| c.is_ascii_digit() || "+-*".contains(c)) {
            // What a call costs is counted where it is spent.
            let cost: f64 = line.split(' ').nth(1).and_then(|cost| cost.parse().ok()).expect("a cost");
            if !std::mem::take(&mut is_call) {
                all += cost;
                of_loops += if inside { cost } else { 0.0 };
            }
        }
    }
    [all, of_loops]
}

/// What more of a thing costs more.
fn more(few: [f64; 2], many: [f64; 2]) -> [f64; 2] {
    [many[0] - few[0], many[1] - few[1]]
}

/// Of the instructions of accelerations and of steps of a tree next to none are of code for loops: the question whether
/// there are any.
#[test]
#[ignore = "needs valgrind, and line tables: not in release, but with --profile profiling"]
fn trees_do_not_pay_for_loops() {
    let folder = tempfile::tempdir().expect("a folder");
    let chain = "[[body]]\nname = \"link\"\nrepeat = 20\nmass = 1.0\ncenter = [0.01, 0.02, -0.1]\ninertia = [0.0034, 0.0033, 0.0002]\n\
                 hinge = { type = \"revolute\", at = [0, 0, -0.2], axis = [0.6, 0.8, 0.0], position = 0.3, velocity = 0.5 }\n";
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    write("tree.toml", chain);
    write("bars.toml", FOUR_BAR);
    let accelerations = |file: &str| {
        let of = |calls: &str| count(&folder, &["bench", file, "--only", "acceleration", "--calls", calls]);
        more(of("4"), of("44"))
    };
    let steps = |file: &str, method: &str| {
        let method = format!("simulate.integrator={method:?}");
        let of = |duration: &str| {
            let duration = format!("simulate.duration={duration}");
            let fixed = ["--set", "simulate.start=\"given\"", "--set", &method, "--set", "record.rate=1"];
            count(&folder, &[&["run", file, "--quiet", "--set", &duration][..], &fixed].concat())
        };
        more(of("0.05"), of("0.25"))
    };
    let tree = [accelerations("tree.toml"), steps("tree.toml", "dopri5"), steps("tree.toml", "sdirk4")];
    for ([all, of_loops], what) in tree.into_iter().zip(["accelerations", "dopri5", "sdirk4"]) {
        eprintln!("{what}: {of_loops} of {all} instructions are of loops");
        assert!(of_loops < 0.005 * all, "{what}: {of_loops} of {all}");
    }
    // The same count sees them where there are some.
    let [all, of_loops] = accelerations("bars.toml");
    assert!(of_loops > 0.1 * all, "{of_loops} of {all}");
}

/// Four-bars in a row: each costs the same, however many there are.
#[test]
#[ignore = "needs valgrind, and line tables: not in release, but with --profile profiling"]
fn a_chain_of_loops_costs_what_its_number_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let bars = |count: usize| {
        let mut text = String::from("gravity = [0, 0, -9.81]\n");
        for i in 0..=count {
            text += &format!(
                "[[body]]\nname = \"rod{i}\"\nmass = 1.0\ncenter = [0, 0, 0.5]\ninertia = [0.08, 0.08, 0.001]\nmarkers = {{ tip = [0, 0, 1] }}\n\
                 hinge = {{ type = \"revolute\", at = [{i}, 0, 0], axis = [0, 1, 0], position = 0.3, velocity = {} }}\n",
                if i == 0 { 0.5 } else { 0.0 }
            );
        }
        for i in 0..count {
            text += &format!(
                "[[body]]\nname = \"bar{i}\"\nmass = 1.0\ncenter = [0.5, 0, 0]\ninertia = [0.001, 0.08, 0.08]\nmarkers = {{ tip = [1, 0, 0] }}\n\
                 hinge = {{ type = \"revolute\", parent = \"rod{i}\", at = \"tip\", axis = [0, 1, 0], position = -0.3 }}\n\
                 [[loop]]\ntype = \"revolute\"\nbetween = [\"bar{i}.tip\", \"rod{}.tip\"]\naxis = [0, 1, 0]\n",
                i + 1
            );
        }
        let name = format!("bars{count}.toml");
        std::fs::write(folder.path().join(&name), text).expect("a file");
        name
    };
    let [few, many] = [2, 40].map(|number| {
        let file = bars(number);
        let calls = |calls: &str| count(&folder, &["bench", &file, "--only", "acceleration", "--calls", calls]);
        let [evaluation, _] = more(calls("4"), calls("24"));
        let [command, _] = count(&folder, &["check", &file]);
        [evaluation / 20.0, command]
    });
    let ratios = [many[0] / few[0], many[1] / few[1]];
    eprintln!(
        "40 four-bars cost {:.1} evaluations of 2, and {:.1} times as much to read and assemble",
        ratios[0], ratios[1]
    );
    assert!(ratios.iter().all(|ratio| *ratio < 25.0), "{ratios:?}");
}
