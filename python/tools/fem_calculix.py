#!/usr/bin/env python3
"""A file of finite elements from CalculiX: matrices stored by `*FREQUENCY, SOLVER=MATRIXSTORAGE`.

    ccx bar                                      # bar.inp with that step and no supports: bar.sti, bar.mas, bar.dof
    python fem_calculix.py bar bar.npz --interface root=ROOT --interface tip=TIP

An interface is a node set of the input, or a node by its number; its nodes move as one rigid body, and its point is their mean.
The first is the root. `--millimetres` is for inputs in mm, t, s (N, MPa).
"""

import argparse
import sys
import numpy as np

from fem_file import save


def cards(path):
    """The keyword lines of an input with their data lines."""
    keyword, data = None, []
    with open(path) as lines:
        for line in lines:
            line = line.strip()
            if not line or line.startswith("**"):
                continue
            if line.startswith("*"):
                if keyword:
                    yield keyword, data
                keyword, data = [part.strip().upper() for part in line[1:].split(",")], []
            else:
                data.append([part.strip() for part in line.split(",") if part.strip()])
    if keyword:
        yield keyword, data


def option(keyword, name):
    for part in keyword[1:]:
        key, _, value = part.partition("=")
        if key.strip() == name:
            return value.strip() or True
    return None


def read_input(path):
    """Places of nodes by number, and node sets by name."""
    nodes, sets = {}, {}
    for keyword, data in cards(path):
        if keyword[0] == "INCLUDE":
            sys.exit(f"{path}: *INCLUDE is not followed: write one input")
        if keyword[0] == "TRANSFORM":
            sys.exit(f"{path}: *TRANSFORM: matrices in other axes than those of the nodes are not read")
        if keyword[0] == "NODE":
            for row in data:
                nodes[int(row[0])] = [float(x) for x in row[1:4]] + [0.0] * (4 - len(row))
            name, own = option(keyword, "NSET"), [int(row[0]) for row in data]
        elif keyword[0] == "NSET":
            name = option(keyword, "NSET")
            if option(keyword, "GENERATE"):
                own = [n for row in data for n in range(int(row[0]), int(row[1]) + 1, int(row[2]) if len(row) > 2 else 1)]
            else:
                own = []
                for part in (part for row in data for part in row):
                    own += sets[part.upper()] if part.upper() in sets else [int(part)]
        else:
            continue
        if name:
            sets.setdefault(name, []).extend(own)
    return nodes, sets


def triple(path):
    """Rows, columns (from 0) and values of one triangle."""
    table = np.loadtxt(path, ndmin=2)
    return table[:, 0].astype(int) - 1, table[:, 1].astype(int) - 1, table[:, 2]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("job", help="name of the job, without ending")
    parser.add_argument("out")
    parser.add_argument("--interface", action="append", required=True, metavar="NAME=SET")
    parser.add_argument("--millimetres", action="store_true")
    a = parser.parse_args()
    places, sets = read_input(a.job + ".inp")
    freedoms = [line.split(".") for line in open(a.job + ".dof").read().split()]
    numbers = sorted({int(node) for node, _ in freedoms})
    index = {number: i for i, number in enumerate(numbers)}
    if missing := [number for number in numbers if number not in places]:
        sys.exit(f"{a.job}.dof has node {missing[0]}, which {a.job}.inp does not have (nodes that CalculiX makes of shells and beams)")
    dofs = [(index[int(node)], int(direction) - 1) for node, direction in freedoms]
    length, mass, stiffness = (1e-3, 1e3, 1e3) if a.millimetres else (1.0, 1.0, 1.0)
    nodes = length * np.array([places[number] for number in numbers])
    interfaces = []
    for one in a.interface:
        name, _, chosen = one.partition("=")
        if chosen.upper() in sets:
            own = sorted(set(sets[chosen.upper()]))
        elif chosen.isdigit():
            own = [int(chosen)]
        else:
            sys.exit(f"{a.job}.inp has no node set `{chosen}`: it has {', '.join(sorted(sets))}")
        own = [index[number] for number in own if number in index]
        if not own:
            sys.exit(f"interface `{name}`: none of the nodes of `{chosen}` is in {a.job}.dof")
        interfaces.append((name, nodes[own].mean(axis=0), own))
    scaled = lambda path, factor: (lambda t: (t[0], t[1], factor * t[2]))(triple(path))
    save(a.out, nodes, dofs, scaled(a.job + ".mas", mass), scaled(a.job + ".sti", stiffness), interfaces)
    print(f"{a.out}: {len(nodes)} nodes, {len(dofs)} freedoms, interfaces " + ", ".join(f"{n} ({len(o)} nodes)" for n, _, o in interfaces))


if __name__ == "__main__":
    main()
