//! What an evaluation costs, in instructions: a slow-down is seen without a clock. Counted by valgrind.

use std::process::Command;
use tempfile::TempDir;

/// Accelerations and tangent per link, as they are without and with full optimisation; fewer are an improvement, more by
/// over a fifth a slow-down that has to say what it is for. (A fifth: what another version of the compiler may change.)
const COUNTS: [f64; 2] = match (cfg!(debug_assertions), cfg!(target_feature = "fma")) {
    (true, _) => [1270.0, 1800.0],
    (false, true) => [790.0, 1390.0],
    // Without fused products; the tangent's as it was before it computed in fours, a bound.
    (false, false) => [1400.0, 4800.0],
};
const SLACK: f64 = 1.2;

/// A chain whose axes alternate, moving.
fn chain(folder: &TempDir, links: usize) -> String {
    let path = folder.path().join(format!("chain{links}.toml"));
    let text = format!(
        "[[body]]\nname = \"link\"\nrepeat = {links}\nmass = 1.0\ncenter = [0.01, 0.02, -0.1]\n\
         inertia = [0.0034, 0.0033, 0.0002, 1e-5, 2e-5, 3e-5]\n\
         hinge = {{ type = \"revolute\", at = [0, 0, -0.2], axis = [0.6, 0.8, 0.0], position = 0.3, velocity = 0.5 }}\n"
    );
    std::fs::write(&path, text).expect("a file");
    path.to_str().expect("a path").to_owned()
}

/// Instructions of one call per link: what more calls cost more.
fn per_link(folder: &TempDir, links: usize, routine: &str) -> f64 {
    let scenario = chain(folder, links);
    let count = |calls: usize| -> f64 {
        let output = Command::new("valgrind")
            .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", env!("CARGO_BIN_EXE_stillpoint"), "bench"])
            .args([&scenario, "--only", routine, "--calls", &calls.to_string()])
            .output()
            .expect("valgrind runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        let number = said.lines().find_map(|line| line.split("Collected :").nth(1)).expect("a count");
        number.trim().parse().expect("a number")
    };
    (count(24) - count(4)) / (20 * links) as f64
}

/// Accelerations and the tangent of an implicit step take a number of instructions that is proportional to the number of
/// links, and no more than it was.
#[test]
#[ignore = "needs valgrind"]
fn sweeps_are_linear_and_no_slower_than_they_were() {
    let folder = tempfile::tempdir().expect("a folder");
    let [short, long] = [40, 400].map(|links| per_link(&folder, links, "acceleration"));
    // The same work per link; what a call costs once is spread over forty links here.
    assert!((short / long - 1.0).abs() < 0.05, "{short} per link of 40, {long} per link of 400");
    let tangent = per_link(&folder, 400, "tangent-solve");
    eprintln!("{long:.0} instructions per link for the accelerations, {tangent:.0} for the tangent");
    assert!(long < SLACK * COUNTS[0], "{long} per link for the accelerations");
    assert!(tangent < SLACK * COUNTS[1], "{tangent} per link for the tangent");
    // Residual pass, factorization and solution: 1.8 accelerations, unoptimised 1.4.
    let most = 2.5;
    assert!(tangent < most * long, "the tangent takes {tangent} per link, the accelerations {long}");
}
