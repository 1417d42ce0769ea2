//! Recordings and their tables as Python sees them: polars, pyarrow, and the official MCAP reader.

use super::{Bench, shipped};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use stillpoint::record::{OwnedSample, Recording};

/// What a script of `tests/python` prints.
fn run(script: &str, arguments: &[PathBuf]) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python").join(script);
    let output = Command::new("python3").arg(script).args(arguments).output().expect("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
#[ignore = "needs Python with tests/python/requirements.txt"]
fn the_schema_takes_every_scenario_and_refuses_broken_ones() {
    let bench = Bench::new();
    let schema = bench.call(&["schema"]).code(0).out;
    bench.write("schema.json", schema);
    let folder = PathBuf::from(shipped("pendulum")).parent().expect("the folder").to_owned();
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("listed").map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    let count = files.len();
    assert!(count > 20, "{count} scenarios");
    for kind in ["pendulum", "chain", "robot", "linkage"] {
        let name = format!("new {kind}.toml");
        bench.call(&["new", &name, "--kind", kind, "--quiet"]).code(0);
        files.push(bench.path().join(name));
    }
    let pendulum = std::fs::read_to_string(shipped("pendulum")).expect("a text");
    let broken = [
        ("key", pendulum.replace("mass =", "mas =")),
        ("type", pendulum.replace("[[body]]\nname = \"rod\"", "[[body]]\nname = 3")),
        ("hinge", pendulum.replace("\"revolute\"", "\"revolt\"")),
        ("range", format!("{}\n[record]\nrate = -1.0\n", pendulum.replace("[record]", "[ignored]"))),
        ("list", format!("gravity = [0.0, -9.81]\n{pendulum}")),
        ("bodies", "body = 3\n".to_owned()),
        ("model", "[model]\nfile = \"arm.urdf\"\nflie = 3\n".to_owned()),
        ("model hinge", "[model]\nfile = \"arm.urdf\"\nhinges = { elbow = { stifness = 3 } }\n".to_owned()),
    ];
    for (name, text) in &broken {
        assert_ne!(*text, pendulum, "{name}");
        let name = format!("broken {name}.toml");
        bench.write(&name, text);
        // Ours finds it too.
        bench.call(&["check", &name]).code(2);
        files.push(bench.path().join(name));
    }
    files.insert(0, bench.path().join("schema.json"));
    let found = run("check_schema.py", &files);
    let answers = found.as_object().expect("an answer for each");
    assert_eq!(answers.len(), count + 4 + broken.len());
    for (name, error) in answers {
        assert_eq!(error.is_null(), !name.starts_with("broken"), "{name}: {error}");
    }
    // The key is named, not only that nothing fits.
    for (name, key) in [("broken model.toml", "'flie'"), ("broken model hinge.toml", "'stifness'")] {
        assert!(answers[name].as_str().expect("a message").contains(key), "{}", answers[name]);
    }
}

/// One number of a sample.
type Number = fn(&OwnedSample) -> f64;

#[test]
#[ignore = "needs Python with tests/python/requirements.txt"]
fn python_reads_every_table_to_the_last_bit() {
    let bench = Bench::new();
    let scenario = shipped("double_pendulum");
    bench.call(&["run", &scenario, "--quiet", "--set", "simulate.duration=1", "--out", "a.mcap"]).code(0);
    bench.call(&["export", "a.mcap", "--csv", "csv", "--quiet"]).code(0);
    if cfg!(feature = "parquet") {
        bench.call(&["export", "a.mcap", "--parquet", "parquet", "--quiet"]).code(0);
    }
    let read = run("read_tables.py", &[bench.path().into()]);

    let recording = Recording::open(&bench.path().join("a.mcap")).expect("a recording");
    let samples: Vec<OwnedSample> = recording.samples().expect("samples").map(|sample| sample.expect("one")).collect();
    let bits =
        |number: Number| -> Value { samples.iter().map(|sample| number(sample).to_bits().to_string()).collect() };
    let columns: [(&str, &str, Number); 4] = [
        ("time", "s", |sample| sample.time),
        ("lower.angle", "rad", |sample| sample.positions[1]),
        ("upper.rate", "rad/s", |sample| sample.velocities[0]),
        ("lower.rate_dot", "rad/s²", |sample| sample.accelerations[1]),
    ];
    assert_eq!(samples.len(), 101);
    assert_eq!(read["recording"], bits(columns[1].2));
    assert_eq!(read["csv_types"], serde_json::json!(["Float64"]));
    for (name, unit, number) in columns {
        assert_eq!(read["csv"][format!("{name} [{unit}]")], bits(number), "{name}");
        if cfg!(feature = "parquet") {
            assert_eq!(read["parquet"][name], bits(number), "{name}");
            assert_eq!(read["units"][name], unit);
        }
    }
}

#[cfg(feature = "parquet")]
#[test]
#[ignore = "needs Python with tests/python/requirements.txt"]
fn datasets_are_read_by_duckdb_polars_and_pyarrow() {
    let bench = Bench::new();
    bench.write("scale.toml", super::SCALE);
    // Some of the masses make no scene: empty cells and words beside numbers.
    let vary = ["--vary", "pan.mass=normal(1,0.8)", "--over", "statics.want=any,stable"];
    let how = ["--cases", "150", "--out", "set", "--json"];
    let answer = bench.call(&[&["sweep", "scale.toml"][..], &vary, &how].concat()).code(1).json();
    let found = run("read_dataset.py", &[bench.path().join("set")]);
    assert_eq!(found["failed"], answer["failed"]);
    let column = |name: &str| found["columns"][name].as_array().unwrap_or_else(|| panic!("{name}")).clone();
    let number = |bits: &Value| bits.as_str().map(|bits| f64::from_bits(bits.parse().expect("bits")));
    assert!(column("case").iter().enumerate().all(|(index, case)| *case == index) && column("case").len() == 300);
    for index in 0..300 {
        let mass = number(&column("pan.mass")[index]).expect("a mass");
        let sunk = number(&column("pan.distance")[index]);
        assert_eq!(sunk.is_some(), column("ok")[index] == true);
        assert_eq!(column("error")[index].is_string(), sunk.is_none());
        assert!(sunk.is_none_or(|sunk| (sunk + mass * 9.80665 / 100.0).abs() < 1e-12));
        assert_eq!(column("statics.want")[index], if index < 150 { "any" } else { "stable" });
    }
    assert_eq!((&found["units"]["pan.distance"], &found["units"]["wall_seconds"]), (&"m".into(), &"s".into()));
}
