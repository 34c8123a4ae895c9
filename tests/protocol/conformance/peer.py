"""A client taken apart, for check_server.py: it sends exactly what a check tells it to, right or wrong, and keeps everything it hears.
Written from PROTOCOL.md alone and shared with no client. Times in s of time.monotonic()."""
import ipaddress
import random
import socket
import struct
import time
from typing import NamedTuple

from google.protobuf.message import DecodeError

import keyed
from schema import code, stream

HEADER = struct.Struct("<BBBBIQ")
MAGIC, MAJOR, PLAIN = 0x48, 1, 5
ACK_EVERY_S = 0.02
REQUEST_TIMEOUT_S = 5.0
HANDSHAKE_TIMEOUT_S = 5.0
HELLO_EVERY_S = 0.25


class Failed(AssertionError):
    """A rule is broken; the text says how."""


class Skipped(Exception):
    """The check cannot be made with this server; the text says why."""


def expect(condition, text):
    if not condition:
        raise Failed(text)


class Heard(NamedTuple):
    """A datagram of the server."""

    at: float
    session: int
    counter: int
    packet: stream.Packet
    size: int


def header(session, counter, kind=PLAIN, magic=MAGIC, major=MAJOR, reserved=0):
    return HEADER.pack(magic, major, kind, reserved, session, counter)


class Peer:
    """One socket and one session of it. What a rule demands of every datagram of a server is checked in `_take`, always."""

    def __init__(self, address, key=None, role=keyed.CONTROL):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        if key is not None and ipaddress.ip_address(address[0]).is_loopback:
            # Of one address few HELLOs a second are looked at; loopback has many addresses.
            self.socket.bind((f"127.{random.randrange(1, 255)}.{random.randrange(255)}.{random.randrange(1, 255)}", 0))
        self.socket.connect(address)
        self.address = address
        self.keys = None if key is None else keyed.Handshake(key, role)
        self.session = random.randrange(1, 2**32) if key is None else 0
        self.counter = 0
        self.applied = 0  # the server's Items, in order
        self.acked = 0  # ours
        self.sent_items = []
        self.items = []  # (id, Item), blobs put together
        self.heard = []
        self.states = []
        self.results = {}
        self.blob = b""
        self.blobs = 0
        self.boot_id = 0
        self.counters = set()
        self.seen = 0
        self.newest = (0, 0)
        self.reports_states = True  # False: as if States were lost
        self.sent_at = 0.0
        self.ahead = 0  # what it announces of Packets ahead, until it hears the server
        self.early = []  # ids of Items that came early, and were skipped
        self.lossy = None  # a random.Random: drops and doubles what is sent and heard

    def close(self):
        self.socket.close()

    # Sending.

    def send_raw(self, data):
        try:
            self.socket.send(data)
        except ConnectionRefusedError:
            pass

    def send_body(self, counter, body):
        """A datagram of this session, with any body."""
        if self.keys is not None and self.keys.sending is None:
            self.shake_hands()
        self.send_raw(self.datagram(counter, body))

    def datagram(self, counter, body):
        """A datagram of this session, PLAIN or DATA."""
        return header(self.session, counter) + body if self.keys is None else self.keys.seal(counter, body)

    def answer_to(self, data, kinds, seconds):
        """Sends and waits for a datagram of one of these kinds; None if none comes."""
        self.send_raw(data)
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            answer = self.hear_raw(end - time.monotonic())
            if answer is not None and answer[2] in kinds:
                return answer
        return None

    def shake_hands(self):
        """HELLO, RETRY, HELLO, WELCOME; the last HELLO stays in `hello`."""
        end = time.monotonic() + HANDSHAKE_TIMEOUT_S
        self.hello = self.keys.hello()
        while time.monotonic() < end:
            answer = self.answer_to(self.hello, (keyed.RETRY, keyed.WELCOME), HELLO_EVERY_S)
            if answer is not None and answer[2] == keyed.RETRY:
                self.hello = self.keys.hello(answer[16:])
            elif answer is not None:
                self.keys.welcome(answer)
                self.session = self.keys.session
                return
        raise Failed(f"no WELCOME in {HANDSHAKE_TIMEOUT_S} s")

    def send(self, counter=None, **fields):
        """A Packet with the right ack, first and Items unless fields say otherwise; the counter grows unless it is given."""
        packet = stream.Packet(ack=self.applied, first=self.acked + 1, seen=self.seen, newest=self.newest[1])
        for name in ("ack", "first"):
            if name in fields:
                setattr(packet, name, fields.pop(name))
        packet.items.extend(fields.pop("items", self._fitting()))
        packet.MergeFrom(stream.Packet(**fields))
        if not self.counters:
            packet.ahead = self.ahead
        if counter is None:
            counter, self.counter = self.counter, self.counter + 1
        if self.keys is not None and self.keys.sending is None:
            self.shake_hands()
        data = self.datagram(counter, packet.SerializeToString())
        copies = 1 if self.lossy is None else self.lossy.choice((0, 0, 1, 1, 1, 2))
        for _ in range(copies):
            self.send_raw(data)
        self.sent_at = time.monotonic()

    def _fitting(self):
        """The oldest of our unacknowledged Items that fit."""
        found, room = [], 1100
        for each in self.sent_items[self.acked:self.acked + 16]:
            room -= each.ByteSize() + 3
            if room < 0:
                break
            found.append(each)
        return found

    def queue(self, item):
        """Takes an Item to be sent; returns its id."""
        self.sent_items.append(item)
        return len(self.sent_items)

    def queue_blob(self, blob, number=1, pieces=900):
        """Takes bytes as Chunks; returns the id of the last."""
        for offset in range(0, len(blob), pieces):
            chunk = stream.Chunk(blob=number, kind=stream.CHUNK_KIND_ITEM, offset=offset, total=len(blob), bytes=blob[offset:offset + pieces])
            self.queue(stream.Item(chunk=chunk))
        return len(self.sent_items)

    # Hearing.

    def hear_raw(self, seconds):
        """The bytes of the next datagram, or None."""
        self.socket.settimeout(max(seconds, 1e-4))
        try:
            return self.socket.recv(4096)
        except (socket.timeout, BlockingIOError, ConnectionRefusedError):
            return None

    def hear(self, seconds):
        """The next datagram, or None. What does not even have a good header, or does not open, is a failure. With keys a RETRY or WELCOME
        that comes late is passed over."""
        data = self.hear_raw(seconds)
        if data is None or (self.keys is not None and data[2] in (keyed.RETRY, keyed.WELCOME)):
            return None
        now = time.monotonic()
        expect(16 <= len(data) <= 1200, f"a datagram of {len(data)} bytes")
        magic, major, kind, reserved, session, counter = HEADER.unpack_from(data)
        wanted = PLAIN if self.keys is None else keyed.DATA
        expect((magic, major, kind, reserved) == (MAGIC, MAJOR, wanted, 0), f"header bytes {data[:4].hex()}")
        try:
            packet = stream.Packet.FromString(data[16:] if self.keys is None else self.keys.open(data))
        except DecodeError as error:
            raise Failed("a body that is not a Packet") from error
        return Heard(now, session, counter, packet, len(data))

    def pump(self, seconds=0.0, until=None, acknowledge=True):
        """Hears, applies and acknowledges for so long, or until the condition holds; returns whether it held."""
        end = time.monotonic() + seconds
        while until is None or not until():
            left = end - time.monotonic()
            if left <= 0:
                return until is None
            fresh = False
            heard = self.hear(min(left, ACK_EVERY_S / 4))
            if heard is not None and heard.session == self.session and not (self.lossy and self.lossy.random() < 0.4):
                fresh = self._take(heard)
            now = time.monotonic()
            waiting = self.acked < len(self.sent_items)
            if acknowledge and (fresh and now - self.sent_at > 0.001 or now - self.sent_at > (ACK_EVERY_S if not waiting else 0.005)):
                self.send()
        return True

    def _take(self, heard):
        """Applies a datagram by the rules; True if it brought something to acknowledge soon."""
        packet = heard.packet
        self.heard.append(heard)
        expect(packet.first >= 1, "a Packet without first")
        expect(packet.boot_id != 0, "a Packet without boot_id")
        if packet.HasField("reset"):
            return False
        expect(self.boot_id in (0, packet.boot_id), "the boot_id changed")
        expect(heard.counter not in self.counters, f"counter {heard.counter} was used twice")
        expect(len(packet.items) <= 16, f"{len(packet.items)} Items in a Packet")
        self.counters.add(heard.counter)
        self.boot_id = packet.boot_id
        expect(packet.ack <= len(self.sent_items), f"ack {packet.ack} of an Item that was never sent")
        self.acked = max(self.acked, packet.ack)
        fresh = False
        for item_id, item in enumerate(packet.items, packet.first):
            expect(item.ByteSize() <= 1000, f"Item {item_id} has {item.ByteSize()} bytes")
            if item_id > self.applied + 1 and self.ahead:
                self.early.append(item_id)
                fresh = True
                continue
            expect(item_id <= self.applied + 1, f"Item {item_id} came after {self.applied}")
            if item_id == self.applied + 1:
                self.applied, fresh = item_id, True
                self._apply(item_id, item)
        if packet.HasField("state"):
            self.seen += self.reports_states
            if self.reports_states:
                self.newest = max(self.newest, (packet.state.scene_id, packet.state.tick))
            self.states.append((heard, packet.state))
            fresh = True
        return fresh

    def _apply(self, item_id, item):
        if item.HasField("chunk"):
            chunk = item.chunk
            self.blobs += chunk.offset == 0
            expect(chunk.blob == self.blobs, f"blob {chunk.blob} where {self.blobs} was due")
            expect(chunk.kind == stream.CHUNK_KIND_ITEM and chunk.offset == len(self.blob), "a Chunk out of place")
            expect(1 <= len(chunk.bytes) <= 900 and chunk.total <= 1 << 22, "a Chunk beyond its limits")
            self.blob += chunk.bytes
            if len(self.blob) < chunk.total:
                return
            expect(len(self.blob) == chunk.total, "a blob longer than its total")
            item, self.blob = stream.Item.FromString(self.blob), b""
            expect(not item.HasField("chunk"), "a Chunk in a Chunk")
        self.items.append((item_id, item))
        if item.HasField("result"):
            expect(item.result.item_id not in self.results, f"a second Result for Item {item.result.item_id}")
            self.results[item.result.item_id] = item.result

    # What most checks begin with.

    def open(self):
        """Opens the session and waits for SceneInfo, LeaseInfo and RecordInfo."""
        self.send()
        expect(self.pump(3.0, lambda: len(self.items) >= 3), f"{len(self.items)} Items in 3 s after the first datagram, not three")
        return self

    def of_kind(self, kind):
        """The Items of a kind, in order."""
        return [getattr(item, kind) for _, item in self.items if item.WhichOneof("body") == kind]

    def result(self, item_id, seconds=REQUEST_TIMEOUT_S):
        """Waits for a Result."""
        expect(self.pump(seconds, lambda: item_id in self.results), f"no Result for Item {item_id} in {seconds} s")
        return self.results[item_id]

    def request(self, item, seconds=REQUEST_TIMEOUT_S):
        """Sends a request and waits for its Result."""
        item_id = self.queue(item)
        self.send()
        return self.result(item_id, seconds)

    def demand(self, item, wanted="OK", seconds=REQUEST_TIMEOUT_S):
        """A request that has to end with that code."""
        result = self.request(item, seconds)
        expect(code(result) == wanted, f"{item.WhichOneof('body')}: {code(result)} {result.path} {result.message}, not {wanted}")
        expect(len(result.message.encode()) <= 400 and len(result.path.encode()) <= 256, "texts of a Result are too long")
        return result

    def lease(self):
        """Whether this session holds the lease, as far as it was told."""
        told = self.of_kind("lease_info")
        return bool(told) and told[-1].yours

    def alive(self):
        """Whether the session is open as far as it was told: no Reset, no Bye either way."""
        if any(each.HasField("bye") for each in self.sent_items) or any(each.packet.HasField("reset") for each in self.heard):
            return False
        return bool(self.items) and not self.of_kind("bye") and self.socket.fileno() >= 0

    def bye(self):
        """Ends the session, so that it does not count any more."""
        bye = self.queue(stream.Item(bye={"reason": "BYE_REASON_DONE"}))
        self.send()
        self.pump(1.0, lambda: self.acked >= bye)
        self.close()

