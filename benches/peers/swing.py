"""A soft rod swings: stillpoint beside MuJoCo and PyElastica. Part of `run --beams`.

The rod is on a pin, drawn straight from it and let go; an error is how far its tip is from where it should be after half a second. MuJoCo's
row of links bends alone, PyElastica's rod stretches and shears, too: ours is both, each beside the one that is like it. The finest run of MuJoCo
says where the tip should be for the first, our finest for the second; the other program has to come close to it before anything is
compared.
"""

import json
import math

import beside
from environment import stop

LENGTH, RADIUS, DENSITY, YOUNG, END, GRAVITY = 1.0, 0.01, 1000.0, 1e7, 0.5, 9.80665
SHEAR = YOUNG / 3.0
AREA, SECOND = math.pi * RADIUS**2, 0.25 * math.pi * RADIUS**4
# Timoshenko's factor that PyElastica has.
SHEAR_FACTOR = 27.0 / 28.0
LEVELS = (1e-2, 3e-3, 1e-3, 3e-4)
# Of the other program's finest run from the reference (m).
CLOSE = {"bend": 1e-4, "full": 1e-3}
FREE = {"bend": ["bend"], "full": ["bend", "stretch", "shear"]}
PEER = {"bend": "mujoco", "full": "pyelastica"}
NAMES = {
    "mujoco": "MuJoCo, links on hinges, RK4",
    "pyelastica": "PyElastica, PositionVerlet",
}
TITLES = {"bend": "swing, bending alone", "full": "swing, with stretch and shear"}
COUNTS = {"mujoco": (4, 8, 16, 32, 64), "pyelastica": (10, 20, 40, 80)}
# Degrees and numbers of elements.
OURS = {"bend": ((1, 1), (1, 2), (1, 4), (2, 1), (2, 2), (2, 4)), "full": ((1, 1), (1, 2))}
# Waves of stretch and shear are what the steps of the second follow, whatever the tolerance: one is enough, and one pass.
TOLERANCES = {"bend": (1e-3, 1e-5), "full": (1e-3,)}
# Degree, elements and tolerance of our finest run; that of the second is known to 3e-4 m only and already takes long.
REFERENCE = {"bend": (2, 4, 1e-5), "full": (1, 4, 1e-5)}


def rod():
    return {
        "length": LENGTH,
        "radius": RADIUS,
        "density": DENSITY,
        "young": YOUNG,
        "shear": SHEAR,
        "mass_per_length": DENSITY * AREA,
        "bending": YOUNG * SECOND,
        "rotary": [2.0 * DENSITY * SECOND, DENSITY * SECOND, DENSITY * SECOND],
        "gravity": GRAVITY,
        "end": END,
    }


def toml(kind):
    axial, across = YOUNG * AREA, SHEAR_FACTOR * SHEAR * AREA
    stiffness = [axial, across, across, 2.0 * SHEAR * SECOND, YOUNG * SECOND, YOUNG * SECOND]
    return f"""title = "A rod swings"
gravity = [0.0, 0.0, {-GRAVITY}]
[simulate]
start = "given"
duration = {END}
integrator = "dop853"
[record]
rate = 2.0
[[beam]]
name = "rod"
hinge = {{ type = "revolute", axis = [0.0, 1.0, 0.0] }}
length = {LENGTH}
section = {{ stiffness = {stiffness} }}
mass_per_length = {DENSITY * AREA!r}
rotary = {rod()["rotary"]}
free = {json.dumps(FREE[kind])}
[[output]]
name = "tip"
type = "position"
of = "rod.tip"
"""


def run(kind, degree, elements, tolerance):
    """Where our tip is at the end, the CPU seconds of the whole process and the wall seconds of its steps."""
    scenario = beside.write(f"swing_{kind}.toml", toml(kind))
    command = ["run", scenario, "--quiet", "--out", beside.WORK / "swing.mcap"]
    for key, value in (
        ("rod.elements", elements),
        ("rod.degree", degree),
        ("simulate.tolerance", tolerance),
        ("simulate.absolute_tolerance", tolerance),
    ):
        command += ["--set", f"{key}={value}"]
    found, cpu = beside.ours(command, patience=1800.0)
    return found["outputs"]["tip"], cpu, found["wall_seconds"]


def theirs(program, passes, quick):
    path = beside.write("swing.json", json.dumps(rod()))
    counts = COUNTS[program][:-1] if quick else COUNTS[program]
    answer, _ = beside.peer("swing_peers.py", program, path, ",".join(map(str, counts)), passes, patience=1800.0)
    if "failed" in answer:
        stop(f"swing: {program}: {answer['failed']}")
    return answer["runs"]


def ours(kind, passes):
    runs = []
    for degree, elements in OURS[kind]:
        for tolerance in TOLERANCES[kind]:
            found = [run(kind, degree, elements, tolerance) for _ in range(passes)]
            label = f"{elements} of degree {degree}, {tolerance:.0e}"
            cpu, wall = (min(times) for times in list(zip(*found))[1:])
            runs.append({"elements": label, "place": found[0][0], "seconds": cpu, "search": wall})
    return runs


def measure(kind, passes, quick):
    """Runs of both programs with their errors; ends everything where they do not come to the same place."""
    program = PEER[kind]
    passes = 1 if kind == "full" else passes
    programs = {"stillpoint": ours(kind, passes), program: theirs(program, passes, quick)}
    finest = programs[program][-1]["place"]
    own, _, _ = run(kind, *REFERENCE[kind])
    apart = math.dist(own, finest)
    if not apart < CLOSE[kind] * (4.0 if quick else 1.0):
        stop(f"swing: {program}'s tip ends {apart:.1e} m from ours, {own} and {finest}")
    reference = finest if kind == "bend" else own
    for runs in programs.values():
        for one in runs:
            one["error"] = math.dist(one["place"], reference)
    return programs, apart


def cells(runs, key):
    """The quickest run to each error."""
    for level in LEVELS:
        reached = [one for one in runs if one["error"] <= level]
        best = min(reached, key=lambda one: one[key], default=None)
        yield "not reached" if best is None else f"{beside.milliseconds(best[key])} ({best['elements']})"


def rows(kind, programs, apart):
    """Lines of the table."""
    mine, program = programs["stillpoint"], PEER[kind]
    return [
        [TITLES[kind], "stillpoint, process", *cells(mine, "seconds"), ""],
        ["", "stillpoint, steps", *cells(mine, "search"), ""],
        ["", NAMES[program], *cells(programs[program], "seconds"), f"{apart:.0e} m"],
    ]
