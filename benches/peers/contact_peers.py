"""Scenes of contact at rest by MuJoCo and Drake: `contact_peers.py PROGRAM SETTING SCENE.json`. Called by contact_beside.py.

The scene is neutral: gravity (m/s²), friction, bodies as boxes or balls with mass and place on the plane z = 0, and two times. Prints one
JSON object: places of all bodies at both times (m) and the CPU seconds of the integration between them.
"""

import json
import sys
import time

SETTINGS = {
    "pyramidal": "",
    "elliptic": 'cone="elliptic" impratio="10"',
    "noslip": 'cone="elliptic" impratio="10" noslip_iterations="10"',
}


def mujoco_places(scene, setting):
    import mujoco

    geom = {
        "box": lambda body: f'type="box" size="{" ".join(str(0.5 * x) for x in body["box"])}"',
        "ball": lambda body: f'type="sphere" size="{body["ball"]}"',
    }
    friction = f'friction="{scene["friction"]} 0 0" condim="3"'
    bodies = "".join(
        f'<body pos="{" ".join(map(str, body["place"]))}"><freejoint/>'
        f'<geom {geom["box" if "box" in body else "ball"](body)} mass="{body["mass"]}" {friction}/></body>'
        for body in scene["bodies"]
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="{" ".join(map(str, scene["gravity"]))}" {SETTINGS[setting]}/><size memory="500M"/>'
        f'<worldbody><geom type="plane" size="50 50 0.1" {friction}/>{bodies}</worldbody></mujoco>'
    )
    data = mujoco.MjData(model)

    def advance(end):
        while data.time < end - 0.5 * model.opt.timestep:
            mujoco.mj_step(model, data)
        return data.qpos.reshape(-1, 7)[:, :3].tolist()

    first = advance(scene["times"][0])
    begun = time.process_time()
    last = advance(scene["times"][1])
    return first, last, time.process_time() - begun


def drake_places(scene, setting):
    """Discrete, steps of 1 ms, contact at points, SAP: boxes touch with small balls in their corners."""
    import logging

    logging.getLogger("drake").setLevel(logging.ERROR)
    from pydrake.all import (
        AddMultibodyPlant,
        CoulombFriction,
        DiagramBuilder,
        HalfSpace,
        MultibodyPlantConfig,
        RigidTransform,
        Simulator,
        SpatialInertia,
        Sphere,
        UnitInertia,
    )

    builder = DiagramBuilder()
    config = MultibodyPlantConfig(time_step=1e-3, contact_model="point", discrete_contact_approximation=setting)
    plant, _ = AddMultibodyPlant(config, builder)
    plant.mutable_gravity_field().set_gravity_vector(scene["gravity"])
    friction = CoulombFriction(scene["friction"], scene["friction"])
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "floor", friction)
    for number, body in enumerate(scene["bodies"]):
        if "box" in body:
            unit, small = UnitInertia.SolidBox(*body["box"]), 1e-3
            x, y, z = (0.5 * size for size in body["box"])
            spheres = [(small, [a, b, small - z]) for a in (-x, x) for b in (-y, y)]
        else:
            unit, spheres = UnitInertia.SolidSphere(body["ball"]), [(body["ball"], [0.0, 0.0, 0.0])]
        link = plant.AddRigidBody(f"body{number}", SpatialInertia(body["mass"], [0.0, 0.0, 0.0], unit))
        for index, (radius, place) in enumerate(spheres):
            plant.RegisterCollisionGeometry(link, RigidTransform(place), Sphere(radius), f"c{number}_{index}", friction)
        plant.SetDefaultFloatingBaseBodyPose(link, RigidTransform(body["place"]))
    plant.Finalize()
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    inner = plant.GetMyContextFromRoot(simulator.get_context())

    def advance(end):
        simulator.AdvanceTo(end)
        return plant.GetPositions(inner).reshape(-1, 7)[:, 4:].tolist()

    first = advance(scene["times"][0])
    begun = time.process_time()
    last = advance(scene["times"][1])
    return first, last, time.process_time() - begun


if __name__ == "__main__":
    with open(sys.argv[3]) as file:
        scene = json.load(file)
    first, last, cpu = {"mujoco": mujoco_places, "drake": drake_places}[sys.argv[1]](scene, sys.argv[2])
    print(json.dumps({"first": first, "last": last, "cpu": cpu}))
