#!/usr/bin/python3
"""A reader of recordings from the format's specification alone: walks a MCAP file, checks its CRCs and its summary, and decodes the
ticks with nothing but the schema in the file. Says what it found: one line per topic with count, bytes and CRC-32 of all messages in
the order of the file, then the numbers of the ticks and the last wrench.

usage: read_recording.py FILE
"""
import struct
import sys
import zlib

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

MAGIC = b"\x89MCAP0\r\n"


class Cursor:
    def __init__(self, data):
        self.data, self.place = data, 0

    def number(self, code):
        size = struct.calcsize("<" + code)
        value, = struct.unpack_from("<" + code, self.data, self.place)
        self.place += size
        return value

    def bytes(self, count):
        taken = self.data[self.place:self.place + count]
        if len(taken) != count:
            raise ValueError("bytes are missing")
        self.place += count
        return taken

    def text(self):
        return self.bytes(self.number("I"))


def records(data, start=0):
    cursor = Cursor(data)
    cursor.place = start
    while cursor.place < len(data):
        place = cursor.place
        opcode = cursor.number("B")
        yield place, opcode, cursor.bytes(cursor.number("Q"))


def message_class(name, file_descriptor_set):
    pool = descriptor_pool.DescriptorPool()
    files = descriptor_pb2.FileDescriptorSet.FromString(file_descriptor_set)
    for file in files.file:
        pool.Add(file)
    descriptor = pool.FindMessageTypeByName(name)
    if hasattr(message_factory, "GetMessageClass"):
        return message_factory.GetMessageClass(descriptor)
    return message_factory.MessageFactory(pool).GetPrototype(descriptor)


class Recording:
    def __init__(self):
        self.schemas, self.channels, self.messages = {}, {}, []

    def take(self, opcode, content):
        cursor = Cursor(content)
        if opcode == 0x03:
            number = cursor.number("H")
            name, encoding, data = cursor.text(), cursor.text(), cursor.text()
            assert encoding == b"protobuf", encoding
            self.schemas[number] = (name.decode(), data)
        elif opcode == 0x04:
            number, schema = cursor.number("H"), cursor.number("H")
            self.channels[number] = (cursor.text().decode(), schema)
        elif opcode == 0x05:
            channel, _, log_time, _ = (cursor.number(code) for code in "HIQQ")
            self.messages.append((channel, log_time, content[cursor.place:]))
        elif opcode == 0x06:
            start, end, size, crc = (cursor.number(code) for code in "QQQI")
            assert cursor.text() == b""
            inner = cursor.bytes(cursor.number("Q"))
            assert len(inner) == size and zlib.crc32(inner) == crc
            before = len(self.messages)
            for _, inner_opcode, inner_content in records(inner):
                self.take(inner_opcode, inner_content)
            times = [log_time for _, log_time, _ in self.messages[before:]]
            assert min(times) == start and max(times) == end


def check_summary(data, recording):
    """Footer, its CRC, and that every chunk index points at its chunk and its indexes."""
    footer = Cursor(data[-8 - 20:-8])
    start, offsets, crc = footer.number("Q"), footer.number("Q"), footer.number("I")
    assert zlib.crc32(data[start:-8 - 4]) == crc, "CRC of the summary"
    chunks = 0
    for place, opcode, content in records(data[:-8 - 29], start):
        if opcode == 0x08:
            cursor = Cursor(content)
            _, _, chunk, length = (cursor.number("Q") for _ in range(4))
            assert data[chunk] == 0x06 and struct.unpack_from("<Q", data, chunk + 1)[0] + 9 == length
            index = Cursor(cursor.text())
            while index.place < len(index.data):
                channel, offset = index.number("H"), index.number("Q")
                assert data[offset] == 0x07 and struct.unpack_from("<H", data, offset + 9)[0] == channel
            chunks += 1
        elif opcode == 0x0B:
            cursor = Cursor(content)
            assert cursor.number("Q") == len(recording.messages), "count in the statistics"
        elif opcode == 0x0E:
            group, group_start, group_length = content[0], *struct.unpack_from("<QQ", content, 1)
            assert place >= offsets and data[group_start] == group and group_start + group_length <= offsets
    assert chunks > 0


def main():
    with open(sys.argv[1], "rb") as file:
        data = file.read()
    assert data[:8] == MAGIC and data[-8:] == MAGIC, "magic"
    recording = Recording()
    for place, opcode, content in records(data, 8):
        if opcode == 0x0F:
            assert zlib.crc32(data[:place]) == struct.unpack("<I", content)[0], "CRC of the data"
            break
        recording.take(opcode, content)
    check_summary(data, recording)
    rows = {}
    for channel, _, content in recording.messages:
        topic, schema = recording.channels[channel]
        count, size, crc = rows.get(topic, (0, 0, 0))
        rows[topic] = (count + 1, size + len(content), zlib.crc32(content, crc))
    for topic in sorted(rows):
        schema = next(recording.schemas[s][0] for t, s in recording.channels.values() if t == topic)
        print(topic, schema, *rows[topic])
    tick_channel, schema = next((c, s) for c, (t, s) in recording.channels.items() if t == "/hapticd/tick")
    tick_class = message_class(*recording.schemas[schema])
    ticks = [tick_class.FromString(content) for channel, _, content in recording.messages if channel == tick_channel]
    print("ticks", ticks[0].tick, ticks[-1].tick)
    print("wrench", *(struct.pack(">d", x).hex() for x in ticks[-1].outputs[0].wrench_h_w.f_n))


if __name__ == "__main__":
    main()
