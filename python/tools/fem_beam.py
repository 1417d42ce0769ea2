#!/usr/bin/env python3
"""A straight beam of Timoshenko or Euler-Bernoulli elements as a file of finite elements, with geometric stiffness.

    python fem_beam.py boom.npz --length 2 --elements 20 --young 70e9 --poisson 0.33 --density 2700 --rectangle 0.06 0.01 \
        --interface tip=20 --interface middle=10

The beam runs along x from its root. `--rectangle` has the sizes along y and z (m); `--thin` leaves shear out (Euler-Bernoulli).
Geometric stiffness is that of tension: under acceleration along x, spin about y and z, and forces along x on the interfaces.
"""

import argparse
import numpy as np

from fem_file import save

AXES = (((1, 5, 7, 11), 1.0), ((2, 4, 8, 10), -1.0))  # deflection and slope in the planes x-y and x-z


def element(h, area, shear, iy, iz, torsion, young, modulus, density):
    """Stiffness and consistent mass of one element, freedoms x y z rx ry rz of both ends (Przemieniecki 1968)."""
    k, m = np.zeros((12, 12)), np.zeros((12, 12))
    for at, stiff, heavy in ((0, young * area / h, density * area * h), (3, modulus * torsion / h, density * (iy + iz) * h)):
        rows = np.ix_((at, at + 6), (at, at + 6))
        k[rows] += stiff * np.array([[1, -1], [-1, 1]])
        m[rows] += heavy / 6 * np.array([[2, 1], [1, 2]])
    for (rows, sign), inertia in zip(AXES, (iz, iy)):
        phi = 12 * young * inertia / (modulus * shear * h * h) if shear else 0.0
        turn = np.diag([1.0, sign, 1.0, sign])
        bend = np.array([
            [12, 6 * h, -12, 6 * h],
            [6 * h, (4 + phi) * h * h, -6 * h, (2 - phi) * h * h],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, (2 - phi) * h * h, -6 * h, (4 + phi) * h * h],
        ]) * young * inertia / (h**3 * (1 + phi))
        p = phi
        a, b = 13 / 35 + 7 * p / 10 + p * p / 3, 9 / 70 + 3 * p / 10 + p * p / 6
        c, d = (11 / 210 + 11 * p / 120 + p * p / 24) * h, (13 / 420 + 3 * p / 40 + p * p / 24) * h
        e, f = (1 / 105 + p / 60 + p * p / 120) * h * h, (1 / 140 + p / 60 + p * p / 120) * h * h
        shift = np.array([[a, c, b, -d], [c, e, d, -f], [b, d, a, -c], [-d, -f, -c, e]])
        q = 1 / 10 - p / 2
        spin = np.array([
            [6 / 5, q * h, -6 / 5, q * h],
            [q * h, (2 / 15 + p / 6 + p * p / 3) * h * h, -q * h, (-1 / 30 - p / 6 + p * p / 6) * h * h],
            [-6 / 5, -q * h, 6 / 5, -q * h],
            [q * h, (-1 / 30 - p / 6 + p * p / 6) * h * h, -q * h, (2 / 15 + p / 6 + p * p / 3) * h * h],
        ])
        both = (density * area * h * shift + density * inertia / h * spin) / (1 + p) ** 2
        k[np.ix_(rows, rows)] += turn @ bend @ turn
        m[np.ix_(rows, rows)] += turn @ both @ turn
    return k, m


def tension(h):
    """Geometric stiffness of one element with tension 1."""
    k = np.zeros((12, 12))
    bend = np.array([[36, 3 * h, -36, 3 * h], [3 * h, 4 * h * h, -3 * h, -h * h], [-36, -3 * h, 36, -3 * h], [3 * h, -h * h, -3 * h, 4 * h * h]])
    for rows, sign in AXES:
        turn = np.diag([1.0, sign, 1.0, sign])
        k[np.ix_(rows, rows)] += turn @ bend @ turn / (30 * h)
    return k


def torsion_constant(a, b):
    """Saint-Venant's constant of a rectangle (Timoshenko and Goodier)."""
    a, b = max(a, b), min(a, b)
    series = sum(np.tanh(n * np.pi * a / (2 * b)) / n**5 for n in range(1, 60, 2))
    return a * b**3 / 3 * (1 - 192 * b / (np.pi**5 * a) * series)


def build(length, elements, young, poisson, density, width, height, interfaces, thin=False):
    """The arguments of `save` but for the path."""
    h, n = length / elements, 6 * (elements + 1)
    area, iy, iz = width * height, width * height**3 / 12, height * width**3 / 12
    modulus = young / (2 * (1 + poisson))
    k, m = element(h, area, 0.0 if thin else 5 / 6 * area, iy, iz, torsion_constant(width, height), young, modulus, density)

    def assembled(of):
        whole = np.zeros((n, n))
        for i in range(elements):
            whole[6 * i : 6 * i + 12, 6 * i : 6 * i + 12] += of(i)
        return whole

    pull = lambda force: assembled(lambda i: force((i + 0.5) * h) * tension(h))
    line = density * area
    spun = lambda x: 0.5 * line * (length**2 - x * x - h * h / 12)
    geometric = {0: pull(lambda x: -line * (length - x)), 7: pull(spun), 8: pull(spun)}
    for i, (_, node) in enumerate(interfaces):
        geometric[12 + 3 * i] = pull(lambda x: 1.0 if x < node * h else 0.0)
    nodes = np.outer(np.linspace(0, length, elements + 1), [1.0, 0.0, 0.0])
    mass = line * length
    declared = {"total_mass": mass, "center": [length / 2, 0, 0]}
    return dict(
        nodes=nodes,
        dofs=[(i // 6, i % 6) for i in range(n)],
        mass=assembled(lambda i: m),
        stiffness=assembled(lambda i: k),
        interfaces=[("root", nodes[0], [0])] + [(name, nodes[node], [node]) for name, node in interfaces],
        geometric=geometric,
        declared=declared,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--length", type=float, required=True)
    parser.add_argument("--elements", type=int, default=20)
    parser.add_argument("--young", type=float, required=True)
    parser.add_argument("--poisson", type=float, default=0.3)
    parser.add_argument("--density", type=float, required=True)
    parser.add_argument("--rectangle", type=float, nargs=2, required=True, metavar=("Y", "Z"))
    parser.add_argument("--interface", action="append", default=[], metavar="NAME=NODE")
    parser.add_argument("--thin", action="store_true")
    a = parser.parse_args()
    interfaces = [(name, int(node)) for name, node in (one.split("=") for one in a.interface)]
    arguments = build(a.length, a.elements, a.young, a.poisson, a.density, *a.rectangle, interfaces or [("tip", a.elements)], a.thin)
    save(a.out, **arguments)


if __name__ == "__main__":
    main()
