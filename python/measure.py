"""What the package costs: the table of docs/guide/python.md.

    python python/measure.py

Times are least ones of several. `batch` beside `sweep` is CPU time of the same runs: both are the same code below Python.
"""

import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import stillpoint

ARM = Path(__file__).resolve().parents[1] / "scenarios" / "spring_arm.toml"


def least(call, times=5):
    def one():
        begin = time.perf_counter()
        call()
        return time.perf_counter() - begin

    return min(one() for _ in range(times))


def cpu(call):
    before = resource.getrusage(resource.RUSAGE_SELF)
    call()
    after = resource.getrusage(resource.RUSAGE_SELF)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def importing():
    code = "import time, numpy; t = time.perf_counter(); import stillpoint; print(time.perf_counter() - t)"
    return min(float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout) for _ in range(5))


def acceleration():
    dynamics = stillpoint.load(ARM).dynamics()
    q, v = np.zeros(dynamics.nq) + 0.1, np.zeros(dynamics.nv)
    call = dynamics.acceleration
    return least(lambda: [call(q, v) for _ in range(10000)]) / 10000


def samples():
    """A run of 10⁶ samples: bytes beyond those of its arrays, as a part of them."""
    scene = stillpoint.describe(
        simulate={"start": "given", "integrator": "rk4", "step": 1e-3},
        body=[{"name": "m", "mass": 1.0, "hinge": {"type": "prismatic", "axis": [1, 0, 0], "stiffness": 1.0, "position": 0.1}}],
    )
    peak = lambda: 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    before = peak()
    run = scene.run(1000.0, rate=1000.0)
    arrays = run.time.nbytes + sum(run[name].nbytes for name in run.columns)
    return len(run.time), arrays, (peak() - before) / arrays


def batch():
    scene = stillpoint.load(ARM)
    values = [300.0 + 0.05 * case for case in range(1000)]
    runs = cpu(lambda: scene.batch([{"shoulder_spring.stiffness": value} for value in values], 0.1, rate=100.0))
    rows = cpu(lambda: scene.with_set({"simulate.duration": 0.1}).sweep({"shoulder_spring.stiffness": values}, run=True))
    return rows / runs


if __name__ == "__main__":
    print(f"import stillpoint          {1e3 * importing():8.1f} ms   (numpy is there)")
    print(f"acceleration(q, v)         {1e6 * acceleration():8.2f} µs   (spring_arm)")
    count, arrays, part = samples()
    print(f"run of {count} samples    {part:8.2f}      times the {arrays / 1e6:.0f} MB of its arrays, at the peak")
    print(f"batch of 1000 short runs   {batch():8.2f}      of the speed of `sweep --run`, CPU time")
    library = Path(stillpoint.__file__).with_name("_stillpoint.abi3.so")
    print(f"library                    {library.stat().st_size / 1e6:8.1f} MB")
