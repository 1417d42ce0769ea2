"""The three problems on which integrators are compared, and where their last points end up."""

import dataclasses
import json
import math

import numpy as np

import models
from environment import HERE

REFERENCES = HERE / "references.json"

# Half decades, and factors of √2 in the number of steps: the same for every program (MuJoCo goes on to more steps).
TOLERANCES = [10.0 ** (-k / 2) for k in range(4, 27)]
STEPS = [round(200 * 2 ** (k / 2)) for k in range(15)]


@dataclasses.dataclass
class Problem:
    """Integrate `model` from its state for `duration` seconds; the answer is where `point` of the last body is then."""

    model: models.Model
    point: tuple
    duration: float
    text: str


def planar(n, **hinge):
    """Links in one plane, released straight and horizontal."""
    return [models.link(i - 1, "R", [0, 1, 0], **hinge) for i in range(n)]


def heavy_top():
    tilt, spin = math.pi / 6, 100.0
    inertia = np.diag([0.002, 0.002, 0.004])
    body = models.Body(-1, "S", np.zeros(3), np.eye(3), np.zeros(3), 1.0, np.array([0, 0, 0.1]), inertia)
    position = np.array([math.cos(tilt / 2), math.sin(tilt / 2), 0.0, 0.0])
    return models.Model("heavy_top", [body], position, np.array([0.0, 0.0, spin]))


TIP = (models.LINK_LENGTH, 0.0, 0.0)
PROBLEMS = {
    "five_links": Problem(
        models.Model("five_links", planar(5)), TIP, 2.0, "Five links in a plane, let go from horizontal"
    ),
    "heavy_top": Problem(heavy_top(), (0.0, 0.0, 0.1), 2.0, "Heavy top on a ball joint, 30° aside, 100 rad/s"),
    "stiff_chain": Problem(
        models.Model("stiff_chain", planar(20, stiffness=5000.0, damping=50.0)),
        TIP,
        2.0,
        "Twenty links with stiff springs and dampers in the hinges",
    ),
}


def references():
    """Name → point, from `references.py`."""
    return {name: np.array(entry["point"]) for name, entry in json.loads(REFERENCES.read_text()).items()}


def say(integrator, setting, seconds, point, status):
    """The line of one result on standard output, where peers may print as well."""
    status = " ".join(status.replace(",", ";").split())[:90]
    print("result", integrator, setting, f"{seconds:.6g}", *(f"{x:.17g}" for x in point), status, sep=",", flush=True)
