//! Files that cannot be right: exit code 2, the place, the reason, no panic, nothing left behind.

use super::Bench;

const ROD: &str = "[[body]]
name = \"rod\"
mass = 1.0
inertia = [0.1, 0.1, 0.1]
center = [0.0, 0.0, -0.5]
hinge = { type = \"revolute\", axis = [0.0, 1.0, 0.0] }
";

#[test]
fn every_wrong_scene_is_answered_with_line_column_and_reason() {
    let hangs_on = |parent: &str| format!("hinge = {{ parent = \"{parent}\",");
    let other = ROD.replace("\"rod\"", "\"other\"");
    let cases = [
        (ROD.replace("mass", "mas"), "3:1", "unknown key `mas`"),
        (ROD.replace("mass = 1.0", "mass = nan"), "3:8", "`rod`: `mass` is nan"),
        (ROD.replace("-0.5", "-inf"), "5:21", "not a finite number"),
        (ROD.replace("mass = 1.0", "mass = -1.0"), "3:8", "-1.0, allowed: ≥ 0 kg"),
        (ROD.replace("mass = 1.0", "mass = \"heavy\""), "3:8", "mass"),
        (
            ROD.lines()
                .filter(|l| !l.starts_with("mass") && !l.starts_with("inertia") && !l.starts_with("center"))
                .map(|l| format!("{l}\n"))
                .collect(),
            "1:1",
            "neither `rod` nor anything it carries has mass",
        ),
        (ROD.replace("0.1, 0.1, 0.1", "0.1, 0.1, 0.3"), "4:11", "no body can have the inertia of `rod`"),
        (format!("{ROD}[[force]]\ntype = \"load\"\non = \"rod.tip\"\n"), "9:6", "`rod` has no marker `tip`"),
        (ROD.replace("hinge = {", &hangs_on("rot")), "6:20", "rot"),
        (
            ROD.replace("hinge = {", &hangs_on("other")) + &other.replace("hinge = {", &hangs_on("rod")),
            "6:20",
            "the parents form a cycle: `rod` hangs on `other` hangs on `rod`",
        ),
        (ROD.repeat(2), "8:8", "two bodies are called `rod`"),
        (ROD.replace("revolute", "revolt"), "6:18", "revolt"),
        (ROD.replace(" = 1.0", " 1.0"), "3:", "3 | mass 1.0"),
    ];
    let bench = Bench::new();
    for (text, place, reason) in cases {
        bench.write("scene.toml", &text);
        for command in ["run", "check"] {
            let answer = bench.call(&[command, "scene.toml"]).code(2);
            assert!(answer.out.is_empty(), "{answer:#?}");
            assert!(answer.err.contains(&format!("scene.toml:{place}")), "{place}: {}", answer.err);
            assert!(answer.err.contains(reason), "{reason}: {}", answer.err);
        }
        assert_eq!(bench.names(), ["scene.toml"]);
    }
}

#[test]
fn all_problems_of_a_file_are_said_at_once() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        ROD.replace("mass = 1.0", "mass = -1.0").replace("type", "tipe").replace("center", "centre"),
    );
    let answer = bench.call(&["run", "scene.toml"]).code(2);
    for place in ["scene.toml:3:8", "scene.toml:5:1", "scene.toml:6:11"] {
        assert!(answer.err.contains(place), "{place}: {}", answer.err);
    }
}

#[test]
fn files_that_are_no_scenes_are_answered_shortly() {
    let bench = Bench::new();
    let binary: Vec<u8> = (0..4096_u32).map(|i| (i * 193 % 251) as u8).collect();
    let cases: [(Vec<u8>, &str); 3] = [
        (Vec::new(), "the scene has no bodies"),
        (binary, "is not UTF-8 text"),
        (ROD.repeat((50 << 20) / ROD.len()).into_bytes(), "larger than 32 MiB"),
    ];
    for (bytes, reason) in cases {
        bench.write("scene.toml", bytes);
        let answer = bench.call(&["run", "scene.toml"]).code(2);
        assert!(answer.out.is_empty() && answer.err.contains(reason), "{answer:#?}");
        assert!(answer.err.contains("scene.toml") && answer.err.len() < 1000, "{answer:#?}");
        assert_eq!(bench.names(), ["scene.toml"]);
    }
}

/// A picture that cannot be drawn stops nothing, and `check` tells of it.
#[test]
fn a_damaged_mesh_that_only_draws_is_told_by_check() {
    let bench = Bench::new();
    bench.write("bad.stl", "garbage");
    bench.write("rod.toml", ROD.replace("center", "shape = { mesh = \"bad.stl\" }\ncenter"));
    let answer = bench.call(&["check", "rod.toml"]).code(0);
    assert!(
        answer.err.contains("rod.toml: body `rod`: the mesh `") && answer.err.contains("is damaged"),
        "{}",
        answer.err
    );
    assert!(bench.call(&["check", "rod.toml", "--quiet"]).code(0).err.is_empty());
    bench.call(&["inspect", "rod.toml"]).code(0);
}
