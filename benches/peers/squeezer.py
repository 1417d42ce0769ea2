"""Andrews' squeezing mechanism: error against time, ours beside Exudyn's solvers for constraints. Called by
`run --squeezer`.

Both read `scenarios/andrews_squeezer.toml`. Errors are against the reference of the tests (quadruple precision): the
largest of the seven relative angles (rad) and of their rates (rad/s) at t = 0.03 s. MuJoCo's and Drake's constraints are
soft or of first order and do not come near these errors.
"""

import json
import math
import os
import subprocess
import sys
import time
import tomllib
import warnings

import numpy as np

warnings.simplefilter("ignore")

from environment import BASE, ROOT, say  # noqa: E402

SCENARIO = ROOT / "scenarios" / "andrews_squeezer.toml"
REFERENCE = ROOT / "tests" / "reference" / "A03_andrews_squeezer.json"
ANGLES = ("beta", "theta", "gamma", "delta", "phi", "epsilon", "omega")
END = 0.03
# Ours: integrator and tolerances; Exudyn: solver and numbers of steps.
OURS = {"dop853": [10.0**-k for k in range(5, 14)], "dopri5": [10.0**-k for k in range(5, 13)]}
STEPS = [300 * 4**k for k in range(6)]
PASSES = 5
PATIENCE = 8.0


def reference():
    state = json.loads(REFERENCE.read_text())["reference"][f"t={END}"]
    return np.array([[float(state[name + dot]["decimal"]) for name in ANGLES] for dot in ("", "_dot")])


def errors(angles, rates, expected):
    off = np.asarray(angles) - expected[0]
    off -= np.round(off / (2 * math.pi)) * 2 * math.pi
    return float(np.abs(off).max()), float(np.abs(np.asarray(rates) - expected[1]).max())


def ours(bodies, integrator, tolerance):
    command = [os.environ["STILLPOINT"], "run", str(SCENARIO), "--json", "--quiet"]
    command += ["--out", str(BASE / "squeezer.mcap"), "--set", "record.rate=100"]
    command += ["--set", f'simulate.integrator="{integrator}"', "--set", f"simulate.tolerance={tolerance!r}"]
    command += ["--set", f"simulate.absolute_tolerance={tolerance!r}"]
    found = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    final = found["final"]
    names = [body["name"] for body in bodies]
    angles = [final["positions"][name][0] for name in names]
    return found["wall_seconds"], angles, [final["velocities"][name][0] for name in names]


def exudyn(bodies, text, solver, steps):
    import exudyn as exu
    from exudyn.utilities import (
        LoadTorqueVector,
        MarkerBodyPosition,
        MarkerBodyRigid,
        NodeRigidBody2D,
        ObjectConnectorSpringDamper,
        ObjectGround,
        ObjectJointRevolute2D,
        ObjectRigidBody2D,
    )

    container = exu.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(ObjectGround(referencePosition=[0, 0, 0]))
    placed = {}

    def turned(angle, point):
        c, s = math.cos(angle), math.sin(angle)
        return np.array([c * point[0] - s * point[1], s * point[0] + c * point[1]])

    def marker(end):
        """A marker at a point of a body: `name.point`, or coordinates on the ground."""
        if isinstance(end, dict):
            return system.AddMarker(MarkerBodyPosition(bodyNumber=ground, localPosition=list(end["at"])))
        name, point = end.split(".")
        at = np.array(placed[name]["body"]["markers"][point]) - placed[name]["body"]["center"]
        return system.AddMarker(MarkerBodyPosition(bodyNumber=placed[name]["object"], localPosition=list(at)))

    def joint(one, other):
        system.AddObject(ObjectJointRevolute2D(markerNumbers=[one, other]))

    for body in bodies:
        hinge = body["hinge"]
        parent = hinge.get("parent")
        angle = hinge.get("position", 0.0) + (placed[parent]["angle"] if parent else 0.0)
        if parent:
            above = placed[parent]
            root = above["root"] + turned(above["angle"], above["body"]["markers"][hinge["at"]])
        else:
            root = np.array(hinge["at"][:2], float)
        center = root + turned(angle, body["center"])
        node = system.AddNode(
            NodeRigidBody2D(referenceCoordinates=[*center, angle], initialCoordinates=[0, 0, 0], initialVelocities=[0, 0, 0])
        )
        number = system.AddObject(
            ObjectRigidBody2D(mass=body["mass"], inertia=body["inertia"][2], nodeNumber=node)
        )
        placed[body["name"]] = {"body": body, "object": number, "node": node, "angle": angle, "root": root}
        own = system.AddMarker(MarkerBodyPosition(bodyNumber=number, localPosition=list(-np.array(body["center"]))))
        end = f"{parent}.{hinge['at']}" if parent else {"at": hinge["at"]}
        joint(marker(end), own)
        if hinge.get("force"):
            turning = system.AddMarker(MarkerBodyRigid(bodyNumber=number, localPosition=[0, 0, 0]))
            system.AddLoad(LoadTorqueVector(markerNumber=turning, loadVector=[0, 0, hinge["force"]]))
    for closed in text["loop"]:
        joint(*(marker(end) for end in closed["between"]))
    (spring,) = text["force"]
    system.AddObject(
        ObjectConnectorSpringDamper(
            markerNumbers=[marker(end) for end in spring["between"]],
            stiffness=spring["stiffness"],
            referenceLength=spring["length"],
        )
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = END
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.relativeTolerance = 1e-12
    settings.timeIntegration.newton.absoluteTolerance = 1e-14
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.solutionWritePeriod = settings.solutionSettings.sensorsWritePeriod = END
    before = time.thread_time()
    done = system.SolveDynamic(
        settings, solverType=getattr(exu.DynamicSolverType, solver), showHints=False, showCausingItems=False
    )
    spent = time.thread_time() - before
    absolute = {}
    for name, part in placed.items():
        q = system.GetNodeOutput(part["node"], exu.OutputVariableType.Coordinates)
        v = system.GetNodeOutput(part["node"], exu.OutputVariableType.Coordinates_t)
        absolute[name] = (part["angle"] + q[2], v[2])
    relative = [
        np.array(absolute[body["name"]]) - (absolute[body["hinge"]["parent"]] if "parent" in body["hinge"] else 0.0)
        for body in bodies
    ]
    return spent, [x[0] for x in relative], [x[1] for x in relative], done is not False


def main():
    text = tomllib.loads(SCENARIO.read_text())
    bodies, expected = text["body"], reference()
    results = []
    for integrator, tolerances in OURS.items():
        say(f"squeezer: stillpoint {integrator}")
        for tolerance in tolerances:
            runs = [ours(bodies, integrator, tolerance) for _ in range(PASSES)]
            spent, angles, rates = min(runs, key=lambda run: run[0])
            results.append(("stillpoint", integrator, f"tolerance {tolerance:.0e}", spent, *errors(angles, rates, expected)))
    for solver in ("GeneralizedAlpha", "TrapezoidalIndex2"):
        say(f"squeezer: Exudyn {solver}")
        for steps in STEPS:
            try:
                spent, angles, rates, done = exudyn(bodies, text, solver, steps)
            except Exception as error:  # Exudyn raises what it likes
                say(f"squeezer: Exudyn {solver} with {steps} steps: {' '.join(str(error).split())[:90]}")
                continue
            if done:
                results.append(("Exudyn", solver, f"step {END / steps:.1e} s", spent, *errors(angles, rates, expected)))
            if spent > PATIENCE:
                break
    print("| program | integrator | setting | ms | angles (rad) | rates (rad/s) |")
    print("|---|---|---|---|---|---|")
    for program, integrator, setting, spent, angle, rate in results:
        print(f"| {program} | {integrator} | {setting} | {1e3 * spent:.3g} | {angle:.1e} | {rate:.1e} |")
    print()
    for most in (1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10):
        best = {}
        for program, integrator, setting, spent, angle, rate in results:
            if angle <= most and rate <= 100 * most and spent < best.get(program, (math.inf,))[0]:
                best[program] = (spent, f"{1e3 * spent:.3g} ms ({integrator}, {setting})")
        shown = [f"{program} {best[program][1] if program in best else 'not reached'}" for program in ("stillpoint", "Exudyn")]
        ratio = f"; ratio {best['stillpoint'][0] / best['Exudyn'][0]:.4f}" if len(best) == 2 else ""
        print(f"angles to {most:.0e} rad, rates to {100 * most:.0e} rad/s: {', '.join(shown)}{ratio}")


if __name__ == "__main__":
    sys.exit(main())
