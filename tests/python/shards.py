"""A sweep whole and by shards, and what is compared at the end: for `cluster_hyperqueue.py` and `cluster_slurm.py`."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet

SHARDS = 6
PARTS = 240
# Some of these masses are negative: such a case is a row with its reason, and its call ends with 1.
PLAN = ["--vary", "machine.mass=normal(160,60)", "--cases", "4800", "--part-rows", "20"]
# No task says which shard it is but the engine that is tested.
ENGINES = ("HQ_", "JOB_COMPLETION_INDEX", "SLURM_", "SBATCH_")


class Failure(Exception):
    """What went wrong, as a sentence."""


def until(what, answer, seconds=120, pause=0.01):
    """Waits for an answer that is true."""
    end = time.monotonic() + seconds
    while not (found := answer()):
        if time.monotonic() > end:
            raise Failure(f"after {seconds} s there is still no {what}")
        time.sleep(pause)
    return found


def processes():
    """The parent and the environment of every process whose environment can be read, by number."""
    found = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            words = (entry / "environ").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        found[int(entry.name)] = (parent, dict(word.partition("=")[::2] for word in words))
    return found


def kill(process):
    """Kills a process, if it is still there."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(process, signal.SIGKILL)


class Sweep:
    """The rows of an undisturbed sweep in `whole`; a folder `shared` for those of the shards."""

    def __init__(self, program, scenario, folder):
        self.shared, whole = folder / "shared", folder / "whole"
        sweep = [str(Path(program).resolve()), "sweep", str(Path(scenario).resolve()), *PLAN]
        self.call = [*sweep, "--shards", str(SHARDS), "--out", str(self.shared)]
        for name in [name for name in os.environ if name.startswith(ENGINES)]:
            del os.environ[name]
        self.ended([*sweep, "--out", str(whole)], codes=[1])
        self.rows = rows(whole)

    @staticmethod
    def ended(call, codes=(0,)):
        """What a call prints; a failure if it ends otherwise."""
        done = subprocess.run(call, capture_output=True, text=True, timeout=120)
        if done.returncode not in codes:
            raise Failure(f"{' '.join(call)} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
        return done.stdout

    def missing(self):
        """The shards of which something is missing, as an array takes them."""
        return self.ended([*self.call, "--missing"]).strip()

    def done(self, shard):
        """How many parts of a shard are there."""
        numbers = [int(path.stem.partition("-")[2]) for path in self.shared.glob("part-*.parquet")]
        return sum(number % SHARDS == shard for number in numbers)

    def half(self, shard):
        """Whether a shard has some of its parts and not all of them."""
        return 0 < self.done(shard) < PARTS // SHARDS

    def check(self):
        """Every part is there, nothing else is, and the rows are those of the undisturbed sweep."""
        if missing := self.missing():
            raise Failure(f"`--missing` prints {missing}")
        names = sorted(path.name for path in self.shared.iterdir())
        if names != ["_study.json", *(f"part-{part:07}.parquet" for part in range(PARTS))]:
            raise Failure(f"the dataset has other files than its parts: {names}")
        found = rows(self.shared)
        if len(found) != len(self.rows):
            raise Failure(f"{len(found)} rows, where the undisturbed sweep has {len(self.rows)}")
        for mine, theirs in zip(found, self.rows):
            if mine != theirs:
                raise Failure(f"not the row of the undisturbed sweep:\n{mine}\n{theirs}")
        return len(found)


def rows(folder):
    """All rows in the order of the cases, without times of the clock; text that has every bit of a number."""
    table = pyarrow.parquet.read_table(folder).sort_by("case").drop_columns(["wall_seconds"])
    return [repr(row) for row in table.to_pylist()]


def main(test):
    """Runs a test with the program and the scenario of the command line."""
    if len(sys.argv) != 3:
        sys.exit(f"usage: {sys.argv[0]} PROGRAM SCENARIO")
    begun = time.monotonic()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("error: ended from outside"))  # What was started is ended then, too.
    try:
        print(f"{test(*sys.argv[1:])}, {time.monotonic() - begun:.0f} s")
    except Failure as failure:
        sys.exit(f"error: {failure}")
