#!/usr/bin/env python3
"""Runs every scenario and puts what came out into docs/guide/how_right_how_fast.md.

    cargo build --release --no-default-features --features cli && docs/measure.py [PROGRAM]

Times are the shortest of three runs. Needs Python's standard library only.
"""

import datetime
import json
import pathlib
import platform
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/guide/how_right_how_fast.md"
BEGIN, END = "<!-- measured -->\n", "<!-- end of measured -->"
RUNS = 3


def asked(program, command, scenario, *options):
    """What `stillpoint COMMAND SCENARIO --json` answers; None where the answer is no."""
    call = [program, command, scenario, *options, "--json", "--quiet"]
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(call, cwd=folder, capture_output=True, text=True)
    if done.returncode == 2:
        sys.exit(f"{' '.join(map(str, call))}\n{done.stderr}")
    return json.loads(done.stdout)


def shortest(program, command, scenario):
    """The first answer, and the shortest time of several."""
    answers = [asked(program, command, scenario) for _ in range(RUNS)]
    return answers[0], min(answer["wall_seconds"] for answer in answers)


def seconds(time):
    for unit, name in [(1.0, "s"), (1e-3, "ms")]:
        if time >= unit:
            return f"{time / unit:.3g} {name}"
    return f"{time / 1e-6:.3g} µs"


def small(number):
    return "0" if number == 0 else f"{number:.0e}"


def table(heads, rows):
    lines = [heads, ["---"] + ["---:"] * (len(heads) - 1), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def equilibrium(program, name, scenario):
    answer, time = shortest(program, "statics", scenario)
    rest = asked(program, "rest", scenario) if answer["converged"] else None
    stays = "–"
    if rest is not None and rest["growth"] is None:
        stays = small(rest["max_displacement"]["value"])
    elif rest is not None:
        growth = rest["growth"]
        stays = f"leaves: {growth['observed'] or 0.0:.5g}/s, predicted {growth['predicted']:.5g}/s"
    lowest = next((f"{f:.4g} Hz" for f in answer["frequencies_hz"] or [] if f), "–")
    verdict = answer["stability"] if answer["converged"] else "none"
    return [name, verdict or "–", small(answer["relative_residual"]), lowest, stays, seconds(time)]


def motion(program, name, scenario):
    answer, time = shortest(program, "run", scenario)
    checked = asked(program, "run", scenario, "--verify")["verified"]
    error = "–" if checked is None else " ".join(
        f"{checked[key]:.0e} {unit}" for key, unit in [("angle", "rad"), ("length", "m")] if checked.get(key)
    ) or "0"
    return [
        name,
        answer["integrator"],
        f"{answer['steps']}",
        small(answer["energy_drift"]),
        small(answer["constraint_error"]) if answer["constraint_error"] else "–",
        error,
        seconds(time),
        f"{answer['end_time'] / time:.3g} ×",
    ]


def main():
    program = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/stillpoint").resolve()
    rests, runs = [], []
    for scenario in sorted((ROOT / "scenarios").glob("*.toml")):
        print(scenario.stem, file=sys.stderr)
        name = f"[{scenario.stem}](../../scenarios/{scenario.name})"
        if 'start = "given"' not in scenario.read_text():
            rests.append(equilibrium(program, name, scenario))
        runs.append(motion(program, name, scenario))
    today = datetime.date.today().isoformat()
    text = f"`docs/measure.py` on {today}, {platform.machine()}, {platform.system()}, one thread.\n\n"
    text += "Equilibria, and how far a hinge moves in the run of `rest` that starts from them (rad or m):\n\n"
    text += table(["scenario", "verdict", "residual", "lowest mode", "moves by", "time"], rests)
    text += "\nRuns as the scenario asks for them. **Energy** is what neither loads nor dampers explain (J); "
    text += "**gap** the widest of loops, drives and gears (m); **error** that of angles and distances at the end, by a "
    text += "second run that is tighter and by another method (`--verify`):\n\n"
    heads = ["scenario", "method", "steps", "energy", "gap", "error at the end", "time", "of real time"]
    text += table(heads, runs)
    page = PAGE.read_text()
    head, rest = page.split(BEGIN)
    PAGE.write_text(head + BEGIN + text + END + rest.split(END)[1])


if __name__ == "__main__":
    main()
