"""Makes references.json: each problem solved by SciPy on Pinocchio's accelerations, twice, by different methods.

    target/peers/venv/bin/python benches/peers/references.py

`apart` is the distance of the two answers (m): what is known of the error of the first.
"""

import json

import numpy as np
import pinocchio
from scipy.integrate import solve_ivp

from models import GRAVITY
from problems import PROBLEMS, REFERENCES

# The method, its relative and its absolute tolerance: the answer, and what it is compared with. SciPy's least relative
# tolerance is 2.3e-14.
TIGHT = ("DOP853", 2.3e-14, 1e-15)
OTHER = {
    "five_links": ("DOP853", 1e-12, 1e-13),
    "heavy_top": ("DOP853", 1e-12, 1e-13),
    "stiff_chain": ("Radau", 1e-9, 1e-11),
}


def pinocchio_model(bodies):
    model = pinocchio.Model()
    model.gravity.linear = np.array(GRAVITY)
    for index, body in enumerate(bodies):
        joint = (
            pinocchio.JointModelSpherical() if body.kind == "S" else pinocchio.JointModelRevoluteUnaligned(*body.axis)
        )
        at = model.addJoint(body.parent + 1, joint, pinocchio.SE3(body.turn, body.place), f"j{index}")
        inertia = pinocchio.Inertia(body.mass, body.center, body.inertia)
        model.appendBodyToJoint(at, inertia, pinocchio.SE3.Identity())
    return model


def angles(problem, method, relative, absolute):
    """A chain of revolute hinges with springs and dampers; returns the point."""
    model = pinocchio_model(problem.model.bodies)
    data, n = model.createData(), problem.model.freedom
    stiffness = np.array([body.stiffness for body in problem.model.bodies])
    damping = np.array([body.damping for body in problem.model.bodies])

    def rates(_, x):
        q, v = x[:n], x[n:]
        return np.concatenate([v, pinocchio.aba(model, data, q, v, -stiffness * q - damping * v)])

    def jacobian(_, x):
        q, v = x[:n], x[n:]
        pinocchio.computeABADerivatives(model, data, q, v, -stiffness * q - damping * v)
        inverse = np.triu(data.Minv)
        inverse = inverse + np.triu(inverse, 1).T
        down = [data.ddq_dq - inverse * stiffness, data.ddq_dv - inverse * damping]
        return np.block([[np.zeros((n, n)), np.eye(n)], down])

    start = np.concatenate([problem.model.position, problem.model.velocity])
    more = {"jac": jacobian} if method == "Radau" else {}
    end = solve_ivp(rates, (0, problem.duration), start, method=method, rtol=relative, atol=absolute, **more).y[:n, -1]
    pinocchio.forwardKinematics(model, data, end)
    return data.oMi[n].act(np.array(problem.point))


def ball(problem, method, relative, absolute):
    """One body on a ball joint; Pinocchio's quaternions have w last."""
    model = pinocchio_model(problem.model.bodies)
    data = model.createData()
    force = np.zeros(3)

    def rates(_, x):
        q, v = x[:4] / np.linalg.norm(x[:4]), x[4:]
        turning = pinocchio.Quaternion(q) * pinocchio.Quaternion(0, *(0.5 * v))
        return np.concatenate([turning.coeffs(), pinocchio.aba(model, data, q, v, force)])

    start = np.concatenate([np.roll(problem.model.position, -1), problem.model.velocity])
    end = solve_ivp(rates, (0, problem.duration), start, method=method, rtol=relative, atol=absolute).y[:4, -1]
    return pinocchio.Quaternion(end / np.linalg.norm(end)).matrix() @ np.array(problem.point)


def main():
    found = {}
    for name, problem in PROBLEMS.items():
        solve = ball if problem.model.bodies[0].kind == "S" else angles
        point, other = solve(problem, *TIGHT), solve(problem, *OTHER[name])
        found[name] = {
            "point": point.tolist(),
            "method": "SciPy {} at {} / {}".format(*TIGHT),
            "other": "SciPy {} at {} / {}".format(*OTHER[name]),
            "apart": float(np.linalg.norm(point - other)),
        }
        print(name, found[name], flush=True)
    REFERENCES.write_text(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
