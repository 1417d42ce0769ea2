#!/usr/bin/env python3
"""A file of finite elements from Nastran: matrices as DMIG cards of a punch file, places of grids from the bulk data.

    python fem_nastran.py model.bdf model.pch model.npz --interface root=1 --interface tip=21

In the case control `EXTSEOUT(DMIGPCH, ASMBULK)`, or `PARAM,POST,...` with an alter that punches KGG and MGG as DMIG; the names of
the matrices are found by their first letter (`--stiffness`, `--mass` to choose). Directions 1 … 6 of a grid are x, y, z and the
turns. Coordinates are basic ones: other systems (CP, CD) are refused. An interface is a grid, or several with `+` between them
(`tip=21+22+23`); its point is their mean, and the first is the root. `--millimetres` is for mm, t, s.

Numbers are read with NumPy alone. With `--op4` the punch file may be an OP4 file whose matrices go over six freedoms of every
grid in ascending order; that needs pyNastran.
"""

import argparse
import sys
import numpy as np

from fem_file import save


def number(text):
    """`1.5`, `1.5D+03`, `1.5+3` and `-2.-4`."""
    text = text.strip().upper().replace("D", "E")
    if not text:
        return 0.0
    for sign in "+-":
        at = text.rfind(sign)
        if at > 0 and text[at - 1] != "E":
            text = text[:at] + "E" + text[at:]
    return float(text)


def fields(line):
    """Of a card in free, small or large fields; the first is its name."""
    line = line.rstrip("\n").split("$")[0]
    if "," in line:
        return [part.strip() for part in line.split(",")]
    wide = 16 if "*" in line[:8] else 8
    return [line[:8].strip()] + [line[at : at + wide].strip() for at in range(8, min(len(line), 72), wide)]


def cards(path):
    """Cards with their continuations."""
    card = None
    with open(path, errors="replace") as lines:
        for line in lines:
            if not line.strip() or line.lstrip().startswith("$"):
                continue
            own = fields(line)
            if own[0] in ("*", "+", "") or line[0] in "*+ ":
                if card:
                    card += own[1:] if "," in line else own[1:]
            else:
                if card:
                    yield card
                card = own
    if card:
        yield card


def grids(path):
    places = {}
    for card in cards(path):
        if card[0].rstrip("*").upper() != "GRID":
            continue
        card = card + [""] * 8
        if card[2] not in ("", "0") or card[6] not in ("", "0"):
            sys.exit(f"{path}: grid {card[1]} is in coordinate system {card[2] or 0}, its displacements in {card[6] or 0}: only basic ones are read")
        places[int(card[1])] = [number(x) for x in card[3:6]]
    return places


def dmig(path):
    """Matrices by name: (grid, direction, grid, direction) -> value, as given."""
    found = {}
    for card in cards(path):
        if card[0].rstrip("*").upper() != "DMIG":
            continue
        name, rest = card[1].upper(), card[2:]
        if rest and rest[0] == "0":
            form = rest[1] if len(rest) > 1 else "6"
            if form not in ("6", "1"):
                sys.exit(f"{path}: matrix {name} has form {form}: symmetric (6) or square (1) ones are read")
            found.setdefault(name, {})
            continue
        column = (int(rest[0]), int(rest[1] or 0))
        terms = [part for part in rest[2:] if part != ""]
        for at in range(0, len(terms) - 2, 3):
            row = (int(terms[at]), int(terms[at + 1]))
            matrix = found.setdefault(name, {})
            matrix[row + column] = matrix.get(row + column, 0.0) + number(terms[at + 2])
    return found


def chosen(found, name, letter, path):
    names = [name.upper()] if name else [one for one in sorted(found) if one.startswith(letter)]
    if len(names) != 1 or names[0] not in found:
        sys.exit(f"{path}: which of the matrices {', '.join(sorted(found))} is it? say so with --stiffness and --mass")
    return found[names[0]]


def from_op4(path, numbers, wanted):
    from pyNastran.op4.op4 import read_op4

    found = {name.upper(): (m.data if hasattr(m, "data") else m[1]) for name, m in read_op4(path).items()}
    rows = [(grid, direction) for grid in numbers for direction in range(1, 7)]
    out = []
    for name, letter in wanted:
        names = [name.upper()] if name else [one for one in sorted(found) if one.startswith(letter)]
        if len(names) != 1 or names[0] not in found:
            sys.exit(f"{path}: which of the matrices {', '.join(sorted(found))} is it?")
        matrix = found[names[0]]
        matrix = matrix.toarray() if hasattr(matrix, "toarray") else np.asarray(matrix)
        if matrix.shape != (len(rows), len(rows)):
            sys.exit(f"{path}: {names[0]} has {matrix.shape[0]} rows, the grids have {len(rows)} freedoms")
        out.append({rows[i] + rows[j]: matrix[i, j] for i, j in zip(*np.nonzero(matrix))})
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bulk", help="bulk data with the GRID cards")
    parser.add_argument("matrices", help="punch file")
    parser.add_argument("out")
    parser.add_argument("--interface", action="append", required=True, metavar="NAME=GRID[+GRID...]")
    parser.add_argument("--stiffness")
    parser.add_argument("--mass")
    parser.add_argument("--op4", action="store_true")
    parser.add_argument("--millimetres", action="store_true")
    a = parser.parse_args()
    places = grids(a.bulk)
    if a.op4:
        k, m = from_op4(a.matrices, sorted(places), [(a.stiffness, "K"), (a.mass, "M")])
    else:
        found = dmig(a.matrices)
        k, m = chosen(found, a.stiffness, "K", a.matrices), chosen(found, a.mass, "M", a.matrices)
    freedoms = sorted({freedom for entry in (*k, *m) for freedom in (entry[:2], entry[2:])})
    numbers = sorted({grid for grid, _ in freedoms})
    if missing := [grid for grid in numbers if grid not in places]:
        sys.exit(f"{a.matrices} has grid {missing[0]}, which {a.bulk} does not have")
    # Freedoms of a grid without any stiffness or mass are not there.
    index, row = {grid: i for i, grid in enumerate(numbers)}, {freedom: i for i, freedom in enumerate(freedoms)}
    length, mass, stiffness = (1e-3, 1e3, 1e3) if a.millimetres else (1.0, 1.0, 1.0)

    def turned(direction):
        # Entries of turns have another power of the length.
        return length if direction > 3 else 1.0

    def triple(matrix, factor):
        rows = [row[e[:2]] for e in matrix]
        columns = [row[e[2:]] for e in matrix]
        return rows, columns, [factor * x * turned(e[1]) * turned(e[3]) for e, x in matrix.items()]

    nodes = length * np.array([places[grid] for grid in numbers])
    interfaces = []
    for one in a.interface:
        name, _, own = one.partition("=")
        own = [int(grid) for grid in own.split("+")]
        if unknown := [grid for grid in own if grid not in index]:
            sys.exit(f"interface `{name}`: grid {unknown[0]} has no rows in the matrices")
        own = [index[grid] for grid in own]
        interfaces.append((name, nodes[own].mean(axis=0), own))
    dofs = [(index[grid], direction - 1) for grid, direction in freedoms]
    save(a.out, nodes, dofs, triple(m, mass), triple(k, stiffness), interfaces)
    print(f"{a.out}: {len(nodes)} nodes, {len(dofs)} freedoms, interfaces " + ", ".join(f"{n} ({len(o)} nodes)" for n, _, o in interfaces))


if __name__ == "__main__":
    main()
