"""Tables on the screen, as Markdown and as CSV."""

import csv
import dataclasses
import datetime
import math
import os
import pathlib
import platform
import shlex
import subprocess

from environment import BASE, ROOT, pinned, say


@dataclasses.dataclass
class Table:
    title: str
    text: str
    columns: list
    rows: list

    def markdown(self):
        widths = [max(len(str(row[i])) for row in [self.columns, *self.rows]) for i in range(len(self.columns))]

        def line(row):
            return "| " + " | ".join(str(cell).ljust(wide) for cell, wide in zip(row, widths, strict=True)) + " |"

        rule = "|" + "|".join("-" * (wide + 2) for wide in widths) + "|"
        return "\n".join([f"### {self.title}", "", self.text, "", line(self.columns), rule, *map(line, self.rows), ""])


class Head:
    """When, where and how: made before measuring, for the load of the machine."""

    def __init__(self, options, passes, peers=("pin", "mujoco", "drake", "exudyn"), threads="One thread"):
        self.options, self.passes, self.threads = options, passes, threads
        self.peers = ", ".join(line.replace("==", " ") for line in pinned(peers))
        self.load, self.commit = os.getloadavg()[0], commit()

    def markdown(self):
        options, skip = [], False
        for option in self.options:
            # Where the program lies and where results go says nothing to others.
            if not skip and option not in ("--docs", "--program", "--binary", "--out"):
                options.append(option)
            skip = option in ("--program", "--binary", "--out")
        command = shlex.join(["benches/peers/run", *options])
        return (
            f"`{command}` on {datetime.date.today()}, commit {self.commit}: {processor()}, {os.cpu_count()} cores, "
            f"{platform.system()}; load {self.load:.1f} before and {os.getloadavg()[0]:.1f} after. "
            f"{self.threads}, {self.passes} pass{'es' if self.passes > 1 else ''}; {self.peers}.\n"
        )


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def commit():
    """What is measured: the last commit, and whether the code differs from it."""

    def git(*command):
        return subprocess.run(["git", "-C", str(ROOT), *command], capture_output=True, text=True).stdout.strip()

    changed = git("status", "--porcelain", "--", "src", "benches", "Cargo.toml", "Cargo.lock")
    return (git("rev-parse", "--short", "HEAD") or "unknown") + (" with changes" if changed else "")


def write(given, name, head, tables, columns, rows, heading=None):
    """Prints the tables and writes NAME.md and NAME.csv; with --docs also into the documentation, under its heading."""
    folder = given.out or BASE / "results"
    folder.mkdir(parents=True, exist_ok=True)
    text = "\n".join([head.markdown(), *(table.markdown() for table in tables)])
    print(text)
    (folder / f"{name}.md").write_text(text, encoding="utf-8")
    with open(folder / f"{name}.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)
    say(f"written: {folder / name}.md, {folder / name}.csv")
    if given.docs:
        into_docs(name, text, heading)


def into_docs(name, text, heading=None):
    """Replaces what stands between `<!-- NAME -->` and `<!-- end of NAME -->` in docs/speed.md; a section that is not there yet
    is added before what is not met."""
    page = ROOT / "docs" / "speed.md"
    whole = page.read_text(encoding="utf-8")
    begin, end, next_section = f"<!-- {name} -->\n", f"<!-- end of {name} -->", "## What is not met"
    if begin not in whole and heading:
        section = f"## {heading}\n\n{begin}{end}\n\n"
        whole = whole.replace(next_section, section + next_section, 1)
    before, rest = whole.split(begin, 1)
    after = rest.split(end, 1)[1]
    page.write_text(f"{before}{begin}{text}{end}{after}", encoding="utf-8")


# Warm colours for us, one for each integrator; one cold colour for each peer.
OURS = ["#7f0000", "#d7301f", "#fc8d59", "#e6550d", "#f4a000", "#dd1c77", "#ff5c5c", "#a63603", "#c51b8a", "#ffb347"]
COLORS = {"MuJoCo": ["#1f77b4"], "Drake": ["#2a9d3a"], "Exudyn": ["#8a5cc2"], "stillpoint": OURS}
MARKS = "osD^vPX<>*"
LEAST_ERROR = 1e-12  # m: so well is the reference known


def front(results):
    """The runs that no shorter one of the same integrator beats, down to what is known of the reference."""
    best, least = [], math.inf
    for run in sorted((r for r in results if r.status == "ok" and r.error < 1), key=lambda r: r.seconds):
        if max(run.error, LEAST_ERROR) < least:
            best.append(run)
            least = max(run.error, LEAST_ERROR)
    return best


def plot(given, measured, titles):
    """The best runs of each integrator, error against time, one panel for each problem, as SVG."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "stillpoint", "font.size": 9})
    import matplotlib.pyplot as pyplot

    figure, panels = pyplot.subplots(
        1, len(measured), figsize=(4.6 * len(measured) + 2.2, 5), layout="constrained", squeeze=False
    )
    lines = {}
    for panel, (name, results) in zip(panels[0], measured.items(), strict=True):
        drawn = dict.fromkeys(COLORS, 0)
        for program, integrator in dict.fromkeys((r.program, r.integrator) for r in results):
            runs = front(r for r in results if (r.program, r.integrator) == (program, integrator))
            number, colors, ours = drawn[program], COLORS[program], program == "stillpoint"
            drawn[program] += 1
            if not runs:
                continue
            (line,) = panel.loglog(
                [max(run.error, LEAST_ERROR) for run in runs],
                [run.seconds for run in runs],
                marker=MARKS[number % len(MARKS)],
                color=colors[number % len(colors)],
                linewidth=1.6 if ours else 0.9,
                markersize=4.5 if ours else 3.5,
                zorder=3 if ours else 2,
            )
            lines.setdefault(f"{program} {integrator}", line)
        panel.invert_xaxis()
        panel.set_title(titles[name], fontsize=9, wrap=True)
        panel.set_xlabel("error of the last point (m; 1e-12 and less are one)")
        panel.grid(alpha=0.3)
    panels[0][0].set_ylabel("time (s)")
    figure.legend(lines.values(), lines.keys(), loc="outside right center", fontsize=8, frameon=False)
    folder = ROOT / "docs" if given.docs else given.out or BASE / "results"
    figure.savefig(folder / "speed_integrators.svg", metadata={"Date": None})
    say(f"written: {folder / 'speed_integrators.svg'}")
