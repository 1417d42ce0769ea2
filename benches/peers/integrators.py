"""Error against time of the integrators of stillpoint, MuJoCo, Drake and Exudyn. Called by `run --ode`.

The error is the distance of the last body's point, at the end, from the reference. Times are CPU seconds of the
integration alone for the peers, and the time in steps, by the wall clock, for us: the shortest of all passes.
"""

import collections
import dataclasses
import json
import math
import os
import subprocess
import sys

import numpy as np

import models
import report
from environment import BASE, HERE, PROGRAMS, PYTHON, say, stop
from options import arguments, chosen
from problems import PROBLEMS, STEPS, TOLERANCES, references

# What each integrator of ours is given.
OURS = {
    "auto": TOLERANCES,
    "rk4": STEPS,
    "dopri5": TOLERANCES,
    "dop853": TOLERANCES,
    "adams": TOLERANCES,
    "sdirk4": TOLERANCES,
    "radau5": TOLERANCES,
    "radau9": TOLERANCES,
    "generalized-alpha": TOLERANCES,
    "gauss": STEPS,
}
# runge_kutta5 does not come back from its first steps on the stiff chain.
DRAKE = {
    "five_links": ("runge_kutta3", "runge_kutta5", "implicit_euler", "radau3"),
    "heavy_top": ("runge_kutta3", "runge_kutta5", "implicit_euler", "radau3"),
    "stiff_chain": ("runge_kutta3", "implicit_euler", "radau3"),
}
# Exudyn's explicit solvers do not take constraints, and need a step below 1e-4 s on the stiff chain.
EXUDYN = {
    "five_links": ("generalized-alpha", "trapezoidal", "RK44", "DOPRI5"),
    "heavy_top": ("generalized-alpha", "trapezoidal"),
    "stiff_chain": ("generalized-alpha", "trapezoidal"),
}
# An integrator that took so long is not asked for more, like the peers' (s).
PATIENCE = 2.0
# One integrator of a peer on one problem may take so long (s).
LIMIT = 120
# Errors (m), and the part of the best peer's time that we mean to need for them.
WANTED = {1e-3: None, 1e-6: 1 / 10, 1e-9: 1 / 30}


@dataclasses.dataclass
class Result:
    program: str
    integrator: str
    setting: str
    seconds: float
    error: float
    status: str


def peer(program, command, reference):
    """The results that a peer prints; it is stopped where it does not come back."""
    command = [str(part) for part in command]
    try:
        text = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, cwd=BASE).stdout
    except subprocess.TimeoutExpired as stopped:
        say(f"stopped after {LIMIT} s: {' '.join(command)}")
        text = (stopped.stdout or b"").decode()
    for line in text.splitlines():
        if line.startswith("result,"):
            _, integrator, setting, seconds, *point, status = line.split(",")
            error = float(np.linalg.norm(np.array(point, float) - reference))
            yield Result(program, integrator, setting, float(seconds), error, status)


def our_integrators(scenario):
    """Those of OURS that this binary has; a new one has to be named there."""
    schema = json.loads(subprocess.run([os.environ["STILLPOINT"], "schema"], capture_output=True, text=True).stdout)
    found = names(schema["properties"]["simulate"]["properties"]["integrator"])
    unknown = found - set(OURS)
    if unknown:
        stop(f"integrators.py does not know what to ask of {', '.join(sorted(unknown))}")
    return [name for name in OURS if name in found]


def names(schema):
    """The strings that a part of a JSON Schema allows."""
    if isinstance(schema, dict):
        own = {schema["const"]} if "const" in schema else set(schema.get("enum", ()))
        return own.union(*(names(part) for part in schema.get("oneOf", schema.get("anyOf", []))))
    return set()


def ours(problem, scenario, integrator, setting, reference, passes):
    fixed = OURS[integrator] is STEPS
    key, value = ("step", problem.duration / setting) if fixed else ("tolerance", setting)
    shown = f"step {value:.3g} s" if fixed else f"tolerance {value:.1e}"
    command = [os.environ["STILLPOINT"], "run", str(scenario), "--json", "--quiet"]
    command += ["--out", str(scenario.with_suffix(".mcap"))]
    command += ["--set", f'simulate.integrator="{integrator}"', "--set", f"simulate.{key}={value!r}"]
    least, error = math.inf, math.nan
    # The wall clock is disturbed by whatever else runs: short runs get more tries than the peers with their CPU clock.
    for attempt in range(3 * passes):
        if attempt >= passes and least > 0.1:
            break
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            return Result(
                "stillpoint", integrator, shown, math.nan, math.nan, "failed: " + " ".join(done.stderr.split())[:90]
            )
        found = json.loads(done.stdout)
        pose = found["final"]["bodies"][f"b{len(problem.model.bodies) - 1}"]
        point = np.array(pose["position"]) + turned(pose["quaternion"], np.array(problem.point))
        error = float(np.linalg.norm(point - reference))
        least = min(least, found["wall_seconds"])
        if least > 1:
            break
    return Result("stillpoint", integrator, shown, least, error, "ok")


def turned(quaternion, vector):
    w, axis = quaternion[0], np.array(quaternion[1:])
    twice = 2 * np.cross(axis, vector)
    return vector + w * twice + np.cross(axis, twice)


def measure(name, problem, reference, passes):
    """All programs in turn on one problem."""
    scenario, neutral = models.write(problem.model, BASE / "models", problem.duration)
    results = []
    for integrator in our_integrators(scenario):
        say(f"{name}: stillpoint {integrator}")
        for setting in OURS[integrator]:
            results.append(ours(problem, scenario, integrator, setting, reference, passes))
            if results[-1].seconds > PATIENCE:
                break
    say(f"{name}: MuJoCo")
    mujoco = [PROGRAMS / "mujoco_integrate", neutral, problem.duration, *problem.point, passes]
    results += peer("MuJoCo", mujoco, reference)
    for integrator in DRAKE[name]:
        say(f"{name}: Drake {integrator}")
        results += peer("Drake", [PYTHON, HERE / "drake_integrate.py", name, integrator, passes], reference)
    for integrator in EXUDYN[name]:
        say(f"{name}: Exudyn {integrator}")
        results += peer("Exudyn", [PYTHON, HERE / "exudyn_integrate.py", name, integrator, passes], reference)
    return results


def quickest(results, program, error):
    """The shortest run of a program that is at least so accurate."""
    good = [r for r in results if r.program == program and r.status == "ok" and r.error <= error]
    return min(good, key=lambda r: r.seconds, default=None)


def milliseconds(result):
    return f"{result.seconds * 1e3:.3g} ({result.integrator}, {result.setting})" if result else "not reached"


def tables(measured):
    programs = ("MuJoCo", "Drake", "Exudyn", "stillpoint")
    short = []
    for name, results in measured.items():
        for error, goal in WANTED.items():
            best = {program: quickest(results, program, error) for program in programs}
            others = [best[program] for program in programs[:-1] if best[program]]
            least, own = min((r.seconds for r in others), default=None), best["stillpoint"]
            ratio = f"{own.seconds / least:.3f}" if own and least else "–"
            if goal and own and least:
                ratio += f" ({'met' if own.seconds <= goal * least else 'missed'}: {goal:.3f})"
            short.append([name, f"{error:.0e} m", *(milliseconds(best[program]) for program in programs), ratio])
    found = [
        report.Table(
            "Time to an error",
            "Milliseconds of the shortest run with an error of at most so much, with its integrator and setting. The "
            "ratio is ours to the best peer's, with our goal.",
            ["problem", "error", *programs, "ratio"],
            short,
        )
    ]
    for name, results in measured.items():
        problem = PROBLEMS[name]
        grouped = collections.defaultdict(list)
        for r in results:
            grouped[r.program, r.integrator].append(r)
        rows = []
        for (program, integrator), runs in grouped.items():
            good = [r for r in runs if r.status == "ok" and math.isfinite(r.error)]
            cells = [
                f"{b.seconds * 1e3:.3g}" if (b := quickest(good, program, 10.0**-k)) else "–" for k in (2, 4, 6, 8, 10)
            ]
            least = min(good, key=lambda r: r.error, default=None)
            end = f"{least.error:.0e} m in {least.seconds * 1e3:.3g} ms" if least else "–"
            bad = [r for r in runs if r.status != "ok"]
            rows.append([program, integrator, *cells, end, f"{len(bad)} of {len(runs)}" if bad else ""])
        found.append(
            report.Table(
                problem.text,
                f"`{name}`, {problem.duration:g} s: milliseconds to an error of at most so many metres.",
                ["program", "integrator", "1e-2", "1e-4", "1e-6", "1e-8", "1e-10", "least error", "failed"],
                rows,
            )
        )
    return found


def main():
    given = arguments()
    passes = given.passes or (1 if given.quick else 5)
    head = report.Head(sys.argv[1:], passes)
    known = references()
    wanted = chosen(given, list(PROBLEMS))
    if not wanted:
        stop(f"--only {given.only}: no such problem; there are {', '.join(PROBLEMS)}")
    measured = {name: measure(name, PROBLEMS[name], known[name], passes) for name in wanted}
    rows = [(name, *dataclasses.astuple(result)) for name, results in measured.items() for result in results]
    columns = ["problem", "program", "integrator", "setting", "seconds", "error", "status"]
    report.write(given, "integrators", head, tables(measured), columns, rows)
    report.plot(given, measured, {name: PROBLEMS[name].text for name in measured})


if __name__ == "__main__":
    main()
