#!/usr/bin/env python3
"""Finds the lower triangular matrices of src/integrate/implicit/splitting.rs and compares them with those that stand there.

    docs/splitting.py

For the test equation with z = h λ a sweep multiplies errors by G(z) = z (1 − z L)⁻¹ (A − L). The diagonal of L is
(det A)^(1/s). Its other entries make the mean of log ‖G³‖^(1/3) least

    smooth   at z = i y, y = 0.3, 0.6, 1, 1.5, 2, 3, 4
    stiff    on the rays of 110, 135, 160 and 180 degrees, at twelve |z| from 10 to 10⁴ that grow by a constant factor

by Nelder and Mead's method from the factor L of A = L U with that diagonal, and from twelve random places around it. It
fails if a matrix of the source leaves half a percent more of an error than what is found, rounded as it is there. Needs
numpy and scipy.
"""

import pathlib
import re
import sys

import numpy as np
from numpy.polynomial.legendre import Legendre
from scipy.optimize import minimize

SOURCE = pathlib.Path(__file__).resolve().parent.parent / "src/integrate/implicit/splitting.rs"
METHODS = {"GAUSS_3": ("gauss", 3), "RADAU_3": ("radau", 3), "RADAU_5": ("radau", 5)}
SMOOTH = 1j * np.array([0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0])
STIFF = np.outer(np.exp(1j * np.radians([110.0, 135.0, 160.0, 180.0])), np.logspace(1, 4, 12)).ravel()
STARTS = 12
DIGITS = 4
WORSE = 0.005


def collocation(nodes, stages):
    """The matrix A."""
    polynomial = Legendre.basis(stages)
    if nodes == "radau":
        polynomial = polynomial - Legendre.basis(stages - 1)
    c = np.sort(0.5 * (1.0 + polynomial.roots().real))
    powers = np.vander(c, stages, increasing=True)
    integrals = c[:, None] * powers / np.arange(1, stages + 1)
    return integrals @ np.linalg.inv(powers)


def triangular(diagonal, below, stages):
    """L from its entries below the diagonal, row by row."""
    matrix = diagonal * np.eye(stages)
    matrix[np.tril_indices(stages, -1)] = below
    return matrix


def sweep(A, L, z):
    """G(z) for all z."""
    z = z[:, None, None]
    return np.linalg.solve(np.eye(len(A)) - z * L, z * (A - L))


def left(A, L, z):
    """Mean of log ‖G³‖^(1/3), Frobenius norm."""
    cubes = np.linalg.matrix_power(sweep(A, L, z), 3)
    return np.log(np.linalg.norm(cubes, axis=(1, 2))).mean() / 3.0


def factor(A):
    """The entries below the diagonal of L in A = L U with equal diagonal entries of L: an L of Crout, its columns scaled."""
    stages = len(A)
    L, U = np.zeros((stages, stages)), np.eye(stages)
    for j in range(stages):
        L[j:, j] = A[j:, j] - L[j:, :j] @ U[:j, j]
        U[j, j + 1 :] = (A[j, j + 1 :] - L[j, :j] @ U[:j, j + 1 :]) / L[j, j]
    L *= np.linalg.det(A) ** (1.0 / stages) / np.diag(L)
    return L[np.tril_indices(stages, -1)]


def search(A, diagonal, z):
    """The best entries found, rounded."""
    stages, start, random = len(A), factor(A), np.random.default_rng(1)
    places = [start] + [start + random.normal(0.0, 0.1, start.size) for _ in range(STARTS)]
    best = None
    for place in places:
        for _ in range(3):
            options = {"xatol": 1e-7, "fatol": 1e-11, "maxfev": 400 * start.size, "adaptive": True}
            found = minimize(
                lambda x: left(A, triangular(diagonal, x, stages), z), place, method="Nelder-Mead", options=options
            )
            place = found.x
        if best is None or found.fun < best.fun:
            best = found
    return best.x.round(DIGITS)


def given(name):
    """Diagonal and entries as they stand in the source."""
    text = SOURCE.read_text().split(f"pub(crate) const {name}: Splitting")[1].split("};")[0]
    number = r"-?\d+\.\d+"
    diagonal = float(re.search(rf"diagonal: ({number})", text)[1])
    lists = {key: re.search(rf"{key}: (.*)", text)[1] for key in ("smooth", "stiff")}
    return diagonal, {key: np.array([float(x) for x in re.findall(number, row)]) for key, row in lists.items()}


def main():
    fails = False
    for name, (nodes, stages) in METHODS.items():
        A = collocation(nodes, stages)
        diagonal, entries = given(name)
        print(f"{name}: diagonal {np.linalg.det(A) ** (1.0 / stages):.6f}, in the source {diagonal}")
        for key, z in (("smooth", SMOOTH), ("stiff", STIFF)):
            found = search(A, np.linalg.det(A) ** (1.0 / stages), z)
            best, there = (left(A, triangular(diagonal, x, stages), z) for x in (found, entries[key]))
            print(f"  {key}: {np.array2string(found, precision=4, max_line_width=120)} leaves {best:.5f}")
            print(f"    in the source {there:.5f}, entries up to {abs(found - entries[key]).max():.4f} away")
            fails |= there > best + WORSE
    sys.exit("an entry of the source is not the best" if fails else 0)


if __name__ == "__main__":
    main()
