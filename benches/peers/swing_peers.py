"""A rod that swings, by MuJoCo and PyElastica: `swing_peers.py PROGRAM ROD.json N,N,… REPEATS`. Called by beams_beside.py.

The rod is on a pin at the origin, drawn along x and let go. Prints one JSON object: for every number of elements and step where
the tip is at the end (m) and the least CPU seconds of the integration alone.
"""

import json
import math
import sys
import time


def mujoco_rod(rod, n, step):
    """Links on hinges with springs, order 2. MuJoCo's composite cable was such a row on balls with springs; it left with version 4, and in
    a plane hinges do what balls did for a third of the cost."""
    import mujoco

    h = rod["length"] / n
    mass = rod["mass_per_length"] * h
    along, across = rod["rotary"][0] * h, rod["rotary"][1] * h + mass * h * h / 12.0
    opened = "".join(
        f'<body pos="{0.0 if i == 0 else h} 0 0">'
        f'<joint type="hinge" axis="0 1 0" stiffness="{0.0 if i == 0 else rod["bending"] / h}"/>'
        f'<inertial pos="{0.5 * h} 0 0" mass="{mass}" diaginertia="{along} {across} {across}"/>'
        + (f'<site name="tip" pos="{h} 0 0"/>' if i == n - 1 else "")
        for i in range(n)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler boundmass="0" balanceinertia="true"/><option gravity="0 0 {-rod["gravity"]}" integrator="RK4" timestep="{step!r}">'
        f'<flag contact="disable" constraint="disable"/></option><worldbody>{opened}{"</body>" * n}</worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    begun = time.process_time()
    mujoco.mj_step(model, data, round(rod["end"] / step))
    seconds = time.process_time() - begun
    mujoco.mj_kinematics(model, data)
    return data.site("tip").xpos.tolist(), seconds


def pyelastica_rod(rod, n, step):
    """A Cosserat rod, its node at the pin held, PositionVerlet as the documentation advises."""
    import elastica
    import numpy as np
    from elastica.modules import BaseSystemCollection, Constraints, Forcing

    class Simulator(BaseSystemCollection, Constraints, Forcing):
        pass

    simulator = Simulator()
    one = elastica.CosseratRod.straight_rod(
        n,
        np.zeros(3),
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, 1.0, 0.0]),
        rod["length"],
        rod["radius"],
        rod["density"],
        youngs_modulus=rod["young"],
        shear_modulus=rod["shear"],
    )
    simulator.append(one)
    simulator.constrain(one).using(
        elastica.GeneralConstraint, constrained_position_idx=(0,), translational_constraint_selector=np.array([True] * 3)
    )
    simulator.add_forcing_to(one).using(elastica.GravityForces, acc_gravity=np.array([0.0, 0.0, -rod["gravity"]]))
    simulator.finalize()
    begun = time.process_time()
    elastica.integrate(elastica.PositionVerlet(), simulator, rod["end"], round(rod["end"] / step), progress_bar=False)
    return one.position_collection[:, -1].tolist(), time.process_time() - begun


def steps(program, rod, n):
    """Steps that are stable, and half of them: MuJoCo's by the highest frequency of the row, PyElastica's by the time a wave takes through an
    element."""
    h = rod["length"] / n
    if program == "mujoco":
        most = 1.2 * h * h / (4.0 * math.sqrt(rod["bending"] / rod["mass_per_length"]))
        most = min(most, 0.02)
    else:
        most = 0.3 * h / math.sqrt(rod["young"] / rod["density"])
    count = math.ceil(rod["end"] / most)
    return [rod["end"] / count, rod["end"] / (2 * count)]


def main(program, rod, counts, repeats):
    run = {"mujoco": mujoco_rod, "pyelastica": pyelastica_rod}[program]
    if program == "pyelastica":
        # Numba compiles on the first call.
        run({**rod, "end": 1e-3}, 4, 1e-4)
    runs = []
    for n in counts:
        for step in steps(program, rod, n):
            found = [run(rod, n, step) for _ in range(repeats)]
            runs.append(
                {"elements": n, "step": step, "place": found[0][0], "seconds": min(seconds for _, seconds in found)}
            )
    print(json.dumps({"runs": runs}))


if __name__ == "__main__":
    with open(sys.argv[2]) as file:
        rod = json.load(file)
    main(sys.argv[1], rod, [int(n) for n in sys.argv[3].split(",")], int(sys.argv[4]))
