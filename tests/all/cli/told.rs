//! What is told of stages, locks and names in summaries and reports.

use super::{Bench, shipped};
use std::fs::read_to_string;

/// Three weights are let go one after the other while a bar creeps: where it is then is told, and differs in the sixth digit. The first weight is
/// locked after a fall.
fn salvo() -> String {
    use std::fmt::Write;
    let mut text = "[simulate]\nstart = \"given\"\nduration = 2.0\n[[output]]\nname = \"place\"\ntype = \"position\"\nof = \"bar\"\n\
                    axis = [1.0, 0.0, 0.0]\n[[body]]\nname = \"bar\"\nmass = 2.0\n\
                    hinge = { type = \"prismatic\", axis = [1.0, 0.0, 0.0], position = 0.5, velocity = 1e-5 }\n"
        .to_owned();
    for k in [1, 2, 10] {
        let _ = write!(
            text,
            "[[body]]\nname = \"w_{k}\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", axis = [0.0, 0.0, 1.0], at = [{k}, 0, 0] }}\n\
             [[stage]]\nname = \"go {k}\"\nwhen = {{ time = {} }}\nrelease = [\"w_{k}\"]\noutputs = [\"place\"]\n",
            0.1 * f64::from(k)
        );
    }
    text + "[[stage]]\nname = \"caught\"\nwhen = { time = 1.6 }\nlock = [\"w_1\"]\n"
}

/// Numbers of one kind that stages tell are told apart, and how they scatter is said.
#[test]
fn a_summary_tells_how_what_stages_tell_scatters() {
    let bench = Bench::new();
    bench.write("salvo.toml", salvo());
    let said = bench.call(&["run", "salvo.toml", "--out", "run.mcap"]).code(0).out;
    for k in ["0.500001", "0.500002", "0.50001"] {
        assert!(said.contains(&format!("place {k}\n")), "{said}");
    }
    // Of 1, 2 and 10 times 1e-6 m: 4.33e-6 m, and a deviation of 4.933e-6 m.
    assert!(said.contains("told         place by 3 stages: mean 0.500004 m, standard deviation 4.933e-6 m"), "{said}");
}

/// In reports stages have no place; what they take out and tell is said with its unit, and names follow their numbers.
#[test]
fn a_report_tells_what_stages_take_out_and_tell() {
    let bench = Bench::new();
    bench.write("salvo.toml", salvo());
    bench.call(&["report", "salvo.toml", "-o", "page.html"]).code(0);
    let page = read_to_string(bench.path().join("page.html")).expect("a page");
    assert!(page.contains("taken out (J)") && page.contains("place 0.500001 m"), "{page}");
    let row = page.lines().find(|line| line.contains("<td>caught</td>")).expect("a row");
    let cells: Vec<&str> = row.split("<td").map(|cell| cell.split_once('>').map_or("", |(_, text)| text)).collect();
    // A fall of 1.5 s: ½ (9.80665 · 1.5)² J; nothing stands at the place or the speed.
    assert!(cells.iter().any(|cell| cell.starts_with("108.2")), "{row}");
    assert_eq!(cells.iter().filter(|cell| cell.starts_with("</td>")).count(), 3, "{row}");
    // No stages, no columns for them.
    bench.call(&["report", &shipped("stops"), "-o", "stops.html"]).code(0);
    assert!(!read_to_string(bench.path().join("stops.html")).expect("a page").contains("taken out (J)"));
}

#[test]
fn a_report_calls_locks_locks_and_counts_names() {
    let bench = Bench::new();
    let text = "[[body]]\nname = \"p\"\nrepeat = 9\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [0, 0, 1], stiffness = 100.0, next = [1, 0, 0] }\n\
                [[body]]\nname = \"w_2\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [0, 0, 1] }\n\
                [[body]]\nname = \"w_10\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [0, 0, 1] }\n\
                [[stage]]\nname = \"go\"\nwhen = { time = 0.1 }\nrelease = [\"w_2\", \"w_10\"]\n[simulate]\nduration = 0.2\n";
    bench.write("held.toml", text);
    bench.call(&["report", "held.toml", "-o", "page.html"]).code(0);
    let page = read_to_string(bench.path().join("page.html")).expect("a page");
    assert!(page.contains("<td>w_2.lock</td><td>lock</td>") && !page.contains("<td>drive</td>"), "{page}");
    let at = |name: &str| page.find(&format!("<td>{name}</td>")).expect("a row");
    assert!(at("w_2") < at("w_10") && at("w_2.lock") < at("w_10.lock"));
    // Eleven coordinates are eleven curves.
    assert!(!page.contains(": the first "), "{page}");
}

/// `-v` means nothing to statics, which prints all, and is no error; a guess that is moved to its limits is not called an equilibrium.
#[test]
fn statics_takes_the_flags_of_a_run_and_says_when_it_moved_the_guess() {
    let bench = Bench::new();
    let scene = |position: &str| {
        format!(
            "[[body]]\nname = \"b\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], position = {position}, limits = [-1.0, 1.0] }}\n"
        )
    };
    bench.write("beyond.toml", scene("2.0"));
    bench.write("within.toml", scene("0.5"));
    let plain = bench.call(&["statics", "within.toml"]).code(0).out;
    assert!(plain.contains("the guess is one already"), "{plain}");
    let said = bench.call(&["statics", "beyond.toml", "-v"]).code(0).out;
    assert!(!said.contains("one already") && said.contains("at its limits, which it was beyond"), "{said}");
}

/// The lines of a grid, in the colour of no other.
fn has_grid(svg: &str) -> bool {
    svg.contains("stroke=\"#d9dde2\"")
}

/// Where nothing falls nothing is a floor, unless a plane is one; and a plane reaches under all that stands on it.
#[test]
fn floors_are_drawn_under_what_falls() {
    let bench = Bench::new();
    let ball = "[[body]]\nname = \"ball\"\nmass = 1.0\nshape = { sphere = 0.1 }\ninertia = [0.1, 0.1, 0.1]\nhinge = { type = \"free\" }\n";
    let plane = "[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n";
    let floats = "gravity = [0, 0, 0]\nsimulate = { start = \"given\", duration = 0.1 }\n";
    for (text, expected) in [
        (floats.to_owned() + ball, false),
        (floats.to_owned() + ball + plane, true),
        (floats.replacen("gravity = [0, 0, 0]\n", "", 1) + ball, true),
    ] {
        bench.write("scene.toml", &text);
        bench.call(&["run", "scene.toml", "--out", "run.mcap", "--quiet"]).code(0);
        bench.call(&["picture", "run.mcap", "-o", "run.svg"]).code(0);
        assert_eq!(has_grid(&read_to_string(bench.path().join("run.svg")).expect("a picture")), expected, "{text}");
    }
    bench
        .call(&["run", &shipped("contact/dominoes"), "--set", "simulate.duration=0.01", "--out", "run.mcap", "--quiet"])
        .code(0);
    let recording = stillpoint::record::Recording::open(&bench.path().join("run.mcap")).expect("a recording");
    let floor = recording.scene.bodies.iter().flat_map(|body| &body.shapes).find(|shape| shape.kind == "plane");
    // The last of five stands at 0.2 m, and is 0.1 m high.
    assert!(floor.is_some_and(|floor| floor.size[0] > 2.0 * 0.35 && floor.size[0] < 2.0), "{floor:?}");
}

/// A start beyond a rigid limit is a wrong file, told before anything is written.
#[test]
fn a_start_beyond_a_limit_leaves_no_recording() {
    let bench = Bench::new();
    bench.write(
        "beyond.toml",
        "simulate = { start = \"given\" }\n[[body]]\nname = \"b\"\nmass = 1.0\n\
         hinge = { type = \"prismatic\", axis = [0, 0, 1], position = 2.0, limits = [-1.0, 1.0] }\n",
    );
    for command in ["check", "run", "inspect"] {
        let said = bench.call(&[command, "beyond.toml"]).code(2).err;
        assert!(said.contains("starts at 2, beyond its limits -1 to 1") && said.contains("beyond.toml:5:"), "{said}");
    }
    assert!(!bench.path().join("beyond.mcap").exists());
    // So is a start file.
    bench.write(
        "within.toml",
        "[[body]]\nname = \"b\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [0, 0, 1], limits = [-1.0, 1.0] }\n",
    );
    bench.write("start.toml", "[positions]\nb = [2.0]\n[velocities]\nb = [0.1]\n");
    let said = bench.call(&["run", "within.toml", "--start", "start.toml"]).code(2).err;
    assert!(said.contains("start.toml") && said.contains("starts at 2, beyond"), "{said}");
    assert!(!bench.path().join("within.mcap").exists());
}
