"""One of Exudyn's integrators on one problem: `exudyn_integrate.py PROBLEM INTEGRATOR PASSES`.

Chains are Exudyn's kinematic trees (minimal coordinates), the top a rigid body on a spherical joint (constraints).
"""

import sys
import time
import warnings

warnings.simplefilter("ignore")

import exudyn as exu  # noqa: E402
import numpy as np  # noqa: E402
from exudyn.utilities import (  # noqa: E402
    NodeGenericODE2,
    ObjectKinematicTree,
    RigidBodyInertia,
    SensorBody,
    SensorKinematicTree,
)

from models import GRAVITY  # noqa: E402
from problems import PROBLEMS, STEPS, TOLERANCES, say  # noqa: E402

SOLVER = exu.DynamicSolverType
# name: solver, whether it follows a tolerance
INTEGRATORS = {
    "generalized-alpha": (SOLVER.GeneralizedAlpha, False),
    "trapezoidal": (SOLVER.TrapezoidalIndex2, False),
    "RK44": (SOLVER.RK44, False),
    "DOPRI5": (SOLVER.DOPRI5, True),
}
# A method that took so long is not asked for more (s).
PATIENCE = 2.0
POSITION = exu.OutputVariableType.Position
SENSED = {"outputVariableType": POSITION, "storeInternal": False, "writeToFile": False}


def chain(problem):
    container = exu.SystemContainer()
    system = container.AddSystem()
    bodies, n = problem.model.bodies, problem.model.freedom
    zeros = [0.0] * n
    node = system.AddNode(
        NodeGenericODE2(
            referenceCoordinates=zeros,
            initialCoordinates=list(problem.model.position),
            initialCoordinates_t=list(problem.model.velocity),
            numberOfODE2Coordinates=n,
        )
    )
    sprung = {}
    if any(body.stiffness or body.damping for body in bodies):
        sprung = {
            "jointPControlVector": [body.stiffness for body in bodies],
            "jointDControlVector": [body.damping for body in bodies],
            "jointPositionOffsetVector": zeros,
            "jointVelocityOffsetVector": zeros,
        }
    assert all(list(body.axis) == [0, 1, 0] for body in bodies)
    tree = system.AddObject(
        ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[exu.JointType.RevoluteY] * n,
            linkParents=[body.parent for body in bodies],
            jointTransformations=exu.Matrix3DList([body.turn for body in bodies]),
            jointOffsets=exu.Vector3DList([list(body.place) for body in bodies]),
            linkInertiasCOM=exu.Matrix3DList([body.inertia for body in bodies]),
            linkCOMs=exu.Vector3DList([list(body.center) for body in bodies]),
            linkMasses=[body.mass for body in bodies],
            baseOffset=[0.0, 0.0, 0.0],
            gravity=list(GRAVITY),
            **sprung,
        )
    )
    sensor = SensorKinematicTree(objectNumber=tree, linkNumber=n - 1, localPosition=list(problem.point), **SENSED)
    return container, system, system.AddSensor(sensor)


def top(problem):
    container = exu.SystemContainer()
    system = container.AddSystem()
    (body,) = problem.model.bodies
    w, x, y, z = problem.model.position
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    spin, center = turn @ problem.model.velocity, turn @ body.center
    ground = system.CreateGround()
    rigid = system.CreateRigidBody(
        inertia=RigidBodyInertia(body.mass, body.inertia),
        referencePosition=list(center),
        referenceRotationMatrix=turn,
        initialVelocity=list(np.cross(spin, center)),
        initialAngularVelocity=list(spin),
        gravity=list(GRAVITY),
    )
    system.CreateSphericalJoint(itemNumbers=[ground, rigid], position=[0, 0, 0], show=False)
    # Exudyn measures from the centre of mass.
    point = list(np.array(problem.point) - body.center)
    return container, system, system.AddSensor(SensorBody(bodyNumber=rigid, localPosition=point, **SENSED))


def integrate(problem, solver, adaptive, setting):
    """CPU seconds of the integration, the point, and what is to be said."""
    build = top if problem.model.bodies[0].kind == "S" else chain
    _container, system, sensor = build(problem)
    system.Assemble()
    settings = exu.SimulationSettings()
    time_settings, output = settings.timeIntegration, settings.solutionSettings
    time_settings.endTime = problem.duration
    time_settings.verboseMode = 0
    output.writeSolutionToFile = False
    output.sensorsWritePeriod = output.solutionWritePeriod = problem.duration
    time_settings.newton.relativeTolerance = 1e-10
    time_settings.newton.absoluteTolerance = 1e-12
    time_settings.generalizedAlpha.spectralRadius = 0.9
    if adaptive:
        time_settings.numberOfSteps = 20
        time_settings.automaticStepSize = True
        time_settings.relativeTolerance = time_settings.absoluteTolerance = setting
    else:
        time_settings.numberOfSteps = setting
        time_settings.adaptiveStep = False
    before = time.thread_time()
    done = system.SolveDynamic(settings, solverType=solver, showHints=False, showCausingItems=False)
    spent = time.thread_time() - before
    point = np.array(system.GetSensorValues(sensor))
    status = "failed" if done is False else "ok" if np.isfinite(point).all() else "not a number, no failure said"
    return spent, point, status


def main():
    problem, integrator, passes = PROBLEMS[sys.argv[1]], sys.argv[2], int(sys.argv[3])
    solver, adaptive = INTEGRATORS[integrator]
    for setting in TOLERANCES if adaptive else STEPS:
        try:
            spent, point, status = integrate(problem, solver, adaptive, setting)
            for _ in range(passes - 1 if spent < 1 else 0):
                spent = min(spent, integrate(problem, solver, adaptive, setting)[0])
        except Exception as error:  # Exudyn raises what it likes
            spent, point, status = np.nan, [np.nan] * 3, f"failed: {error}"
        shown = f"tolerance {setting:.1e}" if adaptive else f"step {problem.duration / setting:.3g} s"
        say(integrator, shown, spent, point, status)
        if spent > PATIENCE:
            break


if __name__ == "__main__":
    main()
