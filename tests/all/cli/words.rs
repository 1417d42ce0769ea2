//! What reports say: units, digits, round-off, numbers of things, names; of every shipped scene.

use super::{Bench, SCALE, shipped};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Every scenario at the top of `scenarios`, by its path.
fn scenes() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let entries = std::fs::read_dir(folder).expect("the scenarios");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "toml");
    let mut names: Vec<String> = paths.filter(is_scene).map(|path| path.display().to_string()).collect();
    names.sort();
    assert!(names.len() > 40, "{names:?}");
    names
}

/// Significant digits of a number as it is written; integers have as many as they need.
fn digits(word: &str) -> usize {
    let mantissa = word.split('e').next().unwrap_or_default();
    if !mantissa.contains('.') {
        return 0;
    }
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    digits.trim_start_matches('0').len()
}

/// The numbers of a line.
fn numbers(line: &str) -> Vec<&str> {
    let words = line.split(|c: char| c.is_whitespace() || "(),;:`[]=".contains(c));
    words
        .filter(|word| word.starts_with(|c: char| c.is_ascii_digit() || c == '-') && word.parse::<f64>().is_ok())
        .collect()
}

/// Why a line should not be printed.
fn fault(line: &str, most_digits: usize) -> Option<String> {
    if line.contains(" or N m") || line.contains("m or rad") {
        return Some("leaves the unit open".to_owned());
    }
    let words: Vec<&str> = line.split_whitespace().map(|word| word.trim_matches(|c| "(),;:".contains(c))).collect();
    let plural = |pair: &[&str]| {
        pair[0] == "1"
            && ["steps", "bodies", "degrees", "samples", "equilibria", "branches", "hinges", "contacts", "modes"]
                .contains(&pair[1])
    };
    if words.windows(2).any(plural) {
        return Some("counts one as many".to_owned());
    }
    // A residual is small, and says so; a proof of rest, too.
    let is_proof = line.contains("residual") || line.contains("at rest: in") || line.contains("balanced at");
    numbers(line).into_iter().find_map(|word| {
        let number: f64 = word.parse().expect("a number");
        match () {
            () if digits(word) > most_digits => Some(format!("{word} has more than {most_digits} digits")),
            () if !is_proof && number != 0.0 && number.abs() < 1e-12 => Some(format!("{word} is round-off")),
            () => None,
        }
    })
}

#[test]
fn reports_say_units_four_digits_and_no_round_off() {
    let bench = Bench::new();
    let mut wrong = Vec::new();
    let mut lines = 0;
    for scene in scenes() {
        for command in ["statics", "inspect"] {
            let said = bench.call(&[command, &scene]);
            for line in said.out.lines() {
                // A title is what the file says.
                let title = !line.starts_with(' ') && !line.contains('(');
                lines += 1;
                wrong
                    .extend(fault(line, 4).filter(|_| !title).map(|why| format!("{command} {scene}: {why}\n  {line}")));
            }
        }
    }
    assert!(lines > 500, "{lines}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_fault_of_a_report_is_noticed() {
    for line in ["  pose rod angle = 1.23456", "  pose rod angle = 1e-17", "bears 3 N or N m", "found (1 steps)"] {
        assert!(fault(line, 4).is_some(), "{line}");
    }
    assert_eq!(fault("  residual 1.2e-16 of the forces (3.1e-15 N m in `rod`), 1 step, 1018 kg", 4), None);
}

#[test]
fn as_many_digits_as_are_asked_for() {
    let bench = Bench::new();
    let mode = |digits: &[&str]| {
        let mut arguments = vec!["statics", "pendulum.toml"];
        arguments.extend(digits);
        bench.write("pendulum.toml", std::fs::read_to_string(shipped("pendulum")).expect("a scene"));
        let out = bench.call(&arguments).code(0).out;
        let line = out.lines().find(|line| line.contains("Hz")).expect("a mode").to_owned();
        numbers(&line)[0].to_owned()
    };
    assert_eq!(mode(&[]), "0.6104");
    let exact: f64 = bench.call(&["statics", "pendulum.toml", "--json"]).code(0).json()["frequencies_hz"][0]
        .as_f64()
        .expect("a mode");
    assert_eq!(mode(&["--digits", "17"]).parse::<f64>(), Ok(exact));
    assert_eq!(mode(&["--digits=2"]), "0.61");
    assert!(bench.call(&["statics", "pendulum.toml", "--digits", "0"]).code(2).err.contains("1..=17"));
}

/// A pendulum of large swings makes more of its errors than they are: a long run says what its steps add up to, that this is of steps by
/// themselves, and what measures the rest. A short one within its tolerance says nothing.
#[test]
fn the_sum_of_errors_is_not_told_as_the_error() {
    let bench = Bench::new();
    bench.write(
        "swing.toml",
        "simulate = { start = \"given\", integrator = \"radau9\", tolerance = 1e-8 }\nrecord = { rate = 0.1 }\n\
         [[body]]\nname = \"a\"\nmass = 1.0\ncenter = [0, 0, -1]\nhinge = { type = \"revolute\", axis = [0, 1, 0], position = 2.5 }\n",
    );
    let told = |duration: &str| {
        let text = bench.call(&["run", "swing.toml", "--set", &format!("simulate.duration={duration}")]).code(0).out;
        text.lines().find(|line| line.contains("accuracy")).map(str::to_owned)
    };
    let long = told("200").expect("more than 2000 steps");
    assert!(
        long.contains("each by itself") && long.contains("`--verify` measures it") && !long.contains("at most"),
        "{long}"
    );
    assert_eq!(told("2"), None);
}

/// Strings of an answer that are names, with where they stand; notes are sentences.
fn names(value: &Value, path: &str, found: &mut Vec<(String, String)>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                found.push((path.to_owned(), key.clone()));
                if !["notes", "error", "why", "integrator_choice"].contains(&key.as_str()) {
                    names(value, &format!("{path}.{key}"), found);
                }
            }
        }
        Value::Array(list) => list.iter().for_each(|value| names(value, path, found)),
        Value::String(text) => found.push((path.to_owned(), text.clone())),
        _ => {}
    }
}

#[test]
fn names_in_json_are_those_of_the_scene() {
    let bench = Bench::new();
    for scene in scenes() {
        let mut found = Vec::new();
        let answer = bench.call(&["statics", &scene, "--json", "--quiet"]);
        if answer.code == 2 {
            // A scene that begins in motion has no statics, and says so.
            assert!(answer.err.contains("statics cannot start"), "{answer:#?}");
            continue;
        }
        names(&answer.json(), "", &mut found);
        let quoted: Vec<_> = found.iter().filter(|(_, name)| name.contains('`')).collect();
        assert!(quoted.is_empty(), "{scene}: {quoted:?}");
    }
}

#[test]
fn a_run_says_the_equilibrium_in_one_line() {
    let bench = Bench::new();
    for (command, arguments) in [("run", &["--out", "x.mcap"][..]), ("rest", &[])] {
        let scene = shipped("machine_on_mounts");
        let call = |more: &[&str]| {
            let mut all = vec![command, &scene, "--set", "simulate.duration=0.1"];
            all.extend(arguments.iter().chain(more));
            bench.call(&all).code(0).out
        };
        let (short, long) = (call(&[]), call(&["-v"]));
        let line = short.lines().find(|line| line.contains("equilibrium")).expect("a verdict");
        assert!(line.contains("residual") && line.contains("first mode 4.824 Hz"), "{line}");
        assert!(!short.contains("  pose") && !short.contains("  modes"), "{short}");
        assert!(long.contains("  pose") && long.contains("  modes") && long.contains("ζ"), "{long}");
    }
    // What cannot begin is said in full.
    bench.write("brick.toml", super::BRICK);
    let refused = bench.call(&["run", "brick.toml"]).code(1).out;
    assert!(refused.contains("no equilibrium found") && refused.contains("  note"), "{refused}");
}

#[test]
fn a_damping_ratio_stands_beside_its_frequency() {
    let bench = Bench::new();
    // ζ = d / (2 √(k m)), over a range of dampings: 5, 50 of 100 %, and beyond, where nothing swings.
    for damping in [1.0, 10.0, 19.0] {
        bench.write(
            "scale.toml",
            SCALE.replace("stiffness = 100.0", &format!("stiffness = 100.0, damping = {damping:?}")),
        );
        let out = bench.call(&["statics", "scale.toml", "--digits", "9"]).code(0).out;
        let line = out.lines().find(|line| line.contains("damped")).expect("damped modes");
        let ratio: f64 = line
            .split('ζ')
            .nth(1)
            .and_then(|rest| rest.split_whitespace().next())
            .expect("ζ")
            .parse()
            .expect("a number");
        assert!((ratio - damping / 20.0).abs() < 1e-8, "{line}");
    }
    bench.write("scale.toml", SCALE.replace("stiffness = 100.0", "stiffness = 100.0, damping = 30.0"));
    let out = bench.call(&["statics", "scale.toml"]).code(0).out;
    assert!(!out.contains('ζ') && out.contains("decays"), "{out}");
}

#[test]
fn verdicts_are_green_or_red() {
    let bench = Bench::new();
    bench.write("brick.toml", super::BRICK);
    bench.write("scale.toml", SCALE);
    for (scene, color) in [("scale.toml", "\u{1b}[1;32mstable"), ("brick.toml", "\u{1b}[1;31mno equilibrium")] {
        let output =
            bench.command(&["statics", scene]).env("CLICOLOR_FORCE", "1").output().expect("the program starts");
        assert!(String::from_utf8_lossy(&output.stdout).contains(color), "{scene}");
    }
}

#[test]
fn given_velocities_are_told_only_where_the_file_gives_them() {
    let bench = Bench::new();
    let told = |text: &str| {
        bench.write("scene.toml", text);
        bench.call(&["run", "scene.toml", "--set", "simulate.duration=0.1"]).err.contains("gives velocities")
    };
    let driven = format!("{SCALE}\n[[drive]]\nhinge = \"pan\"\ntype = \"rate\"\nrate = 0.5\n");
    assert!(!told(SCALE) && !told(&driven));
    assert!(told(&SCALE.replace("stiffness", "velocity = 0.5, stiffness")));
}

#[test]
fn tables_go_where_they_are_sent() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    bench.call(&["run", "scale.toml", "--set", "simulate.duration=0.1"]).code(0);
    let printed = bench.call(&["export", "scale.mcap", "--csv", "-"]).code(0);
    bench.call(&["export", "scale.mcap", "--csv", "x.csv"]).code(0);
    assert_eq!(printed.out, std::fs::read_to_string(bench.path().join("x.csv")).expect("a table"));
    assert!(printed.out.starts_with("time [s],pan.distance [m],"), "{}", printed.out);
    let before = bench.names();
    for name in ["a.xlsx", "a.CVS", "a.parquet"] {
        let refused = bench.call(&["export", "scale.mcap", "--csv", name]).code(2);
        assert!(refused.err.contains("ends in .csv, or a folder"), "{refused:#?}");
    }
    assert!(bench.call(&["export", "scale.mcap", "--csv", "-", "--json"]).code(2).err.contains("standard output"));
    assert_eq!(bench.names(), before);
    bench.call(&["export", "scale.mcap", "--csv", "tables"]).code(0);
    assert!(bench.path().join("tables/hinges.csv").is_file());
}

#[test]
fn a_column_that_is_not_there_names_those_of_its_body() {
    let bench = Bench::new();
    let scene = "[[body]]\nname = \"rope\"\nmass = 1.0\nhinge = { type = \"universal\", axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] }\ncenter = [0.0, 0.0, -1.0]\ninertia = [0.1, 0.1, 0.1]\n";
    bench.write("rope.toml", scene);
    bench.call(&["run", "rope.toml", "--set", "simulate.duration=0.1"]).code(0);
    assert!(bench.call(&["plot", "rope.mcap", "rope.angle"]).code(2).err.contains("`rope.first_angle`"));
    assert!(bench.call(&["plot", "rope.mcap", "rope.zzz"]).code(2).err.contains("rope.second_rate"));
}

/// A body that is there is meant, and not one with a name like it.
#[test]
fn a_column_that_is_not_there_is_looked_for_in_its_body_first() {
    let bench = Bench::new();
    let scene = "[[body]]\nname = \"lamp\"\nmass = 1.0\nhinge = { type = \"universal\", axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] }\ncenter = [0.0, 0.0, -1.0]\ninertia = [0.1, 0.1, 0.1]\n\
                 [[body]]\nname = \"clamp\"\nmass = 1.0\nhinge = { type = \"revolute\", axis = [0, 1, 0] }\ncenter = [0, 0, -1]\ninertia = [0.1, 0.1, 0.1]\n";
    bench.write("lamp.toml", scene);
    bench.call(&["run", "lamp.toml", "--set", "simulate.duration=0.1"]).code(0);
    let asked = |name: &str| bench.call(&["plot", "lamp.mcap", name]).code(2).err;
    assert!(asked("lamp.angle").contains("did you mean `lamp.first_angle`"), "{}", asked("lamp.angle"));
    assert!(asked("clmp.angle").contains("did you mean `clamp.angle`"), "{}", asked("clmp.angle"));
}

#[test]
fn a_sweep_makes_no_folder_of_a_name_that_looks_like_a_file() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let sweep =
        |out: &str| bench.call(&["sweep", "scale.toml", "--over", "pan.stiffness=1e3:2e3:3", "--out", out]).code(2).err;
    assert!(sweep("-").contains("without `--out` the rows are printed"), "{}", sweep("-"));
    assert!(sweep("p.xlsx").contains("no .xlsx is written: name a file that ends in .csv"), "{}", sweep("p.xlsx"));
    assert_eq!(bench.names(), ["scale.toml"]);
}

/// Numbers of stages, as all others: as many digits as are asked for.
#[test]
fn what_a_stage_takes_out_has_the_digits_that_are_asked_for() {
    let bench = Bench::new();
    let docking = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/stages/docking.toml"));
    bench.write("docking.toml", docking.expect("a shipped scene"));
    let told = |digits: &str| bench.call(&["run", "docking.toml", "--digits", digits]).code(0).out;
    assert!(told("4").contains("takes out 67.5 J"), "{}", told("4"));
    assert!(told("2").contains("takes out 68 J"), "{}", told("2"));
}

#[test]
fn colours_have_names() {
    let bench = Bench::new();
    let with = |color: &str| {
        SCALE.replace("mass = 1.0", &format!("mass = 1.0\nshape = {{ sphere = 0.1, color = \"{color}\" }}"))
    };
    bench.write("scale.toml", with("Orange"));
    bench.call(&["check", "scale.toml"]).code(0);
    bench.write("scale.toml", with("ornage"));
    let refused = bench.call(&["check", "scale.toml"]).code(2).err;
    assert!(refused.contains("did you mean \"orange\"?") && refused.contains("teal"), "{refused}");
}

#[test]
fn a_winch_that_is_too_strong_is_named() {
    let bench = Bench::new();
    let said = bench.call(&["statics", &shipped("winch")]).code(1).out;
    assert!(
        said.contains("winds up for ever: nothing balances ")
            && said.contains(" in `drum`, the same all the way: `motor` is stronger than the load")
            && said.contains("no search"),
        "{said}"
    );
    // 90 N m against m g r, r = 0.1 m: the load wins from 91.8 kg on, and no motor is blamed for that.
    for mass in [1.0, 25.0, 60.0, 91.0, 92.5, 150.0, 400.0] {
        let surplus = 90.0 - mass * 9.80665 * 0.1;
        let set = format!("load.mass={mass}");
        let said = bench.call(&["statics", &shipped("winch"), "--set", &set]).code(1).out;
        assert_eq!(said.contains("is stronger than the load"), surplus > 0.0, "{mass}: {said}");
        assert!(said.contains("for ever"), "{mass}: {said}");
        if surplus > 0.0 {
            let by = said.split("nothing balances ").nth(1).and_then(|rest| rest.split(' ').next()).expect("a moment");
            assert!((by.parse::<f64>().expect("a number") - surplus).abs() < 1e-4 * surplus, "{mass}: {said}");
        }
    }
}

#[test]
fn a_hoist_that_is_too_strong_is_named() {
    let bench = Bench::new();
    // A pan of 1 kg on a slide upward, without its spring; a second motor pulls the other way.
    for (up, down) in [(5.0, 0.0), (12.0, 0.0), (30.0, 11.0), (9.0, 3.0), (100.0, 1.0)] {
        let motor = |name: &str, force: f64| {
            format!("[[motor]]\nname = \"{name}\"\nhinge = \"pan\"\ntype = \"constant\"\nforce = {force:?}\n")
        };
        let pan = SCALE.replace(", stiffness = 100.0", "");
        bench.write("hoist.toml", format!("{pan}{}{}", motor("hoist", up), motor("brake", -down)));
        let said = bench.call(&["statics", "hoist.toml"]).code(1).out;
        let surplus = up - down - 9.80665;
        assert_eq!(
            said.contains("is pushed for ever") && said.contains(": `hoist` is stronger than the load"),
            surplus > 0.0,
            "{up}: {said}"
        );
        assert_eq!(said.contains("falls for ever"), surplus < 0.0, "{up}: {said}");
    }
}

#[test]
fn plots_are_light_or_dark_at_fractions_of_a_pixel_and_in_the_format_of_their_name() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    bench
        .call(&[
            "run",
            "scale.toml",
            "--set",
            "pan.velocity=0.1",
            "--set",
            "simulate.start=\"given\"",
            "--set",
            "simulate.duration=0.5",
        ])
        .code(0);
    let plot = |more: &[&str]| {
        bench.call(&[&["plot", "scale.mcap", "pan.distance", "pan.speed", "-o", "x.svg"][..], more].concat()).code(0);
        std::fs::read_to_string(bench.path().join("x.svg")).expect("a plot")
    };
    let (light, dark) = (plot(&[]), plot(&["--theme", "dark"]));
    assert_eq!(light, plot(&["--theme", "light"]));
    let paper = |svg: &str| svg.lines().find(|line| line.starts_with("<rect")).expect("paper").to_owned();
    assert!(paper(&light).contains("#FFFFFF") && paper(&dark).contains("#181A1F"), "{}", paper(&dark));
    assert!(!dark.contains("#000000") && !dark.contains("\"#FFFFFF\""), "ink of light paper on dark");
    for svg in [&light, &dark] {
        assert!(svg.contains("width=\"1120\"") && svg.contains("viewBox=\"0 0 11200 "), "{}", &svg[..200]);
        for text in ["time (s)", "pan.distance (m)", "pan.speed (m/s)"] {
            assert!(svg.contains(text), "{text}");
        }
    }
    let unknown = bench.call(&["plot", "scale.mcap", "pan.speed", "-o", "x.jpg"]).code(2).err;
    assert!(unknown.contains("ends in .svg, .png or .pdf"), "{unknown}");
    let pdf = bench.call(&["plot", "scale.mcap", "pan.speed", "-o", "x.pdf"]);
    if cfg!(feature = "picture") {
        let bytes = std::fs::read(bench.path().join("x.pdf")).expect("a plot");
        assert!(bytes.starts_with(b"%PDF-") && bytes.len() > 5000);
    } else {
        assert!(pdf.code(2).err.contains("built without PDF"));
    }
}
