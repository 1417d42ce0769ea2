"""Many cases of one model by MuJoCo's `rollout`: `many_peers.py MODEL.xml STARTS.json STEP STEPS THREADS RK4|EULER`.
Called by many_beside.py.

Contact and constraints (limits, friction) are off, as they are in our scenario. Prints one JSON object:
positions of all cases at the end, CPU seconds of the rollout alone (all threads) and its wall seconds.
"""

import json
import sys
import time

import mujoco
import numpy as np
from mujoco import rollout


def main(model_path, starts_path, step, steps, threads, integrator):
    model = mujoco.MjModel.from_xml_path(model_path)
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    model.opt.timestep = step
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    with open(starts_path) as file:
        starts = json.load(file)
    data = [mujoco.MjData(model) for _ in range(threads)]
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data[0], 0)
    varied = [model.joint(name).qposadr[0] for name in starts["joints"]]
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty((len(starts["cases"]), mujoco.mj_stateSize(model, kind)))
    for row, case in zip(state, starts["cases"], strict=True):
        data[0].qpos[varied] = case
        mujoco.mj_getState(model, data[0], row, kind)
    out = np.zeros((len(state), steps, state.shape[1]))
    sensed = np.zeros((len(state), steps, model.nsensordata))
    wall, cpu = time.perf_counter(), time.process_time()
    rollout.rollout(model, data, state, nstep=steps, skip_checks=False, state=out, sensordata=sensed)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    # The state begins with the time.
    ends = out[:, -1, 1 : 1 + model.nq]
    print(json.dumps({"ends": ends.tolist(), "cpu": cpu, "wall": wall}))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], float(sys.argv[3]), int(sys.argv[4]), int(sys.argv[5]), sys.argv[6])
