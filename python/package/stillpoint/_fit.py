"""Fits of a scene to measurements."""

import csv
import json
import os
from html import escape

import numpy as np


def columns(data):
    """Headings and columns of a CSV file, a mapping, or a data frame; `nan` where nothing was measured."""
    if isinstance(data, (str, os.PathLike)):
        with open(data, newline="", encoding="utf-8") as file:
            rows = list(csv.reader(line for line in file if not line.startswith("#")))
        if not rows:
            raise ValueError(f"`{os.fspath(data)}` is empty")
        headings = rows[0]
        for number, row in enumerate(rows[1:], 1):
            if len(row) != len(headings):
                raise ValueError(f"`{os.fspath(data)}`: row {number} has {len(row)} cells, the headings are {len(headings)}")
        cells = [[row[at].strip() for row in rows[1:]] for at in range(len(headings))]
        return [(name.strip(), np.array([float(cell) if cell else np.nan for cell in column])) for name, column in zip(headings, cells)]
    names = list(data.columns) if hasattr(data, "columns") else list(data)
    return [(str(name), _measured(data[name])) for name in names]


def _measured(column):
    """The numbers of a column; of what is masked `nan`."""
    if np.ma.is_masked(column):
        column = np.ma.filled(column.astype(float), np.nan)
    return np.asarray(column, dtype=float).reshape(-1)


class Fit:
    """Parameters that bring a scene closest to measurements, and how well these determine them."""

    def __init__(self, scene, text):
        self._text = text
        told = json.loads(text)
        parameters = told["parameters"]
        number = lambda x: np.nan if x is None else x
        matrix = lambda rows: np.array([[number(x) for x in row] for row in rows], dtype=float)
        self.values = {one["address"]: one["value"] for one in parameters}
        self.errors = {one["address"]: number(one["standard_error"]) for one in parameters}
        self.intervals = {one["address"]: one["interval"] and tuple(one["interval"]) for one in parameters}
        self.covariance, self.correlations = matrix(told["covariance"]), matrix(told["correlations"])
        self.residuals = {one["name"]: np.array([number(x) for x in one["residuals"]]) for one in told["columns"]}
        self.rms = {one["name"]: one["rms"] for one in told["columns"]}
        self.converged, self.notes = told["converged"], told["notes"]
        self._base = scene

    @property
    def scene(self):
        """The scene with the fitted values."""
        return self._base.with_set(self.values)

    def as_dict(self):
        """All that `study --fit --json` prints."""
        return json.loads(self._text)

    def _lines(self):
        for one in json.loads(self._text)["parameters"]:
            error = one["standard_error"]
            spread = "runs off" if one["runs_off"] else "at its bound" if one["held"] else "not determined" if error is None else f"± {error:.2g}"
            yield one["address"], f"{one['value']:.6g}", spread, one["unit"]

    def __repr__(self):
        shown = ", ".join(" ".join(line).strip() for line in self._lines())
        return f"<Fit: {shown}>" if self.converged else f"<Fit, not converged: {shown}>"

    def _repr_html_(self):
        rows = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in line) + "</tr>" for line in self._lines())
        return f"<b>Fit</b><table>{rows}</table>"
