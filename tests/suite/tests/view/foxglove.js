// Reads a log through the client and the decoders of Foxglove, and prints them as JSON:
// channels, the ranges of each scan by its time in nanoseconds, counts, and the refusals.
//
//   NODE_PATH=node_modules node foxglove.js ADDRESS END_NS
"use strict";
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const WebSocket = require("ws");

const [address, end] = [process.argv[2], BigInt(process.argv[3])];
const socket = new WebSocket(address, ["foxglove.sdk.v1"]);
const client = new FoxgloveClient({ ws: socket });
const [readers, found] = [new Map(), { scans: {}, counts: {}, status: [] }];
client.on("error", (error) => { throw error; });
client.on("serverInfo", (info) => { found.info = info; });
client.on("status", ({ message }) => found.status.push(message));
client.on("advertise", (channels) => {
  for (const { id, topic, schema, schemaName } of channels) {
    const reader = new MessageReader(parse(schema, { ros2: true }));
    readers.set(client.subscribe(id), { topic, schemaName, reader });
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const { topic, reader } = readers.get(subscriptionId);
  const message = reader.readMessage(data);
  found.counts[topic] = (found.counts[topic] ?? 0) + 1;
  if (topic === "/scan") {
    found.scans[timestamp] = Array.from(message.ranges, (range) => (range === Infinity ? null : range));
  }
});
client.on("time", ({ timestamp }) => {
  if (timestamp < end) return;
  // The messages of the last tick follow its time.
  setTimeout(() => {
    console.log(JSON.stringify({ ...found, subprotocol: socket.protocol }));
    process.exit(0);
  }, 300);
});
