//! Sweeps on engines as they are, with their own daemons and workers: a worker or a task is lost, and no row. What tasks that begin at
//! once do to each other, at the moments that hardly ever come.

use super::{Bench, SCALE, shipped};
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// A script of `tests/python` runs the shards on an engine, disturbs it, and compares the rows with those of an undisturbed sweep.
fn no_row_is_lost(script: &str) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python").join(script);
    let mut command = Command::new("python3");
    command.arg("-B").arg(script).arg(env!("CARGO_BIN_EXE_stillpoint")).arg(shipped("machine_on_mounts"));
    let output = command.output().expect("python3");
    let [out, err] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    assert!(output.status.success(), "{out}{err}");
}

#[test]
#[ignore = "needs Python with hyperqueue and pyarrow (tests/python/requirements.txt)"]
fn a_killed_worker_of_hyperqueue_loses_no_row() {
    no_row_is_lost("cluster_hyperqueue.py");
}

#[test]
#[ignore = "needs Slurm, as .ci/run unpacks it, and Python with pyarrow (tests/python/requirements.txt)"]
fn tasks_that_slurm_requeues_and_cancels_lose_no_row() {
    no_row_is_lost("cluster_slurm.py");
}

/// Two shards with one part each, in `set`.
const CALL: [&str; 9] =
    ["sweep", "scale.toml", "--over", "pan.mass=1:2:8", "--part-rows", "4", "--shards", "2", "--out"];
const PARTS: [&str; 2] = ["set/part-0000000.parquet", "set/part-0000001.parquet"];

/// A folder with a scene, and with the library that makes calls wait.
fn bench_of_waits() -> Bench {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all/cli/waits.c");
    let mut compile = Command::new("cc");
    compile.args(["-shared", "-fPIC", "-o"]).arg(bench.path().join("waits.so")).arg(source).arg("-ldl");
    assert!(compile.status().expect("a C compiler").success());
    bench
}

/// A task that has come to a call of the C library and waits there until a file has something in it.
fn waiting(bench: &Bench, shard: &str, call: &str, file: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stillpoint"));
    command.args(CALL).args(["set", "--quiet", "--shard", shard]).current_dir(bench.path());
    command.env("LD_PRELOAD", bench.path().join("waits.so")).env("WAIT_IN", call).env("WAIT_FOR", file);
    let child = command.spawn().expect("the program starts");
    let (said, begun) = (bench.path().join("waits"), Instant::now());
    while !said.exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "it does not come to {call}");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::fs::remove_file(said).expect("removed");
    child
}

#[track_caller]
fn succeeds(mut task: Child) {
    let status = task.wait().expect("an end");
    assert!(status.success(), "{status}");
}

/// Of two tasks that begin a dataset one has written a part before the other one looks what is in the folder.
#[test]
#[ignore = "needs a C compiler"]
fn a_task_may_begin_beside_parts_of_a_faster_one() {
    let bench = bench_of_waits();
    let slow = waiting(&bench, "1", "mkdir", PARTS[0]);
    bench.call(&[&CALL[..], &["set", "--shard", "0"]].concat()).code(0);
    succeeds(slow);
    assert!(PARTS.iter().all(|part| bench.path().join(part).exists()));
}

/// What a killed task has left is removed by one that begins, and by another one that found it at the same time: not the file that
/// the first one has written under that name since.
#[test]
#[ignore = "needs a C compiler"]
fn tidying_up_after_a_killed_task_removes_nothing_else() {
    let bench = bench_of_waits();
    bench.call(&[&CALL[..], &["set", "--shard", "1"]].concat()).code(0);
    std::fs::remove_file(bench.path().join(PARTS[1])).expect("removed");
    let left = format!("{}.partial", PARTS[0]);
    bench.write(&left, "");
    let tidies = waiting(&bench, "1", "flock", &left);
    let writes = waiting(&bench, "0", "fsync", PARTS[1]);
    succeeds(tidies);
    succeeds(writes);
    assert!(PARTS.iter().all(|part| bench.path().join(part).exists()));
    assert!(!bench.path().join(left).exists());
}
