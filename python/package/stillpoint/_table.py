"""Columns as CSV."""

import csv


def save(path, names, time, columns) -> None:
    """Writes the time and the columns with their names and units."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["time [s]"] + [f"{name} [{unit}]" for name, unit in names])
        rows.writerows(zip(time.tolist(), *(column.tolist() for column in columns)))
