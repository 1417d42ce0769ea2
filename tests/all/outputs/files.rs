//! `[[output]]` in scenario files and in the answers of the program.

use crate::scenarios::file;
use assert_cmd::Command;
use serde_json::Value;
use stillpoint::scenario::parse;

const ARM: &str = r#"
[[body]]
name = "arm"
mass = 1.0
center = [0.0, 0.0, -0.5]
inertia = [0.1, 0.1, 0.01]
markers = { tip = [0.0, 0.0, -1.0] }
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], position = 0.4 }
[[force]]
name = "stay"
type = "spring"
between = ["arm.tip", { body = "ground", at = [1.0, 0.0, 0.0] }]
stiffness = 10.0
length = 1.0
[[force]]
name = "push"
type = "load"
on = "arm.tip"
force = [1.0, 0.0, 0.0]
"#;

fn wrong(output: &str) -> String {
    parse("s.toml", &format!("{ARM}[[output]]\n{output}\n"), &[]).expect_err("a problem").to_string()
}

/// Every mistake is shown at its place, with what was meant.
#[test]
fn mistakes_are_told_with_a_hint() {
    let cases = [
        (
            "name = \"x\"\ntype = \"positon\"\nof = \"arm.tip\"",
            "unknown output type `positon`",
            "did you mean `position`?",
        ),
        ("name = \"x\"\ntype = \"position\"", "`of` is missing", "of = \"arm.tip\""),
        ("name = \"x\"\ntype = \"position\"\nof = \"amr.tip\"", "there is no body `amr`", "did you mean `arm`?"),
        ("name = \"x\"\ntype = \"position\"\nof = \"arm.tap\"", "`arm` has no marker `tap`", "did you mean `tip`?"),
        (
            "name = \"x\"\ntype = \"position\"\nof = \"arm.tip\"\naxis = [0.0, 0.0, 0.0]",
            "has no direction",
            "any length",
        ),
        ("name = \"x\"\ntype = \"position\"\nof = \"arm.tip\"\nin = \"bdy\"", "in", "body"),
        ("name = \"x\"\ntype = \"force\"\nof = \"sty\"", "is called `sty`", "did you mean `stay`?"),
        ("name = \"x\"\ntype = \"force\"\nof = \"arm\"", "has no stops", "reaction"),
        (
            "name = \"x\"\ntype = \"force\"\nof = \"stay\"\ncomponent = \"fx\"",
            "has no components",
            "bushings, loads, contacts",
        ),
        ("name = \"x\"\ntype = \"length\"\nof = \"push\"", "`push` has no length", "springs"),
        ("name = \"x\"\ntype = \"coordinate\"\nof = \"amr\"", "no hinge coordinate `amr`", "did you mean `arm`?"),
        ("name = \"x\"\ntype = \"coordinate\"\nof = \"arm.angel\"", "has no coordinate `angel`", "`arm.angle`"),
        ("name = \"x\"\ntype = \"coordinate\"\nof = \"arm.position[1]\"", "has no coordinate", "`arm.angle`"),
        ("name = \"x\"\ntype = \"orientation\"\nof = \"ground\"", "is of the ground", "name a body"),
        ("name = \"x\"\ntype = \"energy\"\nof = \"kinetik\"", "kinetik", "kinetic"),
        ("name = \"x\"\ntype = \"distance\"\nof = \"arm.tip\"", "`against` is missing", ""),
        ("name = \"x\"\ntype = \"distance\"", "two points", "between"),
        ("name = \"x\"\ntype = \"expression\"\nexpression = \"2*y\"", "unknown name `y`", ""),
        ("name = \"x\"\ntype = \"expression\"\nexpression = \"2*x\"", "follow from each other: `x` uses `x`", ""),
        ("name = \"x\"\ntype = \"shear\"\nof = \"arm\"", "unknown output type `shear`", ""),
        ("name = \"x\"\ntype = \"section\"\nof = \"arm\"", "`s` is missing", "s = 0.5"),
        ("name = \"x\"\ntype = \"section\"\nof = \"arm\"\ns = 0.1", "no beam or cable is called `arm`", ""),
        ("name = \"t\"\ntype = \"orientation\"\nof = \"arm\"", "cannot be called `t`", "the time"),
        ("name = \"time\"\ntype = \"orientation\"\nof = \"arm\"", "cannot be called `time`", "a column of that name"),
        ("type = \"orientation\"\nof = \"arm\"", "`name` is missing", "camber"),
    ];
    for (output, message, hint) in cases {
        let told = wrong(output);
        assert!(told.contains(message) && told.contains(hint), "{output}\n{told}");
        assert!(told.contains("s.toml:"), "{told}");
    }
}

#[test]
fn outputs_that_follow_from_each_other_are_named() {
    let two = "name = \"a\"\ntype = \"expression\"\nexpression = \"b + 1\"\n[[output]]\nname = \"b\"\ntype = \"expression\"\nexpression = \"2*a\"";
    let told = wrong(two);
    assert!(told.contains("outputs follow from each other: `a` uses `b` uses `a`"), "{told}");
    let list = "name = \"p\"\ntype = \"position\"\nof = \"arm.tip\"\n[[output]]\nname = \"b\"\ntype = \"expression\"\nexpression = \"2*p\"";
    assert!(wrong(list).contains("unknown name `p`"), "{}", wrong(list));
    let twice = "name = \"p\"\ntype = \"orientation\"\nof = \"arm\"\n[[output]]\nname = \"p\"\ntype = \"orientation\"\nof = \"arm\"";
    assert!(wrong(twice).contains("two outputs are called `p`"), "{}", wrong(twice));
}

/// What has several numbers names each of them: no other output is called so, in whatever order they stand.
#[test]
fn no_output_is_called_like_a_number_of_another() {
    let tip = "name = \"tip\"\ntype = \"position\"\nof = \"arm.tip\"";
    let other = "name = \"tip[0]\"\ntype = \"coordinate\"\nof = \"arm\"";
    for both in [[tip, other], [other, tip]] {
        let told = wrong(&both.join("\n[[output]]\n"));
        for part in ["cannot be called `tip[0]`", "a number of the output `tip`", "another name", "s.toml:"] {
            assert!(told.contains(part), "{part}: {told}");
        }
    }
    // One number has no index, and three end before the fourth.
    let fine = |name: &str, of: &str| {
        let text = format!(
            "{ARM}[[output]]\nname = \"tip\"\n{of}\n[[output]]\nname = \"{name}\"\ntype = \"coordinate\"\nof = \"arm\"\n"
        );
        parse("s.toml", &text, &[]).expect("fine");
    };
    fine("tip[0]", "type = \"coordinate\"\nof = \"arm\"");
    fine("tip[3]", "type = \"position\"\nof = \"arm.tip\"");
}

#[test]
fn events_watch_outputs_by_name() {
    let with = |event: &str| {
        format!("{ARM}[[output]]\nname = \"tip\"\ntype = \"position\"\nof = \"arm.tip\"\n[[event]]\n{event}\n")
    };
    parse("s.toml", &with("output = \"tip[2]\""), &[]).expect("fine");
    for (event, message) in [
        ("output = \"tip\"", "the output `tip` has 3 numbers"),
        ("output = \"top[2]\"", "there is no output `top[2]`"),
        ("output = \"tip[2]\"\nhinge = \"arm\"", "exactly one of `hinge`, `on` and `output`"),
    ] {
        let told = parse("s.toml", &with(event), &[]).expect_err("a problem").to_string();
        assert!(told.contains(message), "{told}");
    }
}

fn call(folder: &std::path::Path, arguments: &[&str]) -> String {
    let answer = Command::new(env!("CARGO_BIN_EXE_stillpoint")).current_dir(folder).args(arguments).output().unwrap();
    assert!(answer.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&answer.stderr));
    String::from_utf8(answer.stdout).unwrap()
}

/// One number under one name wherever it is told.
#[test]
fn every_command_tells_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "[[output]]\nname = \"tip\"\ntype = \"position\"\nof = \"arm.tip\"\n[[output]]\nname = \"pull\"\ntype = \"force\"\nof = \"stay\"\n[[output]]\nname = \"high\"\ntype = \"expression\"\nexpression = \"{tip[2]} + 1\"\nunit = \"m\"\n[[event]]\nname = \"level\"\noutput = \"high\"\nvalue = 0.3\n";
    let settings = "[simulate]\nstart = \"given\"\nduration = 1.0\n[record]\nrate = 20.0\n";
    std::fs::write(folder.path().join("s.toml"), format!("{settings}{ARM}{scene}")).unwrap();
    let json = |arguments: &[&str]| -> Value { serde_json::from_str(&call(folder.path(), arguments)).unwrap() };
    let seen = json(&["inspect", "s.toml", "--json"]);
    let (x, z) = (-(0.4_f64.sin()), -(0.4_f64.cos()));
    assert!((seen["outputs"]["tip"][0].as_f64().unwrap() - x).abs() < 1e-15);
    assert!((seen["outputs"]["high"].as_f64().unwrap() - (z + 1.0)).abs() < 1e-15);
    let rests = json(&["statics", "s.toml", "--json"]);
    assert!(rests["outputs"]["pull"].is_number() && rests["outputs"]["tip"].is_array());
    let ran = json(&["run", "s.toml", "--json", "--out", "s.mcap"]);
    let events = ran["events"].as_array().unwrap();
    assert!(
        events.iter().any(|event| event["name"] == "level" && event["speed"].as_f64().unwrap() != 0.0),
        "{events:?}"
    );
    let info = call(folder.path(), &["info", "s.mcap"]);
    assert!(info.contains("/outputs"), "{info}");
    call(folder.path(), &["export", "s.mcap", "--csv", "t", "--quiet"]);
    let table = std::fs::read_to_string(folder.path().join("t/outputs.csv")).unwrap();
    let head = table.lines().next().unwrap();
    assert!(head.contains("tip[2] [m]") && head.contains("pull [N]") && head.contains("high [m]"), "{head}");
    let last: Vec<f64> = table.lines().last().unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    assert_eq!(last[4], ran["outputs"]["pull"].as_f64().unwrap());
    // The event is where the output has the value: to the interpolation of the samples here.
    let time = events.iter().find(|event| event["name"] == "level").unwrap()["time"].as_f64().unwrap();
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    let after = rows.iter().position(|row| row[0] >= time).unwrap();
    assert!((rows[after - 1][5] - 0.3) * (rows[after][5] - 0.3) <= 0.0, "{time}");
    call(folder.path(), &["plot", "s.mcap", "high", "--out", "p.svg", "--quiet"]);
    let compared = json(&["compare", "s.mcap", "s.mcap", "--channel", "outputs", "--json"]);
    assert_eq!(compared["same"], true);
    let swept = json(&["sweep", "s.toml", "--over", "arm.mass=1,2", "--json"]);
    assert!(swept["cases"][1]["result"]["tip[0]"].is_number(), "{swept}");
    let swept = json(&["sweep", "s.toml", "--run", "--over", "arm.mass=1,2", "--json"]);
    assert!(swept["cases"][1]["result"]["high.rms"].is_number(), "{swept}");
}

/// A table along a path has a column for each number.
#[test]
fn paths_have_columns_of_outputs() {
    let folder = tempfile::tempdir().unwrap();
    let path = "statics.path={ parameter = \"chassis.mass\", from = 300.0, to = 350.0 }";
    let scenario = file("double_wishbone").display().to_string();
    call(folder.path(), &["statics", &scenario, "--set", path, "--out", "w", "--quiet"]);
    let table = std::fs::read_to_string(folder.path().join("w.path.csv")).unwrap();
    let head = table.lines().next().unwrap();
    assert!(head.contains("camber [rad]") && head.contains("travel [m]"), "{head}");
    assert!(table.lines().skip(1).all(|line| line.split(',').count() == head.split(',').count()));
}
