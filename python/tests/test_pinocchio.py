"""Dynamics beside Pinocchio's, on robots of other people's packages: joints of one coordinate, roots fixed."""

import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

import stillpoint

pin = pytest.importorskip("pinocchio")

ROBOTS = ["ur_description/urdf/ur5_robot.urdf", "solo_description/robots/solo12.urdf", "kinova_description/robots/kinova.urdf"]
GRAVITY = np.array([0.0, 0.0, -9.80665])


def robots():
    for path in map(Path, sys.path):
        for found in path.glob("cmeel.prefix/share/example-robot-data/robots"):
            return [found / robot for robot in ROBOTS if (found / robot).exists()]
    return []


def close(mine, theirs):
    np.testing.assert_allclose(mine, theirs, atol=1e-10 * max(1.0, np.abs(theirs).max()))


def test_the_robots_are_there():
    assert len(robots()) >= 2


@pytest.mark.parametrize("urdf", robots(), ids=lambda path: path.stem)
def test_dynamics_are_those_of_pinocchio(urdf):
    model = pin.buildModelFromUrdf(str(urdf))
    model.gravity.linear = GRAVITY
    # Dampers are there in both since their version 3; here they are taken out.
    model.damping[:] = 0
    data = model.createData()
    root = ElementTree.parse(urdf).getroot()
    child = {joint.get("name"): joint.find("child").get("link") for joint in root.findall("joint")}
    scene = stillpoint.parse(f'gravity = [0, 0, -9.80665]\n[model]\nfile = "{urdf}"\nhinges = {{ "*" = {{ damping = 0 }} }}\n')
    dynamics = scene.dynamics()
    mine = [name.rsplit(".", 1)[0] for name in scene.coordinates]
    theirs = [name for name in model.names if name in child]
    order = [mine.index(child[name]) for name in theirs]
    assert len(order) == dynamics.nv == model.nv
    random = np.random.default_rng(5)
    for _ in range(10):
        state, v, a = random.uniform(-1, 1, (3, model.nv))
        q = pin.neutral(model)
        for k, name in enumerate(theirs):
            joint = model.joints[model.getJointId(name)]
            q[joint.idx_q : joint.idx_q + joint.nq] = [state[k]] if joint.nq == 1 else [np.cos(state[k]), np.sin(state[k])]
        of = np.argsort(order)
        take = lambda x: np.asarray(x)[order]
        q_mine, v_mine, a_mine = state[of], v[of], a[of]
        close(take(dynamics.acceleration(q_mine, v_mine)), pin.aba(model, data, q, v, np.zeros(model.nv)))
        close(take(dynamics.inverse(q_mine, v_mine, a_mine)), pin.rnea(model, data, q, v, a))
        mass = pin.crba(model, data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        close(dynamics.mass(q_mine)[np.ix_(order, order)], mass)
        by_q, by_v, _ = pin.computeABADerivatives(model, data, q, v, np.zeros(model.nv))
        mine_q, mine_v = (matrix[np.ix_(order, order)] for matrix in dynamics.derivatives(q_mine, v_mine))
        close(mine_q, by_q)
        close(mine_v, by_v)
        for name in theirs:
            frame = model.getFrameId(child[name])
            expected = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
            close(dynamics.jacobian(child[name], q_mine, angular=True)[:, order], expected)
