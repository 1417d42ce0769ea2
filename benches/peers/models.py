"""The models of the comparison: built once, written as our scenarios and as the neutral text that the peers read.

Coordinates, velocities and forces are those of our scenario files: quaternions w, x, y, z, angular velocities and
torques in body axes, a free body's position and its rates in the hinge frame.
"""

import dataclasses
import pathlib

import numpy as np

LINK_LENGTH = 0.2  # m
LINK_MASS = 1.0  # kg
LINK_RADIUS = 0.05  # m
GRAVITY = (0.0, 0.0, -9.81)  # m/s²

# kg m², added to a body of less: the inertias of some of the iCub's small parts are round-off, not even positive.
LEAST_INERTIA = 1e-9

KIND = {"R": "revolute", "P": "prismatic", "S": "spherical", "F": "free"}

# name: (file in example-robot-data, whether it floats)
ROBOTS = {
    "panda": ("panda_description/urdf/panda.urdf", False),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", False),
    "solo12": ("solo_description/robots/solo12.urdf", True),
    "anymal": ("anymal_b_simple_description/robots/anymal.urdf", True),
    "talos": ("talos_data/robots/talos_reduced.urdf", True),
    "icub": ("icub_description/robots/icub.urdf", True),
}


@dataclasses.dataclass
class Body:
    """A body and the hinge that carries it; `kind` is a key of KIND, `parent` a number or -1 for the ground."""

    parent: int
    kind: str
    axis: np.ndarray
    turn: np.ndarray  # hinge frame in the parent
    place: np.ndarray
    mass: float
    center: np.ndarray
    inertia: np.ndarray  # about the centre of mass
    stiffness: float = 0.0
    damping: float = 0.0

    @property
    def positions(self):
        return {"S": 4, "F": 7}.get(self.kind, 1)

    @property
    def velocities(self):
        return {"S": 3, "F": 6}.get(self.kind, 1)


@dataclasses.dataclass
class Model:
    """Bodies in depth-first order (Pinocchio's derivatives need that) and a state."""

    name: str
    bodies: list
    position: np.ndarray = None
    velocity: np.ndarray = None
    force: np.ndarray = None

    def __post_init__(self):
        if self.position is None:
            self.position = np.concatenate([at_zero(body) for body in self.bodies])
        if self.velocity is None:
            self.velocity = np.zeros(self.freedom)
        if self.force is None:
            self.force = np.zeros(self.freedom)

    @property
    def freedom(self):
        return sum(body.velocities for body in self.bodies)

    def hinges(self):
        """Index, body, and where its coordinates and velocities are."""
        p = v = 0
        for index, body in enumerate(self.bodies):
            yield index, body, slice(p, p + body.positions), slice(v, v + body.velocities)
            p, v = p + body.positions, v + body.velocities


def at_zero(body):
    return {"S": np.array([1.0, 0, 0, 0]), "F": np.array([0, 0, 0, 1.0, 0, 0, 0])}.get(body.kind, np.zeros(1))


def link(parent, kind, axis, **hinge):
    """A round bar along its own x axis, hinged at the end of its parent."""
    across = LINK_MASS * (3 * LINK_RADIUS**2 + LINK_LENGTH**2) / 12
    inertia = np.diag([LINK_MASS * LINK_RADIUS**2 / 2, across, across])
    place = np.array([LINK_LENGTH if parent >= 0 else 0.0, 0.0, 0.0])
    center = np.array([LINK_LENGTH / 2, 0.0, 0.0])
    return Body(parent, kind, np.array(axis, float), np.eye(3), place, LINK_MASS, center, inertia, **hinge)


AXES = ([0, 1, 0], [1, 0, 0])  # taken in turn, from link to link


def chain(n):
    return [link(i - 1, "R", AXES[i % 2]) for i in range(n)]


def spherical_chain(n):
    return [link(i - 1, "S", [0, 0, 0]) for i in range(n)]


def tree(depth):
    """A binary tree of 2^depth − 1 links."""
    bodies = []

    def grow(parent, level):
        bodies.append(link(parent, "R", AXES[level % 2]))
        index = len(bodies) - 1
        if level + 1 < depth:
            grow(index, level + 1)
            grow(index, level + 1)

    grow(-1, 0)
    return bodies


def robot(name):
    """A robot of example-robot-data; Pinocchio has merged welded bodies by then."""
    import pinocchio

    root = pathlib.Path(pinocchio.__file__).resolve()
    root = next(p for p in root.parents if p.name == "cmeel.prefix") / "share/example-robot-data/robots"
    file, floats = ROBOTS[name]
    base = (pinocchio.JointModelFreeFlyer(),) if floats else ()
    model = pinocchio.buildModelFromUrdf(str(root / file), *base)
    if name == "panda":  # an arm of seven hinges: the gripper is held
        fingers = [model.getJointId(joint) for joint in model.names if "finger" in joint]
        model = pinocchio.buildReducedModel(model, fingers, pinocchio.neutral(model))
    return from_pinocchio(model)


def from_pinocchio(model):
    import pinocchio

    bodies = []
    for j in range(1, model.njoints):
        joint, placement, inertia = model.joints[j], model.jointPlacements[j], model.inertias[j]
        short = joint.shortname()
        axis = np.zeros(3)
        if "FreeFlyer" in short:
            kind = "F"
        elif "Spherical" in short:
            kind = "S"
        elif joint.nv == 1 and joint.nq == 1:
            data = joint.createData()
            joint.calc(data, pinocchio.neutral(model))
            linear, angular = np.split(np.asarray(data.S).reshape(6), 2)
            kind, axis = ("R", angular) if angular.any() else ("P", linear)
        else:
            raise ValueError(f"no hinge for a joint {short}")
        turn, place = placement.rotation, placement.translation
        own = inertia.inertia + (
            LEAST_INERTIA * np.eye(3) if np.linalg.eigvalsh(inertia.inertia)[0] < LEAST_INERTIA else 0
        )
        bodies.append(Body(model.parents[j] - 1, kind, axis, turn, place, inertia.mass, inertia.lever, own))
    return bodies


def random_state(model, seed=1):
    """Angles within half a radian (turns of balls: in each direction), rates and forces within one."""
    random = np.random.default_rng(seed)
    model.velocity = random.uniform(-1, 1, model.freedom)
    model.force = random.uniform(-1, 1, model.freedom)
    for _, body, at, _ in model.hinges():
        if body.kind in "RP":
            model.position[at] = random.uniform(-0.5, 0.5)
            continue
        turn = random.uniform(-0.5, 0.5, 3)
        angle = np.linalg.norm(turn)
        ball = np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * turn / angle])
        model.position[at] = ball if body.kind == "S" else np.concatenate([random.uniform(-0.5, 0.5, 3), ball])
    return model


def make(name):
    """A model of the comparison by its name: chain10, spherical10, tree6, or a robot."""
    for prefix, build in (("chain", chain), ("spherical", spherical_chain), ("tree", tree)):
        if name.startswith(prefix):
            return random_state(Model(name, build(int(name.removeprefix(prefix)))))
    return random_state(Model(name, robot(name)))


# Writers. Every number is written so that it reads back bit for bit.


def numbers(values):
    return " ".join(repr(float(x)) for x in np.asarray(values, float).reshape(-1))


def moments(inertia):
    """xx, yy, zz, xy, xz, yz."""
    return [inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]]


def neutral(model):
    lines = [f"gravity {numbers(GRAVITY)}", f"bodies {len(model.bodies)}"]
    for b in model.bodies:
        own = [*b.axis, *b.turn.reshape(-1), *b.place, b.mass, *b.center, *moments(b.inertia), b.stiffness, b.damping]
        lines.append(f"{b.parent} {b.kind} {numbers(own)}")
    lines += [f"{key} {numbers(getattr(model, key))}" for key in ("position", "velocity", "force")]
    return "\n".join(lines) + "\n"


def roll_pitch_yaw(turn):
    """Angles of Rz(yaw) Ry(pitch) Rx(roll), as in URDF."""
    pitch = np.arctan2(-turn[2, 0], np.hypot(turn[0, 0], turn[1, 0]))
    if abs(np.cos(pitch)) < 1e-9:  # roll and yaw are about one axis
        return [0.0, pitch, np.arctan2(-turn[0, 1], turn[1, 1])]
    return [np.arctan2(turn[2, 1], turn[2, 2]), pitch, np.arctan2(turn[1, 0], turn[0, 0])]


def scenario(model, duration=1.0):
    """Our scenario file."""

    def value(x):
        x = [float(number) for number in np.atleast_1d(x)]
        return repr(x[0]) if len(x) == 1 else repr(x)

    lines = [
        f'title = "{model.name}"',
        f"gravity = {value(GRAVITY)}",
        "[simulate]",
        'start = "given"',
        f"duration = {duration!r}",
        "[record]",
        f"rate = {1 / duration!r}",
    ]
    for index, body, at, rates in model.hinges():
        hinge = [f'type = "{KIND[body.kind]}"', f"at = {value(body.place)}"]
        if body.parent >= 0:
            hinge.append(f'parent = "b{body.parent}"')
        if not np.array_equal(body.turn, np.eye(3)):
            hinge.append(f"rpy = {value(roll_pitch_yaw(body.turn))}")
        if body.kind in "RP":
            hinge.append(f"axis = {value(body.axis)}")
        hinge.append(f"position = {value(model.position[at])}")
        hinge.append(f"velocity = {value(model.velocity[rates])}")
        for key, there in (("force", model.force[rates]), ("stiffness", body.stiffness), ("damping", body.damping)):
            if np.any(there):
                hinge.append(f"{key} = {value(there)}")
        lines += [
            "[[body]]",
            f'name = "b{index}"',
            f"mass = {value(body.mass)}",
            f"center = {value(body.center)}",
            f"inertia = {value(moments(body.inertia))}",
            f"hinge = {{ {', '.join(hinge)} }}",
        ]
    return "\n".join(lines) + "\n"


def write(model, folder, duration=1.0):
    """Writes NAME.toml and NAME.model; returns both paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = folder / f"{model.name}.toml", folder / f"{model.name}.model"
    for path, text in zip(paths, (scenario(model, duration), neutral(model)), strict=True):
        path.write_text(text, encoding="utf-8")
    return paths
