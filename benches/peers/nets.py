"""Scenes that are graphs: nets of springs, ladders of loops, a bridge, grids of rods, chains with far springs.

    python3 benches/peers/nets.py net 20 > net20.toml              our scenario
    python3 benches/peers/nets.py net 20 --neutral > net20.json    points, bars, hinges and springs, for other programs

Functions of the same names give a `Graph`; `Graph.toml()` and `Graph.neutral()` are what is printed. Standard library only.

| scene | what it is | coordinates |
|---|---|---|
| net N | N × N balls of 50 g, their corners fixed, springs to the neighbours 3 % shorter than the mesh, let down from flat | 3 (N² − 4) |
| ladder N | N parallelograms side by side, four-bars that share their cranks, each crank on a spring | 2 N + 1 |
| bridge N | a cable of N links, a deck of N planks of unequal weight on it by N − 1 rods | 2 N |
| rods N | a grid of N × N knots, balls, with rods between neighbours, corners fixed | 6 N (N − 1) |
| chain N M | a chain of N links with M springs between links that may be far apart | N |
"""

import json
import math
import sys

GRAVITY = 9.80665


class Random:
    """The same numbers everywhere (xorshift)."""

    def __init__(self, seed):
        self.state = seed

    def __call__(self):
        mask = (1 << 64) - 1
        self.state ^= (self.state << 13) & mask
        self.state ^= self.state >> 7
        self.state ^= (self.state << 17) & mask
        return (self.state >> 11) / (1 << 53)

    def below(self, count):
        return int(self() * count)


class Graph:
    """Bodies on hinges, loops that close, springs; every body begins with axes parallel to the inertial ones or turned about
    one of them, so that places in the world are known without this program."""

    def __init__(self, title, story=""):
        self.title, self.story = title, story
        self.bodies, self.loops, self.forces, self.settings = [], [], [], []
        self.points, self.bars, self.springs, self.joints = [], [], [], []

    def body(self, name, hinge, **keys):
        self.bodies.append({"name": name, **keys, "hinge": hinge})

    def loop(self, **keys):
        self.loops.append(keys)

    def force(self, **keys):
        self.forces.append(keys)

    def toml(self):
        """Our scenario."""
        lines = [f"# {line}".rstrip() for line in self.story.strip().splitlines()]
        lines += [f"title = {value(self.title)}", ""] + self.settings
        for table, entries in (("body", self.bodies), ("loop", self.loops), ("force", self.forces)):
            for entry in entries:
                lines += [f"[[{table}]]", *(f"{key} = {value(x)}" for key, x in entry.items()), ""]
        return "\n".join(lines)

    def neutral(self):
        """`points`: masses (kg) at places (m) that move along three axes, `fixed` ones without; `bars`: rigid bodies from `from` to
        `to` (m, inertial axes) with mass (kg), centre (m) and inertia about it (kg m², inertial axes) in the drawn pose; `joints`:
        between bars (`null` is the ground) at a place, of a `type`, with an axis, a `rod` with its two places; `springs`: between
        `[kind, index, place]` with stiffness (N/m), unstretched length (m) and damping (N s/m)."""
        parts = {"points": self.points, "bars": self.bars, "joints": self.joints, "springs": self.springs}
        return json.dumps({"title": self.title, "gravity": [0.0, 0.0, -GRAVITY], **parts}, indent=1)


def value(x):
    """As TOML has it."""
    if isinstance(x, bool):
        return "true" if x else "false"
    if isinstance(x, str):
        return json.dumps(x)
    if isinstance(x, dict):
        return "{ " + ", ".join(f"{key} = {value(entry)}" for key, entry in x.items()) + " }"
    if isinstance(x, (list, tuple)):
        return "[" + ", ".join(value(entry) for entry in x) + "]"
    return repr(x)


def ball(graph, name, place, mass, shape=None):
    """A mass that moves along three axes: a body for each."""
    parent = "ground"
    for axis, letter in enumerate("xyz"):
        last = axis == 2
        along = [0.0] * 3
        along[axis] = 1.0
        hinge = {"type": "prismatic", "parent": parent, "axis": along, "position": place[axis]}
        parent = name if last else f"{name}.{letter}"
        keys = {"mass": mass} if last else {}
        if last and shape:
            keys["shape"] = shape
        graph.body(parent, hinge, **keys)


def net(n, stiffness=400.0, length=0.97, mass=0.05, start=-0.05, color=None):
    """A square net of n × n balls, one metre wide."""
    graph = Graph(f"Net of {n} x {n}")
    a = 1.0 / (n - 1)
    corner = lambda i, j: i in (0, n - 1) and j in (0, n - 1)
    shape = {"sphere": 0.15 * a, "color": color} if color else None
    for i in range(n):
        for j in range(n):
            place = [i * a, j * a, 0.0 if corner(i, j) else start]
            graph.points.append({"place": place, "mass": mass, "fixed": corner(i, j)})
            if not corner(i, j):
                ball(graph, f"ball{i}_{j}", place, mass, shape)
    end = lambda i, j: {"body": "ground", "at": [i * a, j * a, 0.0]} if corner(i, j) else f"ball{i}_{j}"
    for i in range(n):
        for j in range(n):
            for k, l in ((i + 1, j), (i, j + 1)):
                if k < n and l < n:
                    spring = {"stiffness": stiffness, "length": length * a, "damping": 0.1}
                    graph.force(type="spring", between=[end(i, j), end(k, l)], **spring)
                    ends = [["point", i * n + j, None], ["point", k * n + l, None]]
                    graph.springs.append({"between": ends, **spring})
    return graph


def slender(mass, length, thin=1e-3):
    """Inertia of a bar along x about its centre (kg m²)."""
    across = mass * length * length / 12.0
    return [
        thin * mass * length * length,
        across + thin * mass * length * length,
        across + thin * mass * length * length,
    ]


def bar(graph, name, hinge, place, angle, length, mass, **keys):
    """A bar along its x, in the plane of x and z, turned by `angle` upward from x."""
    graph.body(
        name,
        hinge,
        mass=mass,
        center=[0.5 * length, 0.0, 0.0],
        inertia=slender(mass, length),
        markers={"end": [length, 0.0, 0.0]},
        **keys,
    )
    tip = [place[0] + length * math.cos(angle), place[1], place[2] + length * math.sin(angle)]
    graph.bars.append(
        {"name": name, "from": list(place), "to": tip, "mass": mass, "inertia_along_across": slender(mass, length)[:2]}
    )
    return tip


UPWARD = [0.0, -1.0, 0.0]


def ladder(n):
    """n parallelograms side by side; cranks lean by 0.3 and stand on springs of all stiffnesses."""
    graph, random, lean = Graph(f"Ladder of {n} four-bars"), Random(5), 0.5 * math.pi + 0.3
    index = {}
    for i in range(n + 1):
        foot = [2.0 * i, 0.0, 0.0]
        tip = bar(
            graph, f"crank{i}", {"type": "revolute", "at": foot, "axis": UPWARD, "position": lean}, foot, lean, 1.0, 1.0
        )
        index[f"crank{i}"] = len(graph.bars) - 1
        graph.joints.append({"type": "revolute", "between": [None, index[f"crank{i}"]], "place": foot, "axis": UPWARD})
        if i > 0:
            left = [tip[0] - 2.0, 0.0, tip[2]]
            bar(
                graph,
                f"rung{i}",
                {"type": "revolute", "parent": f"crank{i - 1}", "at": "end", "axis": UPWARD, "position": -lean},
                left,
                0.0,
                2.0,
                2.0,
            )
            index[f"rung{i}"] = len(graph.bars) - 1
            graph.joints.append(
                {
                    "type": "revolute",
                    "between": [index[f"crank{i - 1}"], index[f"rung{i}"]],
                    "place": left,
                    "axis": UPWARD,
                }
            )
            graph.joints.append(
                {"type": "revolute", "between": [index[f"rung{i}"], index[f"crank{i}"]], "place": tip, "axis": UPWARD}
            )
            graph.loop(type="revolute", between=[f"rung{i}.end", f"crank{i}.end"], axis=[0.0, 1.0, 0.0])
        post = [foot[0] - 1.0, 0.0, 1.2]
        spring = {"stiffness": 5.0 + 25.0 * random(), "length": 0.2 + random(), "damping": 0.1}
        graph.force(type="spring", between=[f"crank{i}.end", {"body": "ground", "at": post}], **spring)
        graph.springs.append({"between": [["bar", index[f"crank{i}"], tip], ["ground", None, post]], **spring})
    return graph


def bridge(n):
    """A cable of n links from tower to tower, drawn as a parabola; a deck of n planks of unequal weight hangs on it by rods."""
    graph, random = Graph(f"Bridge of {n} planks"), Random(7)
    width, sag, high = 10.0, 1.5, 3.0
    x = lambda i: width * i / n
    z = lambda i: high - 4.0 * sag * (x(i) / width) * (1.0 - x(i) / width)
    d, before = width / n, 0.0
    for i in range(n):
        angle, length = math.atan2(z(i + 1) - z(i), d), math.hypot(d, z(i + 1) - z(i))
        hinge = {"type": "revolute", "axis": UPWARD, "position": angle - before}
        hinge |= {"at": [0.0, 0.0, high]} if i == 0 else {"parent": f"cable{i - 1}", "at": "end"}
        bar(graph, f"cable{i}", hinge, [x(i), 0.0, z(i)], angle, length, 0.2 * d)
        graph.joints.append(
            {
                "type": "revolute",
                "between": [2 * i - 2 if i else None, 2 * i],
                "place": [x(i), 0.0, z(i)],
                "axis": UPWARD,
            }
        )
        before = angle
        hinge = {"type": "revolute", "axis": UPWARD} | (
            {"at": [0.0, 0.0, 0.0]} if i == 0 else {"parent": f"deck{i - 1}", "at": "end", "stiffness": 50.0}
        )
        bar(graph, f"deck{i}", hinge, [x(i), 0.0, 0.0], 0.0, d, (2.0 + 2.0 * random()) * d)
        graph.joints.append(
            {
                "type": "revolute",
                "between": [2 * i - 1 if i else None, 2 * i + 1],
                "place": [x(i), 0.0, 0.0],
                "axis": UPWARD,
                "stiffness": 0.0 if i == 0 else 50.0,
            }
        )
        if i > 0:
            graph.loop(type="rod", between=[f"cable{i - 1}.end", f"deck{i - 1}.end"], length=z(i))
            graph.joints.append(
                {"type": "rod", "between": [2 * i - 2, 2 * i - 1], "places": [[x(i), 0.0, z(i)], [x(i), 0.0, 0.0]]}
            )
    graph.loop(
        type="revolute",
        between=[f"cable{n - 1}.end", {"body": "ground", "at": [width, 0.0, high]}],
        axis=[0.0, 1.0, 0.0],
    )
    graph.loop(type="rod", between=[f"deck{n - 1}.end", {"body": "ground", "at": [width, 0.0, -1.0]}], length=1.0)
    graph.joints.append({"type": "revolute", "between": [2 * n - 2, None], "place": [width, 0.0, high], "axis": UPWARD})
    graph.joints.append(
        {"type": "rod", "between": [2 * n - 1, None], "places": [[width, 0.0, 0.0], [width, 0.0, -1.0]]}
    )
    return graph


def quaternion(direction):
    """The shortest turn (w, x, y, z) that takes x to a direction."""
    size = math.sqrt(sum(c * c for c in direction))
    d = [c / size for c in direction]
    w = math.sqrt(0.5 * (1.0 + d[0]))
    return [w, 0.0, -d[2] / (2.0 * w), d[1] / (2.0 * w)]


def times(p, q):
    return [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ]


def rods(n, stiffness=0.1):
    """A grid of rods between n × n knots that sags; each rod hangs on a ball, other rods close on the first that reached a knot."""
    graph = Graph(f"Grid of {n} x {n} rods")
    bow = lambda i: math.sin(3.1 * i / (n - 1))
    place = lambda i, j: [float(i), float(j), -0.3 * (bow(i) + bow(j))]
    tip, turn, queue, closing = {(0, 0): None}, {None: [1.0, 0.0, 0.0, 0.0]}, [(0, 0)], []
    number = {}
    for i, j in queue:
        for a, b in ((i + 1, j), (i, j + 1)):
            if a >= n or b >= n:
                continue
            p, q, parent = place(i, j), place(a, b), tip[i, j]
            name = f"rod{i}_{j}_{a}_{b}"
            length = math.dist(p, q)
            turn[name] = quaternion([y - x for x, y in zip(p, q)])
            back = turn[parent]
            relative = times([back[0], -back[1], -back[2], -back[3]], turn[name])
            hinge = {"type": "spherical", "position": relative, "rest": relative, "stiffness": stiffness}
            hinge |= {"at": p} if parent is None else {"parent": parent, "at": "end"}
            graph.body(
                name,
                hinge,
                mass=0.3,
                center=[0.5 * length, 0.0, 0.0],
                inertia=slender(0.3, length),
                markers={"end": [length, 0.0, 0.0]},
            )
            number[name] = len(graph.bars)
            graph.bars.append(
                {"name": name, "from": p, "to": q, "mass": 0.3, "inertia_along_across": slender(0.3, length)[:2]}
            )
            graph.joints.append(
                {"type": "spherical", "between": [number.get(parent), number[name]], "place": p, "stiffness": stiffness}
            )
            if (a, b) in tip:
                closing.append((name, tip[a, b], q))
            else:
                tip[a, b] = name
                queue.append((a, b))
    for a, b in ((n - 1, 0), (0, n - 1), (n - 1, n - 1)):
        closing.append((tip[a, b], None, place(a, b)))
    for name, other, at in closing:
        end = f"{other}.end" if other else {"body": "ground", "at": at}
        graph.loop(type="spherical", between=[f"{name}.end", end])
        graph.joints.append(
            {"type": "spherical", "between": [number[name], number.get(other)], "place": at, "stiffness": 0.0}
        )
    return graph


def chain(n, far, reach=0):
    """A hanging chain of n links whose axes stand across each other, `far` springs between links at random or within `reach`."""
    graph, random, length = Graph(f"Chain of {n} with {far} far springs"), Random(11), 10.0 / n
    for i in range(n):
        axis = [0.0, 1.0, 0.0] if i % 2 == 0 else [0.0, 0.0, 1.0]
        hinge = {
            "type": "revolute",
            "axis": axis,
            "stiffness": 2.0,
            "damping": 0.01,
            "position": 0.05 * math.sin(0.3 * i),
        }
        hinge |= {"at": [0.0, 0.0, 0.0]} if i == 0 else {"parent": f"link{i - 1}", "at": "end"}
        graph.body(
            f"link{i}",
            hinge,
            mass=0.05,
            center=[0.5 * length, 0.0, 0.0],
            inertia=slender(0.05, length),
            markers={"end": [length, 0.0, 0.0]},
        )
        graph.bars.append(
            {
                "name": f"link{i}",
                "from": [i * length, 0.0, 0.0],
                "to": [(i + 1) * length, 0.0, 0.0],
                "mass": 0.05,
                "inertia_along_across": slender(0.05, length)[:2],
            }
        )
        graph.joints.append({"type": "revolute", "between": [i - 1 if i else None, i], "axis": axis, "stiffness": 2.0})
    for _ in range(far):
        i = random.below(n)
        j = min(i + 2 + random.below(reach), n - 1) if reach else random.below(n)
        if i != j:
            spring = {"stiffness": 20.0 + 50.0 * random(), "length": 0.95 * abs(i - j) * length, "damping": 0.1}
            graph.force(type="spring", between=[f"link{i}.end", f"link{j}.end"], **spring)
            graph.springs.append({"between": [["bar", i, "end"], ["bar", j, "end"]], **spring})
    return graph


SCENES = {"net": net, "ladder": ladder, "bridge": bridge, "rods": rods, "chain": chain}

if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if not word.startswith("--")]
    if not words or words[0] not in SCENES:
        sys.exit(__doc__)
    graph = SCENES[words[0]](*(int(word) for word in words[1:]))
    print(graph.neutral() if "--neutral" in sys.argv else graph.toml())
