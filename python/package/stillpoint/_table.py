"""Columns by name: as CSV, and for programs that speak Arrow."""

import csv

import numpy as np

from ._stillpoint import arrow_stream


class Table(dict):
    """Columns by name, a row a case; `polars.DataFrame(table)` takes it as it is."""

    def __arrow_c_stream__(self, requested_schema=None):
        return arrow_stream(list(self.items()))


class Modes(list):
    """Small motions, slowest first; `polars.DataFrame(modes)` is their table."""

    def __arrow_c_stream__(self, requested_schema=None):
        names = ("frequency", "damping_ratio", "decay_rate")
        return arrow_stream([(name, np.array([getattr(mode, name) for mode in self], dtype=float)) for name in names])


def save(path, names, time, columns) -> None:
    """Writes the time and the columns with their names and units."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["time [s]"] + [f"{name} [{unit}]" for name, unit in names])
        rows.writerows(zip(time.tolist(), *(column.tolist() for column in columns)))
