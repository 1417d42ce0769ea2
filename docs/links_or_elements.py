#!/usr/bin/env python3
"""Sets rigid links with springs beside beam elements: error against time of the elastica, docs/links_or_elements.svg.

    cargo build --release --no-default-features --features cli && docs/links_or_elements.py [PROGRAM]

Times are the shortest of `--runs` runs (20) of the search alone, as `statics --json` has it. The answer is by elliptic
integrals (tests/reference/beams/elastica_tip_force.json). Needs Python's standard library only.
"""

import argparse
import json
import math
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
BEAMS = ROOT / "scenarios/beams"
COLORS = {"rigid links": "#d55e00", "elements, degree 1": "#0072b2", "elements, degree 2": "#009e73"}
WIDTH, HEIGHT, LEFT, RIGHT, TOP, FOOT = 760, 460, 86, 190, 46, 56


def exact():
    case = json.loads((ROOT / "tests/reference/beams/elastica_tip_force.json").read_text())
    across, down, _ = case["expected"][3]["value"]
    return 1.0 - across, -down


def asked(program, scenario, changes, runs):
    """Error of the tip (parts of the length) and the shortest time (s)."""
    call = [program, "statics", BEAMS / scenario, "--json", "--quiet"]
    for change in changes:
        call += ["--set", change]
    times = []
    for _ in range(runs):
        done = json.loads(subprocess.run(call, capture_output=True, text=True, check=True).stdout)
        times.append(done["wall_seconds"])
    x, _, z = done["outputs"]["tip"]
    to = exact()
    return math.hypot(x - to[0], z - to[1]), min(times), done["factorizations"]


def measured(program, runs):
    def links(n):
        end = f'"link[{n - 1}].end"'
        return [f"parameters.n={n}", f"link.repeat={n}", f"pull.on={end}", f"tip.of={end}"]

    rows = {name: [] for name in COLORS}
    for n in [4, 8, 16, 32, 64, 128, 256]:
        rows["rigid links"].append((n, *asked(program, "elastica_of_links.toml", links(n), runs)))
    for degree in [1, 2]:
        for n in [1, 2, 4, 8, 16, 32]:
            change = [f"rod.elements={n}", f"rod.degree={degree}"]
            rows[f"elements, degree {degree}"].append((n, *asked(program, "elastica.toml", change, runs)))
    return rows


def plot(rows):
    points = [point for of in rows.values() for point in of]
    decades = lambda values: (math.floor(math.log10(min(values))), math.ceil(math.log10(max(values))))
    across, up = decades([p[2] for p in points]), decades([max(p[1], 1e-14) for p in points])
    x = lambda t: LEFT + (math.log10(t) - across[0]) / (across[1] - across[0]) * (WIDTH - LEFT - RIGHT)
    y = lambda e: TOP + (up[1] - math.log10(max(e, 1e-14))) / (up[1] - up[0]) * (HEIGHT - TOP - FOOT)
    text = lambda px, py, words, anchor="start", size=14: (
        f'<text x="{px:.1f}" y="{py:.1f}" text-anchor="{anchor}" font-family="sans-serif" font-size="{size}">{words}</text>'
    )
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>',
        text(LEFT, 26, "Elastica, P L²/EI = 10, from the straight rod", size=17),
    ]
    for k in range(across[0], across[1] + 1):
        px = x(10.0**k)
        out.append(f'<path d="M{px:.1f} {TOP}V{HEIGHT - FOOT}" stroke="#dddddd"/>')
        out.append(text(px, HEIGHT - FOOT + 20, f"1e{k}", "middle"))
    for k in range(up[0], up[1] + 1, 2):
        py = y(10.0**k)
        out.append(f'<path d="M{LEFT} {py:.1f}H{WIDTH - RIGHT}" stroke="#dddddd"/>')
        out.append(text(LEFT - 8, py + 5, f"1e{k}", "end"))
    out.append(text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 12, "time of the search (s)", "middle"))
    out.append(
        f'<text transform="translate(22 {(TOP + HEIGHT - FOOT) / 2}) rotate(-90)" text-anchor="middle" '
        f'font-family="sans-serif" font-size="14">error of the tip / L</text>'
    )
    for row, (name, of) in enumerate(rows.items()):
        color = COLORS[name]
        path = "L".join(f"{x(p[2]):.1f} {y(p[1]):.1f}" for p in of)
        out.append(f'<path d="M{path}" fill="none" stroke="{color}" stroke-width="2"/>')
        for n, error, time, _ in of:
            out.append(f'<circle cx="{x(time):.1f}" cy="{y(error):.1f}" r="4" fill="{color}"/>')
            out.append(text(x(time) + 6, y(error) - 6, n, size=11))
        py = TOP + 20 + 24 * row
        out.append(f'<path d="M{WIDTH - RIGHT + 16} {py}h26" stroke="{color}" stroke-width="2"/>')
        out.append(text(WIDTH - RIGHT + 50, py + 5, name))
    out.append("</svg>\n")
    return "\n".join(out)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", nargs="?", default=ROOT / "target/release/stillpoint")
    parser.add_argument("--runs", type=int, default=20)
    given = parser.parse_args()
    rows = measured(given.program, given.runs)
    print("| | n | error / L | time (ms) | factorizations |\n|---|---|---|---|---|")
    for name, of in rows.items():
        for n, error, time, factorizations in of:
            print(f"| {name} | {n} | {error:.1e} | {1e3 * time:.3f} | {factorizations} |")
    (ROOT / "docs/links_or_elements.svg").write_text(plot(rows))


if __name__ == "__main__":
    main()
