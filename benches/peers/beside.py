"""What the tables beside other programs share: processes and what they cost, the markers in docs/speed.md."""

import dataclasses
import json
import os
import subprocess
import tempfile

from environment import BASE, PYTHON, HERE, stop

WORK = BASE / "work"


@dataclasses.dataclass
class Done:
    """A process that ended: what it printed, and its CPU seconds, user and system together, start-up and all."""

    code: int
    out: str
    err: str
    cpu: float


def process(command, patience=600.0):
    """Runs a command to its end. The clock is the CPU time of the process and its threads, which neighbours hardly disturb."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        child = subprocess.Popen(["timeout", str(patience), *map(str, command)], stdout=out, stderr=err)
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        return Done(child.returncode, out.read(), err.read(), used.ru_utime + used.ru_stime)


def ours(command, patience=600.0, codes=(0,)):
    """Runs `stillpoint` with `--json`; its answer and its CPU seconds."""
    command = [os.environ["STILLPOINT"], *map(str, command), "--json"]
    done = process(command, patience)
    if done.code not in codes:
        stop(" ".join(map(str, command)) + f": exit code {done.code}\n" + done.err)
    return json.loads(done.out), done.cpu


def peer(script, *words, patience=600.0):
    """Runs one of the peers' scripts of this folder, which prints one JSON object last. None where it fails."""
    done = process([PYTHON, HERE / script, *words], patience)
    lines = done.out.strip().splitlines()
    if done.code != 0 or not lines:
        return {"failed": failure(done)}, done.cpu
    return json.loads(lines[-1]), done.cpu


def failure(done):
    if done.code == 124:
        return "did not end"
    lines = [line for line in (done.err + done.out).strip().splitlines() if line.strip()]
    return lines[-1][:100] if lines else f"exit code {done.code}"


def write(name, text):
    """A file in the working folder."""
    WORK.mkdir(parents=True, exist_ok=True)
    path = WORK / name
    path.write_text(text)
    return path


def milliseconds(seconds):
    return f"{1e3 * seconds:.3g}" if seconds < 0.9995 else f"{1e3 * seconds:.0f}"


def times(ratio):
    return f"{ratio:.2f}" if ratio < 10 else f"{ratio:.0f}"
