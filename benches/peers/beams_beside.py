"""Beams: error against time, stillpoint beside Exudyn. Called by `run --beams`.

Each case has an answer that neither program made: elliptic integrals, shooting, the catenary in closed form. All begin without strain at
full load, Exudyn in ten load steps. An error is the distance of one point to where it should be, over the length of the beam.
"""

import math
import sys

import beside
import report
import swing
from environment import say, stop
from options import arguments

ELASTICA = """title = "Elastica"
gravity = [0.0, 0.0, 0.0]
[[beam]]
name = "rod"
hinge = { type = "fixed" }
length = 1.0
section = { stiffness = [1e4, 1e4, 1e4, 1.0, 1.0, 1.0] }
mass_per_length = 1.0
free = ["bend"]
[[force]]
type = "load"
on = "rod.tip"
force = [0.0, 0.0, -10.0]
[[output]]
name = "point"
type = "position"
of = "rod.tip"
"""
BATHE = """title = "Bathe's bend"
gravity = [0.0, 0.0, 0.0]
[[beam]]
name = "rod"
hinge = { type = "fixed" }
curve = { arc = [100.0, 0.7853981633974483] }
section = { stiffness = [1e7, 5e6, 5e6, 833333.3333333334, 833333.3333333334, 833333.3333333334] }
mass_per_length = 1.0
free = ["bend", "twist", "stretch", "shear"]
[[force]]
type = "load"
on = "rod.tip"
force = [0.0, 0.0, 600.0]
[[output]]
name = "point"
type = "position"
of = "rod.tip"
"""
CATENARY = """title = "Mooring line"
gravity = [0.0, 0.0, -9.80665]
[[cable]]
name = "rod"
between = [{ body = "ground", at = [0.0, 0.0, 0.0] }, { body = "ground", at = [100.0, 0.0, 0.0] }]
length = 110.0
section = { stiffness = [1e6, 1e6, 1e6, 1.0, 1.0, 1.0] }
bending = 0.0
mass_per_length = 5.098581064889641
markers = { middle = 55.0 }
[[output]]
name = "point"
type = "position"
of = "rod.middle"
"""
# Text of our scenario, the point's place (m) and the length (m), how Exudyn's axes name ours, and its elements.
CASES = {
    "elastica": {
        "text": ELASTICA,
        # Elliptic integrals (Mattiasson 1981), P L²/EI = 10.
        "answer": (1.0 - 0.5549955977537513, 0.0, -0.8106090248802965),
        "length": 1.0,
        "theirs": lambda p: (p[0], 0.0, p[1]),
        "elements": ("ge2d", "ancf2d"),
    },
    "bathe": {
        "text": BATHE,
        # Shooting on the equations of the rod to 1e-12; Bathe and Bolourchi 1979.
        "answer": (47.15043857362912, 15.684800534038828, 53.47485879182519),
        "length": 100.0 * 0.25 * math.pi,
        "theirs": tuple,
        "elements": ("ge3d",),
    },
    "catenary": {
        "text": CATENARY,
        # Elastic catenary (Irvine 1981): the middle hangs so far below its ends.
        "answer": (50.0, 0.0, -20.445392367292417),
        "length": 110.0,
        "theirs": lambda p: (p[0], 0.0, p[1]),
        "elements": ("ancf2d",),
    },
}
TITLES = {
    "elastica": "elastica, P L²/EI = 10",
    "bathe": "Bathe's bend, 600",
    "catenary": "mooring line",
}
NAMES = {
    "ge2d": "Exudyn GeometricallyExactBeam2D",
    "ge3d": "Exudyn BeamGeometricallyExact (3D)",
    "ancf2d": "Exudyn ANCFCable2D",
}
OURS = (1, 2, 4, 8, 16, 32, 64)
COUNTS = {"ge2d": (8, 16, 32, 64, 128, 256, 512), "ge3d": (4, 8, 16, 32), "ancf2d": (4, 8, 16, 32, 64, 128)}
LEVELS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
# Where both programs are finest they have to be this close to the answer, or a case is not the same on both sides.
AGREE = 2e-3


def error(case, place):
    return math.dist(place, CASES[case]["answer"]) / CASES[case]["length"]


def ours(case, passes):
    """For every number of elements: error, least CPU seconds of the process and least wall seconds of search and certificate."""
    scenario = beside.write(f"beam_{case}.toml", CASES[case]["text"])
    runs = []
    for n in OURS if case != "catenary" else OURS[1:]:
        command = ["statics", scenario, "--quiet", "--set", f"rod.elements={n}"]
        found = [beside.ours(command) for _ in range(passes)]
        answer = found[0][0]
        if answer["stability"] != "stable":
            stop(f"{case}, {n} elements: stillpoint says {answer['stability']}")
        runs.append(
            {
                "elements": n,
                "error": error(case, answer["outputs"]["point"]),
                "seconds": min(cpu for _, cpu in found),
                "search": min(found["wall_seconds"] for found, _ in found),
            }
        )
    return runs


def theirs(case, element, passes):
    counts = ",".join(map(str, COUNTS[element]))
    answer, _ = beside.peer("beams_exudyn.py", case, element, counts, passes, patience=900.0)
    if "failed" in answer:
        stop(f"{case}, {element}: Exudyn: {answer['failed']}")
    for run in answer["runs"]:
        if "place" in run:
            run["error"] = error(case, CASES[case]["theirs"](run["place"]))
    return answer["runs"]


def check(case, name, runs):
    """Something in the ladder comes close to the answer; a run far away says what it is."""
    close = [run["error"] for run in runs if run.get("error", math.inf) < AGREE]
    if not close:
        stop(f"{case}: {name} comes nowhere near the answer: it is another case")


def quickest(runs, level, key="seconds"):
    reached = [run for run in runs if run.get("error", math.inf) <= level]
    return min(reached, key=lambda run: run[key], default=None)


def cell(run, key="seconds"):
    return "not reached" if run is None else f"{beside.milliseconds(run[key])} ({run['elements']})"


def lines(case, programs):
    """Rows of the table: time to an error for each program, and our process over the peer's solver."""
    mine = programs["stillpoint"]
    first = [TITLES[case], "stillpoint, process", *(cell(quickest(mine, level)) for level in LEVELS)]
    second = ["", "stillpoint, search", *(cell(quickest(mine, level, "search"), "search") for level in LEVELS)]
    rows = [[*first, remarks(mine)], [*second, ""]]
    for element in CASES[case]["elements"]:
        runs = programs[element]
        rows.append(["", NAMES[element], *(cell(quickest(runs, level)) for level in LEVELS), remarks(runs)])
    return rows


def remarks(runs):
    least = min((run["error"] for run in runs if "error" in run), default=math.nan)
    failed = [str(run["elements"]) for run in runs if "failed" in run]
    wrong = [str(run["elements"]) for run in runs if run.get("error", 0.0) > 0.05 and run["elements"] > 4]
    said = [f"least error {least:.0e}"]
    if failed:
        said.append(f"no convergence with {', '.join(failed)}")
    if wrong:
        said.append(f"wrong and said to be right with {', '.join(wrong)}")
    return "; ".join(said)


def main():
    given = arguments()
    passes = given.passes or (1 if given.quick else 5)
    names = [name for name in (*CASES, "swing") if not given.only or name in given.only.split(",")]
    head = report.Head(sys.argv[1:], passes, ("exudyn", "mujoco", "pyelastica"))
    rows, table = [], []
    for case in (name for name in names if name in CASES):
        say(case)
        programs = statics(case, passes)
        table += lines(case, programs)
        rows += csv_rows(case, programs)
    tables = [statics_table(table)] if table else []
    if "swing" in names:
        tables.append(swing_table(passes, given.quick, rows))
    csv = ["case", "program", *KEYS]
    report.write(given, "beams", head, tables, csv, rows, "Beams beside Exudyn, MuJoCo and PyElastica")


KEYS = ("elements", "error", "seconds", "search", "failed")


def csv_rows(case, programs):
    return [[case, name, *(run.get(key, "") for key in KEYS)] for name, runs in programs.items() for run in runs]


def statics(case, passes):
    """The runs of all programs, after a look at whether they are of the same case."""
    programs = {"stillpoint": ours(case, passes)}
    for element in CASES[case]["elements"]:
        programs[element] = theirs(case, element, passes)
    for name, runs in programs.items():
        check(case, name, runs)
    return programs


def swing_table(passes, quick, rows):
    table = []
    for kind in swing.FREE:
        say(swing.TITLES[kind])
        programs, apart = swing.measure(kind, min(passes, 2), quick)
        table += swing.rows(kind, programs, apart)
        rows += csv_rows(f"swing, {kind}", programs)
    text = (
        "A rod of rubber (1 m, 20 mm thick, E = 10 MPa) on a pin falls from horizontal for half a second: CPU milliseconds to an error of the tip of at most so "
        "many metres, in brackets the number of elements (ours with degree and tolerance of `dop853`). Our process is CPU time of all of `stillpoint run`, our steps "
        "what it says of them (wall time); the peers' is CPU time of the integration alone, Python, Numba's compilation and building of the model not counted. The last column is how far our finest run is from the peer's."
    )
    columns = ["case", "program", *(f"{level:.0e} m" for level in swing.LEVELS), "apart"]
    return report.Table("A rod swings", text, columns, table)


def statics_table(table):
    text = (
        "Milliseconds to an error of at most so much of the length of the beam, in brackets the number of elements. Our process is CPU time of all of "
        "`stillpoint statics`, with certificate, modes and JSON; our search is what it says of search and certificate itself (wall time: it suffers on a busy "
        "machine). Exudyn's is the CPU time of its solver alone, the scene built already and Python (about 0.7 s) not counted. Ten load steps: with "
        "one the 2D beams come to wrong equilibria and report success. Its 2D beams stretch and shear with 1e9 N, as good as not at all. Nothing "
        "of MuJoCo and PyElastica is here: they have no statics."
    )
    columns = ["case", "program", *(f"{level:.0e}" for level in LEVELS), "remarks"]
    return report.Table("Time to an error, from the beam without strain", text, columns, table)


if __name__ == "__main__":
    main()
