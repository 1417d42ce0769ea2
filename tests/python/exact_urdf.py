"""How far accelerations of an imported robot, and Pinocchio's, are from exact ones.

    exact_urdf.py STILLPOINT [ROBOT.urdf]

Newton's and Euler's equations of every link with 50 digits (package `mpmath`), from the decimals of the URDF, at the states
of compare_urdf.py, the root fixed; without a robot the iCub of `example-robot-data`. For robots whose joints turn, without
mimics. Prints for every state the condition of the mass matrix, the largest errors relative to the largest acceleration,
and the largest residuals of the exact equations (N m). compare_urdf.py asks it where Pinocchio's accelerations are not
known well enough to compare with, the root fixed or free.
"""

import pathlib
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import numpy as np
import pinocchio as pin
from mpmath import cos, lu_solve, matrix, mp, mpf, sin, sqrt

mp.dps = 50
ZERO = [mpf(0)] * 3


def numbers(element, key, default="0 0 0"):
    return [mpf(x) for x in (element.get(key, default) if element is not None else default).split()]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def add(*vectors):
    return [sum(parts) for parts in zip(*vectors)]


def times(factor, vector):
    return [factor * x for x in vector]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def turned(turn, vector):
    return [dot(row, vector) for row in turn]


def product(a, b):
    return [[sum(row[k] * b[k][j] for k in range(3)) for j in range(3)] for row in a]


def transposed(a):
    return [list(column) for column in zip(*a)]


def about(axis, angle):
    """The turn about an axis of length one."""
    x, y, z = axis
    skew = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    c, s = cos(angle), sin(angle)
    part = lambda i, j: (c if i == j else 0) + (1 - c) * axis[i] * axis[j] + s * skew[i][j]
    return [[part(i, j) for j in range(3)] for i in range(3)]


def roll_pitch_yaw(roll, pitch, yaw):
    axes = [[mpf(i == j) for j in range(3)] for i in range(3)]
    return product(about(axes[2], yaw), product(about(axes[1], pitch), about(axes[0], roll)))


class Link:
    def __init__(self, element):
        inertial = element.find("inertial")
        self.mass, self.center, self.inertia = mpf(0), ZERO, [ZERO] * 3
        if inertial is None:
            return
        origin, inertia = inertial.find("origin"), inertial.find("inertia")
        turn = roll_pitch_yaw(*numbers(origin, "rpy"))
        part = lambda i, j: mpf(inertia.get("i" + "".join(sorted("xyz"[i] + "xyz"[j]))))
        own = [[part(i, j) for j in range(3)] for i in range(3)]
        self.mass = mpf(inertial.find("mass").get("value"))
        self.center = numbers(origin, "xyz")
        self.inertia = product(product(turn, own), transposed(turn))


class Base:
    """Where the root stands and how it moves: not at all, or as a free body (`turn` by a quaternion w, x, y, z)."""

    def __init__(self, position=None, velocity=None):
        self.free = position is not None
        self.turn = [[mpf(i == j) for j in range(3)] for i in range(3)]
        self.rate = ZERO
        if self.free:
            w, *axis = [mpf(x) for x in position[3:]]
            size = sqrt(w * w + dot(axis, axis))
            (x, y, z), w = times(1 / size, axis), w / size
            self.turn = [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
            self.rate = turned(self.turn, [mpf(x) for x in velocity[3:]])

    def still(self):
        base = Base()
        base.free, base.turn = self.free, self.turn
        return base


# What a free root has: the acceleration of its place, inertial axes, then of its turn, root axes.
LINEAR, ANGULAR = (tuple(f"root {part} {axis}" for axis in "xyz") for part in ["linear", "angular"])


class Joint:
    def __init__(self, element, parent):
        origin, axis, dynamics = (element.find(key) for key in ["origin", "axis", "dynamics"])
        self.name, self.parent, self.child = element.get("name"), parent, element.find("child").get("link")
        self.moves = element.get("type") != "fixed"
        if element.get("type") not in ["fixed", "revolute", "continuous"]:
            raise SystemExit(f"{self.name} does not turn")
        self.place, self.turn = numbers(origin, "xyz"), roll_pitch_yaw(*numbers(origin, "rpy"))
        axis = numbers(axis, "xyz", "1 0 0")
        self.axis = times(1 / (sqrt(dot(axis, axis)) or 1), axis)
        self.damping = mpf(dynamics.get("damping", "0")) if dynamics is not None else mpf(0)


class Robot:
    def __init__(self, path):
        root = ElementTree.parse(path).getroot()
        self.links = {link.get("name"): Link(link) for link in root.findall("link")}
        of_parent = {}
        for joint in root.findall("joint"):
            of_parent.setdefault(joint.find("parent").get("link"), []).append(joint)
        children = {joint.find("child").get("link") for joints in of_parent.values() for joint in joints}
        self.root = next(name for name in self.links if name not in children)
        self.joints = []
        self.grow(of_parent, self.root, None)
        self.damping = {joint.name: joint.damping for joint in self.joints}

    def grow(self, of_parent, link, parent):
        for element in of_parent.get(link, []):
            self.joints.append(Joint(element, parent))
            self.grow(of_parent, self.joints[-1].child, len(self.joints) - 1)

    def needs(self, link, turn, rate, spin, lift):
        """The force and the moment about its origin that a link needs for its acceleration."""
        center = turned(turn, link.center)
        inertia = product(product(turn, link.inertia), transposed(turn))
        force = times(link.mass, add(lift, cross(spin, center), cross(rate, cross(rate, center))))
        return force, add(cross(center, force), turned(inertia, spin), cross(rate, turned(inertia, rate)))

    def torques(self, q, v, a, gravity, base=Base()):
        """What every joint, and the root where it is free, has to push for these accelerations."""
        spin = turned(base.turn, [a[name] for name in ANGULAR]) if base.free else ZERO
        lift = add([a[name] for name in LINEAR] if base.free else ZERO, times(-1, gravity))
        root = (base.turn, base.rate, spin, lift)
        at_root = self.needs(self.links[self.root], *root)
        frames, forces, moments = [], [], []
        for joint in self.joints:
            turn, rate, spin, lift = root if joint.parent is None else frames[joint.parent][:4]
            arm = turned(turn, joint.place)
            lift = add(lift, cross(spin, arm), cross(rate, cross(rate, arm)))
            turn = product(turn, joint.turn)
            axis = turned(turn, joint.axis)
            if joint.moves:
                turn = product(turn, about(joint.axis, q[joint.name]))
                own = times(v[joint.name], axis)
                spin = add(spin, times(a[joint.name], axis), cross(rate, own))
                rate = add(rate, own)
            frames.append((turn, rate, spin, lift, arm, axis))
            force, moment = self.needs(self.links[joint.child], turn, rate, spin, lift)
            forces.append(force)
            moments.append(moment)
        torques = {}
        for index in reversed(range(len(self.joints))):
            joint, arm, axis = self.joints[index], *frames[index][4:]
            if joint.moves:
                torques[joint.name] = dot(axis, moments[index])
            moment = add(moments[index], cross(arm, forces[index]))
            if joint.parent is None:
                at_root = add(at_root[0], forces[index]), add(at_root[1], moment)
            else:
                forces[joint.parent] = add(forces[joint.parent], forces[index])
                moments[joint.parent] = add(moments[joint.parent], moment)
        if base.free:
            torques.update(zip(LINEAR, at_root[0]))
            torques.update(zip(ANGULAR, turned(transposed(base.turn), at_root[1])))
        return torques

    def accelerations(self, q, v, names, gravity, base=Base()):
        """Of the joints in the order of `names`; before them, where it is free, of the root."""
        names = [*LINEAR, *ANGULAR, *names] if base.free else names
        rest = dict.fromkeys(names, mpf(0))
        bias = self.torques(q, v, rest, gravity, base)
        mass = matrix(len(names))
        for column, name in enumerate(names):
            unit = self.torques(q, rest, {**rest, name: mpf(1)}, ZERO, base.still())
            for row, other in enumerate(names):
                mass[row, column] = unit[other]
        damping = lambda name: self.damping[name] * v[name] if name in self.damping else 0
        return list(lu_solve(mass, matrix([-bias[name] - damping(name) for name in names])))


def main(program, path=None):
    import compare_urdf as urdf

    path = pathlib.Path(path or urdf.folder_of_robots() / "icub_description/robots/icub.urdf").resolve()
    model, robot = pin.buildModelFromUrdf(str(path)), Robot(path)
    model.gravity.linear = np.array(urdf.GRAVITY)
    names = [model.names[index] for index in range(1, model.njoints)]
    bodies = urdf.call(program, "convert", path, "--json", "--quiet", "--no-limits")["joints"]
    gravity, random = [mpf(x) for x in urdf.GRAVITY], np.random.default_rng(7)
    with tempfile.TemporaryDirectory() as folder:
        scenario = pathlib.Path(folder) / "state.toml"
        for _ in range(urdf.STATES):
            state = urdf.State(model, {}, random)
            scenario.write_text(urdf.scenario(path, False, state, robot.root))
            found = urdf.call(program, "inspect", scenario, "--json", "--quiet")["accelerations"]
            crba, condition = urdf.theirs(model, state, np.eye(model.nv))
            aba = pin.aba(model, model.createData(), state.q, state.v, -model.damping * state.v)
            q, v = ({name: mpf(float(state.ours[name][part][0])) for name in names} for part in [0, 1])
            exact = robot.accelerations(q, v, names, gravity)
            largest = max(map(abs, exact))
            print(f"condition {condition:.1e}, largest acceleration {float(largest):.1e} rad/s²")
            for who, list_of in [
                ("stillpoint", [found[bodies[name]][0] for name in names]),
                ("Pinocchio, crba", crba),
                ("Pinocchio, aba", aba),
            ]:
                list_of = [mpf(float(x)) for x in list_of]
                error = max(abs(a - b) for a, b in zip(list_of, exact)) / largest
                left = robot.torques(q, v, dict(zip(names, list_of)), gravity)
                residual = max(abs(left[name] + robot.damping[name] * v[name]) for name in names)
                print(f"  {who:<16} error {float(error):.1e}, residual {float(residual):.1e} N m", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
