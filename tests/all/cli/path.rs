//! `statics` of a file with `[statics.path]`: the table, the plot, the recording and the keys.

use super::{Bench, shipped};
use stillpoint::record::Recording;

#[test]
fn a_path_is_written_as_table_plot_and_recording() {
    let bench = Bench::new();
    let answer = bench.call(&["statics", &shipped("snap_through"), "--json", "--out", "arch"]).code(0);
    assert_eq!(bench.names(), ["arch.path.csv", "arch.path.mcap", "arch.path.svg"]);
    let found = answer.json();
    let path = &found["path"];
    assert_eq!((&found["converged"], &path["complete"], &path["unit"]), (&true.into(), &true.into(), &"N".into()));
    let kinds: Vec<&str> =
        path["events"].as_array().expect("events").iter().filter_map(|event| event["event"]["kind"].as_str()).collect();
    assert_eq!(kinds, ["fold", "fold"]);
    let points = path["branches"][0]["points"].as_array().expect("points");
    assert_eq!(points.iter().filter(|point| point["wanted"] == true).count(), 3);

    let read = |name: &str| std::fs::read_to_string(bench.path().join(name)).expect("a file");
    let table = read("arch.path.csv");
    let mut lines = table.lines();
    let head: Vec<&str> = lines.next().expect("a head").split(',').collect();
    assert_eq!((head[3], head[head.len() - 1]), ("parameter [N]", "joint.distance [m]"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), points.len());
    for (row, point) in rows.iter().zip(points) {
        assert_eq!(row.len(), head.len());
        let (written, said) =
            (row[3].parse::<f64>().expect("a number"), point["parameter"].as_f64().expect("a number"));
        // The reader of JSON rounds in its own way.
        assert!((written - said).abs() <= f64::EPSILON * said.abs(), "all digits: {written} {said}");
    }
    assert!(rows.iter().any(|row| row[4] == "unstable") && rows.iter().filter(|row| row[6] == "fold").count() == 2);

    let plot = read("arch.path.svg");
    for text in ["push.force[2] (N)", "joint.distance (m)", "unstable", "fold"] {
        assert!(plot.contains(text), "no `{text}` in the plot");
    }
    // Arclength stands for time, and the joint is where the table has it.
    let recording = Recording::open(&bench.path().join("arch.path.mcap")).expect("a recording");
    let samples: Vec<_> = recording.samples().expect("samples").map(|sample| sample.expect("a sample")).collect();
    assert_eq!(samples.len(), rows.len());
    for (sample, row) in samples.iter().zip(&rows) {
        let height: f64 = row[head.len() - 1].parse().expect("a number");
        assert_eq!((sample.positions[0], sample.bodies[0].translation.z), (height, height));
    }
}

#[test]
fn a_path_over_what_does_not_exist_is_a_wrong_call_and_one_without_a_start_answers_no() {
    let bench = Bench::new();
    let arch = shipped("snap_through");
    let answer = bench.call(&["statics", &arch, "--set", "statics.path.parameter=push.forse[2]"]).code(2);
    assert!(answer.err.contains("did you mean `force`"), "{}", answer.err);
    let pendulum = shipped("pendulum");
    let path = "statics.path={ parameter = \"rod.force\", from = 1e3, to = 0 }";
    let answer = bench.call(&["statics", &pendulum, "--json", "--set", path]).code(1);
    let found = answer.json();
    assert_eq!(found["path"]["complete"], false);
    assert!(found["path"]["notes"][0].as_str().expect("a note").contains("no equilibrium at `rod.force` = 1000"));
    assert!(bench.names().is_empty(), "nothing to write");
}

/// The last section of a beam is at its end: a longer one has an element more, and says so instead of coming to grief.
#[test]
fn beams_that_are_cut_otherwise_have_no_path_and_no_derivative() {
    let bench = Bench::new();
    bench.write(
        "beam.toml",
        "[[beam]]\nname = \"b\"\nhinge = { type = \"fixed\" }\nlength = 1.85\nelements = 4\nmass_per_length = 0.68\n\
         section = [{ s = 0.0, stiffness = [2e3, 8e2, 3e2, 44, 35, 22] }, { s = 1.85, stiffness = [1.6e3, 7e2, 2e2, 23, 33, 14] }]\n\
         [[output]]\nname = \"z\"\ntype = \"position\"\nof = \"b.tip\"\naxis = [0, 0, 1]\n",
    );
    let path = "statics.path={ parameter = \"b.length\", from = 1.85, to = 2.0 }";
    let answer = bench.call(&["statics", "beam.toml", "--set", path]).code(2);
    assert!(answer.err.contains("another number of elements"), "{}", answer.err);
    let answer = bench.call(&["statics", "beam.toml", "--sensitivity", "z", "--json"]).code(0).json();
    assert!(!answer["sensitivities"].is_null(), "{answer}");
}

#[test]
fn a_recorded_path_goes_along_its_arclength_and_is_plotted_over_its_parameter() {
    let bench = Bench::new();
    bench.call(&["statics", &shipped("snap_through"), "--quiet", "--out", "arch"]).code(0);
    let plot = |more: &[&str]| {
        bench.call(&[&["plot", "arch.path.mcap", "joint.distance", "-o", "x.svg"][..], more].concat()).code(0);
        std::fs::read_to_string(bench.path().join("x.svg")).expect("a plot")
    };
    assert!(plot(&[]).contains("push.force[2] (N)"));
    let along = plot(&["--x", "arclength"]);
    assert!(along.contains("\narclength\n") && !along.contains("time"), "{along}");
    assert!(plot(&["--x", "potential"]).contains("potential (J)"));
    assert!(
        bench.call(&["plot", "arch.path.mcap", "joint.distance", "--x", "time"]).code(2).err.contains("no channel")
    );
    assert!(bench.call(&["info", "arch.path.mcap"]).code(0).out.contains("arclength from 0 to"));
    // The recording has the parameters of the table, at its arclengths.
    let read = |text: &str, names: [&str; 2]| -> Vec<[f64; 2]> {
        let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let head = lines.next().expect("a head");
        let columns = names.map(|name| head.iter().position(|one| *one == name).expect(name));
        lines.map(|row| columns.map(|column| row[column].parse().expect("a number"))).collect()
    };
    let recorded = bench.call(&["export", "arch.path.mcap", "--csv", "-"]).code(0).out;
    let recorded = read(&recorded, ["arclength [1]", "push.force[2] [N]"]);
    let table = std::fs::read_to_string(bench.path().join("arch.path.csv")).expect("a table");
    let table = read(&table, ["arclength", "parameter [N]"]);
    assert_eq!(recorded.len(), table.len());
    for (recorded, written) in recorded.iter().zip(&table) {
        // Times of recordings are whole nanoseconds.
        assert!((recorded[0] - written[0]).abs() <= 1e-9 && recorded[1] == written[1], "{recorded:?} {written:?}");
    }
}
