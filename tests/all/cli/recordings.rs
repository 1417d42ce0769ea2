//! Recordings as data: what is in them, what is left of them, their numbers in files, pictures and comparisons.

use super::{Answer, Bench, shipped};
use serde_json::Value;
use stillpoint::record::{OwnedSample, Recording};

/// Two seconds of the double pendulum, recorded under this name.
fn record(bench: &Bench, name: &str, more: &[&str]) {
    let scenario = shipped("double_pendulum");
    let arguments = ["run", &scenario, "--quiet", "--set", "simulate.duration=2", "--out", name];
    bench.call(&[&arguments[..], more].concat()).code(0);
}

fn samples(bench: &Bench, name: &str) -> Vec<OwnedSample> {
    let recording = Recording::open(&bench.path().join(name)).expect("a recording");
    recording.samples().expect("samples").map(|sample| sample.expect("a sample")).collect()
}

#[test]
fn info_says_what_is_in_a_recording() {
    let bench = Bench::new();
    record(&bench, "a.mcap", &[]);
    let info = bench.call(&["info", "a.mcap", "--json"]).code(0).json();
    assert_eq!((&info["state"], &info["complete"], &info["samples"]), (&"complete".into(), &true.into(), &201.into()));
    assert_eq!((&info["first_time"], &info["last_time"]), (&0.0.into(), &2.0.into()));
    assert_eq!(info["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(info["attachments"][0]["name"], "scenario.toml");
    assert_eq!(info["columns"]["hinges"][1], serde_json::json!({ "name": "lower.angle", "unit": "rad" }));
    let hinges = info["channels"].as_array().expect("channels").iter().find(|channel| channel["topic"] == "/hinges");
    assert_eq!(hinges.expect("/hinges")["messages"], 201);
    assert_eq!(info["run"]["end_time"], 2.0);
    let text = bench.call(&["info", "a.mcap"]).code(0).out;
    for part in ["complete", "201, from 0 s to 2 s", "upper.rate_dot [rad/s²]", "scenario.toml"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let statics = shipped("pencil");
    bench.call(&["run", &statics, "--quiet", "--set", "simulate.duration=0.1"]).code(0);
    assert_eq!(bench.call(&["info", "pencil.mcap", "--json"]).code(0).json()["statics"]["stability"], "unstable");
}

/// A run that fails after more events than samples: its range is that of the samples.
#[test]
fn info_tells_the_range_of_samples_and_not_of_events() {
    let bench = Bench::new();
    bench.write(
        "jam.toml",
        "record = { rate = 2.0 }\nsimulate = { start = \"given\", duration = 9.0 }\n\
         [[body]]\nname = \"ball\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [0, 0, 1], position = 0.2, \
         limits = { low = 0.0, restitution = 0.9 } }\n\
         [[body]]\nname = \"ram\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [1, 0, 0], limits = { high = 1.3 } }\n\
         [[drive]]\nname = \"press\"\nhinge = \"ram\"\ntype = \"rate\"\nrate = 1.0\n",
    );
    bench.call(&["run", "jam.toml", "--quiet"]).code(1);
    let info = bench.call(&["info", "jam.mcap", "--json"]).code(0).json();
    let events = info["channels"].as_array().expect("channels").iter().find(|channel| channel["topic"] == "/events");
    assert!(events.expect("/events")["messages"].as_u64() > info["samples"].as_u64(), "{info}");
    let said = (&info["state"], &info["samples"], &info["first_time"], &info["last_time"]);
    assert_eq!(said, (&"failed".into(), &3.into(), &0.0.into(), &1.0.into()));
}

#[test]
fn what_was_cut_is_recovered_up_to_the_last_whole_chunk() {
    let bench = Bench::new();
    // Long enough for several chunks: they are closed at a mebibyte.
    record(&bench, "whole.mcap", &["--set", "record.rate=4000"]);
    let whole = std::fs::read(bench.path().join("whole.mcap")).expect("read");
    let all = samples(&bench, "whole.mcap");
    bench.write("run.mcap.partial", &whole[..whole.len() / 2]);
    let kept = samples(&bench, "run.mcap.partial").len();
    assert!(kept > 100 && kept < all.len(), "{kept} of {}", all.len());
    let answer = bench.call(&["recover", "run.mcap.partial"]).code(0);
    assert!(answer.out.contains(&format!("{kept} samples saved, from 0 s to")), "{answer:#?}");
    assert!(answer.out.contains("lost: ") && answer.out.contains("(the file was cut in it)"), "{answer:#?}");
    assert_eq!(samples(&bench, "run.mcap"), all[..kept]);
    assert_eq!(std::fs::read(bench.path().join("run.mcap.partial")).expect("read"), whole[..whole.len() / 2]);
    // It has its end and its index again, and does not pretend to be the whole run.
    let bytes = std::fs::read(bench.path().join("run.mcap")).expect("read");
    let summary = mcap::Summary::read(&bytes).expect("an MCAP file").expect("with a summary");
    assert_eq!(summary.stats.expect("statistics").message_count, 1 + 4 * kept as u64);
    let info = bench.call(&["info", "run.mcap", "--json"]).code(0).json();
    assert_eq!((&info["state"], &info["complete"]), (&"recovered".into(), &false.into()));
    assert_eq!(info["recovered"]["samples"], kept);
    assert_eq!(info["attachments"][0]["name"], "scenario.toml");
    // Nothing that is there is overwritten unasked.
    let again = bench.call(&["recover", "run.mcap.partial"]).code(2);
    assert!(again.err.contains("`run.mcap` is there already"), "{again:#?}");
    let json = bench.call(&["recover", "run.mcap.partial", "--out", "run.mcap", "--json"]).code(0).json();
    assert_eq!((&json["samples"], &json["messages"]), (&kept.into(), &(1 + 4 * kept).into()));
    let itself = bench.call(&["recover", "run.mcap.partial", "--out", "run.mcap.partial"]).code(2);
    assert!(itself.err.contains("what is being recovered"), "{itself:#?}");
    assert!(bench.call(&["recover", "whole.mcap"]).code(0).out.contains("nothing to recover"));
}

#[test]
fn a_damaged_chunk_costs_its_own_samples_only() {
    let bench = Bench::new();
    record(&bench, "whole.mcap", &["--set", "record.rate=4000"]);
    let mut bytes = std::fs::read(bench.path().join("whole.mcap")).expect("read");
    let all = samples(&bench, "whole.mcap");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x55;
    bench.write("bad.mcap", &bytes);
    let info = bench.call(&["info", "bad.mcap", "--json"]).code(1).json();
    assert_eq!(info["state"], "damaged");
    let answer = bench.call(&["recover", "bad.mcap", "--json"]).code(0).json();
    assert_eq!(answer["recording"], "bad.recovered.mcap");
    let lost = answer["lost"].as_array().expect("lost");
    assert_eq!(lost.len(), 1, "{answer}");
    let saved = samples(&bench, "bad.recovered.mcap");
    let outside = |sample: &&OwnedSample| {
        // Chunks hold whole samples; their headers tell times to the nanosecond.
        let ends = [0, 1].map(|end| lost[0]["span"][end].as_f64().expect("a time"));
        sample.time < ends[0] - 1e-9 || sample.time > ends[1] + 1e-9
    };
    assert_eq!(saved, all.iter().filter(outside).cloned().collect::<Vec<_>>());
    assert!(saved.len() < all.len() && saved.last() == all.last());
}

#[test]
fn tables_hold_every_digit_and_name_their_units() {
    let bench = Bench::new();
    record(&bench, "a.mcap", &[]);
    let all = samples(&bench, "a.mcap");
    bench.call(&["export", "a.mcap", "--csv", "tables", "--quiet"]).code(0);
    let mut names: Vec<_> = std::fs::read_dir(bench.path().join("tables"))
        .expect("a folder")
        .map(|f| f.expect("a file").file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["energy.csv", "hinges.csv", "reactions.csv", "tf.csv"]);
    let text = std::fs::read_to_string(bench.path().join("tables/hinges.csv")).expect("a table");
    let mut lines = text.lines();
    let head = "time [s],upper.angle [rad],lower.angle [rad],upper.rate [rad/s],lower.rate [rad/s],upper.rate_dot [rad/s²],lower.rate_dot [rad/s²]";
    assert_eq!(lines.next(), Some(head));
    for (line, sample) in lines.zip(&all) {
        let read: Vec<u64> = line.split(',').map(|field| field.parse::<f64>().expect("a number").to_bits()).collect();
        let kept = [sample.time]
            .into_iter()
            .chain(sample.positions.iter().chain(&sample.velocities).chain(&sample.accelerations).copied());
        assert_eq!(read, kept.map(f64::to_bits).collect::<Vec<_>>());
    }
    assert_eq!(text.lines().count(), 1 + all.len());
    // One file with what is asked for.
    let one = bench.call(&[
        "export",
        "a.mcap",
        "--csv",
        "one.csv",
        "--channel",
        "lower.angle",
        "--channel",
        "/energy",
        "--json",
    ]);
    assert_eq!(one.code(0).json()["files"][0], serde_json::json!({ "file": "one.csv", "rows": 201, "columns": 7 }));
    let text = std::fs::read_to_string(bench.path().join("one.csv")).expect("a table");
    assert!(text.starts_with("time [s],lower.angle [rad],kinetic [J],potential [J],"), "{text}");
    let wrong = bench.call(&["export", "a.mcap", "--csv", "x.csv", "--channel", "lower.angel"]).code(2);
    assert!(wrong.err.contains("did you mean `lower.angle`?"), "{wrong:#?}");
    let nowhere = bench.call(&["export", "a.mcap", "--csv", "nowhere/x.csv"]).code(2);
    assert!(nowhere.err.contains("cannot write `nowhere/x.csv`"), "{nowhere:#?}");
    // `-o` says by its ending what is written.
    bench.call(&["export", "a.mcap", "-o", "same.csv", "--channel", "lower.angle", "--channel", "/energy"]).code(0);
    assert_eq!(std::fs::read_to_string(bench.path().join("same.csv")).expect("a table"), text);
    let other = bench.call(&["export", "a.mcap", "-o", "x.txt"]).code(2);
    assert!(other.err.contains("`x.txt`: the name of a table ends in .csv or .parquet"), "{other:#?}");
    assert_eq!(bench.names(), ["a.mcap", "one.csv", "same.csv", "tables"]);
}

#[cfg(not(feature = "parquet"))]
#[test]
fn a_program_without_parquet_says_so() {
    let bench = Bench::new();
    record(&bench, "a.mcap", &[]);
    let answer = bench.call(&["export", "a.mcap", "--parquet", "a.parquet"]).code(2);
    assert!(answer.err.contains("--features parquet"), "{answer:#?}");
}

#[test]
fn a_plot_has_the_names_and_units_of_its_lines() {
    let bench = Bench::new();
    record(&bench, "a.mcap", &[]);
    record(&bench, "b.mcap", &["--set", "upper.position=1"]);
    let answer = bench.call(&["plot", "a.mcap", "b.mcap", "upper.angle", "kinetic", "-o", "x.svg"]).code(0);
    assert_eq!(answer.out, "x.svg: 4 lines\n");
    let svg = std::fs::read_to_string(bench.path().join("x.svg")).expect("a picture");
    for label in ["a.mcap: upper.angle (rad)", "b.mcap: kinetic (J)", "Chaotic double pendulum", "time (s)"] {
        assert!(svg.contains(label), "{label}");
    }
    bench.call(&["plot", "a.mcap", "tf"]).code(0);
    assert!(bench.names().contains(&"a.svg".to_owned()));
    let hint = |arguments: &[&str]| bench.call(arguments).code(2).err;
    assert!(hint(&["plot", "a.mcap", "uper.angle"]).contains("did you mean `upper.angle`?"));
    assert!(hint(&["plot", "a.mcap", "rate"]).contains("upper.rate, lower.rate, upper.rate_dot"));
    let names = hint(&["plot", "a.mcap"]);
    assert!(
        names.contains("\n  hinges       upper.angle, lower.angle, ") && names.contains("\n  energy       kinetic"),
        "{names}"
    );
    assert!(
        names.contains("hint: `stillpoint plot a.mcap upper.angle`") && names.lines().all(|line| line.len() < 150),
        "{names}"
    );
    assert!(hint(&["plot", "upper.angle"]).contains("`upper.angle` is no recording"));
    // Cut in its only chunk: there is nothing to draw, and no empty picture of it.
    let whole = std::fs::read(bench.path().join("a.mcap")).expect("read");
    bench.write("cut.mcap", &whole[..whole.len() / 2]);
    assert!(hint(&["plot", "cut.mcap", "upper.angle"]).contains("there are no samples in it"));
    assert!(!bench.names().contains(&"cut.svg".to_owned()));
}

/// An output with several numbers is plotted with all of them; along x stands one.
#[test]
fn all_numbers_of_an_output_are_plotted_by_its_name() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        "[simulate]\nstart = \"given\"\nduration = 0.1\n[[body]]\nname = \"m\"\nmass = 1.0\n\
         hinge = { type = \"prismatic\", axis = [1, 0, 0] }\n\
         [[output]]\nname = \"tip\"\ntype = \"position\"\nof = \"m\"\n",
    );
    bench.call(&["run", "scene.toml", "--out", "run.mcap", "--quiet"]).code(0);
    assert_eq!(bench.call(&["plot", "run.mcap", "tip", "-o", "x.svg"]).code(0).out, "x.svg: 3 lines\n");
    let said = |arguments: &[&str]| bench.call(&[&["plot", "run.mcap"], arguments].concat()).code(2).err;
    assert!(said(&["tap"]).contains("did you mean `tip`?"));
    assert!(said(&["kinetic", "--x", "tip"]).contains("name one of `tip[0]`, `tip[1]`, `tip[2]`"));
}

/// What a reader of a table has not taken is no error.
#[test]
fn a_reader_that_leaves_ends_the_export_in_silence() {
    let bench = Bench::new();
    record(&bench, "a.mcap", &["--set", "record.rate=2000"]);
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_stillpoint"));
    let piped = std::process::Stdio::piped;
    let call = ["export", "a.mcap", "--csv", "-"];
    let mut child =
        command.current_dir(bench.path()).args(call).stdout(piped()).stderr(piped()).spawn().expect("a process");
    drop(child.stdout.take());
    let answer = child.wait_with_output().expect("an answer");
    assert!(answer.status.success() && answer.stderr.is_empty(), "{answer:?}");
}

#[test]
fn comparison_finds_the_largest_difference_and_when() {
    let bench = Bench::new();
    record(&bench, "a.mcap", &[]);
    record(&bench, "b.mcap", &[]);
    let same = bench.call(&["compare", "a.mcap", "b.mcap"]).code(0);
    assert!(same.out.contains("37 columns are the same to the last bit"), "{same:#?}");
    // Another start, and half the samples.
    record(&bench, "c.mcap", &["--set", "upper.position=1.5707963", "--set", "record.rate=50"]);
    let find = |answer: &Value, name: &str| {
        let columns = answer["columns"].as_array().expect("columns");
        columns.iter().find(|column| column["name"] == name).cloned().expect("a column")
    };
    let apart = bench.call(&["compare", "a.mcap", "c.mcap", "--json"]).code(1).json();
    assert_eq!(
        (&apart["common_samples"], &apart["only_first"], &apart["only_second"]),
        (&101.into(), &100.into(), &0.into())
    );
    let (a, c) = (samples(&bench, "a.mcap"), samples(&bench, "c.mcap"));
    let mut largest = (0.0, f64::NAN);
    for (one, other) in a.iter().step_by(2).zip(&c) {
        let apart = (one.positions[1] - other.positions[1]).abs();
        if apart > largest.0 {
            largest = (apart, one.time);
        }
    }
    let lower = find(&apart, "lower.angle");
    // What reads JSON here may round the last digit.
    let told = lower["largest"].as_f64().expect("a number");
    assert!((told / largest.0 - 1.0).abs() < 1e-15 && lower["time"].as_f64() == Some(largest.1), "{told} {largest:?}");
    let wide = format!("{}", largest.0);
    bench.call(&["compare", "a.mcap", "c.mcap", "--channel", "lower.angle", "--tolerance", &wide]).code(0);
    let narrow = format!("{}", 0.99 * largest.0);
    bench.call(&["compare", "a.mcap", "c.mcap", "--channel", "lower.angle", "--tolerance", &narrow]).code(1);
    // Another scene has other columns.
    bench.call(&["run", &shipped("pencil"), "--quiet", "--out", "d.mcap", "--set", "simulate.duration=2"]).code(0);
    let other = bench.call(&["compare", "a.mcap", "d.mcap"]).code(1);
    assert!(other.out.contains("not in d.mcap: upper.angle"), "{other:#?}");
    assert!(bench.call(&["compare", "a.mcap", "b.mcap", "--tolerance", "-1"]).code(2).err.contains("≥ 0"));
    assert!(bench.call(&["compare", "a.mcap", "none.mcap"]).code(2).err.contains("none.mcap"));
}

#[cfg(unix)]
#[test]
fn a_recording_that_is_being_written_is_left_to_its_run() {
    let bench = Bench::new();
    record(&bench, "a.mcap", &[]);
    let partial = bench.path().join("b.mcap.partial");
    std::fs::copy(bench.path().join("a.mcap"), &partial).expect("copied");
    let held = std::fs::File::options().write(true).open(&partial).expect("opened");
    held.lock().expect("locked");
    let answer: Answer = bench.call(&["recover", "b.mcap.partial", "--out", "b.mcap"]).code(2);
    assert!(answer.err.contains("still being written"), "{answer:#?}");
    assert_eq!(bench.names(), ["a.mcap", "b.mcap.partial"]);
}
