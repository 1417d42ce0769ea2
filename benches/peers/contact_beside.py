"""Contact and dry friction at rest: stillpoint beside MuJoCo and Drake. Called by `run --contact`.

A box on an incline at 0.5, 0.999 and 1.001 of its friction cone, a pile of four balls that needs a friction of √3 − √2, a stack and a
wall. All programs get the same bodies, friction and gravity. Before that all have to slide alike where the box is at 1.5 of its cone.
"""

import json
import math
import sys

import beside
import report
from environment import say, stop
from options import arguments

GRAVITY = 9.80665
FRICTION = 0.5
# Of balls on each other and on the floor (three that touch, one on top), least for which they stand.
NEEDED = math.sqrt(3.0) - math.sqrt(2.0)
PEERS = {
    "MuJoCo, pyramidal": ("mujoco", "pyramidal"),
    "MuJoCo, elliptic, impratio 10": ("mujoco", "elliptic"),
    "MuJoCo, the same and noslip 10": ("mujoco", "noslip"),
    "Drake, SAP, 1 ms": ("drake", "sap"),
}
MUJOCO = [name for name in PEERS if name.startswith("MuJoCo")]
# At 1.5 of the cone nothing sticks: soft contacts slide by this part of the way otherwise than rigid ones, at most.
AGREE = 0.02
PATIENCE = 900.0


def scene(name, bodies, friction, slope=0.0, times=(1.0, 11.0)):
    """A neutral scene: bodies on z = 0, gravity leant by `slope` (rad) towards +x."""
    gravity = [GRAVITY * math.sin(slope), 0.0, -GRAVITY * math.cos(slope)]
    return {"name": name, "gravity": gravity, "friction": friction, "bodies": bodies, "times": list(times)}


def incline(part, times=(1.0, 11.0)):
    box = {"box": [0.4, 0.2, 0.2], "mass": 2.0, "place": [0.0, 0.0, 0.1]}
    return scene(f"incline{part}", [box], FRICTION, math.atan(FRICTION * part), times)


def speed(part, times):
    """Mean speed of the box between two times (m/s), exactly."""
    slope = math.atan(FRICTION * part)
    rate = max(0.0, GRAVITY * (math.sin(slope) - FRICTION * math.cos(slope)))
    return 0.5 * rate * (times[1] ** 2 - times[0] ** 2) / (times[1] - times[0])


def balls(part):
    radius, out = 0.1, 0.2 / math.sqrt(3.0)
    low = [[out * math.cos(2.0 * math.pi * k / 3.0), out * math.sin(2.0 * math.pi * k / 3.0), radius] for k in range(3)]
    top = [0.0, 0.0, radius + math.sqrt(4.0 * radius**2 - out**2)]
    bodies = [{"ball": radius, "mass": 1.0, "place": place} for place in (*low, top)]
    return scene(f"balls{part}", bodies, NEEDED * part, times=(0.0, 10.0))


def stack():
    boxes = [{"box": [0.2, 0.2, 0.2], "mass": 1.0, "place": [0.0, 0.0, 0.1 + 0.2 * k]} for k in range(10)]
    return scene("stack", boxes, FRICTION)


def wall():
    """105 bricks in ten courses, half ones at the ends of every other."""
    long, deep, high, bodies = 0.25, 0.12, 0.07, []
    for course in range(10):
        ends = (
            [k * long for k in range(11)]
            if course % 2 == 0
            else [0.0, *((k + 0.5) * long for k in range(10)), 10 * long]
        )
        for low, up in zip(ends, ends[1:]):
            size = [up - low, deep, high]
            mass = 1800.0 * size[0] * size[1] * size[2]
            bodies.append({"box": size, "mass": mass, "place": [0.5 * (low + up), 0.0, (course + 0.5) * high]})
    return scene("wall", bodies, 0.6)


def toml(made):
    """Our scenario."""
    lines = [f"gravity = {made['gravity']}", "[simulate]", 'start = "given"', "[record]", "rate = 1.0"]
    lines += ["[[body]]", 'name = "floor"', "shape = { plane = [0.0, 0.0, 1.0] }", 'hinge = { type = "fixed" }']
    for number, body in enumerate(made["bodies"]):
        if "box" in body:
            shape = f"box = {body['box']}"
            squares = [size * size for size in body["box"]]
            inertia = [body["mass"] * (sum(squares) - square) / 12.0 for square in squares]
        else:
            shape, inertia = f"sphere = {body['ball']}", [0.4 * body["mass"] * body["ball"] ** 2] * 3
        place = [*body["place"], 1.0, 0.0, 0.0, 0.0]
        lines += ["[[body]]", f'name = "b{number}"', f"mass = {body['mass']}", f"inertia = {inertia}"]
        lines += [f"shape = {{ {shape} }}", f'hinge = {{ type = "free", position = {place} }}']
    lines += ["[[contact]]", 'between = ["*", "*"]', f"friction = {made['friction']!r}"]
    return "\n".join(lines) + "\n"


def ours(made):
    """Places at both times, by a run from the start to each; CPU seconds of the longer one, the whole process."""
    scenario = beside.write(f"contact_{made['name']}.toml", toml(made))
    answers = []
    for end in made["times"]:
        if end == 0.0:
            answers.append(([body["place"] for body in made["bodies"]], 0.0))
            continue
        out = beside.WORK / "contact.mcap"
        command = ["run", scenario, "--quiet", "--set", f"simulate.duration={end}", "--out", out]
        found, cpu = beside.ours(command, PATIENCE)
        bodies = found["final"]["bodies"]
        answers.append(([bodies[f"b{number}"]["position"] for number in range(len(made["bodies"]))], cpu))
    (first, _), (last, cpu) = answers
    return {"first": first, "last": last, "cpu": cpu}


def theirs(name, made):
    path = beside.write(f"contact_{made['name']}.json", json.dumps(made))
    return beside.peer("contact_peers.py", *PEERS[name], path, patience=PATIENCE)[0]


def one(name, made):
    return ours(made) if name == "stillpoint" else theirs(name, made)


def least(name, made, passes):
    answers = [one(name, made) for _ in range(passes)]
    if any("failed" in answer for answer in answers):
        return answers[0]
    return min(answers, key=lambda answer: answer["cpu"])


def along(answer, times):
    return (answer["last"][0][0] - answer["first"][0][0]) / (times[1] - times[0])


def check():
    """All slide alike where friction is far exceeded."""
    times = (0.5, 1.5)
    for name in ("stillpoint", *PEERS):
        answer = one(name, incline(1.5, times))
        if "failed" in answer:
            stop(f"{name}: {answer['failed']}")
        exact = speed(1.5, times)
        if abs(along(answer, times) - exact) > AGREE * exact:
            stop(f"{name}: a box at 1.5 of its cone slides with {along(answer, times)} m/s instead of {exact}")


def inclines(passes, rows):
    parts = (0.5, 0.999, 1.001)
    lines = [["exactly", *(f"{1e6 * speed(part, (1.0, 11.0)):.1f}" for part in parts), ""]]
    for name in ("stillpoint", *PEERS):
        cells, cost = [], 0.0
        for part in parts:
            made = incline(part)
            answer = least(name, made, passes)
            if "failed" in answer:
                cells.append(answer["failed"])
                continue
            mean, cost = along(answer, made["times"]), max(cost, answer["cpu"])
            cells.append("0" if mean == 0.0 else f"{1e6 * mean:.4g}" if abs(mean) < 0.01 else f"{1e6 * mean:.1f}")
            rows.append(["incline", name, part, mean, answer["cpu"]])
        lines.append([name, *cells, beside.milliseconds(cost)])
    text = (
        "Mean speed down the incline from the first to the eleventh second (µm/s). Time is CPU milliseconds of the slowest of the three, "
        "ours of the whole process, the peers' of ten seconds of integration alone."
    )
    return report.Table("A box on an incline", text, ["", *(f"{part} of the cone" for part in parts), "time"], lines)


def verdict(made):
    """What our statics says without running."""
    scenario = beside.write(f"contact_{made['name']}.toml", toml(made))
    answer, cpu = beside.ours(["statics", scenario, "--quiet"], PATIENCE, codes=(0, 1))
    standing = answer["standing"]
    margin = standing.get("friction_margin")
    said = f"{standing['verdict']} ({100.0 * margin:.1f} % of its friction needed)" if margin else standing["verdict"]
    return said, cpu


def pile(passes, rows):
    parts = (0.9, 1.01, 1.2)
    said = [verdict(balls(part)) for part in parts]
    cost = max(cpu for _, cpu in said)
    lines = [["stillpoint, statics", *(text for text, _ in said), beside.milliseconds(cost)]]
    for name in ("stillpoint", *PEERS):
        cells, cost = [], 0.0
        for part in parts:
            if name == "stillpoint" and part < 1.0:
                cells.append("not run")
                continue
            made = balls(part)
            answer = least(name, made, passes)
            if "failed" in answer:
                cells.append(answer["failed"])
                continue
            sank, cost = made["bodies"][3]["place"][2] - answer["last"][3][2], max(cost, answer["cpu"])
            cells.append("fell" if sank > 0.05 else "0" if sank == 0.0 else f"sank {1e3 * sank:.2g} mm")
            rows.append(["balls", name, part, sank, answer["cpu"]])
        lines.append([f"{name}, 10 s", *cells, beside.milliseconds(cost)])
    text = (
        "Three balls on a floor that touch each other, one on top, at 0.9, 1.01 and 1.2 times the friction that they need (√3 − √2). Where the "
        "uppermost is after ten seconds, and CPU milliseconds of the slowest. Only statics says by how much it stands."
    )
    return report.Table("Four balls", text, ["", *(f"{part} of what it needs" for part in parts), "time"], lines)


def masonry(passes, rows, quick):
    lines = []
    for made, title in ((stack(), "stack of 10 boxes"),) if quick else (
        (stack(), "stack of 10 boxes"),
        (wall(), "wall of 105 bricks"),
    ):
        for name in ("stillpoint", *MUJOCO):
            answer = least(name, made, 1 if made["name"] == "wall" else passes)
            if "failed" in answer:
                lines.append([title, name, answer["failed"], ""])
                continue
            drift = max(math.dist(a, b) for a, b in zip(answer["first"], answer["last"], strict=True))
            shown = "0" if drift == 0.0 else f"{1e3 * drift:.2g} mm"
            lines.append([title, name, shown, beside.milliseconds(answer["cpu"])])
            rows.append([made["name"], name, "", drift, answer["cpu"]])
    text = (
        "How far the body that moved most moved from the first to the eleventh second, and CPU milliseconds: ours of the whole process over eleven "
        "seconds, MuJoCo's of ten seconds of integration alone. Drake is not here: boxes on boxes need another of its models of contact."
    )
    return report.Table("Stack and wall", text, ["scene", "", "drift", "time"], lines)


def main():
    given = arguments()
    passes = given.passes or (1 if given.quick else 3)
    head = report.Head(sys.argv[1:], passes, ("mujoco", "drake"))
    wanted = given.only.split(",") if given.only else ("incline", "balls", "masonry")
    rows, tables = [], []
    say("all slide alike")
    check()
    for name, make in (("incline", inclines), ("balls", pile), ("masonry", masonry)):
        if name in wanted:
            say(name)
            tables.append(make(passes, rows, given.quick) if name == "masonry" else make(passes, rows))
    columns = ["scene", "program", "part", "speed_or_distance", "cpu_seconds"]
    report.write(given, "contact", head, tables, columns, rows, "Contact at rest beside MuJoCo and Drake")


if __name__ == "__main__":
    main()
