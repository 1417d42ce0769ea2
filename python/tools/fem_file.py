"""Files of finite elements for modal bodies of stillpoint: what the converters beside this have in common.

A file is an archive of NumPy arrays; docs/guide/modal_bodies.md has the table. All numbers are SI.
"""

import numpy as np


def entries(matrix):
    """Rows, columns and values of the upper triangle of a symmetric matrix (dense)."""
    row, column = np.nonzero(np.triu(matrix))
    return row, column, matrix[row, column]


def save(path, nodes, dofs, mass, stiffness, interfaces, geometric=None, declared=None):
    """Write a file.

    nodes       N x 3, m
    dofs        n x 2: node (from 0) and direction (0..5: x, y, z, about x, y, z) of every row of the matrices
    mass        (row, column, value) or an n x n array; stiffness alike
    interfaces  list of (name, point, nodes); the first is the root, whose point is the origin of the body
    geometric   dict from the number of a unit load to (row, column, value) or an array
    declared    dict with any of total_mass, center, inertia: compared with the matrices when the file is read
    """
    triple = lambda m: m if isinstance(m, tuple) else entries(np.asarray(m))
    arrays = {"nodes": np.asarray(nodes, float), "dofs": np.asarray(dofs, np.int64)}
    for name, matrix in (("mass", mass), ("stiffness", stiffness)):
        row, column, value = triple(matrix)
        arrays[name + "_row"] = np.asarray(row, np.int64)
        arrays[name + "_column"] = np.asarray(column, np.int64)
        arrays[name + "_value"] = np.asarray(value, float)
    arrays["interface_names"] = np.array([name for name, _, _ in interfaces])
    arrays["interface_points"] = np.array([point for _, point, _ in interfaces], float)
    pairs = [(i, node) for i, (_, _, own) in enumerate(interfaces) for node in own]
    arrays["interface_nodes"] = np.array(pairs, np.int64).reshape(-1, 2)
    if geometric:
        parts = {load: triple(matrix) for load, matrix in sorted(geometric.items())}
        arrays["geometric_load"] = np.concatenate([np.full(len(p[2]), load, np.int64) for load, p in parts.items()])
        for i, name in enumerate(("row", "column", "value")):
            arrays["geometric_" + name] = np.concatenate([np.asarray(p[i]) for p in parts.values()])
    for name, value in (declared or {}).items():
        arrays[name] = np.atleast_1d(np.asarray(value, float))
    # The same bytes every time: the members of the archive carry no date.
    import io
    import zipfile

    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            stream = io.BytesIO()
            np.lib.format.write_array(stream, np.ascontiguousarray(array), version=(1, 0))
            archive.writestr(zipfile.ZipInfo(name + ".npy", (1980, 1, 1, 0, 0, 0)), stream.getvalue(), zipfile.ZIP_DEFLATED)
