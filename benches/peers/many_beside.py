"""Many cases of one model: stillpoint's sweeps and lanes beside MuJoCo's `rollout`. Called by `run --many`.

Both read the same MJCF file, take the same starts, the same method (RK4), step and number of steps, without contact, limits and dry
friction, and run on as many threads as there are cores. Their ends are compared before anything is timed.
"""

import csv
import json
import math
import os
import sys
import time

import beside
import report
from environment import packages, say, stop
from options import arguments

THREADS = os.cpu_count() or 1
# Joint names, and how far they may begin from where the file has them.
SPREAD = 0.5
# The same method with the same steps: ends differ by round-off alone, which motions amplify (m, rad).
AGREE = 1e-9


def arm():
    """Seven links with axes that turn about each other, dampers, rotors and general inertias."""
    axes = ("0 0 1", "0 1 0", "0 0 1", "0 -1 0", "0 0 1", "0 1 0", "0 0 1")
    masses = (4.0, 4.0, 3.0, 2.7, 1.7, 1.8, 0.3)
    lines, ends = [], []
    for number, (axis, mass) in enumerate(zip(axes, masses)):
        moment = mass * 0.02
        place = "0 0 0" if number == 0 else "0.03 0 0.25"
        lines += [
            f'<body name="link{number}" pos="{place}">',
            f'<joint name="joint{number}" axis="{axis}" damping="0.1" armature="0.01"/>',
            f'<inertial pos="0.02 0.01 0.12" mass="{mass}" fullinertia="{moment} {0.9 * moment} {0.3 * moment} {0.02 * moment} '
            f'{-0.03 * moment} {0.05 * moment}"/>',
        ]
        ends.append("</body>")
    return "\n".join(
        ['<mujoco model="arm"><option gravity="0 0 -9.81"/><worldbody>', *lines, *ends, "</worldbody></mujoco>"]
    )


def humanoid():
    return (packages() / "mujoco" / "mjx" / "test_data" / "humanoid" / "humanoid.xml").read_text()


# Model: text, varied joints with the bodies that ours calls them by and their places in the file, step, steps, cases.
MODELS = {
    "arm": {
        "text": arm,
        "varied": {f"joint{k}": (f"link{k}", 0.1 * k) for k in range(7)},
        "step": 1e-3,
        "steps": 500,
        "cases": 1024,
    },
    "humanoid": {
        "text": humanoid,
        "varied": {
            "knee_right": ("shin_right", -2.65),
            "knee_left": ("shin_left", -2.65),
            "elbow_right": ("lower_arm_right", 0.0),
            "elbow_left": ("lower_arm_left", 0.0),
        },
        "step": 1e-3,
        "steps": 250,
        "cases": 512,
    },
}


def sweep(name, scenario, lanes, cases):
    """Rows of our sweep (from its CSV file), its CPU seconds and its wall seconds: the whole process."""
    model = MODELS[name]
    duration = model["step"] * model["steps"]
    out = beside.WORK / f"many_{name}.csv"
    command = [os.environ["STILLPOINT"], "sweep", scenario, "--run", "--quiet", "--out", out]
    command += ["--cases", cases, "--seed", 1, "--threads", THREADS, "--lanes", lanes]
    for key, value in (
        ("integrator", '"rk4"'),
        ("start", '"given"'),
        ("step", repr(model["step"])),
        ("duration", repr(duration)),
    ):
        command += ["--set", f"simulate.{key}={value}"]
    command += ["--set", f"record.rate={1.0 / duration!r}"]
    for body, place in model["varied"].values():
        command += ["--vary", f"{body}.position=uniform({place - SPREAD},{place + SPREAD})"]
    begun = time.perf_counter()
    done = beside.process(command)
    wall = time.perf_counter() - begun
    if done.code != 0:
        stop(f"{name}: sweep: exit code {done.code}\n{done.err}")
    with open(out, newline="") as file:
        rows = list(csv.DictReader(file))
    if failed := [row["error"] for row in rows if row["ok"] != "true"]:
        stop(f"{name}: {len(failed)} of {len(rows)} cases failed: {failed[0]}")
    if any(int(row["steps"]) != model["steps"] for row in rows):
        stop(f"{name}: a case took another number of steps than {model['steps']}")
    return rows, done.cpu, wall


def starts(name, rows):
    """The starts that our sweep drew, for MuJoCo."""
    varied = MODELS[name]["varied"]
    cases = [[float(row[f"{body}.position"]) for body, _ in varied.values()] for row in rows]
    return beside.write(f"many_{name}.json", json.dumps({"joints": list(varied), "cases": cases}))


def rollout(name, rows, integrator="RK4"):
    model = MODELS[name]
    words = (beside.WORK / f"many_{name}.xml", starts(name, rows), model["step"], model["steps"], THREADS, integrator)
    answer, _ = beside.peer("many_peers.py", *words)
    if "failed" in answer:
        stop(f"{name}: MuJoCo: {answer['failed']}")
    return answer


def distance(rows, ends):
    """How far the two programs are apart at the end: metres and radians, quaternions up to their sign."""
    farthest = 0.0
    for row, theirs in zip(rows, ends, strict=True):
        mine = [float(value) for key, value in row.items() if key.startswith("final ")]
        if len(mine) != len(theirs):
            stop(f"{len(mine)} coordinates here, {len(theirs)} in MuJoCo")
        if any(key.endswith(".qw") for key in row) and mine[3] * theirs[3] < 0.0:
            theirs = [*theirs[:3], *(-x for x in theirs[3:7]), *theirs[7:]]
        farthest = max(farthest, *(abs(a - b) for a, b in zip(mine, theirs, strict=True)))
    return farthest


def prepare(name):
    """Writes the model, converts it, and compares the ends of a few cases."""
    source = beside.write(f"many_{name}.xml", MODELS[name]["text"]())
    scenario = beside.WORK / f"many_{name}.toml"
    scenario.unlink(missing_ok=True)
    done = beside.process(
        [os.environ["STILLPOINT"], "convert", source, "--no-limits", "--no-friction", "--quiet", "-o", scenario]
    )
    if done.code != 0:
        stop(f"{name}: convert: exit code {done.code}\n{done.err}")
    rows, _, _ = sweep(name, scenario, "auto", 8)
    off = distance(rows, rollout(name, rows)["ends"])
    if not off <= AGREE:
        stop(f"{name}: MuJoCo ends {off:.1e} away from where stillpoint does")
    return scenario, off


def measure(name, passes, quick):
    scenario, off = prepare(name)
    cases = MODELS[name]["cases"] // (4 if quick else 1)
    least = {}
    for _ in range(passes):
        for lanes in ("auto", "off"):
            rows, cpu, wall = sweep(name, scenario, lanes, cases)
            keep(least, f"sweep, lanes {lanes}", cpu, wall)
        for integrator in ("RK4", "EULER"):
            answer = rollout(name, rows, integrator)
            keep(least, f"MuJoCo rollout {integrator}", answer["cpu"], answer["wall"])
        bench, _ = beside.ours(["bench", scenario, "--set", 'simulate.start="given"'])
        lanes = bench.get("lanes") or {}
        for routine, value in (
            ("acceleration", bench["acceleration_ns"]["min"]),
            ("lane acceleration", lanes.get("acceleration_ns", {}).get("min", math.nan)),
            ("lane rk4 step", lanes.get("rk4_step_ns", {}).get("min", math.nan)),
        ):
            keep(least, routine, value, value)
    return {"off": off, "cases": cases, "least": least}


def keep(least, key, cpu, wall):
    before = least.get(key, (math.inf, math.inf))
    least[key] = (min(before[0], cpu), min(before[1], wall))


COLUMNS = [
    "model",
    "cases × steps",
    "sweep, lanes",
    "sweep, one by one",
    "MuJoCo rollout",
    "ratio",
    "ends apart",
]


def cases_row(name, found):
    cases, least = found["cases"], found["least"]
    rate = lambda key: cases / least[key][0]
    cells = [f"{rate(key):.0f}" for key in ("sweep, lanes auto", "sweep, lanes off", "MuJoCo rollout RK4")]
    ratio = f"{rate('sweep, lanes auto') / rate('MuJoCo rollout RK4'):.2f}"
    return [name, f"{cases} × {MODELS[name]['steps']}", *cells, ratio, f"{found['off']:.0e}"]


def step_row(name, found):
    """Nanoseconds of one case, and the ratios that we want to be small."""
    least, steps = found["least"], found["cases"] * MODELS[name]["steps"]
    theirs, euler = (1e9 * least[f"MuJoCo rollout {method}"][0] / steps for method in ("RK4", "EULER"))
    whole = 1e9 * least["sweep, lanes auto"][0] / steps
    single, lane, step = (least[key][0] for key in ("acceleration", "lane acceleration", "lane rk4 step"))
    cells = [f"{value:.0f}" for value in (single, lane, step, whole, theirs, euler)]
    return [name, *cells, *(f"{ratio:.2f}" for ratio in (lane / single, lane / euler, step / euler, whole / theirs))]


STEP_COLUMNS = [
    "model",
    "acceleration alone",
    "in lanes",
    "rk4 step in lanes",
    "whole sweep, a step",
    "MuJoCo RK4 step",
    "MuJoCo Euler step",
    "lanes to alone (goal 0.4)",
    "lane acceleration to Euler step (goal 0.1)",
    "lane rk4 step to Euler step (goal 0.4)",
    "sweep to RK4 rollout",
]


def main():
    given = arguments()
    passes = given.passes or (1 if given.quick else 3)
    names = [name for name in MODELS if not given.only or name in given.only.split(",")]
    head = report.Head(sys.argv[1:], passes, ("mujoco", "mujoco-mjx"), f"{THREADS} threads on either side")
    found, rows = {}, []
    for name in names:
        say(name)
        found[name] = measure(name, passes, given.quick)
        for key, (cpu, wall) in found[name]["least"].items():
            rows.append([name, key, found[name]["cases"], MODELS[name]["steps"], cpu, wall])
    text = (
        "Cases for each second of CPU time (minima over passes; on n idle cores n times as many each second). Ours is the whole process: reading "
        "the scene, drawing the cases, the runs with their account of the energy, a CSV file with a row for each. MuJoCo's is `rollout` "
        "alone, models and data made already. The arm has seven hinges; the humanoid is that of MuJoCo's own models (27 degrees of freedom)."
    )
    steps_text = (
        "Nanoseconds of one case. Accelerations and the step in lanes are what `stillpoint bench` says (wall time, minima: they suffer on "
        "a busy machine); the sweep and MuJoCo's rollout are CPU time over cases and steps of four evaluations."
    )
    tables = [
        report.Table("Cases for each second of CPU time", text, COLUMNS, [cases_row(*pair) for pair in found.items()]),
        report.Table("One step of one case", steps_text, STEP_COLUMNS, [step_row(*pair) for pair in found.items()]),
    ]
    columns = ["model", "what", "cases", "steps", "least_cpu", "least_wall"]
    report.write(given, "many", head, tables, columns, rows, "Many cases beside MuJoCo")


if __name__ == "__main__":
    main()
