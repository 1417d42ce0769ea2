"""The shards of a sweep as one job of HyperQueue, on two workers of which one is killed with its tasks: no row is lost.

    python3 tests/python/cluster_hyperqueue.py target/release/stillpoint scenarios/machine_on_mounts.toml
"""

import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from hyperqueue import Job
from hyperqueue.cluster import LocalCluster, WorkerConfig
from shards import SHARDS, Failure, Sweep, kill, main, processes, until

CORES = 2
# The package has no program `hq`, and workers of a cluster are threads of its process. One that can be killed is that of a second
# cluster, in a process of its own, whose folder points to the server of the first.
WORKER = f"""
import os, sys, time
from hyperqueue.cluster import LocalCluster, WorkerConfig
server, own = sys.argv[1:]
cluster = LocalCluster(own)
os.remove(own + "/hq-current")
os.symlink(os.path.realpath(server + "/hq-current"), own + "/hq-current")
cluster.start_worker(WorkerConfig(cores={CORES}))
print("works", flush=True)
time.sleep(600)
"""


def worker(server, own):
    """A process that is one worker."""
    started = subprocess.Popen([sys.executable, "-c", WORKER, server, own], stdout=subprocess.PIPE, text=True)
    if "works\n" not in started.stdout:
        raise Failure("a worker of HyperQueue does not start")
    return started


def tasks(process):
    """The processes of the tasks that a worker runs, each with its shard."""
    everyone = processes()
    found, above = {}, {process.pid}
    while below := {number for number, (parent, _) in everyone.items() if parent in above}:
        found |= {number: int(everyone[number][1].get("HQ_TASK_ID", -1)) for number in below}
        above = below
    return found


def test(program, scenario):
    """What was done, as a sentence."""
    with tempfile.TemporaryDirectory(prefix="hyperqueue") as folder:
        folder = Path(folder)
        sweep = Sweep(program, scenario, folder)
        workers = []
        with LocalCluster(str(folder / "server")) as cluster:
            try:
                workers.extend(worker(str(folder / "server"), str(folder / f"worker{i}")) for i in range(2))
                client, job = cluster.client(), Job(default_workdir=folder)
                for _ in range(SHARDS):
                    # Cases that failed are rows, and no failure of the task.
                    call = ["sh", "-c", '"$@" || [ $? -eq 1 ]', "sh", *sweep.call, "--threads", "1"]
                    job.program(call, stderr=str(folder / "task%{TASK_ID}.%{INSTANCE_ID}.txt"))
                submitted = client.submit(job)

                def half():
                    shards = set(tasks(workers[0]).values())
                    return len(shards) == CORES and all(map(sweep.half, shards)) and shards

                lost = until("worker whose tasks have each written some of their parts", half)
                # As a machine dies: nobody is told, and nothing is tidied up.
                workers[0].send_signal(signal.SIGSTOP)
                for process in tasks(workers[0]):
                    kill(process)
                workers[0].kill()
                if not all(map(sweep.half, lost)):
                    raise Failure("the tasks ended before their worker was killed: give the sweep more cases")
                client.wait_for_jobs([submitted])
            finally:
                for process in workers:
                    for task in tasks(process):
                        kill(task)
                    process.kill()
                    process.wait()
        for shard in range(SHARDS):
            said = sorted(folder.glob(f"task{shard}.*.txt"))
            if len(said) != 1 + (shard in lost):
                raise Failure(f"shard {shard} was started {len(said)} times; those that were lost: {sorted(lost)}")
            if f"by HQ_TASK_ID={shard}" not in said[-1].read_text():
                raise Failure(f"task {shard} does not say which shard it is:\n{said[-1].read_text()}")
        return f"{sweep.check()} rows by HyperQueue, the worker of the shards {sorted(lost)} killed"


main(test)
