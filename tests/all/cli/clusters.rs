//! Sweeps on engines as they are, with their own daemons and workers: a worker or a task is lost, and no row.

use super::shipped;
use std::path::Path;
use std::process::Command;

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
