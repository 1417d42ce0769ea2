"""Reads a recording and its exported tables with other people's programs; prints what it finds as JSON, numbers as bits."""

import json
import struct
import sys
from pathlib import Path

import polars
from mcap_protobuf.reader import read_protobuf_messages


def bits(values):
    return [str(struct.unpack("<Q", struct.pack("<d", value))[0]) for value in values]


def main(folder):
    folder = Path(folder)
    # As the README has it.
    messages = read_protobuf_messages(str(folder / "a.mcap"), topics=["/hinges"])
    rows = [{"time": m.proto_msg.time, "angle": m.proto_msg.positions.lower_angle} for m in messages]
    recording = polars.DataFrame(rows)

    csv = polars.read_csv(folder / "csv" / "hinges.csv")
    found = {
        "recording": bits(recording["angle"]),
        "time": bits(recording["time"]),
        "csv": {name: bits(csv[name]) for name in csv.columns},
        "csv_types": sorted({str(dtype) for dtype in csv.dtypes}),
    }
    if (folder / "parquet").exists():
        import pyarrow.parquet

        table = pyarrow.parquet.read_table(folder / "parquet" / "hinges.parquet")
        polared = polars.read_parquet(folder / "parquet" / "hinges.parquet")
        assert polared.columns == table.column_names
        for name in polared.columns:
            assert bits(polared[name]) == bits(table[name].to_pylist())
        found["parquet"] = {name: bits(polared[name]) for name in polared.columns}
        found["units"] = {field.name: field.metadata[b"unit"].decode() for field in table.schema}
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1])
