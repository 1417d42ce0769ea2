"""Columns by name: as CSV, and for programs that speak Arrow."""

import csv

import numpy as np

from ._stillpoint import arrow_stream


class Table(dict):
    """Columns by name, a row a case; `polars.DataFrame(table)` takes it as it is."""

    def __arrow_c_stream__(self, requested_schema=None):
        return arrow_stream(list(self.items()))


class Sensitivities(dict):
    """Derivatives by address, and `notes`: why there is none, and as long as what they hold."""

    def __init__(self, derivatives=(), notes=()):
        super().__init__(derivatives)
        self.notes = list(notes)

    def __repr__(self) -> str:
        notes = f", notes={self.notes!r}" if self.notes else ""
        return f"Sensitivities({dict.__repr__(self)}{notes})"


class Modes:
    """Small motions, slowest first, as a list has them; `polars.DataFrame(modes)` is their table.

    Not a `list`: polars takes lists for a column of objects before it asks for a table.
    """

    def __init__(self, modes=()):
        self._modes = list(modes)

    def __len__(self) -> int:
        return len(self._modes)

    def __getitem__(self, which):
        found = self._modes[which]
        return Modes(found) if isinstance(which, slice) else found

    def __iter__(self):
        return iter(self._modes)

    def __eq__(self, other) -> bool:
        return self._modes == (other._modes if isinstance(other, Modes) else other)

    def __repr__(self) -> str:
        return repr(self._modes)

    def __arrow_c_stream__(self, requested_schema=None):
        names = ("frequency", "damping_ratio", "decay_rate")
        return arrow_stream([(name, np.array([getattr(mode, name) for mode in self], dtype=float)) for name in names])


def save(path, names, time, columns) -> None:
    """Writes the time and the columns with their names and units."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["time [s]"] + [f"{name} [{unit}]" for name, unit in names])
        rows.writerows(zip(time.tolist(), *(column.tolist() for column in columns)))
