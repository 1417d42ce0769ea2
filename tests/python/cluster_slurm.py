"""The shards of a sweep as an array of Slurm, of which one task is requeued and another cancelled while they run: no row is lost.

    python3 tests/python/cluster_slurm.py target/release/stillpoint scenarios/machine_on_mounts.toml

Slurm and MUNGE need not be installed: their daemons run from the folder SLURM_ROOT, else `target/slurm`, as whoever calls this and
only as long as this runs. `.ci/run` unpacks Debian's packages there.
"""

import ctypes
import os
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
from contextlib import contextmanager, suppress
from pathlib import Path

from shards import SHARDS, Failure, Sweep, kill, main, processes, until

ROOT = Path(os.environ.get("SLURM_ROOT") or Path(__file__).resolve().parents[2] / "target/slurm")
PR_SET_PDEATHSIG = 1  # of <sys/prctl.h>
# As docs/guide/studies.md has it. What a call says goes to a file for each start of a task.
SCRIPT = f"""#!/bin/bash
#SBATCH --array=0-{SHARDS - 1} --cpus-per-task=1 --requeue
"$@" --threads "$SLURM_CPUS_PER_TASK" 2> "task$SLURM_ARRAY_TASK_ID.${{SLURM_RESTART_COUNT:-0}}.txt" || [ $? -eq 1 ]
"""
# One node that believes to have four processors. A job that was requeued waits until credentials of its first start have expired.
CONFIGURATION = """
ClusterName=stillpoint
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
PluginDir={plugins}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
MailProg=/bin/true
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,sched_interval=1,bf_interval=1
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
"""


def program(*names):
    """Where a program is, in the folder or in the system; Debian calls some of them otherwise."""
    folders = [ROOT / "usr/bin", ROOT / "usr/sbin", *os.environ["PATH"].split(":"), "/usr/sbin"]
    found = [path for name in names if (path := shutil.which(name, path=":".join(map(str, folders))))]
    if not found:
        raise Failure(
            f"Slurm cannot be tested: there is no `{names[0]}` in {ROOT} nor in the system. `.ci/run` unpacks Debian's "
            "packages slurmctld, slurmd and slurm-client there, with all that they need; SLURM_ROOT names another folder"
        )
    return found[0]


def free_ports(count):
    """Ports that nobody uses."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


@contextmanager
def slurm(folder):
    """A cluster of one node, in a folder; every process of it has ended at the end."""
    needed = [("munged",), ("slurmctld", "slurmctld-wlm"), ("slurmd", "slurmd-wlm"), ("slurmstepd", "slurmstepd-wlm")]
    munged, slurmctld, slurmd, slurmstepd = [program(*names) for names in needed]
    plugins = [path.parent for top in (ROOT, Path("/")) for path in top.glob("usr/lib/*/slurm*/proctrack_linuxproc.so")]
    if not plugins:
        raise Failure(f"Slurm cannot be tested: its plugins (slurm-wlm-basic-plugins) are neither in {ROOT} nor in the system")
    libraries = {str(path.parent) for path in (ROOT / "usr/lib").glob("**/*.so*")}
    host, ports, configuration = socket.gethostname().partition(".")[0], free_ports(2), folder / "slurm.conf"
    user = pwd.getpwuid(os.getuid()).pw_name
    text = CONFIGURATION.format(host=host, ports=ports, user=user, folder=folder, plugins=plugins[0])
    configuration.write_text(text)
    os.environ["SLURM_CONF"] = str(configuration)
    os.environ["LD_LIBRARY_PATH"] = ":".join([*libraries, *os.environ.get("LD_LIBRARY_PATH", "").split(":")]).strip(":")
    for name in ("state", "spool"):
        (folder / name).mkdir()
    key = folder / "munge.key"
    key.write_bytes(os.urandom(128))
    key.chmod(0o600)
    folder.chmod(0o755)  # MUNGE wants that everybody may reach its socket.
    munge = [f"--{what}={folder / 'munge'}.{what.partition('-')[0]}" for what in ("key-file", "socket", "pid-file", "seed-file")]
    daemons = []

    def start(name, call):
        with (folder / f"{name}.log").open("wb") as log:
            # A daemon ends with this process, even if that is killed.
            own = lambda: ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
            daemons.append(subprocess.Popen(call, stdout=log, stderr=log, stdin=subprocess.DEVNULL, preexec_fn=own))

    def none_left():
        """Kills what is left of the cluster: steps of jobs outlive the daemon that began them."""
        left = [process for process, (_, environment) in processes().items() if environment.get("SLURM_CONF") == str(configuration)]
        for process in left:
            kill(process)
        return not left

    try:
        start("munged", [munged, "--foreground", *munge])
        until("socket of munged", (folder / "munge.socket").exists, 20)
        start("slurmctld", [slurmctld, "-D", "-f", str(configuration)])
        start("slurmd", [slurmd, "-D", "-f", str(configuration), "-d", slurmstepd])
        until("node that is idle", lambda: "idle" in said("sinfo", "--noheader", "--format=%t"), 30, 0.1)
        yield
    except BaseException:
        for log in sorted([*folder.glob("*.log"), *folder.glob("task*.txt")]):
            print(f"--- {log.name}", *log.read_text(errors="replace").splitlines()[-30:], sep="\n", file=sys.stderr)
        raise
    finally:
        for process in reversed(daemons):
            process.terminate()
            with suppress(subprocess.TimeoutExpired):
                process.wait(10)
        until("end of all processes of Slurm", none_left, 20)
        for process in daemons:
            process.wait()


def said(name, *arguments):
    """What a program of Slurm prints, whether it succeeds or not."""
    return subprocess.run([program(name), *arguments], capture_output=True, text=True, timeout=60).stdout


def ended(job):
    """The states of the tasks of an array and how often each was started again, once all of them have ended."""
    lines = said("scontrol", "show", "job", job, "--oneliner").splitlines()
    fields = [dict(word.partition("=")[::2] for word in line.split()) for line in lines]
    if any(one["JobState"] in ("PENDING", "RUNNING", "COMPLETING", "CONFIGURING") for one in fields):
        return None
    return {int(one["ArrayTaskId"]): (one["JobState"], int(one["Restarts"])) for one in fields}


def test(stillpoint, scenario):
    """What was done, as a sentence."""
    with tempfile.TemporaryDirectory(prefix="slurm") as folder:
        folder = Path(folder)
        program("slurmctld", "slurmctld-wlm")
        sweep = Sweep(stillpoint, scenario, folder)
        (folder / "sweep.sh").write_text(SCRIPT)
        submit = ["--parsable", "--chdir", str(folder), "--output=/dev/null"]
        array = [str(folder / "sweep.sh"), *sweep.call]
        again, left = 1, 2
        with slurm(folder):
            job = Sweep.ended([program("sbatch"), *submit, *array]).strip()
            until("task that has written some of its parts", lambda: sweep.half(again) and sweep.half(left))
            Sweep.ended([program("scontrol"), "requeue", f"{job}_{again}"])
            Sweep.ended([program("scancel"), f"{job}_{left}"])
            states = until("end of the array", lambda: ended(job), pause=0.2)
            expected = {shard: ("COMPLETED", 0) for shard in range(SHARDS)}
            expected |= {again: ("COMPLETED", 1), left: ("CANCELLED", 0)}
            if states != expected:
                raise Failure(f"tasks ended so, with restarts: {states}")
            if (missing := sweep.missing()) != str(left):
                raise Failure(f"`--missing` prints `{missing}`, where task {left} was cancelled")
            job = Sweep.ended([program("sbatch"), *submit, f"--array={missing}", *array]).strip()
            if (states := until("end of what was missing", lambda: ended(job), pause=0.2)) != {left: ("COMPLETED", 0)}:
                raise Failure(f"the task that was missing ended so: {states}")
        return f"{sweep.check()} rows by Slurm, task {again} requeued, task {left} cancelled and called again"


main(test)
