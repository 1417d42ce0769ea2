// Reads a recording with the packages that Foxglove and Lichtblick are made of: every message of every channel is decoded
// by its own schema. Prints what it finds as JSON; numbers as their bits, as read_recording.py does.
"use strict";

const { open } = require("node:fs/promises");
const { McapIndexedReader } = require("@mcap/core");
const { FileHandleReadable } = require("@mcap/nodejs");
const { loadDecompressHandlers, protobufFromBinaryDescriptor } = require("@mcap/support");

const view = new DataView(new ArrayBuffer(8));
function bits(value) {
  view.setFloat64(0, value);
  return view.getBigUint64(0).toString();
}

async function main(path) {
  const readable = new FileHandleReadable(await open(path));
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
  const [metadata, attachments, samples] = [{}, {}, new Map()];
  for await (const record of reader.readMetadata()) metadata[record.name] = record.metadata;
  for await (const record of reader.readAttachments()) attachments[record.name] = new TextDecoder().decode(record.data);
  const decoders = new Map();
  for (const [id, schema] of reader.schemasById) {
    decoders.set(id, protobufFromBinaryDescriptor(schema.data).lookupType(schema.name));
  }
  let [units, entities, messages] = [{}, [], 0];
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    if (channel.messageEncoding !== "protobuf") throw new Error(`${channel.topic} is ${channel.messageEncoding}`);
    const type = decoders.get(channel.schemaId);
    // What is absent has the default, as for everybody who draws it.
    const decoded = type.toObject(type.decode(message.data), { defaults: true, longs: Number });
    messages += 1;
    if (channel.topic === "/scene") {
      entities = decoded.entities.map((entity) => entity.id);
      continue;
    }
    const time = message.logTime;
    if (!samples.has(time)) samples.set(time, { log_time: Number(time) });
    const sample = samples.get(time);
    if (channel.topic === "/hinges") {
      units = Object.fromEntries(channel.metadata);
      sample.time = bits(decoded.time);
      sample.upper_angle = bits(decoded.positions.upper_angle);
      sample.box_z_rate = bits(decoded.velocities.box_z);
      sample.lower_acceleration = bits(decoded.accelerations.lower_rate);
    } else if (channel.topic === "/energy") {
      sample.potential = bits(decoded.potential);
    } else if (channel.topic === "/reactions") {
      sample.rod_force_z = bits(decoded.rod_0.force.z);
    } else if (channel.topic === "/tf") {
      const box = decoded.transforms.find((transform) => transform.child_frame_id === "box");
      sample.box_height = bits(box.translation.z);
      sample.parents = [...new Set(decoded.transforms.map((transform) => transform.parent_frame_id))].sort();
      const stamp = BigInt(box.timestamp.seconds) * 1_000_000_000n + BigInt(box.timestamp.nanos);
      if (stamp !== time) throw new Error(`${stamp} is not ${time}`);
    }
  }
  const times = [...samples.keys()].sort((a, b) => (a < b ? -1 : 1));
  const found = {
    scenario: attachments["scenario.toml"],
    statics: metadata.statics.get("json"),
    run: metadata.run.get("json"),
    units,
    entities,
    messages,
    samples: times.map((time) => samples.get(time)),
  };
  process.stdout.write(JSON.stringify(found));
}

main(process.argv[2]);
