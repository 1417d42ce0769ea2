"""Random MJCF models of one feature each, as imported here and as MuJoCo compiles them.

    mjcf_features.py STILLPOINT [--cases N] [--seed S] [FEATURE…]

For each case a model with random numbers is written, converted, and compared with MuJoCo: total mass, centre of mass, accelerations at
random states (compare_mjcf.py), and where the model starts. One JSON object on standard output: for each feature the largest
differences, how many cases MuJoCo refused, and what is wrong with a case: its model, and why.
"""

import json
import os
import sys
import tempfile

import mujoco
import numpy as np

import compare_mjcf

# Corners and faces of closed surfaces that look outwards: a tetrahedron, a box, an L (not convex).
SOLIDS = {
    "tetrahedron": ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]),
    "box": (
        [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)],
        [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
    ),
    "angle": (
        [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))],
        [(0, 5, 4, 3), (0, 3, 2, 1), (6, 7, 8, 9), (6, 9, 10, 11)]
        + [(i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i) for i in range(6)],
    ),
}

# MuJoCo keeps the inertia of a mesh by its principal axes, of which 4e-8 of the accelerations were left at most in 840 cases;
# everything else is round-off.
ALIKE = {"difference": 1e-7, "mass": 1e-12, "start": 1e-9}


def text(numbers):
    return " ".join(repr(float(x)) for x in np.atleast_1d(numbers))


class Case:
    """Random numbers, and the folder that a model lies in."""

    def __init__(self, random, folder):
        self.random, self.folder = random, folder

    def number(self, low, high):
        return float(self.random.uniform(low, high))

    def vector(self, low=-0.3, high=0.3, size=3):
        return text(self.random.uniform(low, high, size))

    def one(self, *choices):
        return choices[self.random.integers(len(choices))]

    def turn(self):
        return self.one(
            f'quat="{text(self.random.normal(size=4))}"',
            f'euler="{self.vector(-90, 90)}"',
            f'axisangle="{self.vector(-1, 1)} {self.number(-90, 90)}"',
        )

    def write(self, name, content):
        path = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w") as file:
            file.write(content)

    def solid(self, name, open_surface=False):
        """An OBJ file with a solid, moved and stretched."""
        corners, faces = SOLIDS[self.one(*SOLIDS)]
        stretch = self.random.uniform(-0.3, 0.3, (3, 3)) + np.eye(3)
        # Of so few digits that every reader finds the same 32-bit numbers. Four corners of a side need not lie in a plane then.
        corners = np.round((np.array(corners) - 0.4) @ stretch.T * 0.2 * 4096) / 4096
        faces = list(faces)
        if open_surface:
            del faces[self.random.integers(len(faces))]
        lines = [f"v {text(corner)}" for corner in corners]
        lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
        self.write(name, "\n".join(lines) + "\n")

    def geom(self):
        """A solid with its place."""
        place = f'pos="{self.vector()}" {self.turn()}'
        weight = self.one("", f'mass="{self.number(0.1, 2)}"', f'density="{self.number(100, 2000)}"')
        kind, sizes = self.one(("sphere", 1), ("capsule", 2), ("cylinder", 2), ("box", 3), ("ellipsoid", 3))
        return f'<geom type="{kind}" size="{self.vector(0.05, 0.2, sizes)}" {place} {weight}/>'

    def axis(self):
        return f'axis="{self.vector(-1, 1)}"'

    def joint(self, name, more=""):
        return f'<joint name="{name}" type="{self.one("hinge", "hinge", "slide")}" {self.axis()} pos="{self.vector()}" {more}/>'

    def arm(self, inner="", name="b"):
        """A body on a joint with something in it."""
        return f'<body name="{name}" pos="{self.vector()}" {self.turn()}>{self.joint("j" + name)}{self.geom()}{inner}</body>'

    def model(self, world, rest="", settings=""):
        return f"<mujoco>{settings}<worldbody>{world}</worldbody>{rest}</mujoco>"


def mesh(case, rule=None, open_surface=False, mirrored=False):
    rule = rule or case.one("", 'inertia="legacy"', 'inertia="exact"', 'inertia="convex"', 'inertia="shell"')
    case.solid("part.obj", open_surface)
    scale = case.random.uniform(0.3, 2, 3) * ([1, -1, 1] if mirrored else [1, 1, 1])
    more = case.one("", f'refpos="{case.vector()}"', f'refquat="{text(case.random.normal(size=4))}"')
    more += case.one("", f' scale="{text(scale)}"') if not mirrored else f' scale="{text(scale)}"'
    weight = case.one("", f'mass="{case.number(0.1, 2)}"', f'density="{case.number(100, 2000)}"')
    geom = f'<geom type="mesh" mesh="m" pos="{case.vector()}" {case.turn()} {weight}/>'
    assets = f'<asset><mesh name="m" file="part.obj" {rule} {more}/></asset>'
    return case.model(case.arm(f'<body pos="{case.vector()}">{case.joint("k")}{geom}</body>'), settings=assets)


def open_mesh(case):
    return mesh(case, case.one("", 'inertia="convex"', 'inertia="shell"', 'inertia="exact"'), open_surface=True)


def mirrored_mesh(case):
    return mesh(case, case.one("", 'inertia="exact"', 'inertia="shell"'), mirrored=True)


def corners_in_the_model(case):
    points = case.random.normal(size=(case.random.integers(4, 30), 3)) * 0.1
    geom = f'<geom type="mesh" mesh="m" pos="{case.vector()}" {case.turn()}/>'
    return case.model(case.arm(geom), settings=f'<asset><mesh name="m" vertex="{text(points.ravel())}"/></asset>')


def shell(case):
    kind, sizes = case.one(("sphere", 1), ("capsule", 2), ("cylinder", 2), ("box", 3), ("ellipsoid", 3))
    size, weight = case.vector(0.05, 0.3, sizes), case.one("", f'mass="{case.number(0.1, 2)}"')
    return case.model(case.arm(f'<geom type="{kind}" size="{size}" shellinertia="true" pos="{case.vector()}" {weight}/>'))


def fromto(case):
    kind = case.one("capsule", "cylinder", "box", "ellipsoid")
    return case.model(case.arm(f'<geom type="{kind}" fromto="{case.vector(size=6)}" size="{case.vector(0.02, 0.1, 1)}"/>'))


def welded_inertia(case):
    """A body of inertia and, at times, no mass, welded to one that weighs."""
    moments = np.sort(case.random.uniform(0.1, 0.15, 3))
    inertial = f'<inertial pos="{case.vector()}" mass="{case.one(0, 0, 1e-12, 0.5)}" diaginertia="{text(moments)}" {case.turn()}/>'
    return case.model(case.arm(f'<body pos="{case.vector()}" {case.turn()}>{inertial}</body>'))


def compiler(case):
    """What <compiler> does to mass."""
    what = case.one(
        f'boundmass="{case.number(0.5, 5)}"',
        f'boundinertia="{case.number(0.01, 0.5)}"',
        f'settotalmass="{case.number(1, 20)}"',
        f'inertiafromgeom="{case.one("true", "auto")}"',
        'inertiagrouprange="0 1"',
        f'eulerseq="{case.one("XYZ", "zyx", "yxY", "zxz")}"',
        'angle="radian"',
    )
    other = case.geom().replace("/>", f' group="{case.random.integers(4)}"/>')
    return case.model(case.arm(other + case.arm(name="c")), settings=f"<compiler {what}/>")


def bounds_of_nothing(case):
    """Bodies that weigh nothing but for bounds, in frames and not, welded and not."""
    inside = case.one("", f'<geom size="0.1" mass="0" pos="{case.vector()}"/>')
    joint = case.one("", case.joint("k"))
    bare = f'<body name="c" pos="{case.vector()}" {case.turn()}>{joint}{inside}</body>'
    framed = f'<frame pos="{case.vector()}" {case.turn()}>{bare}</frame>'
    bounds = f'<compiler boundmass="{case.number(0.1, 2)}" boundinertia="{case.number(0.01, 0.1)}"/>'
    return case.model(case.arm(case.one(bare, framed)), settings=bounds)


def actuator(case, joint, more=""):
    limited = f'forcerange="{text(np.sort(case.random.uniform(-3, 3, 2)))}"'
    kind = case.one(
        "<motor {}/>",
        '<position kp="%r" {}/>' % case.number(0.5, 20),
        '<position kp="%r" kv="%r" {}/>' % (case.number(0.5, 20), case.number(0.1, 2)),
        '<velocity kv="%r" {}/>' % case.number(0.1, 3),
        '<damper kv="%r" ctrlrange="0 1" {}/>' % case.number(0.1, 3),
        '<general gainprm="%r" biastype="affine" biasprm="%r %r %r" {}/>'
        % (case.number(-2, 2), case.number(-1, 1), -case.number(0, 9), -case.number(0, 2)),
    )
    gear = case.one("", f'gear="{case.number(-3, 3)}"')
    return kind.format(f'joint="{joint}" {gear} {case.one("", limited)} {more}')


def actuators(case, joint_more="", count=1, more=""):
    world = f'<body pos="{case.vector()}">{case.joint("k", joint_more)}{case.geom()}{case.arm()}</body>'
    list_of = "".join(actuator(case, "k", more) for _ in range(count))
    key = f'<keyframe><key ctrl="{case.vector(-2, 2, count)}"/></keyframe>'
    return world, f"<actuator>{list_of}</actuator>{key}"


def forces_of_actuators(case):
    return case.model(*actuators(case, count=int(case.random.integers(1, 4))))


def force_range_of_joint(case):
    limits = text(np.sort(case.random.uniform(-4, 4, 2)))
    return case.model(*actuators(case, f'actuatorfrcrange="{limits}"'))


def force_range_of_several(case):
    """Motors and servos without bounds of their own."""
    world, rest = actuators(case, f'actuatorfrcrange="{text(np.sort(case.random.uniform(-4, 4, 2)))}"', count=3)
    while "forcerange" in rest:
        world, rest = actuators(case, f'actuatorfrcrange="{text(np.sort(case.random.uniform(-4, 4, 2)))}"', count=3)
    return case.model(world, rest)


def idle_groups(case):
    world, rest = actuators(case, count=1, more=f'group="{case.random.integers(4)}"')
    groups = text(case.random.integers(0, 4, case.random.integers(1, 3))).replace(".0", "")
    return case.model(world, rest, f'<option actuatorgroupdisable="{groups}"/>')


def start_beyond_limits(case):
    """The reference, or a keyframe, beyond a limit."""
    ends = np.sort(case.random.uniform(-1, 1, 2))
    ref = f'ref="{case.number(-0.5, 0.5)}"'
    joint = case.joint("k", f'range="{text(ends)}" {case.one("", ref)}').replace('type="slide"', 'type="hinge"')
    world = f'<body pos="{case.vector()}">{joint}{case.geom()}</body>'
    key = case.one("", f'<keyframe><key qpos="{case.number(-2, 2)}"/></keyframe>')
    return case.model(world, key, '<compiler angle="radian"/>')


def limited_by_default(case):
    other = f'<body pos="{case.vector()}"><joint {case.axis()} range="-10 10"/>{case.geom()}</body>'
    free = f'<body pos="{case.vector()}"><joint type="free"/>{case.geom()}<body><joint type="ball" range="0 0"/>{case.geom()}</body></body>'
    return case.model(free + other, settings=f'<default><joint limited="{case.one("true", "auto")}"/></default>')


def include(case):
    """Files that include files, found from the main folder or from their own."""
    near = case.one(True, False)
    case.write("sub/leaf.xml" if near else "leaf.xml", f"<mujocoinclude>{case.geom()}</mujocoinclude>")
    case.write("sub/middle.xml", f'<mujocoinclude>{case.geom()}<include file="leaf.xml"/></mujocoinclude>')
    return case.model(case.arm('<include file="sub/middle.xml"/>'))


def part(case):
    """A model to attach: own units, classes, motors, springs between its bodies."""
    settings = case.one("", '<compiler angle="radian"/>', '<compiler eulerseq="zyx"/>')
    settings += case.one("", f'<default><joint damping="{case.number(0, 1)}"/><geom density="{case.number(100, 900)}"/></default>')
    world = f'<frame name="f" pos="{case.vector()}" {case.turn()}>{case.arm(case.arm(name="q"), "p")}</frame>'
    motors = case.one("", f"<actuator>{actuator(case, 'jq')}{actuator(case, 'jp')}</actuator>")
    tendon = f'<tendon><fixed stiffness="{case.number(1, 9)}"><joint joint="jq" coef="{case.number(1, 2)}"/></fixed></tendon>'
    key = f'<keyframe><key name="home" qpos="{case.vector(size=2)}" ctrl="{case.vector(size=2)}"/></keyframe>' if motors else ""
    return case.model(world, motors + case.one("", tendon) + case.one("", key), settings)


def attach(case):
    case.write("part.xml", part(case))
    which = case.one("", 'body="p"', 'body="q"', 'frame="f"')
    twice = case.one(False, True)
    one = f'<frame pos="{case.vector()}" {case.turn()}><attach model="part" {which} prefix="x_"/></frame>'
    if twice:
        one += f'<frame pos="{case.vector()}"><attach model="part" {which} prefix="y_"/></frame>'
    rest = case.one("", '<actuator><motor joint="jb"/></actuator>')
    size = 1 + (1 if "q" in which else 2) * (2 if twice else 1)
    rest += case.one("", f'<keyframe><key qpos="{case.vector(size=size)}"/></keyframe>')
    return case.model(case.arm(one), rest, '<asset><model name="part" file="part.xml"/></asset>')


def attach_within(case):
    """A model that attaches a model."""
    case.write("part.xml", part(case))
    inner = case.arm('<attach model="part" body="p" prefix="in_"/>', "m")
    case.write("middle.xml", case.model(inner, "", '<asset><model name="part" file="part.xml"/></asset>'))
    assets = '<asset><model name="middle" file="middle.xml"/></asset>'
    return case.model(case.arm('<attach model="middle" body="m" prefix="out_"/>'), "", assets)


def attach_itself(case):
    """A body of the model, once more."""
    which = case.one('body="c"', 'frame="g"')
    first = case.arm(f'<frame name="g" pos="{case.vector()}" {case.turn()}>{case.arm(name="c")}</frame>')
    second = f'<body name="d" pos="{case.vector()}">{case.joint("jd")}{case.geom()}<frame pos="{case.vector()}"><attach {which} prefix="again_"/></frame></body>'
    return case.model(first + second)


def springs(case):
    more = case.one(
        f'stiffness="{case.number(1, 9)}" springref="{case.number(-30, 30)}"',
        f'springdamper="{case.number(0.1, 1)} {case.number(0.5, 2)}"',
        f'armature="{case.number(0, 1)}" damping="{case.number(0, 1)}"',
    )
    return case.model(f'<body>{case.joint("k", more)}{case.geom()}{case.arm()}</body>')


def tendon_springs(case):
    length = case.number(-1, 1)
    lengths = case.one("", 'springlength="-1"', f'springlength="{length}"', f'springlength="{length} {length}"')
    numbers = f'stiffness="{case.number(1, 9)}" damping="{case.number(0, 1)}" {lengths}'
    tendon = f'<tendon><fixed {numbers}><joint joint="jt" coef="{case.number(0.5, 2)}"/></fixed></tendon>'
    more = case.one("", f'ref="{case.number(-0.3, 0.3)}"', f'springref="{case.number(-0.3, 0.3)}"')
    return case.model(f'<body>{case.joint("jt", more)}{case.geom()}{case.arm()}</body>', tendon)


def gravity_compensation(case):
    return case.model(case.arm().replace("<body ", f'<body gravcomp="{case.number(0, 1.5)}" '))


def replicate(case):
    inner = f'<body name="r">{case.joint("jr")}{case.geom()}</body>'
    count, offset = case.random.integers(1, 5), case.vector()
    return case.model(case.arm(f'<replicate count="{count}" offset="{offset}" euler="{case.vector(-40, 40)}">{inner}</replicate>'))


FEATURES = [
    mesh,
    open_mesh,
    mirrored_mesh,
    corners_in_the_model,
    shell,
    fromto,
    welded_inertia,
    compiler,
    bounds_of_nothing,
    forces_of_actuators,
    force_range_of_joint,
    force_range_of_several,
    idle_groups,
    start_beyond_limits,
    limited_by_default,
    include,
    attach,
    attach_within,
    attach_itself,
    springs,
    tendon_springs,
    gravity_compensation,
    replicate,
]


def started(program, path, model, folder):
    """How far the start here is from MuJoCo's first keyframe or reference, within the limits, and the centre of mass there."""
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    for joint in np.flatnonzero(model.jnt_limited):
        if int(model.jnt_type[joint]) in (int(compare_mjcf.HINGE), int(compare_mjcf.SLIDE)):
            at = model.jnt_qposadr[joint]
            data.qpos[at] = np.clip(data.qpos[at], *model.jnt_range[joint])
    mujoco.mj_forward(model, data)
    scenario = os.path.join(folder, "model.toml")
    ours = compare_mjcf.inspect(program, scenario)
    names = compare_mjcf.hinges(model)
    found = compare_mjcf.flat(model, names, ours["positions"], compare_mjcf.COORDINATES)
    expected = np.concatenate([compare_mjcf.coordinates(model, joint, data.qpos) for joint in range(model.njnt)])
    center = np.abs(np.array(ours["center_of_mass"]) - data.subtree_com[0]).max()
    return max(float(np.abs(found - expected).max(initial=0.0)), float(center))


def one(program, feature, random, states):
    with tempfile.TemporaryDirectory() as folder:
        xml = feature(Case(random, folder))
        path = os.path.join(folder, "case.xml")
        with open(path, "w") as file:
            file.write(xml)
        try:
            model = mujoco.MjModel.from_xml_path(path)
        except ValueError as error:
            return {"mujoco": str(error), "xml": xml}
        try:
            result = compare_mjcf.compare(program, path, states, folder)
            if "refused" not in result:
                result["start"] = started(program, path, model, folder)
            return result | {"xml": xml}
        except (RuntimeError, KeyError, ValueError) as error:
            return {"refused": f"{type(error).__name__}: {error}", "xml": xml}


def main(arguments):
    number = {"--cases": 5, "--seed": 1, "--states": 2}
    for key in number:
        if key in arguments:
            at = arguments.index(key)
            number[key] = int(arguments[at + 1])
            arguments = arguments[:at] + arguments[at + 2 :]
    program, *wanted = arguments
    results = {}
    for feature in FEATURES:
        if wanted and feature.__name__ not in wanted:
            continue
        random = np.random.default_rng([number["--seed"], FEATURES.index(feature)])
        worst = {"cases": 0, "mujoco_refused": 0, "difference": 0.0, "mass": 0.0, "start": 0.0, "wrong": []}
        for _ in range(number["--cases"]):
            found = one(program, feature, random, number["--states"])
            worst["cases"] += 1
            if "mujoco" in found:
                worst["mujoco_refused"] += 1
                worst["last_refused"] = found["mujoco"]
                continue
            if "refused" in found:
                worst["wrong"].append(found)
                continue
            if any(not found[key] <= limit for key, limit in ALIKE.items()):
                worst["wrong"].append(found)
            for key in ALIKE:
                worst[key] = max(worst[key], found[key])
        results[feature.__name__] = worst
    json.dump(results, sys.stdout, indent=1)


if __name__ == "__main__":
    main(sys.argv[1:])
