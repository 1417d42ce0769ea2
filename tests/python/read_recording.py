"""Reads a recording with the official Python packages and prints what it finds as JSON; numbers as their bits."""

import json
import struct
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def bits(value):
    return str(struct.unpack("<Q", struct.pack("<d", value))[0])


def main(path):
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        attachments = {record.name: record.data.decode() for record in reader.iter_attachments()}
        samples, units, entities = {}, {}, []
        for _, channel, message, decoded in reader.iter_decoded_messages():
            if channel.topic == "/scene":
                entities = [entity.id for entity in decoded.entities]
                continue
            sample = samples.setdefault(message.log_time, {"log_time": message.log_time})
            if channel.topic == "/hinges":
                units = dict(channel.metadata)
                sample["time"] = bits(decoded.time)
                sample["upper_angle"] = bits(decoded.positions.upper_angle)
                sample["box_z_rate"] = bits(decoded.velocities.box_z)
                sample["lower_acceleration"] = bits(decoded.accelerations.lower_rate)
            elif channel.topic == "/energy":
                sample["potential"] = bits(decoded.potential)
            elif channel.topic == "/reactions":
                sample["rod_force_z"] = bits(decoded.rod_0.force.z)
            elif channel.topic == "/tf":
                box = next(t for t in decoded.transforms if t.child_frame_id == "box")
                sample["box_height"] = bits(box.translation.z)
                sample["parents"] = sorted({t.parent_frame_id for t in decoded.transforms})
                stamp = box.timestamp.seconds * 10**9 + box.timestamp.nanos
                assert stamp == message.log_time, (stamp, message.log_time)
    json.dump(
        {
            "scenario": attachments["scenario.toml"],
            "statics": metadata["statics"]["json"],
            "run": metadata["run"]["json"],
            "units": units,
            "entities": entities,
            "samples": [samples[time] for time in sorted(samples)],
        },
        sys.stdout,
    )


if __name__ == "__main__":
    main(sys.argv[1])
