"""Writes the scenes of `scenarios/nets`: nets, trusses and towers that no `repeat` can say.

    python3 benches/peers/net_scenes.py            writes scenarios/nets/*.toml

Standard library only. What each scene claims stands in its first lines and is tested in `tests/all/nets`.
"""

import math
import pathlib

import nets
from nets import GRAVITY, UPWARD, Graph, ball, bar

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "scenarios" / "nets"
SETTINGS = ["[simulate]", "duration = 1.0", "tolerance = 1e-6", "", "[record]", "rate = 50.0", ""]


def scene(title, story, settings=()):
    graph = Graph(title, story)
    graph.settings = [*settings, *SETTINGS]
    return graph


def ground(place):
    return {"body": "ground", "at": list(place)}


def hanging_net():
    """From flat; each corner carries a quarter of the weight."""
    n, mass = 8, 0.05
    graph = nets.net(n, mass=mass, color="#4f6f8f")
    graph.title = "Net let down from flat"
    graph.story = f"""
A net of {n} x {n} knots, held at its corners, is let down from flat: 60 balls of 50 g on three slides each, springs between
neighbours that are 3 % shorter than the meshes.

Flat springs have no stiffness across the net, so statics begins at a place of which Newton's method knows nothing. By
symmetry each corner carries a quarter of the weight.

    stillpoint statics scenarios/nets/hanging_net.toml
"""
    graph.settings = SETTINGS
    return graph


ROOF = {"meshes": 8, "width": 8.0, "density": 2000.0, "stiffness": 2e5, "mass": 6.0, "along": 0.05}


def roof_across():
    """Curvature across, so that the surplus of both curvatures carries the weight: 2 q (a - b) = m g / d²."""
    d = ROOF["width"] / ROOF["meshes"]
    return ROOF["along"] - 0.5 * ROOF["mass"] * GRAVITY / (ROOF["density"] * d * d)


def cable_roof():
    """Force densities that are equal make the discrete surface z = a x² - b y² one in balance."""
    n, q, k, m, a = ROOF["meshes"], ROOF["density"], ROOF["stiffness"], ROOF["mass"], ROOF["along"]
    d, b = ROOF["width"] / n, roof_across()
    graph = scene(
        "Roof of prestressed cables",
        f"""
A roof of cables over 8 m x 8 m, saddle-shaped: hanging cables along x, stressing cables along y, {(n - 1) ** 2} knots of {m} kg.

Its cables are cut so that each has the force density q = {q} N/m (tension over length; Schek 1974) on the surface
z = a x² - b y². There a knot's neighbours pull it up by 2 q (a - b) d², its weight, if b = a - m g / (2 q d²): that surface is in
balance, whatever the cables' stiffness. Statics begins from flat and finds its knots.

    stillpoint statics scenarios/nets/cable_roof.toml
""",
    )
    at = lambda i: (i - n / 2) * d
    height = lambda i, j: a * at(i) ** 2 - b * at(j) ** 2
    edge = lambda i, j: i in (0, n) or j in (0, n)
    for i in range(n + 1):
        for j in range(n + 1):
            if not edge(i, j):
                ball(graph, f"knot{i}_{j}", [at(i), at(j), 0.0], m, {"sphere": 0.06, "color": "#c08a3e"})
    end = lambda i, j: ground([at(i), at(j), height(i, j)]) if edge(i, j) else f"knot{i}_{j}"
    for i in range(n + 1):
        for j in range(n + 1):
            for x, y, name in ((i + 1, j, "hanging"), (i, j + 1, "stressing")):
                if x > n or y > n or (edge(i, j) and edge(x, y)):
                    continue
                length = math.hypot(d, height(x, y) - height(i, j))
                slack = length - q * length / k
                graph.force(
                    name=f"{name}{i}_{j}",
                    type="spring",
                    between=[end(i, j), end(x, y)],
                    stiffness=k,
                    length=slack,
                    damping=20.0,
                )
    return graph


TRUSS = {"panels": 20, "panel": 2.0, "height": 2.5, "deck": 1500.0, "knot": 40.0}


def truss_bridge():
    """A Warren truss of rigid bars: their forces follow from statics alone."""
    n, a, h = TRUSS["panels"], TRUSS["panel"], TRUSS["height"]
    graph = scene(
        "Truss bridge",
        f"""
A Warren truss of {4 * n - 1} bars over {n * a:.0f} m, {h} m high: pinned on the left bank, on rollers on the right one. Every
bar is a rigid rod with a name, every knot weighs {TRUSS["knot"]:.0f} kg, every knot of the deck carries {TRUSS["deck"]:.0f} N.

There is nothing left to move, and statics says what each bar carries. By Ritter's section through panel i the lower chord
carries M(i)/h, M the moment of all forces left of the section about the upper knot.

    stillpoint statics scenarios/nets/truss_bridge.toml --json
""",
    )
    lower = [[i * a, 0.0, 0.0] for i in range(n + 1)]
    upper = [[(i + 0.5) * a, 0.0, h] for i in range(n)]

    def knot(name, place, rolls=False):
        graph.body(
            f"{name}.x" if not rolls else name,
            {"type": "prismatic", "at": place, "axis": [1.0, 0.0, 0.0]},
            **({"mass": TRUSS["knot"]} if rolls else {}),
        )
        if not rolls:
            graph.body(
                name,
                {"type": "prismatic", "parent": f"{name}.x", "axis": [0.0, 0.0, 1.0]},
                mass=TRUSS["knot"],
                shape={"sphere": 0.12, "color": "#4f6f8f"},
            )

    for i in range(1, n):
        knot(f"lower{i}", lower[i])
        graph.force(name=f"deck{i}", type="load", on=f"lower{i}", force=[0.0, 0.0, -TRUSS["deck"]])
    knot(f"lower{n}", lower[n], rolls=True)
    for i in range(n):
        knot(f"upper{i}", upper[i])
    end = lambda row, i: ground(lower[0]) if row == "lower" and i == 0 else f"{row}{i}"
    place = {"lower": lower, "upper": upper}

    def rod(name, one, other):
        length = math.dist(place[one[0]][one[1]], place[other[0]][other[1]])
        graph.loop(name=name, type="rod", between=[end(*one), end(*other)], length=length)

    for i in range(n):
        rod(f"lower chord {i}", ("lower", i), ("lower", i + 1))
        rod(f"rising {i}", ("lower", i), ("upper", i))
        rod(f"falling {i}", ("upper", i), ("lower", i + 1))
        if i + 1 < n:
            rod(f"upper chord {i}", ("upper", i), ("upper", i + 1))
    return graph


MAST = {"stages": 100, "bar": 0.4, "mass": 0.1, "spring": 2e4, "rest": 0.9366, "start": 0.6}


def scissor_mast():
    """Stages of crossed bars; one spring at the foot carries the whole mast."""
    n, length, mass, start = MAST["stages"], MAST["bar"], MAST["mass"], MAST["start"]
    graph = scene(
        "Deployable scissor mast",
        f"""
A mast of {n} stages of crossed bars that lengthens like a lazy tongs: {2 * n} bars of {length} m and {mass} kg, closed by {2 * n}
hinges. A spring in the hinge at its foot carries it.

All bars lean by one angle θ: the mast has one way to move, its weight works with m g n² L sin θ, m the mass of a bar, and it
stands where the spring's moment k (θ₀ - θ) is m g n² L cos θ.

    stillpoint statics scenarios/nets/scissor_mast.toml
""",
    )
    keys = {
        "shape": {
            "capsule": [0.01, length],
            "at": [0.5 * length, 0.0, 0.0],
            "rpy": [0.0, 0.5 * math.pi, 0.0],
            "color": "#9aa0a6",
        }
    }
    across = math.pi - start
    middle = [0.5 * length, 0.0, 0.0]
    step = length * math.sin(start)
    wide = length * math.cos(start)
    before = 0.0
    for k in range(n):
        hinge = {"type": "revolute", "axis": UPWARD, "position": start - before}
        hinge |= {"parent": f"left{k - 1}", "at": "end"} if k else {"stiffness": MAST["spring"], "rest": MAST["rest"]}
        bar(graph, f"right{k}", hinge, [0.0, 0.0, k * step], start, length, mass, **keys)
        crossing = {"type": "revolute", "parent": f"right{k}", "at": middle, "axis": UPWARD, "position": across - start}
        graph.body(
            f"left{k}",
            crossing,
            mass=mass,
            inertia=nets.slender(mass, length),
            markers={"end": [0.5 * length, 0.0, 0.0], "foot": [-0.5 * length, 0.0, 0.0]},
            shape={**keys["shape"], "at": [0.0, 0.0, 0.0], "color": "#c08a3e"},
        )
        before = across
        if k == 0:
            graph.body(
                "foot",
                {"type": "prismatic", "axis": [1.0, 0.0, 0.0], "position": wide},
                mass=0.2,
                shape={"box": [0.06, 0.1, 0.04]},
            )
            graph.loop(name="foot hinge", type="revolute", between=["left0.foot", "foot"], axis=[0.0, 1.0, 0.0])
        else:
            graph.loop(
                name=f"hinge{k}", type="revolute", between=[f"left{k}.foot", f"right{k - 1}.end"], axis=[0.0, 1.0, 0.0]
            )
    return graph


MAIL = {"rows": 8, "radius": 0.01, "mass": 2e-3, "rope": 2e-3, "stiffness": 1e4}


def chain_mail():
    """A triangle of rings, each of which hangs in two."""
    rows, r, m, gap = MAIL["rows"], MAIL["radius"], MAIL["mass"], MAIL["rope"]
    graph = scene(
        "Patch of chain mail",
        f"""
A triangle of {rows * (rows + 1) // 2} rings of {1e3 * m:.0f} g, {rows} rows: each hangs in the two above it, the first row in hooks. Where two rings
touch there is a short rope, which pulls and never pushes.

Drawn square, with all ropes vertical, it is balanced and unstable: rings turn until their ropes pull along diagonals, and the patch
lengthens. Whatever it does, the ropes between two rows carry the weight of all rings below.

    stillpoint statics scenarios/nets/chain_mail.toml
""",
    )
    c = r / math.sqrt(2.0)
    drop = 2.0 * c + gap
    markers = {
        f"{v}_{h}": [x * c, 0.0, z * c]
        for v, z in (("upper", 1.0), ("lower", -1.0))
        for h, x in (("left", -1.0), ("right", 1.0))
    }
    shape = [
        {
            "capsule": [0.08 * r, 2.0 * r * math.sin(math.pi / 8)],
            "at": [r * math.cos(math.pi / 8) * math.cos(t), 0.0, r * math.cos(math.pi / 8) * math.sin(t)],
            "rpy": [0.0, -t, 0.0],
            "color": "#9aa0a6",
        }
        for t in [math.pi * k / 4.0 + math.pi / 8.0 for k in range(8)]
    ]
    for i in range(rows):
        for j in range(rows - i):
            # A little aside and turned: the patch swings into place.
            x, z, lean = (2.0 * j + i) * c, -(c + gap) - i * drop, 0.02 * math.sin(1.0 + 7.0 * i + 3.0 * j)
            hinge = {
                "type": "free",
                "position": [
                    x + 2e-4 * math.sin(i + 2.0 * j),
                    1e-4 * math.cos(3.0 * i + j),
                    z,
                    math.cos(lean),
                    0.0,
                    math.sin(lean),
                    0.0,
                ],
            }
            graph.body(
                f"ring{i}_{j}",
                hinge,
                mass=m,
                inertia=[0.5 * m * r * r, m * r * r, 0.5 * m * r * r],
                markers=markers,
                shape=shape,
            )
            for side, above in (("left", f"ring{i - 1}_{j}.lower_right"), ("right", f"ring{i - 1}_{j + 1}.lower_left")):
                where = x - c if side == "left" else x + c
                other = above if i else ground([where, 0.0, 0.0])
                graph.force(
                    name=f"touch{i}_{j}_{side}",
                    type="rope",
                    through=[f"ring{i}_{j}.upper_{side}", other],
                    stiffness=MAIL["stiffness"],
                    length=gap,
                    damping=0.5,
                )
    return graph


TOWER = {"stages": 20, "radius": 1.0, "strut": 2.4, "mass": 8.0, "stiffness": 1e5, "cable": 1.2}


def tensegrity_tower():
    """Prisms of three struts and three cables on top of each other."""
    n, r, strut = TOWER["stages"], TOWER["radius"], TOWER["strut"]
    graph = scene(
        "Tensegrity tower",
        f"""
{n} tensegrity prisms on top of each other: triangular plates of {TOWER["mass"]:.0f} kg, between each two three struts that push (rigid rods
without mass) and three cables that pull. No strut touches another.

Without weight each plate is turned by 30° against the one below, whatever the cables' stiffness: there strut and cable, which
are a third of a turn apart, pull a plate's corner the same way (Tobie 1967). With the weight of all above it a stage is a problem
of one unknown, its twist.

    stillpoint statics scenarios/nets/tensegrity_tower.toml
""",
    )
    corner = [[r * math.cos(t), r * math.sin(t), 0.0] for t in [2.0 * math.pi * k / 3.0 for k in range(3)]]
    markers = {f"corner{k}": place for k, place in enumerate(corner)}
    twist = math.radians(30.0)
    height = math.sqrt(strut**2 - 2.0 * r * r * (1.0 - math.cos(twist + 2.0 * math.pi / 3.0)))
    edge = [[0.5 * (corner[k][c] + corner[(k + 1) % 3][c]) for c in range(3)] for k in range(3)]
    shape = [
        {
            "capsule": [0.03, r * math.sqrt(3.0)],
            "at": edge[k],
            "rpy": [0.5 * math.pi, 0.0, 2.0 * math.pi * k / 3.0 + math.pi / 3.0],
            "color": "#4f6f8f",
        }
        for k in range(3)
    ]
    for k in range(n):
        hinge = {"type": "free", "position": [0.0, 0.0, height, math.cos(0.5 * twist), 0.0, 0.0, math.sin(0.5 * twist)]}
        if k:
            hinge["parent"] = f"plate{k - 1}"
        inertia = TOWER["mass"] * r * r
        graph.body(
            f"plate{k}",
            hinge,
            mass=TOWER["mass"],
            inertia=[0.25 * inertia, 0.25 * inertia, 0.5 * inertia],
            markers=markers,
            shape=shape,
        )
        for c in range(3):
            below = f"plate{k - 1}.corner{c}" if k else ground(corner[c])
            graph.loop(name=f"strut{k}_{c}", type="rod", between=[below, f"plate{k}.corner{(c + 1) % 3}"], length=strut)
            graph.force(
                name=f"cable{k}_{c}",
                type="spring",
                between=[below, f"plate{k}.corner{c}"],
                stiffness=TOWER["stiffness"],
                length=TOWER["cable"],
                damping=50.0,
            )
    return graph


WEB = {"rays": 14, "turns": 7, "radius": 0.3, "stiffness": 2.0, "stretched": 1.25, "knot": 2e-6, "insect": 3e-4}


def spider_web():
    """Rays and turns of thread in a plane, and an insect on one knot."""
    n, turns, k = WEB["rays"], WEB["turns"], WEB["stiffness"]
    graph = scene(
        "Spider web with an insect",
        f"""
A spider's web in a vertical plane: {n} rays and {turns} turns of thread, stretched by a quarter, {n * turns + 1} knots of {1e6 * WEB["knot"]:.0f} mg, and
an insect of {1e6 * WEB["insect"]:.0f} mg that is caught on one of them. Threads are {k} N/m over 0.3 m, shorter ones stiffer.

The scene is stiff within the web and soft across it. Where the insect hangs is what SciPy finds for the same threads.

    stillpoint statics scenarios/nets/spider_web.toml
""",
    )
    angle = lambda i: 2.0 * math.pi * i / n + 0.06 * math.sin(5.0 * i)
    away = lambda i, j: WEB["radius"] * j / (turns + 1) * (1.0 + 0.05 * math.sin(3.0 * i))
    place = lambda i, j: [away(i, j) * math.cos(angle(i)), 0.0, away(i, j) * math.sin(angle(i))]
    ball(graph, "hub", [0.0, 0.0, 0.0], WEB["knot"])
    for i in range(n):
        for j in range(1, turns + 1):
            caught = (i, j) == (3, 5)
            shape = {"sphere": 0.006, "color": "#803030"} if caught else {"sphere": 0.001}
            ball(graph, f"knot{i}_{j}", place(i, j), WEB["insect"] + WEB["knot"] if caught else WEB["knot"], shape)

    def thread(name, one, other):
        ends = [
            ground(place(*e)) if e[1] == turns + 1 else ("hub" if e[1] == 0 else f"knot{e[0]}_{e[1]}")
            for e in (one, other)
        ]
        slack = math.dist(place(*one), place(*other)) / WEB["stretched"]
        graph.force(
            name=name, type="spring", between=ends, stiffness=k * WEB["radius"] / slack, length=slack, damping=1e-4
        )

    for i in range(n):
        for j in range(turns + 1):
            thread(f"ray{i}_{j}", (i, j), (i, j + 1))
            if j:
                thread(f"turn{i}_{j}", (i, j), ((i + 1) % n, j))
    return graph


SCENES = (hanging_net, cable_roof, truss_bridge, scissor_mast, chain_mail, tensegrity_tower, spider_web)

if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for make in SCENES:
        (FOLDER / f"{make.__name__}.toml").write_text(make().toml())
