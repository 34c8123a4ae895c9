// Reads a MCAP file with @mcap/core, the reader of the format's own authors, and says what it found:
// one line per topic with the count of its messages, their bytes and the CRC-32 of all of them in
// the order read.
//   usage: node read_with_core.mjs indexed|stream FILE
import { readFileSync } from "node:fs";
import { crc32Init, crc32Update, crc32Final } from "@foxglove/crc";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";

const [mode, path] = process.argv.slice(2);
const bytes = new Uint8Array(readFileSync(path));
const channels = new Map();
const schemas = new Map();
const found = new Map();

function take(topic, schema, message) {
  const row = found.get(topic) ?? { count: 0, bytes: 0, crc: crc32Init(), schema };
  row.count += 1;
  row.bytes += message.data.byteLength;
  row.crc = crc32Update(row.crc, message.data);
  found.set(topic, row);
}

if (mode === "indexed") {
  const readable = {
    size: async () => BigInt(bytes.byteLength),
    read: async (offset, size) => bytes.slice(Number(offset), Number(offset + size)),
  };
  const reader = await McapIndexedReader.Initialize({ readable });
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    take(channel.topic, reader.schemasById.get(channel.schemaId).name, message);
  }
  const counted = [...found.values()].reduce((sum, row) => sum + row.count, 0);
  if (reader.statistics.messageCount !== BigInt(counted)) throw new Error("wrong statistics");
} else {
  const reader = new McapStreamReader({ validateCrcs: true });
  reader.append(bytes);
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema") schemas.set(record.id, record.name);
    if (record.type === "Channel") channels.set(record.id, record);
    if (record.type === "Message") {
      const channel = channels.get(record.channelId);
      take(channel.topic, schemas.get(channel.schemaId), record);
    }
  }
}
for (const topic of [...found.keys()].sort()) {
  const row = found.get(topic);
  console.log(`${topic} ${row.schema} ${row.count} ${row.bytes} ${crc32Final(row.crc) >>> 0}`);
}
