"""Equilibria of nets of springs by the peers: `nets_peers.py exudyn|scipy SCENE.json`. Called by nets_beside.py.

The scene is what `nets.py net N --neutral` prints. Prints one JSON object: positions of all points, seconds of the search
alone (CPU), and how many of them were spent on building.
"""

import json
import sys
import time


def exudyn_statics(scene):
    """As Exudyn's manual has it for large systems: mass points, spring-dampers between them, its sparse solver. The smallest
    number of load steps that reaches the equilibrium is taken: more cost more."""
    import exudyn as exu
    import numpy as np
    from exudyn.utilities import (
        LoadMassProportional,
        MarkerBodyMass,
        MarkerBodyPosition,
        MassPoint,
        NodePoint,
        ObjectConnectorSpringDamper,
        ObjectGround,
    )

    begun = time.process_time()
    container = exu.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(ObjectGround())
    nodes, markers = [], []
    for point in scene["points"]:
        if point["fixed"]:
            nodes.append(None)
            markers.append(system.AddMarker(MarkerBodyPosition(bodyNumber=ground, localPosition=point["place"])))
            continue
        node = system.AddNode(NodePoint(referenceCoordinates=point["place"]))
        body = system.AddObject(MassPoint(physicsMass=point["mass"], nodeNumber=node))
        system.AddLoad(
            LoadMassProportional(markerNumber=system.AddMarker(MarkerBodyMass(bodyNumber=body)), loadVector=scene["gravity"])
        )
        nodes.append(node)
        markers.append(system.AddMarker(MarkerBodyPosition(bodyNumber=body)))
    for spring in scene["springs"]:
        system.AddObject(
            ObjectConnectorSpringDamper(
                markerNumbers=[markers[end[1]] for end in spring["between"]],
                stiffness=spring["stiffness"],
                damping=spring["damping"],
                referenceLength=spring["length"],
            )
        )
    system.Assemble()
    built = time.process_time() - begun
    settings = exu.SimulationSettings()
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolverType = exu.LinearSolverType.EigenSparse
    static = settings.staticSolver
    static.verboseMode = 0
    static.newton.relativeTolerance = 1e-10
    static.newton.absoluteTolerance = 1e-10
    static.newton.maxIterations = 50
    static.numberOfLoadSteps = 1
    begun = time.process_time()
    system.SolveStatic(settings, updateInitialValues=True)
    seconds = time.process_time() - begun
    place = lambda node, point: (
        point["place"] if node is None else list(system.GetNodeOutput(node, exu.OutputVariableType.Position))
    )
    positions = [list(np.asarray(place(*pair), float)) for pair in zip(nodes, scene["points"], strict=True)]
    return positions, seconds, built


def scipy_statics(scene):
    """A page of SciPy: Newton's method on the potential, steps halved until it falls, `splu` on the sparse stiffness."""
    import numpy as np
    from scipy.sparse import csc_matrix, identity
    from scipy.sparse.linalg import splu

    begun = time.process_time()
    places = np.array([point["place"] for point in scene["points"]])
    masses = np.array([point["mass"] for point in scene["points"]])
    free = np.flatnonzero([not point["fixed"] for point in scene["points"]])
    one, other = np.array([[end[1] for end in spring["between"]] for spring in scene["springs"]]).T
    stiffness = np.array([spring["stiffness"] for spring in scene["springs"]])
    length = np.array([spring["length"] for spring in scene["springs"]])
    gravity = np.array(scene["gravity"])
    number = np.full(len(places), -1)
    number[free] = np.arange(len(free))
    rows = 3 * number[:, None] + np.arange(3)
    blocks = [(a, b) for a in (one, other) for b in (one, other)]
    at = [np.broadcast_to(rows[a][:, :, None], (len(a), 3, 3)) for a, _ in blocks]
    across = [np.broadcast_to(rows[b][:, None, :], (len(b), 3, 3)) for _, b in blocks]
    held = [np.broadcast_to(((number[a] >= 0) & (number[b] >= 0))[:, None, None], (len(a), 3, 3)) for a, b in blocks]
    kept = np.stack(held).ravel()
    i, j = np.stack(at).ravel()[kept], np.stack(across).ravel()[kept]

    def potential(x):
        size = np.linalg.norm(x[other] - x[one], axis=1)
        return 0.5 * np.sum(stiffness * (size - length) ** 2) - np.sum(masses[free] * (x[free] @ gravity))

    def tangent(x):
        along = x[other] - x[one]
        size = np.linalg.norm(along, axis=1)
        pull = (stiffness * (size - length) / size)[:, None] * along
        force = masses[:, None] * gravity
        np.add.at(force, one, pull)
        np.add.at(force, other, -pull)
        unit = along / size[:, None]
        cross = (stiffness * (1.0 - length / size))[:, None, None] * np.eye(3)
        block = cross + (stiffness * length / size)[:, None, None] * unit[:, :, None] * unit[:, None, :]
        values = np.stack([block, -block, -block, block]).ravel()[kept]
        return csc_matrix((values, (i, j)), shape=(3 * len(free),) * 2), force[free].ravel()

    built = time.process_time() - begun
    begun = time.process_time()
    x, shift, weight = places.copy(), 0.0, float(np.abs(masses[free]).max() * np.linalg.norm(gravity))
    for _ in range(200):
        matrix, force = tangent(x)
        if np.abs(force).max() < 1e-12 * weight:
            break
        while True:
            shifted = matrix + shift * identity(matrix.shape[0], format="csc") if shift else matrix
            step = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve(force)
            if force @ step > 0.0:
                break
            shift = max(4.0 * shift, 1e-3 * abs(matrix.diagonal()).max())
        size, before = 1.0, potential(x)
        while size > 1e-6:
            moved = x.copy()
            moved[free] += size * step.reshape(-1, 3)
            if potential(moved) <= before + 1e-14 * abs(before):
                break
            size *= 0.5
        x, shift = moved, shift / 8.0 if shift > 1e-6 else 0.0
    else:
        raise RuntimeError("no equilibrium in 200 steps")
    return x.tolist(), time.process_time() - begun, built


if __name__ == "__main__":
    with open(sys.argv[2]) as file:
        scene = json.load(file)
    solve = {"exudyn": exudyn_statics, "scipy": scipy_statics}[sys.argv[1]]
    positions, seconds, built = solve(scene)
    print(json.dumps({"positions": positions, "seconds": seconds, "built": built}))
