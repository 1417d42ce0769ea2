"""Equilibria of hanging nets: stillpoint beside Exudyn's sparse solver and a page of SciPy. Called by `run --nets`.

The scene is `nets.py net N`: N × N balls let down from flat. All three begin there and have to find the same places.
"""

import collections
import json
import math
import sys

import beside
import nets
import report
from environment import say, stop
from options import arguments

SIZES = (10, 20, 30, 50)
# Two programs have found the same equilibrium if no ball is further away than this, of a net one metre wide (m).
AGREE = 1e-8
PROGRAMS = ("stillpoint", "exudyn", "scipy")
PATIENCE = 300.0


def distance(places, others):
    return max(math.dist(one, other) for one, other in zip(places, others, strict=True))


def ours(n):
    """Places of all points in the order of the scene, what the search and the certificate took, and the whole process."""
    answer, cpu = beside.ours(["statics", beside.WORK / f"net{n}.toml"], PATIENCE)
    if answer["stability"] != "stable" or not answer["converged"]:
        stop(f"net {n}: stillpoint says {answer['stability']}")
    corner = lambda i, j: [i / (n - 1), j / (n - 1), 0.0]
    found = lambda i, j: answer["bodies"].get(f"ball{i}_{j}", {}).get("position", corner(i, j))
    return {
        "positions": [found(i, j) for i in range(n) for j in range(n)],
        "seconds": answer["wall_seconds"],
        "modes": len(answer["modes"]),
        "residual": answer["relative_residual"],
    }, cpu


def once(program, n):
    if program == "stillpoint":
        return ours(n)
    return beside.peer("nets_peers.py", program, beside.WORK / f"net{n}.json", patience=PATIENCE)


def measure(n, passes):
    """The answers of one net and the least CPU seconds of each program: whole process, and the peers' search alone."""
    graph = nets.net(n)
    beside.write(f"net{n}.toml", graph.toml())
    beside.write(f"net{n}.json", graph.neutral())
    answers, whole, search = {}, collections.defaultdict(list), collections.defaultdict(list)
    for number in range(passes):
        for program in PROGRAMS:
            if "failed" in answers.get(program, {}):
                continue
            answer, cpu = once(program, n)
            if number == 0:
                answers[program] = answer
                if "failed" not in answer and program != "stillpoint":
                    off = distance(answer["positions"], answers["stillpoint"]["positions"])
                    if off > AGREE:
                        stop(f"net {n}: {program} puts a ball {off:.1e} m from where stillpoint has it")
                    answer["off"] = off
            if "failed" not in answer:
                whole[program].append(cpu)
                search[program].append(answer["seconds"])
    least = lambda lists: {program: min(times) for program, times in lists.items()}
    return answers, least(whole), least(search)


def row(n, answers, whole, search):
    """A line of the table and one of the CSV."""
    said = lambda program, value: answers[program].get("failed") or value
    off = max((answers[p]["off"] for p in ("exudyn", "scipy") if "off" in answers[p]), default=math.nan)
    cell = lambda program, lists: said(program, beside.milliseconds(lists[program]) if program in lists else "")
    ratio = lambda program, lists: (
        said(program, "") and "–" if "failed" in answers[program] else beside.times(whole["stillpoint"] / lists[program])
    )
    shown = [
        n,
        3 * (n * n - 4),
        beside.milliseconds(whole["stillpoint"]),
        cell("exudyn", search),
        cell("exudyn", whole),
        cell("scipy", search),
        cell("scipy", whole),
        ratio("exudyn", search),
        ratio("scipy", search),
        f"{off:.0e} m",
    ]
    return shown


COLUMNS = [
    "net",
    "coordinates",
    "stillpoint, process",
    "Exudyn, search",
    "Exudyn, process",
    "SciPy, search",
    "SciPy, process",
    "to Exudyn's search",
    "to SciPy's search",
    "farthest ball",
]


def growth(measured):
    """Exponents of the time over the coordinates, from each net to the next."""
    lines = []
    sizes = sorted(measured)
    for one, two in zip(sizes, sizes[1:]):
        step = math.log((two * two - 4) / (one * one - 4))
        exponent = lambda lists, program: (
            f"{math.log(lists[two][program] / lists[one][program]) / step:.2f}"
            if program in lists[one] and program in lists[two]
            else "–"
        )
        whole = {n: measured[n][1] for n in sizes}
        search = {n: measured[n][2] for n in sizes}
        lines.append(
            [f"{one} to {two}", exponent(whole, "stillpoint"), exponent(search, "exudyn"), exponent(search, "scipy")]
        )
    return lines


def main():
    given = arguments()
    passes = given.passes or (1 if given.quick else 3)
    sizes = [int(n) for n in given.only.split(",")] if given.only else SIZES
    head = report.Head(sys.argv[1:], passes, ("exudyn", "scipy", "numpy"))
    measured, rows = {}, []
    for n in sizes:
        say(f"net {n}")
        measured[n] = measure(n, passes)
        answers, whole, search = measured[n]
        for program in PROGRAMS:
            rows.append([n, program, whole.get(program), search.get(program), answers[program].get("failed", "")])
    text = (
        "CPU milliseconds, minima. Ours is the whole process: reading the file, the search, the certificate with the lowest eight modes "
        "and the JSON that is printed. The peers' search is their solver alone, without certificate and modes, the scene built already; their "
        "process is also Python, its imports and building the scene. Ratios are our whole process to a peer's search alone."
    )
    tables = [report.Table("Equilibria of hanging nets", text, COLUMNS, [row(n, *measured[n]) for n in sizes])]
    if len(sizes) > 1:
        note = "Exponents of these times over the number of coordinates: our process, the peers' searches."
        tables.append(report.Table("Growth", note, ["nets", "stillpoint", "Exudyn", "SciPy"], growth(measured)))
    columns = ["net", "program", "process_cpu_seconds", "search_seconds", "failed"]
    report.write(given, "nets", head, tables, columns, rows, "Nets beside Exudyn and SciPy")


if __name__ == "__main__":
    main()
