"""Reads a dataset of `sweep` with DuckDB, polars and pyarrow; prints what they agree on as JSON, numbers as bits."""

import json
import struct
import sys
from pathlib import Path

import duckdb
import polars
import pyarrow.parquet


def bits(values):
    return [None if value is None else str(struct.unpack("<Q", struct.pack("<d", value))[0]) for value in values]


def main(folder):
    parts = str(Path(folder) / "*.parquet")
    polared = polars.read_parquet(parts).sort("case")
    ducked = duckdb.sql(f"select * from '{parts}' order by \"case\"")
    arrow = pyarrow.parquet.read_table(folder).sort_by("case")
    assert polared.columns == ducked.columns == arrow.column_names
    rows = ducked.fetchall()
    found = {}
    for index, name in enumerate(polared.columns):
        column = polared[name].to_list()
        assert column == [row[index] for row in rows], name
        assert column == arrow[name].to_pylist(), name
        found[name] = bits(column) if polared[name].dtype == polars.Float64 else column
    units = {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in arrow.schema}
    # A question as the guide asks it.
    failed = duckdb.sql(f"select count(*) from '{parts}' where not ok").fetchall()[0][0]
    json.dump({"columns": found, "units": units, "failed": failed}, sys.stdout)


main(sys.argv[1])
