"""One of Drake's error-controlled integrators on one problem: `drake_integrate.py PROBLEM INTEGRATOR PASSES`."""

import sys
import time

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BallRpyJoint,
    BodyIndex,
    FixedOffsetFrame,
    RevoluteJoint,
    RevoluteSpring,
    RotationalInertia,
    SpatialInertia,
)
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

from models import GRAVITY, moments
from problems import PROBLEMS, TOLERANCES, say

# An integrator that took so long is not asked for more accuracy (s).
PATIENCE = 2.0
# With a longer one runge_kutta5 does not come back from its first step on the top (s).
LONGEST_STEP = 0.1


def build(model):
    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector(np.array(GRAVITY))
    for index, body in enumerate(model.bodies):
        inertia = SpatialInertia.MakeFromCentralInertia(
            body.mass, body.center, RotationalInertia(*moments(body.inertia))
        )
        here = plant.AddRigidBody(f"b{index}", inertia)
        parent = plant.world_frame() if body.parent < 0 else plant.GetFrameByName(f"b{body.parent}")
        at = RigidTransform(RotationMatrix(body.turn), body.place)
        frame = plant.AddFrame(FixedOffsetFrame(f"f{index}", parent, at))
        if body.kind == "S":
            plant.AddJoint(BallRpyJoint(f"j{index}", frame, here.body_frame()))
            continue
        joint = plant.AddJoint(RevoluteJoint(f"j{index}", frame, here.body_frame(), body.axis, body.damping))
        if body.stiffness:
            plant.AddForceElement(RevoluteSpring(joint, 0.0, body.stiffness))
    plant.Finalize()
    return plant


def start(plant, context, model):
    for index, body, at, rates in model.hinges():
        joint = plant.GetJointByName(f"j{index}")
        if body.kind == "S":  # angles in place of the quaternion, angular velocity in the axes of the parent
            w, x, y, z = model.position[at]
            assert y == z == 0, "only a turn about x is translated"
            angle = 2 * np.arctan2(x, w)
            joint.set_angles(context, [angle, 0, 0])
            joint.set_angular_velocity(context, RotationMatrix.MakeXRotation(angle) @ model.velocity[rates])
        else:
            joint.set_angle(context, model.position[at][0])
            joint.set_angular_rate(context, model.velocity[rates][0])


def integrate(problem, plant, scheme, accuracy):
    """CPU seconds of the integration, and the point."""
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    ResetIntegratorFromFlags(simulator, scheme, LONGEST_STEP)
    simulator.get_mutable_integrator().set_maximum_step_size(LONGEST_STEP)
    simulator.get_mutable_integrator().set_target_accuracy(accuracy)
    start(plant, context, problem.model)
    before = time.thread_time()
    simulator.Initialize()
    simulator.AdvanceTo(problem.duration)
    spent = time.thread_time() - before
    last = plant.get_body(BodyIndex(plant.num_bodies() - 1))
    return spent, plant.EvalBodyPoseInWorld(context, last).multiply(np.array(problem.point))


def main():
    problem, scheme, passes = PROBLEMS[sys.argv[1]], sys.argv[2], int(sys.argv[3])
    plant = build(problem.model)
    for accuracy in TOLERANCES:
        try:
            spent, point = integrate(problem, plant, scheme, accuracy)
            for _ in range(passes - 1 if spent < 1 else 0):
                spent = min(spent, integrate(problem, plant, scheme, accuracy)[0])
            status = "ok"
        except (RuntimeError, ValueError) as error:
            spent, point, status = np.nan, [np.nan] * 3, f"failed: {error}"
        say(scheme, f"accuracy {accuracy:.1e}", spent, point, status)
        if not spent < PATIENCE:
            break


if __name__ == "__main__":
    main()
