"""Accelerations of imported robots beside Pinocchio's, at random states.

    compare_urdf.py STILLPOINT [--states N] [ROBOT.urdf …]

Without robots: those of the package `example-robot-data` that are named below. Every robot is taken with its root fixed
and with its root free; `stillpoint inspect` tells the accelerations at the given state. Prints one JSON object: for
every robot and base the largest difference relative to the largest acceleration over all states, and the largest condition
of the mass matrix: it is what rounding is multiplied by. Where the two differ by more than Pinocchio's own rounding may
come to, both are compared with accelerations of fifty digits (exact_urdf.py): `difference` is ours from those, `theirs` is
Pinocchio's, `exact` the number of such states.

What is done by hand, because conventions differ:

* our free hinge has the rates of x, y, z in the hinge frame, then the angular velocity in body axes; Pinocchio's has the
  linear velocity in body axes as well: x'' = R (a + w × v);
* joints without limits are angles here, and a cosine and a sine there;
* mimics are gears here; there the joints are independent, so the equations are projected on the motions they allow;
* damping is subtracted explicitly.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import exact_urdf
import numpy as np
import pinocchio as pin

ROBOTS = [
    "panda_description/urdf/panda.urdf",
    "ur_description/urdf/ur5_robot.urdf",
    "solo_description/robots/solo12.urdf",
    "anymal_b_simple_description/robots/anymal.urdf",
    "talos_data/robots/talos_full_v2.urdf",
    "icub_description/robots/icub.urdf",
]
STATES = 4
# Beyond this it has to be found out who is right.
DOUBTFUL = 3e-10
GRAVITY = [0.0, 0.0, -9.80665]


def folder_of_robots():
    for path in map(pathlib.Path, sys.path):
        for found in path.glob("cmeel.prefix/share/example-robot-data/robots"):
            return found
    raise SystemExit("the package example-robot-data is not there")


def call(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{arguments}: {done.stderr}")
    return json.loads(done.stdout)


def mimics(urdf):
    """Follower: (leader, multiplier, offset)."""
    found = {}
    for joint in ElementTree.parse(urdf).getroot().iter("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            number = lambda key, default: float(mimic.get(key, default))
            found[joint.get("name")] = (mimic.get("joint"), number("multiplier", 1), number("offset", 0))
    return found


class State:
    """A random state, in both conventions."""

    def __init__(self, model, follows, random):
        self.q, self.v = pin.neutral(model), np.zeros(model.nv)
        self.ours = {}
        for index in range(1, model.njoints):
            joint, name = model.joints[index], model.names[index]
            if name in follows:
                continue
            at, rate = joint.idx_q, joint.idx_v
            if joint.nv == 6:
                turn = pin.Quaternion(random.normal(size=4)).normalized()
                place, linear, angular = random.uniform(-1, 1, 3), random.uniform(-1, 1, 3), random.uniform(-1, 1, 3)
                self.q[at : at + 7] = [*place, *turn.coeffs()]
                self.v[rate : rate + 6] = [*linear, *angular]
                self.ours[name] = ([*place, turn.w, turn.x, turn.y, turn.z], [*(turn.matrix() @ linear), *angular])
            else:
                self.set(joint, random.uniform(-1, 1), random.uniform(-1, 1))
                self.ours[name] = ([self.angle(joint)], [self.v[rate]])
        # Ours find their own way: followers are not told where they are.
        for name in follows:
            self.follow(model, follows, name)

    def follow(self, model, follows, name):
        leader, multiplier, offset = follows[name]
        if leader in follows:
            self.follow(model, follows, leader)
        ahead = model.joints[model.getJointId(leader)]
        joint = model.joints[model.getJointId(name)]
        self.set(joint, multiplier * self.angle(ahead) + offset, multiplier * self.v[ahead.idx_v])

    def set(self, joint, angle, rate):
        self.q[joint.idx_q : joint.idx_q + joint.nq] = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
        self.v[joint.idx_v] = rate

    def angle(self, joint):
        q = self.q[joint.idx_q : joint.idx_q + joint.nq]
        return q[0] if joint.nq == 1 else np.arctan2(q[1], q[0])


def allowed_motions(model, follows):
    """The columns of v = T u: one for every velocity that follows no other."""
    motions = np.eye(model.nv)
    for _ in follows:
        for name, (leader, multiplier, _) in follows.items():
            rate = lambda joint: model.joints[model.getJointId(joint)].idx_v
            motions[rate(name)] = multiplier * motions[rate(leader)]
    followers = [model.joints[model.getJointId(name)].idx_v for name in follows]
    return np.delete(motions, followers, axis=1)


def theirs(model, state, motions):
    """Accelerations, and the condition of the matrix they were solved with."""
    data = model.createData()
    mass = pin.crba(model, data, state.q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    force = -pin.nonLinearEffects(model, data, state.q, state.v) - model.damping * state.v
    reduced = motions.T @ mass @ motions
    return motions @ np.linalg.solve(reduced, motions.T @ force), np.linalg.cond(reduced)


def scenario(urdf, free, state, root):
    hinges = {root if name == "root_joint" else name: at for name, at in state.ours.items()}
    lines = [f'gravity = {GRAVITY}\n[model]\nfile = "{urdf}"\nbase = "{"free" if free else "fixed"}"\nlimits = false']
    lines.append("[model.hinges]")
    for name, (position, velocity) in hinges.items():
        numbers = lambda values: [float(value) for value in values]
        lines.append(f'"{name}" = {{ position = {numbers(position)}, velocity = {numbers(velocity)} }}')
    return "\n".join(lines)


def exactly(urdf, model, state, root_joint):
    """Accelerations to fifty digits, in the order of the model and with our conventions."""
    names = [model.names[index] for index in range(1, model.njoints) if model.names[index] != root_joint]
    base = exact_urdf.Base(*state.ours[root_joint]) if root_joint else exact_urdf.Base()
    q, v = ({name: exact_urdf.mpf(float(state.ours[name][part][0])) for name in names} for part in [0, 1])
    gravity = [exact_urdf.mpf(x) for x in GRAVITY]
    return np.array(exact_urdf.Robot(urdf).accelerations(q, v, names, gravity, base), dtype=float)


def compare(program, urdf, free, folder, states):
    args = [str(urdf)] + ([pin.JointModelFreeFlyer()] if free else [])
    model = pin.buildModelFromUrdf(*args)
    model.gravity.linear = np.array(GRAVITY)
    follows = {name: how for name, how in mimics(urdf).items() if model.existJointName(name)}
    motions = allowed_motions(model, follows)
    bodies = call(program, "convert", urdf, "--json", "--quiet", "--no-limits")["joints"]
    document = ElementTree.parse(urdf).getroot()
    children = {joint.find("child").get("link") for joint in document.findall("joint")}
    root = next(link.get("name") for link in document.findall("link") if link.get("name") not in children)
    random = np.random.default_rng(7)
    worst, condition, of_theirs, exact = 0.0, 0.0, 0.0, 0
    apart = lambda one, other: float(np.abs(one - other).max() / np.abs(other).max())
    for _ in range(states):
        state = State(model, follows, random)
        path = folder / "state.toml"
        path.write_text(scenario(urdf, free, state, root))
        found = call(program, "inspect", path, "--json", "--quiet")["accelerations"]
        expected, at_state = theirs(model, state, motions)
        condition = max(condition, float(at_state))
        ours = np.zeros(model.nv)
        for index in range(1, model.njoints):
            joint, name = model.joints[index], model.names[index]
            rate = joint.idx_v
            body = root if name == "root_joint" else bodies[name]
            ours[rate : rate + joint.nv] = found[body]
            if joint.nv == 6:
                turn = pin.Quaternion(state.q[joint.idx_q + 3 : joint.idx_q + 7]).matrix()
                linear, angular = state.v[rate : rate + 3], state.v[rate + 3 : rate + 6]
                expected[rate : rate + 3] = turn @ (expected[rate : rate + 3] + np.cross(angular, linear))
        difference = apart(ours, expected)
        if difference > DOUBTFUL and not follows:
            right = exactly(urdf, model, state, "root_joint" if free else None)
            difference, of_theirs, exact = apart(ours, right), max(of_theirs, apart(expected, right)), exact + 1
        worst = max(worst, difference)
    known = {"theirs": of_theirs, "exact": exact} if exact else {}
    return {"difference": worst, "condition": condition, "velocities": model.nv, "mimics": len(follows), **known}


def main(program, *robots):
    states = STATES
    if robots[:1] == ("--states",):
        states, robots = int(robots[1]), robots[2:]
    robots = robots or [folder_of_robots() / robot for robot in ROBOTS]
    results = {}
    with tempfile.TemporaryDirectory() as folder:
        for robot in map(pathlib.Path, robots):
            for free in [False, True]:
                name = f"{robot.stem} {'free' if free else 'fixed'}"
                results[name] = compare(program, robot.resolve(), free, pathlib.Path(folder), states)
    json.dump(results, sys.stdout, indent=1)


if __name__ == "__main__":
    main(*sys.argv[1:])
