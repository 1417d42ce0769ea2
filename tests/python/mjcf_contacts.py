"""Which geoms touch in MuJoCo.

    mjcf_contacts.py MODEL.xml …

Prints one JSON object: for every model the pairs of geoms that are in contact at its start, as "g0 g1" with the names in order of
their numbers, and the coefficient of sliding friction; 0 where the contact has none (`condim` 1).
"""

import json
import sys

import mujoco


def contacts(path):
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found = {}
    for contact in data.contact:
        numbers = sorted(int(model.geom(geom).name[1:]) for geom in contact.geom)
        found[f"g{numbers[0]} g{numbers[1]}"] = contact.friction[0] if contact.dim > 1 else 0.0
    return found


print(json.dumps({path: contacts(path) for path in sys.argv[1:]}))
