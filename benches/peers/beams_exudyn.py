"""Equilibria of beams by Exudyn: `beams_exudyn.py CASE ELEMENT N,N,… REPEATS`. Called by beams_beside.py.

CASE is `elastica`, `bathe` or `catenary`, as beams_beside.py describes them; ELEMENT is `ge2d`
(ObjectBeamGeometricallyExact2D), `ancf2d` (ObjectANCFCable2D) or `ge3d` (ObjectBeamGeometricallyExact). The full load comes in ten steps: in
one step the 2D beams converge to wrong equilibria and say that it is well. Prints one JSON object: for every number of elements the
place of interest (m) and the least CPU seconds of the solver alone.
"""

import json
import math
import sys
import time

import exudyn as exu
import numpy as np
from exudyn.utilities import (
    CoordinateConstraint,
    Force,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    NodePoint2DSlope1,
    NodeRigidBody2D,
    NodeRigidBodyRotVecLG,
    ObjectANCFCable2D,
    ObjectBeamGeometricallyExact,
    ObjectBeamGeometricallyExact2D,
)

LOAD_STEPS = 10
# A beam that does not stretch or shear has none of its own here: stiff enough to change nothing in the eighth digit.
RIGID = 1e9


class Model:
    def __init__(self):
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        nothing = self.system.AddNode(NodePointGround())
        self.still = self.system.AddMarker(MarkerNodeCoordinate(nodeNumber=nothing, coordinate=0))

    def hold(self, node, coordinates):
        for coordinate in coordinates:
            marker = self.system.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
            self.system.AddObject(CoordinateConstraint(markerNumbers=[self.still, marker]))

    def pull(self, node, force):
        marker = self.system.AddMarker(MarkerNodePosition(nodeNumber=node))
        self.system.AddLoad(Force(markerNumber=marker, loadVector=force))

    def solve(self):
        self.system.Assemble()
        settings = exu.SimulationSettings()
        settings.solutionSettings.writeSolutionToFile = False
        settings.linearSolverType = exu.LinearSolverType.EigenSparse
        static = settings.staticSolver
        static.verboseMode = 0
        static.numberOfLoadSteps = LOAD_STEPS
        static.newton.relativeTolerance = 1e-9
        static.newton.absoluteTolerance = 1e-9
        static.newton.maxIterations = 50
        begun = time.process_time()
        self.system.SolveStatic(settings, updateInitialValues=True)
        return time.process_time() - begun

    def place(self, node):
        return list(np.asarray(self.system.GetNodeOutput(node, exu.OutputVariableType.Position), float))


def straight(model, element, n, length, axial, bending, mass=0.0):
    """Nodes along x of a beam in its plane, and its elements."""
    h, nodes, objects = length / n, [], []
    for i in range(n + 1):
        if element == "ge2d":
            nodes.append(model.system.AddNode(NodeRigidBody2D(referenceCoordinates=[i * h, 0.0, 0.0])))
        else:
            nodes.append(model.system.AddNode(NodePoint2DSlope1(referenceCoordinates=[i * h, 0.0, 1.0, 0.0])))
    for pair in zip(nodes, nodes[1:]):
        common = {
            "nodeNumbers": list(pair),
            "physicsLength": h,
            "physicsMassPerLength": mass,
            "physicsBendingStiffness": bending,
            "physicsAxialStiffness": axial,
        }
        if element == "ge2d":
            beam = ObjectBeamGeometricallyExact2D(
                **common, physicsShearStiffness=axial, physicsCrossSectionInertia=mass * 1e-6
            )
        else:
            beam = ObjectANCFCable2D(**common)
        objects.append(model.system.AddObject(beam))
    return nodes, objects


def elastica(element, n):
    model = Model()
    nodes, _ = straight(model, element, n, 1.0, RIGID, 1.0)
    # Clamped: place and angle, or place and the slope's part across.
    model.hold(nodes[0], (0, 1, 2) if element == "ge2d" else (0, 1, 3))
    model.pull(nodes[-1], [0.0, -10.0, 0.0])
    seconds = model.solve()
    return model.place(nodes[-1]), seconds


def bathe(element, n):
    model = Model()
    radius, angle = 100.0, math.pi / 4.0
    section = exu.BeamSection()
    section.stiffnessMatrix = np.diag([1e7, 5e6, 5e6, 2.5e6 / 3.0, 2.5e6 / 3.0, 2.5e6 / 3.0])
    section.massPerLength = 1.0
    section.inertia = np.diag([0.2, 0.1, 0.1])
    nodes = []
    for i in range(n + 1):
        turn = angle * i / n
        place = [radius * math.sin(turn), radius * (1.0 - math.cos(turn)), 0.0]
        nodes.append(model.system.AddNode(NodeRigidBodyRotVecLG(referenceCoordinates=[*place, 0.0, 0.0, turn])))
    chord = 2.0 * radius * math.sin(0.5 * angle / n)
    for pair in zip(nodes, nodes[1:]):
        model.system.AddObject(
            ObjectBeamGeometricallyExact(nodeNumbers=list(pair), physicsLength=chord, sectionData=section)
        )
    model.hold(nodes[0], range(6))
    model.pull(nodes[-1], [0.0, 0.0, 600.0])
    seconds = model.solve()
    return model.place(nodes[-1]), seconds


def catenary(element, n):
    """Straight between its ends to begin with, and longer than they are apart: what Newton's method gets to see first."""
    model = Model()
    length, span, weight = 110.0, 100.0, 50.0
    gravity = 9.80665
    nodes, objects = straight(model, element, n, length, 1e6, 0.1, weight / gravity)
    for beam in objects:
        marker = model.system.AddMarker(MarkerBodyMass(bodyNumber=beam))
        model.system.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=[0.0, -gravity, 0.0]))
    # As Irvine's parabola hangs: nodes are given displacements from the straight line that they are drawn on.
    sag = math.sqrt(3.0 * span * (length - span) / 8.0)
    for i, node in enumerate(nodes):
        x = span * i / n
        slope = 4.0 * sag / span * (1.0 - 2.0 * x / span)
        size = math.hypot(1.0, slope)
        start = [x - length * i / n, -4.0 * sag * x / span * (1.0 - x / span), 1.0 / size - 1.0, -slope / size]
        model.system.SetNodeParameter(node, "initialCoordinates", start)
    model.hold(nodes[0], (0, 1))
    far = model.system.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[-1], coordinate=0))
    model.system.AddObject(CoordinateConstraint(markerNumbers=[model.still, far], offset=span - length))
    model.hold(nodes[-1], (1,))
    seconds = model.solve()
    return model.place(nodes[n // 2]), seconds


def main(case, element, counts, repeats):
    build = {"elastica": elastica, "bathe": bathe, "catenary": catenary}[case]
    runs = []
    for n in counts:
        try:
            found = [build(element, n) for _ in range(repeats)]
            runs.append({"elements": n, "place": found[0][0], "seconds": min(seconds for _, seconds in found)})
        except Exception as error:
            runs.append({"elements": n, "failed": str(error).strip().splitlines()[0][:100]})
    print(json.dumps({"runs": runs}))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], [int(n) for n in sys.argv[3].split(",")], int(sys.argv[4]))
