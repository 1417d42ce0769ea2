//! Datasets: rows are what `statics` and `run` answer, and nothing loses them.

use super::{Answer, Bench, SCALE, shipped};
use crate::common::Random;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, RecordBatch};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;
use stillpoint::study::parquet::told;

/// The files of a dataset with this ending, in order.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("an entry").path());
    let mut found: Vec<PathBuf> = entries.filter(|path| path.to_string_lossy().ends_with(ending)).collect();
    found.sort();
    found
}

fn cell(column: &dyn Array, row: usize) -> Value {
    if column.is_null(row) {
        return Value::Null;
    }
    match column.data_type() {
        arrow_schema::DataType::Float64 => json!(column.as_primitive::<Float64Type>().value(row)),
        arrow_schema::DataType::Int64 => json!(column.as_primitive::<Int64Type>().value(row)),
        arrow_schema::DataType::Boolean => json!(column.as_boolean().value(row)),
        _ => json!(column.as_string::<i32>().value(row)),
    }
}

/// All rows of a dataset in the order of the cases, without times of the clock.
pub(super) fn rows(folder: &Path) -> Vec<Map<String, Value>> {
    let mut rows = Vec::new();
    for path in files(folder, ".parquet") {
        let file = File::open(&path).expect("a part");
        let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("Parquet").build().expect("rows");
        for batch in reader {
            let batch: RecordBatch = batch.expect("rows");
            let schema = batch.schema();
            rows.extend((0..batch.num_rows()).map(|row| {
                let named = schema.fields().iter().zip(batch.columns());
                let timeless = named.filter(|(field, _)| !field.name().starts_with("wall_"));
                timeless.map(|(field, column)| (field.name().clone(), cell(column, row))).collect()
            }));
        }
    }
    rows.sort_by_key(|row: &Map<String, Value>| row["case"].as_i64());
    assert!(rows.iter().enumerate().all(|(index, row)| row["case"] == index), "every case once");
    rows
}

/// A random chain with whatever statics reports: springs, stops, locks, motors, dampers; one hinge may have no
/// equilibrium, so that some cases fail.
fn random_scene(random: &mut Random) -> (String, Vec<String>) {
    let mut text = String::from("[simulate]\nduration = 0.2\n");
    let count = 1 + random.below(4);
    let mut addresses = Vec::new();
    let mut more = String::new();
    for i in 0..count {
        let parent = if i == 0 || random.below(3) == 0 { "ground".to_owned() } else { format!("b{}", i - 1) };
        let kind = ["revolute", "prismatic", "planar", "spherical", "universal"][random.below(5)];
        let single = random.below(2) == 0;
        let kind = if single { ["revolute", "prismatic"][random.below(2)] } else { kind };
        let one = matches!(kind, "revolute" | "prismatic");
        let axes = match kind {
            "universal" => "axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], ",
            "revolute" | "prismatic" => "axis = [0.0, 0.6, 0.8], ",
            _ => "",
        };
        let mut hinge =
            format!("type = \"{kind}\", parent = \"{parent}\", {axes}stiffness = {:.3}", random.between(20.0, 90.0));
        if random.below(2) == 0 {
            let _ = write!(hinge, ", damping = {:.3}", random.between(0.1, 3.0));
        }
        if one {
            match random.below(5) {
                0 => hinge += ", lock = true",
                1 => hinge += ", limits = [-0.01, 0.01]",
                2 => {
                    let _ = writeln!(
                        more,
                        "[[motor]]\nname = \"m{i}\"\nhinge = \"b{i}\"\ntype = \"constant\"\nforce = {:.3}\n",
                        random.between(-1.0, 1.0)
                    );
                    addresses.push(format!("m{i}.force"));
                }
                _ => {}
            }
        }
        let _ = writeln!(
            text,
            "[[body]]\nname = \"b{i}\"\nmass = {:.3}\ncenter = [{:.3}, 0.1, {:.3}]\ninertia = [0.3, 0.2, 0.25]\nhinge = {{ {hinge} }}\n",
            random.between(0.5, 2.0),
            random.between(-0.3, 0.3),
            random.between(-0.3, 0.3),
        );
        addresses.extend([format!("b{i}.mass"), format!("b{i}.stiffness"), format!("b{i}.center[0]")]);
    }
    (format!("{text}{more}"), addresses)
}

/// What a row has to hold, from the JSON of `statics`.
fn expected(statics: &Value) -> Map<String, Value> {
    let mut found = Map::new();
    let mut put = |name: String, value: &Value| {
        found.insert(name, value.clone());
    };
    for key in ["stability", "residual_force", "residual_acceleration", "iterations"] {
        put(key.to_owned(), &statics[key]);
    }
    for (index, value) in statics["frequencies_hz"].as_array().expect("a list").iter().enumerate() {
        put(format!("frequencies_hz[{index}]"), value);
    }
    for (index, mode) in statics["damped_modes"].as_array().expect("a list").iter().enumerate() {
        put(format!("damping_ratios[{index}]"), &mode["damping_ratio"]);
        put(format!("damped_frequencies_hz[{index}]"), &mode["frequency_hz"]);
    }
    for (name, value) in statics["motors"].as_object().expect("a map") {
        put(format!("motors.{name}"), value);
    }
    for one in statics["holding"].as_array().expect("a list") {
        put(format!("holding.{}", one["hinge"].as_str().expect("a name").trim_matches('`')), &one["force"]);
    }
    for one in statics["stops"].as_array().expect("a list") {
        let (hinge, side) = (one["hinge"].as_str().expect("a name"), one["side"].as_str().expect("a side"));
        put(format!("stops.{}.{side}", hinge.trim_matches('`')), &one["load"]);
    }
    found
}

/// The coordinates of a body in a row, in order.
fn pose_columns(row: &Map<String, Value>, body: &str) -> Vec<Value> {
    let own = |name: &str| name.strip_prefix(body).and_then(|rest| rest.strip_prefix('.')).is_some();
    let inputs = ["mass", "stiffness", "center[0]"];
    row.iter()
        .filter(|(name, _)| own(name) && !inputs.iter().any(|key| name.ends_with(key)))
        .map(|(_, v)| v.clone())
        .collect()
}

/// Random scenes, random numbers of theirs: a row is what `statics --set …` and `run --set …` answer, to the last bit.
#[test]
fn a_row_is_what_the_commands_answer() {
    let bench = Bench::new();
    let mut random = Random::new(71);
    let (mut answered, mut refused) = (0, 0);
    for scene in 0..16 {
        let (text, addresses) = random_scene(&mut random);
        bench.write("scene.toml", text);
        let path = addresses[random.below(addresses.len())].clone();
        let with_run = scene % 3 == 0;
        let out = format!("out{scene}");
        // A mass around zero: some of the cases are refused.
        let drawn = if path.ends_with("mass") { "uniform(-0.5, 1)" } else { "uniform(-0.2, 60)" };
        let vary = format!("{path}={drawn}");
        let over = "gravity[2]=-9.81,-1.62";
        let mut call =
            vec!["sweep", "scene.toml", "--over", over, "--vary", &vary, "--cases", "3", "--out", &out, "--quiet"];
        if with_run {
            call.push("--run");
        }
        let answer = bench.call(&call);
        assert!(answer.code < 2, "{answer:?}");
        let code = answer.code;
        let table = rows(&bench.path().join(&out));
        assert_eq!(table.len(), 6);
        assert_eq!(code, i32::from(table.iter().any(|row| row["ok"] == false)));
        for row in table {
            let set = [format!("gravity[2]={}", row["gravity[2]"]), format!("{path}={}", row[&path])];
            let command = if with_run { "run" } else { "statics" };
            let arguments = [command, "scene.toml", "--json", "--set", &set[0], "--set", &set[1]];
            let alone = bench.call(&arguments);
            assert_eq!(alone.code == 0, row["ok"] == true, "{set:?}: {} {alone:?}", row["error"]);
            if alone.code != 0 {
                assert!(row["error"].as_str().is_some_and(|why| !why.is_empty()));
                refused += 1;
                continue;
            }
            let alone = alone.json();
            let statics = if with_run { &alone["start"] } else { &alone };
            for (name, value) in expected(statics) {
                assert_eq!(row.get(&name), Some(&value), "{name} of {set:?} in scene {scene}");
            }
            for (body, list) in statics["positions"].as_object().expect("positions") {
                assert_eq!(json!(pose_columns(&row, body)), *list, "{body}");
            }
            if with_run {
                for key in ["end_time", "steps", "energy_drift"] {
                    assert_eq!(row[key], alone[key], "{key}");
                }
                assert_eq!(row["events"], alone["events"].as_array().expect("a list").len());
                for (body, list) in alone["final"]["positions"].as_object().expect("positions") {
                    assert_eq!(json!(pose_columns(&row, &format!("final {body}"))), *list, "{body}");
                }
            }
            answered += 1;
        }
    }
    assert!(answered > 60 && refused > 2, "{answered} answered, {refused} refused");
}

/// The call of a study that takes some seconds in a debug build.
fn long(out: &str) -> Vec<&str> {
    let vary = ["--vary", "rod.mass=lognormal(1,0.2)", "--vary", "rod.position=uniform(-1,1)", "--sample", "latin"];
    // A mass of zero makes no scene: failures are rows, too.
    let over = ["--over", "gravity[2]=-9.81,-1.62,0.5", "--over", "rod.stiffness=0,1,-1"];
    let mut call = vec!["--cases", "400", "--seed", "9", "--part-rows", "40", "--json", "--out", out];
    call.extend(vary.into_iter().chain(over));
    call
}

#[test]
fn a_killed_study_goes_on_where_it_was() {
    let bench = Bench::new();
    let pendulum = shipped("pendulum");
    let whole = bench.call(&[&["sweep", &pendulum][..], &long("whole")].concat());
    assert_eq!(whole.code, 1, "{whole:?}");
    let exact = rows(&bench.path().join("whole"));
    assert_eq!(exact.len(), 3600);
    let begun = std::time::Instant::now();
    bench.call(&[&["sweep", &pendulum][..], &long("timed")].concat());
    let length = begun.elapsed();
    let mut random = Random::new(std::process::id().into());
    let (mut kills, mut left) = (0, 0);
    for _ in 0..20 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_stillpoint"))
            .args([&["sweep", &pendulum, "--resume"][..], &long("killed")].concat())
            .current_dir(bench.path())
            .stdout(Stdio::null())
            .spawn()
            .expect("the program starts");
        std::thread::sleep(length.mul_f64(random.between(0.02, 0.3)));
        kills += usize::from(child.try_wait().expect("a child").is_none());
        child.kill().expect("killed");
        child.wait().expect("an end");
        left += files(bench.path(), "killed").first().map_or(0, |folder| files(folder, ".partial").len());
    }
    assert!(kills > 3, "{kills} kills");
    let last = bench.call(&[&["sweep", &pendulum, "--resume"][..], &long("killed")].concat());
    assert_eq!(last.code, 1, "{last:?}");
    assert_eq!(last.json()["failed"], whole.json()["failed"]);
    assert_eq!(rows(&bench.path().join("killed")), exact, "{kills} kills, {left} unfinished parts");
    assert_eq!(files(&bench.path().join("killed"), ".partial"), Vec::<PathBuf>::new());
    // Whole now: nothing is done again.
    let again = bench.call(&[&["sweep", &pendulum, "--resume"][..], &long("killed")].concat());
    assert_eq!((again.code, &again.json()["answered"]), (1, &json!(0)));
}

#[cfg(unix)]
#[test]
fn an_interrupted_study_ends_in_good_order() {
    let bench = Bench::new();
    let pendulum = shipped("pendulum");
    let child = Command::new(env!("CARGO_BIN_EXE_stillpoint"))
        .args([&["sweep", &pendulum][..], &long("set")].concat())
        .current_dir(bench.path())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let begun = std::time::Instant::now();
    while !bench.path().join("set/part-0000000.parquet").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no part is written");
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(sent.success());
    let output = child.wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(130));
    assert!(String::from_utf8_lossy(&output.stderr).contains("`--resume` continues it"));
    assert_eq!(files(&bench.path().join("set"), ".partial"), Vec::<PathBuf>::new());
    bench.call(&[&["sweep", &pendulum, "--resume"][..], &long("set")].concat()).code(1);
    assert_eq!(rows(&bench.path().join("set")).len(), 3600);
}

#[test]
fn any_threads_and_any_shards_give_the_same_rows() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let call = |out: &str, more: &[&str]| {
        let vary = ["--vary", "pan.mass=normal(2,0.3)", "--vary", "pan.stiffness=triangular(90,100,130)"];
        let fixed = ["sweep", "scale.toml", "--cases", "150", "--sample", "sobol", "--seed", "4", "--out", out];
        bench.call(&[&fixed[..], &vary, more].concat())
    };
    call("one", &["--threads", "1"]).code(0);
    let exact = rows(&bench.path().join("one"));
    assert_eq!(exact.len(), 150);
    call("two", &["--threads", "2"]).code(0);
    assert_eq!(rows(&bench.path().join("two")), exact);
    for shards in ["1", "3", "7", "200"] {
        let out = format!("shards{shards}");
        let missing = |left: &str| {
            assert_eq!(call(&out, &["--shards", shards, "--missing"]).code(0).out.trim(), left, "{shards}");
        };
        let list: Vec<String> = (0..shards.parse::<u64>().expect("a number").min(75)).map(|k| k.to_string()).collect();
        missing(&list.join(","));
        // Two processes on every shard, the last one first.
        for shard in (0..shards.parse::<u64>().expect("a number")).rev() {
            let shard = shard.to_string();
            if shards.len() < 3 || shard.parse::<u64>().is_ok_and(|shard| shard < 75) {
                call(&out, &["--shards", shards, "--shard", &shard]).code(0);
            }
            if shard == "1" {
                missing("0");
            }
        }
        missing("");
        assert_eq!(rows(&bench.path().join(&out)), exact, "{shards} shards");
    }
    // A part that was lost is missed, and made again.
    std::fs::remove_file(bench.path().join("two/part-0000004.parquet")).expect("removed");
    assert_eq!(call("two", &["--missing"]).code(0).out.trim(), "4");
    assert_eq!(call("two", &["--missing", "--shards", "3"]).code(0).out.trim(), "1");
    call("two", &["--resume"]).code(0);
    assert_eq!(rows(&bench.path().join("two")), exact);
    // Other numbers with another seed.
    let other = ["--seed", "5", "--threads", "2"];
    let vary = ["--vary", "pan.mass=normal(2,0.3)", "--vary", "pan.stiffness=triangular(90,100,130)"];
    let fixed = ["sweep", "scale.toml", "--cases", "150", "--sample", "sobol", "--out", "seed"];
    bench.call(&[&fixed[..], &vary, &other].concat()).code(0);
    assert!(rows(&bench.path().join("seed")).iter().zip(&exact).all(|(a, b)| a["pan.mass"] != b["pan.mass"]));
}

/// A dataset of 40 cases in five parts, in `d`.
const FIVE_PARTS: [&str; 10] =
    ["sweep", "scale.toml", "--vary", "pan.mass=normal(2,0.3)", "--cases", "40", "--out", "d", "--part-rows", "8"];

/// A part that was cut off, damaged at its end or within its numbers, or is none is told, with what to do, by whoever comes to it; done so, the dataset
/// is whole again.
#[test]
fn a_damaged_part_is_told_and_made_again() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let call = |more: &[&str]| bench.call(&[&FIVE_PARTS[..], more].concat());
    call(&[]).code(0);
    let exact = rows(&bench.path().join("d"));
    let part = bench.path().join("d/part-0000002.parquet");
    let whole = std::fs::read(&part).expect("a part");
    let mut random = Random::new(7);
    for kind in 0..16 {
        let cut = random.below(whole.len());
        let damaged = match kind % 4 {
            0 => whole[..cut].to_vec(),
            1 => [&whole[..whole.len() - 8], &[0xff; 8]].concat(),
            2 => {
                // One bit among the numbers, which begin after the first four bytes.
                let mut flipped = whole.clone();
                flipped[4 + cut % 200] ^= 1 << random.below(8);
                flipped
            }
            _ => b"no Parquet".to_vec(),
        };
        std::fs::write(&part, damaged).expect("damaged");
        let missing = call(&["--missing"]).code(0);
        assert_eq!(missing.out.trim(), "2");
        let resumed = call(&["--resume"]).code(2);
        let studied = bench.call(&["study", "d"]).code(2);
        for error in [missing.err, resumed.err, studied.err] {
            assert!(error.contains("part-0000002.parquet` is damaged") && error.contains("delete it"), "{error}");
        }
        std::fs::remove_file(&part).expect("removed");
        call(&["--resume"]).code(0);
        assert_eq!(rows(&bench.path().join("d")), exact);
    }
}

/// One bit of a part is another, wherever: that is told before anything is read from it.
#[test]
fn every_flipped_bit_of_a_part_is_told() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let fixed =
        ["sweep", "scale.toml", "--vary", "pan.mass=normal(2,0.3)", "--cases", "16", "--out", "d", "--part-rows", "8"];
    let call = |more: &[&str]| bench.call(&[&fixed[..], more].concat());
    call(&[]).code(0);
    let part = bench.path().join("d/part-0000001.parquet");
    let whole = std::fs::read(&part).expect("a part");
    let flip = |at: usize| {
        let mut flipped = whole.clone();
        flipped[at] ^= 1 << (at % 8);
        std::fs::write(&part, flipped).expect("damaged");
    };
    for at in 0..whole.len() {
        flip(at);
        assert!(told(File::open(&part).expect("a part")).is_err(), "byte {at} of {}", whole.len());
    }
    for at in (0..whole.len()).step_by(whole.len() / 10) {
        flip(at);
        let missing = call(&["--missing"]).code(0);
        assert_eq!(missing.out.trim(), "1", "byte {at}");
        for error in [missing.err, call(&["--resume"]).code(2).err, bench.call(&["study", "d"]).code(2).err] {
            assert!(error.contains("part-0000001.parquet` is damaged") && error.contains("delete it"), "{at}: {error}");
        }
    }
}

/// Files in the folder that would be read as rows and are no parts are refused by whoever comes to it, as are parts without a manifest.
#[test]
fn files_beside_the_parts_are_refused() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let call = |more: &[&str]| bench.call(&[&FIVE_PARTS[..], more].concat());
    call(&[]).code(0);
    let folder = bench.path().join("d");
    for name in ["part-0000099.parquet", "part-3.parquet", "copy of part-0000003.parquet", "part-0000005.parquet"] {
        std::fs::copy(folder.join("part-0000003.parquet"), folder.join(name)).expect("copied");
        for answer in [call(&["--missing"]), call(&["--resume"]), bench.call(&["study", "d"])] {
            let error = answer.code(2).err;
            assert!(error.contains(&format!("{name}` is no part of this dataset")) && error.contains("move it away"));
            assert!(error.contains("part-0000000.parquet to part-0000004.parquet"), "{error}");
        }
        std::fs::remove_file(folder.join(name)).expect("removed");
    }
    call(&["--resume"]).code(0);
    std::fs::rename(folder.join("_study.json"), folder.join("other.json")).expect("renamed");
    for answer in [call(&["--missing"]), call(&["--resume"]), bench.call(&["study", "d"])] {
        assert!(answer.code(2).err.contains("_study.json`"));
    }
}

/// A part under the name of another, one of another plan, and one that no plan has are refused by whoever comes to them, by name; what they
/// stand for is computed once they are away.
#[test]
fn parts_of_another_study_are_refused() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let call = |out: &str, mass: &str, more: &[&str]| {
        let vary = format!("pan.mass={mass}");
        let fixed = ["sweep", "scale.toml", "--vary", &vary, "--cases", "40", "--out", out, "--part-rows", "8"];
        bench.call(&[&fixed[..], more].concat())
    };
    let (own, other) = ("normal(2,0.3)", "normal(3,0.3)");
    call("d", own, &[]).code(0);
    call("e", other, &[]).code(0);
    let exact = rows(&bench.path().join("d"));
    let place = |name: &str| bench.path().join(name);
    let told = |called: &str, why: &str| {
        for answer in [call("d", own, &["--missing"]), call("d", own, &["--resume"]), bench.call(&["study", "d"])] {
            let error = answer.code(2).err;
            assert!(error.contains(&format!("{called}` is no part of this dataset")) && error.contains(why), "{error}");
        }
    };
    std::fs::copy(place("d/part-0000003.parquet"), place("d/part-0000002.parquet")).expect("copied");
    told("part-0000002.parquet", "it has cases 24 to 31 of this study, not cases 16 to 23");
    std::fs::copy(place("e/part-0000002.parquet"), place("d/part-0000002.parquet")).expect("copied");
    told("part-0000002.parquet", "it has cases 16 to 23 of another study (hash ");
    std::fs::remove_file(place("d/part-0000002.parquet")).expect("removed");
    call("d", own, &["--resume"]).code(0);
    assert_eq!(rows(&place("d")), exact);
}

/// Parts of earlier versions do not say what they belong to and have no sum: they count, and it is said.
#[test]
fn parts_that_do_not_say_what_they_are_are_told() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let call = |more: &[&str]| bench.call(&[&FIVE_PARTS[..], more].concat());
    call(&[]).code(0);
    let exact = rows(&bench.path().join("d"));
    let part = bench.path().join("d/part-0000002.parquet");
    let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(&part).expect("a part")).expect("Parquet");
    let schema = builder.schema().clone();
    let batches: Vec<RecordBatch> = builder.build().expect("rows").map(|batch| batch.expect("rows")).collect();
    let failed = parquet::file::metadata::KeyValue::new("failed".to_owned(), "0".to_owned());
    let properties =
        parquet::file::properties::WriterProperties::builder().set_key_value_metadata(Some(vec![failed])).build();
    let file = File::create(&part).expect("a part");
    let mut writer = parquet::arrow::ArrowWriter::try_new(file, schema, Some(properties)).expect("a writer");
    batches.iter().for_each(|batch| writer.write(batch).expect("rows"));
    writer.close().expect("written");
    for answer in [call(&["--missing"]), call(&["--resume"]), bench.call(&["study", "d"])] {
        let error = answer.code(0).err;
        assert!(error.contains("1 part does not say which study they belong to"), "{error}");
    }
    assert_eq!(rows(&bench.path().join("d")), exact);
}

/// A kill while the manifest is written leaves it unfinished: whoever continues removes that, with a manifest and without.
#[test]
fn unfinished_manifests_are_removed() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let call = ["sweep", "scale.toml", "--over", "pan.mass=1:2:8", "--out", "d", "--resume"];
    std::fs::create_dir(bench.path().join("d")).expect("a folder");
    for _ in 0..2 {
        for name in ["_study.json.partial", "_study.2.json.partial"] {
            std::fs::write(bench.path().join("d").join(name), "{ \"format\"").expect("written");
        }
        bench.call(&call).code(0);
        assert_eq!(files(&bench.path().join("d"), ".partial"), Vec::<PathBuf>::new());
        assert_eq!(rows(&bench.path().join("d")).len(), 8);
    }
}

/// What has to be there at the start are the addresses and numbers that fit somewhere: cases that make no scene are rows, whatever the
/// middle of the plan is and in whatever order its numbers come.
#[test]
fn a_plan_begins_if_any_of_its_numbers_may_stand_there() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let call = |text: &str| bench.call(&[&["sweep", "scale.toml"][..], &text.split(' ').collect::<Vec<_>>()].concat());
    let plans = [
        "--vary pan.mass=uniform(-100,100) --cases 40",
        "--vary pan.mass=uniform(-100000g,100000g) --cases 40",
        "--vary pan.axis[0]=uniform(-1,1) --vary pan.axis[1]=uniform(-1,1) --vary pan.axis[2]=uniform(-1,1) --cases 40",
        "--over pan.mass=-1,2",
        "--over pan.mass=2,-1",
        "--over statics.want=nothing,any --over pan.mass=0,2",
    ];
    for (index, plan) in plans.iter().enumerate() {
        let out = format!("plan{index}");
        let answer = call(&format!("{plan} --out {out}"));
        assert!([0, 1].contains(&answer.code), "{plan}: {}", answer.err);
        let rows = rows(&bench.path().join(&out));
        assert!(rows.iter().any(|row| row["ok"] == true), "{plan}");
        assert!(rows.iter().all(|row| row["ok"] == true || row["error"].as_str().is_some_and(|why| !why.is_empty())));
    }
    for plan in [
        "--vary pan.mas=uniform(-100,100) --cases 4 --out no",
        "--vary pan.name=uniform(-100,100) --cases 4 --out no",
        "--vary pan.mass=uniform(-100m,100m) --cases 4 --out no",
        "--vary pan.mass=uniform(-100,-1) --cases 4 --out no",
        "--over pan.axis[3]=1,2 --out no",
        "--over statics.want=nothing,never --out no",
    ] {
        call(plan).code(2);
    }
}

/// Two processes write the same shard at once, and both are content.
#[test]
fn two_processes_may_share_a_shard() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let start = |out: &str| {
        let vary = ["--vary", "pan.mass=normal(2,0.3)", "--cases", "600", "--part-rows", "5", "--quiet"];
        Command::new(env!("CARGO_BIN_EXE_stillpoint"))
            .args([&["sweep", "scale.toml", "--out", out, "--shards", "1", "--shard", "0"][..], &vary].concat())
            .current_dir(bench.path())
            .spawn()
            .expect("the program starts")
    };
    let children = [start("both"), start("both"), start("both"), start("alone")];
    for mut child in children {
        assert_eq!(child.wait().expect("an end").code(), Some(0));
    }
    assert_eq!(rows(&bench.path().join("both")), rows(&bench.path().join("alone")));
    assert_eq!(files(&bench.path().join("both"), ".partial"), Vec::<PathBuf>::new());
}

#[test]
fn engines_say_which_shard_it_is() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let arguments = ["sweep", "scale.toml", "--over", "pan.mass=1:2:8", "--out", "set", "--shards", "4"];
    let of = |set: &[(&str, &str)]| {
        let mut command = bench.command(&arguments);
        ["HQ_TASK_ID", "JOB_COMPLETION_INDEX", "SLURM_ARRAY_TASK_ID"].into_iter().for_each(|name| {
            command.env_remove(name);
        });
        Answer::of(command.envs(set.iter().copied()))
    };
    assert!(of(&[]).code(2).err.contains("say which shard this is, 0 to 3"));
    assert!(of(&[("HQ_TASK_ID", "4")]).code(2).err.contains("0 to 3"));
    assert_eq!(bench.names(), ["scale.toml"]);
    assert!(of(&[("HQ_TASK_ID", "3")]).code(0).err.contains("shard 3 of 0 to 3, by HQ_TASK_ID=3"));
    assert!(of(&[("JOB_COMPLETION_INDEX", "0")]).code(0).err.contains("JOB_COMPLETION_INDEX=0"));
    let slurm = |task| [("SLURM_ARRAY_TASK_ID", task), ("SLURM_ARRAY_TASK_MIN", "1"), ("SLURM_ARRAY_TASK_MAX", "4")];
    assert!(of(&slurm("2")).code(0).err.contains("shard 1 "));
    assert!(of(&slurm("3")).code(0).err.contains("shard 2 "));
    assert_eq!(rows(&bench.path().join("set")).len(), 8);
}

#[test]
fn what_makes_no_dataset_is_refused_and_nothing_is_overwritten() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    bench.write("matrix.csv", "pan.mass,pan.stiffness\n1,1\n1,1\n");
    bench.write("matrix.txt", "");
    let call = |text: &str| bench.call(&[&["sweep", "scale.toml"][..], &text.split(' ').collect::<Vec<_>>()].concat());
    let refused = |text: &str, word: &str| {
        let error = call(text).code(2).err;
        assert!(error.contains(word), "{text}: {error}");
    };
    let two = "--vary pan.mass=normal(2,0.1) --vary pan.stiffness=normal(100,1) --cases 5";
    refused("--vary pan.mas=normal(1,0.1) --cases 5 --out d", "did you mean `mass`?");
    refused("--vary pan.mass=normal(1,-0.1) --cases 5 --out d", "is not negative");
    refused("--vary pan.mass=normal(1m,0.1m) --cases 5 --out d", "kg");
    refused("--vary pan.mass=normal(1,0.1) --out d", "--cases");
    refused("--over pan.mass=1,2 --cases 5 --out d", "--vary");
    refused("--vary pan.mass=normal(1,0.1) --cases 0 --out d", "0");
    refused(&format!("{two} --correlate matrix.csv --out d"), "matrix.csv: it is not positive definite");
    refused(&format!("{two} --correlate none.csv --out d"), "none.csv");
    refused("--over pan.mass=1,2 --out d --shards 2 --shard 2", "0 to 1");
    refused("--over pan.mass=1,2 --out d --shard 1", "--shards");
    refused("--over pan.mass=1,2 --out d.csv --resume", "needs a dataset");
    refused("--over pan.mass=1,2 --out scale.toml", "it would replace");
    refused("--over pan.mass=1,2 --out matrix.txt", "is a file");
    refused("--over pan.mass=1,2 --vary pan.mass=normal(1,1) --cases 2 --out d", "twice");
    refused("--vary pan.mass=normal(1,1) --cases 2000000000 --out d", "from 1 to 1000000000");
    assert_eq!(bench.names(), ["matrix.csv", "matrix.txt", "scale.toml"], "nothing was begun");
    call("--over pan.mass=1,2 --out d").code(0);
    let before = rows(&bench.path().join("d"));
    refused("--over pan.mass=1,2 --out d", "`--resume` continues it");
    refused("--over pan.mass=1,3 --out d", "another plan");
    refused("--over pan.mass=1,3 --out d --resume", "another plan");
    refused("--over pan.mass=1,3 --out d --missing", "another plan");
    refused("--over pan.mass=1,2 --out d --resume --run", "another plan");
    refused("--over pan.mass=1,2 --out d --shards 2 --shard 0 --part-rows 2", "another plan");
    bench.write("scale.toml", format!("{SCALE}\n# changed\n"));
    refused("--over pan.mass=1,2 --out d --resume", "another plan");
    bench.write("scale.toml", SCALE);
    assert_eq!(rows(&bench.path().join("d")), before);
    std::fs::rename(bench.path().join("d/_study.json"), bench.path().join("d/other.json")).expect("renamed");
    refused("--over pan.mass=1,2 --out d --resume", "no `_study.json`");
    bench.write("d/_study.json", "{");
    refused("--over pan.mass=1,2 --out d --resume", "no manifest");
    assert_eq!(rows(&bench.path().join("d")), before);
    // Nothing is asked of `--resume` but that the plan is the same: an empty folder begins.
    std::fs::create_dir(bench.path().join("e")).expect("a folder");
    call("--over pan.mass=1,2 --out e --resume").code(0);
}

/// A disk that is full, by a limit on the size of files: the parts that fit stay, and the others follow once there is room.
#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_and_no_loss() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let study = "sweep scale.toml --vary 'pan.mass=normal(2,0.1)' --cases 3000 --part-rows 2000 --out d --resume";
    let limited = format!("ulimit -f 64; exec {} {study}", env!("CARGO_BIN_EXE_stillpoint"));
    let output = Command::new("sh").args(["-c", &limited]).current_dir(bench.path()).output().expect("a shell");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    // Two threads write the two parts: either may be the first that does not fit.
    assert!(error.contains("is not complete") && error.contains("part-000000"), "{error}");
    assert!(!error.contains("panicked"), "{error}");
    assert_eq!(files(&bench.path().join("d"), ".partial"), Vec::<PathBuf>::new());
    bench.call(&study.replace('\'', "").split(' ').collect::<Vec<_>>()).code(0);
    assert_eq!(rows(&bench.path().join("d")).len(), 3000);
    let full = bench.call(&["sweep", "scale.toml", "--over", "pan.mass=1:2:2000", "--out", "/dev/full"]);
    assert!(full.code == 2 && full.err.contains("/dev/full"), "{full:?}");
}

#[test]
fn a_case_that_takes_too_long_is_a_row() {
    let bench = Bench::new();
    let chain = shipped("hanging_chain");
    let long =
        ["--run", "--set", "simulate.start=given", "--over", "simulate.duration=0.001,10000", "--time-limit", "0.5"];
    let begun = std::time::Instant::now();
    bench.call(&[&["sweep", &chain, "--out", "d"][..], &long].concat()).code(1);
    assert!(begun.elapsed() < Duration::from_secs(60));
    let rows = rows(&bench.path().join("d"));
    assert_eq!(rows[0]["ok"], true);
    assert_eq!(rows[1]["error"], "the time limit of 0.5 s for a case ended it");
}

/// The columns of a scene whose copies are counted by an axis are those of all of its scenes.
#[test]
fn columns_are_those_of_every_scene() {
    let bench = Bench::new();
    let body = "[[body]]\nname = \"link\"\nrepeat = 2\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n";
    let hinge = "hinge = { type = \"prismatic\", axis = [0.0, 0.0, 1.0], stiffness = 100.0 }\n";
    bench.write("chain.toml", format!("{body}{hinge}"));
    bench.call(&["sweep", "chain.toml", "--over", "link.repeat=1,3", "--out", "d"]).code(0);
    let rows = rows(&bench.path().join("d"));
    for (row, copies) in rows.iter().zip([1, 3]) {
        for (i, name) in ["link[0].distance", "link[1].distance", "link[2].distance"].iter().enumerate() {
            assert_eq!(row[*name].is_number(), i < copies, "{name}: {row:?}");
        }
    }
}

/// Correlated numbers keep their distributions; what statics makes of them is in the rows.
#[test]
fn drawn_numbers_are_distributed_as_they_are_written() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    bench.write("matrix.csv", "pan.stiffness,pan.mass\n1,0.7\n0.7,1\n");
    for sample in ["random", "latin", "sobol"] {
        let vary = ["--vary", "pan.mass=normal(2 kg,0.2 kg)", "--vary", "pan.stiffness=normal(0.1 N/mm,0.004 N/mm)"];
        let how = ["--cases", "2000", "--sample", sample, "--correlate", "matrix.csv", "--out", sample, "--quiet"];
        bench.call(&[&["sweep", "scale.toml"][..], &vary, &how].concat()).code(0);
        let rows = rows(&bench.path().join(sample));
        let column = |name: &str| rows.iter().map(|row| row[name].as_f64().expect("a number")).collect::<Vec<_>>();
        let (mass, stiffness) = (column("pan.mass"), column("pan.stiffness"));
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let (m, k) = (mean(&mass), mean(&stiffness));
        let covariance = |a: &[f64], b: &[f64]| {
            let (a0, b0) = (mean(a), mean(b));
            a.iter().zip(b).map(|(a, b)| (a - a0) * (b - b0)).sum::<f64>() / a.len() as f64
        };
        // Five standard deviations of the estimates from 2000 independent samples.
        assert!((m - 2.0).abs() < 5.0 * 0.2 / 2000_f64.sqrt(), "{sample}: {m}");
        assert!((k - 100.0).abs() < 5.0 * 4.0 / 2000_f64.sqrt(), "{sample}: {k}");
        let deviations = [covariance(&mass, &mass).sqrt(), covariance(&stiffness, &stiffness).sqrt()];
        assert!((deviations[0] - 0.2).abs() < 5.0 * 0.2 / 4000_f64.sqrt(), "{sample}: {deviations:?}");
        assert!((deviations[1] - 4.0).abs() < 5.0 * 4.0 / 4000_f64.sqrt(), "{sample}: {deviations:?}");
        let r = covariance(&mass, &stiffness) / (deviations[0] * deviations[1]);
        assert!((r - 0.7).abs() < 5.0 * 0.51 / 2000_f64.sqrt(), "{sample}: {r}");
        for row in &rows {
            let number = |name: &str| row[name].as_f64().expect("a number");
            let sunk = -number("pan.mass") * 9.80665 / number("pan.stiffness");
            assert!((number("pan.distance") - sunk).abs() < 1e-12);
        }
    }
}

/// Units of what is varied stand where those of the answers do: in the fields of the parts and in the manifest.
#[test]
fn what_is_varied_has_units_in_a_dataset() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    bench.call(&["sweep", "scale.toml", "--over", "pan.mass=1,2", "--out", "set", "--quiet"]).code(0);
    let manifest = std::fs::read_to_string(bench.path().join("set/_study.json")).expect("the manifest");
    let manifest: Value = serde_json::from_str(&manifest).expect("JSON");
    let unit = |name: &str| {
        let columns = manifest["columns"].as_array().expect("columns");
        columns.iter().find(|column| column["name"] == name).expect("a column")["unit"].clone()
    };
    assert_eq!((unit("pan.mass"), unit("case")), (json!("kg"), json!("")));
    let part = File::open(bench.path().join("set/part-0000000.parquet")).expect("a part");
    let reader = ParquetRecordBatchReaderBuilder::try_new(part).expect("Parquet");
    let field = reader.schema().field_with_name("pan.mass").expect("a column").clone();
    assert_eq!(field.metadata().get("unit").map(String::as_str), Some("kg"));
}

/// Few cases are computed side by side as many are: a part has as many rows as go together, at least.
#[test]
fn parts_hold_what_is_computed_side_by_side() {
    let bench = Bench::new();
    let chain = shipped("chain_of_twenty");
    let set = ["--set", "simulate.integrator=rk4", "--set", "simulate.duration=0.02", "--quiet"];
    let of = |more: &[&str], folder: &str| {
        let call = [&["sweep", &chain, "--run", "--vary", "link[7].mass=uniform(0.1,1)", "--out", folder], more, &set]
            .concat();
        bench.call(&call).code(0);
        let manifest = std::fs::read_to_string(bench.path().join(folder).join("_study.json")).expect("the manifest");
        let manifest: Value = serde_json::from_str(&manifest).expect("JSON");
        [&manifest["side_by_side"], &manifest["rows_per_part"]].map(|number| number.as_u64().expect("a number"))
    };
    let [together, rows] = of(&["--cases", "8"], "eight");
    assert!(together > 1 && rows == together, "{together} side by side in parts of {rows}");
    assert_eq!(of(&["--cases", "3"], "three")[1], 1);
    let [together, rows] = of(&["--cases", "8", "--part-rows", "5"], "asked");
    assert!(together > 1 && rows == 5, "{rows}");
}
