"""Compares accelerations of MJCF models as imported here with MuJoCo's own, at random states.

    compare_mjcf.py STILLPOINT MODEL.xml… [--states N]

Contacts, limits and dry friction are switched off in MuJoCo; they are not taken over. For models with equality constraints MuJoCo's
soft ones are replaced by exact ones: M a + Jᵀ λ = f, J a = −J̇ v, with its own M, J and f. One JSON object on standard output:
per model the largest difference, relative to the largest acceleration of the state.
"""

import json
import os
import subprocess
import sys
import tempfile

import mujoco
import numpy as np

OFF = mujoco.mjtDisableBit
HINGE, SLIDE, BALL, FREE = (
    mujoco.mjtJoint.mjJNT_HINGE,
    mujoco.mjtJoint.mjJNT_SLIDE,
    mujoco.mjtJoint.mjJNT_BALL,
    mujoco.mjtJoint.mjJNT_FREE,
)
COORDINATES = {int(HINGE): 1, int(SLIDE): 1, int(BALL): 4, int(FREE): 7}
VELOCITIES = {int(HINGE): 1, int(SLIDE): 1, int(BALL): 3, int(FREE): 6}


def hinges(model):
    """The body by which each joint's hinge is known here."""
    names = []
    for body in range(model.nbody):
        first, count = model.body_jntadr[body], model.body_jntnum[body]
        name = model.body(body).name or f"body_{body}"
        for place in range(count):
            joint = model.joint(first + place).name or f"joint_{place}"
            names.append(name if place == count - 1 else f"{name}/{joint}")
    return names


def coordinates(model, joint, qpos):
    """A joint's coordinates as they are here: hinges and slides count from their references."""
    at, kind = model.jnt_qposadr[joint], int(model.jnt_type[joint])
    numbers = qpos[at : at + COORDINATES[kind]].copy()
    if kind in (int(HINGE), int(SLIDE)):
        numbers -= model.qpos0[at]
    return numbers.tolist()


def guesses(model, names, qpos):
    """A pose from which loops are closed."""
    for joint, name in enumerate(names):
        numbers = coordinates(model, joint, qpos)
        yield from ("--set", f"{name}.position={numbers[0] if len(numbers) == 1 else numbers}")


def start_file(model, names, qpos, qvel, path):
    """A state as a start file."""
    positions, velocities = {}, {}
    for joint, name in enumerate(names):
        rate = model.jnt_dofadr[joint]
        positions[name] = coordinates(model, joint, qpos)
        velocities[name] = qvel[rate : rate + VELOCITIES[int(model.jnt_type[joint])]].tolist()
    with open(path, "w") as file:
        for title, table in (("positions", positions), ("velocities", velocities)):
            file.write(f"[{title}]\n")
            file.writelines(f"{json.dumps(name)} = {numbers!r}\n" for name, numbers in table.items())


def random_state(model, generator, data):
    """A keyframe's or the reference state, moved at random."""
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    else:
        mujoco.mj_resetData(model, data)
    mujoco.mj_integratePos(model, data.qpos, generator.uniform(-0.7, 0.7, model.nv), 1.0)
    data.qvel[:] = generator.uniform(-1.0, 1.0, model.nv)


def inspect(program, scenario, *changes):
    command = [program, "inspect", scenario, *changes, "--json"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")
    return json.loads(done.stdout)


def flat(model, names, by_hinge, counts):
    """Numbers by hinge in MuJoCo's order."""
    return np.concatenate([by_hinge[name][: counts[int(model.jnt_type[joint])]] for joint, name in enumerate(names)])


def smooth(model, data):
    """Accelerations without any constraint."""
    mujoco.mj_forward(model, data)
    return data.qacc_smooth.copy()


def equality_rows(model, data):
    """The Jacobian and the gaps of equality constraints."""
    mujoco.mj_forward(model, data)
    rows = np.array(data.efc_type)[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    jacobian = np.array(data.efc_J).reshape(data.nefc, model.nv) if not mujoco.mj_isSparse(model) else None
    # Gears engage wherever they start: only the gaps of loops are gaps.
    kinds = np.array(model.eq_type)[np.array(data.efc_id)[: data.nefc][rows]]
    loops = np.isin(kinds, [int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD)])
    return jacobian[rows], np.where(loops, np.array(data.efc_pos)[: data.nefc][rows], 0.0)


def constrained(model, data):
    """Accelerations with exact equality constraints, by MuJoCo's matrices."""
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    jacobian, gaps = equality_rows(model, data)
    free = data.qacc_smooth.copy()
    mass = np.zeros((model.nv, model.nv))
    for column, direction in enumerate(np.eye(model.nv)):
        mujoco.mj_mulM(model, data, mass[column], direction)
    moved = mujoco.MjData(model)
    change = np.zeros_like(jacobian)
    step = 1e-5
    for sign in (1.0, -1.0):
        moved.qpos[:], moved.qvel[:] = data.qpos, data.qvel
        mujoco.mj_integratePos(model, moved.qpos, data.qvel, sign * step)
        change += sign * equality_rows(model, moved)[0] / (2 * step)
    inverse = np.linalg.inv(mass)
    response = jacobian @ inverse @ jacobian.T
    wanted = -change @ data.qvel - jacobian @ free
    multipliers = np.linalg.lstsq(response, wanted, rcond=1e-10)[0]
    return free + inverse @ jacobian.T @ multipliers, jacobian, gaps


def compare(program, path, states, folder):
    model = mujoco.MjModel.from_xml_path(path)
    # Nothing moves in a fluid here.
    model.opt.density, model.opt.viscosity = 0.0, 0.0
    model.opt.disableflags |= OFF.mjDSBL_CONTACT | OFF.mjDSBL_LIMIT | OFF.mjDSBL_FRICTIONLOSS
    data = mujoco.MjData(model)
    scenario = os.path.join(folder, "model.toml")
    done = subprocess.run([program, "convert", path, "-o", scenario], capture_output=True, text=True)
    result = {"notes": [line for line in done.stderr.splitlines() if ": " in line]}
    if done.returncode:
        return result | {"refused": done.stderr}
    if model.nv == 0:
        return result | {"difference": 0.0, "gap": 0.0, "mass": 0.0, "velocities": 0, "states": 0}
    names = hinges(model)
    generator = np.random.default_rng(1)
    start = os.path.join(folder, "start.toml")
    tied = model.neq > 0 and not model.opt.disableflags & OFF.mjDSBL_EQUALITY and bool(data.eq_active.any())
    difference, gap = 0.0, 0.0
    for _ in range(states):
        random_state(model, generator, data)
        if tied:
            # Near the reference, so that the loops close again, and at rest.
            pose = data.qpos.copy()
            mujoco.mj_resetData(model, data)
            if model.nkey:
                mujoco.mj_resetDataKeyframe(model, data, 0)
            apart = np.zeros(model.nv)
            mujoco.mj_differentiatePos(model, apart, 1.0, data.qpos, pose)
            mujoco.mj_integratePos(model, data.qpos, 0.1 * apart, 1.0)
            data.qvel[:] = 0.0
        if tied:
            ours = inspect(program, scenario, *guesses(model, names, data.qpos))
            closed = flat(model, names, ours["positions"], COORDINATES)
            scalar = np.isin(model.jnt_type, [int(HINGE), int(SLIDE)])
            closed[model.jnt_qposadr[scalar]] += model.qpos0[model.jnt_qposadr[scalar]]
            data.qpos[:] = closed
            theirs, _, gaps = constrained(model, data)
            gap = max(gap, float(np.abs(gaps).max(initial=0.0)))
        else:
            start_file(model, names, data.qpos, data.qvel, start)
            ours = inspect(program, scenario, "--start", start)
            theirs = smooth(model, data)
        found = flat(model, names, ours["accelerations"], VELOCITIES)
        scale = max(float(np.abs(theirs).max(initial=0.0)), 1e-12)
        difference = max(difference, float(np.abs(found - theirs).max(initial=0.0)) / scale)
    masses = abs(ours["total_mass"] - float(model.body_mass.sum())) / max(float(model.body_mass.sum()), 1e-300)
    return result | {"difference": difference, "gap": gap, "mass": masses, "velocities": int(model.nv), "states": states}


def main(arguments):
    states = 5
    if "--states" in arguments:
        at = arguments.index("--states")
        states = int(arguments[at + 1])
        arguments = arguments[:at] + arguments[at + 2 :]
    program, *paths = arguments
    results = {}
    for path in paths:
        with tempfile.TemporaryDirectory() as folder:
            try:
                results[path] = compare(program, path, states, folder)
            except (RuntimeError, ValueError, KeyError) as error:
                results[path] = {"error": f"{type(error).__name__}: {error}"}
    json.dump(results, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1:])
