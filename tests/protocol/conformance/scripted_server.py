"""A server taken apart, for check_client.py: it answers what a client asks as a plausible server would, unless a check tells it to do
something else, and keeps everything the client says. What a rule demands of every datagram of a client is checked always."""
import socket
import time
from typing import NamedTuple

from google.protobuf.message import DecodeError

from peer import HEADER, MAGIC, MAJOR, PLAIN, expect, header
from schema import answer, stream

POLL_S = 0.001
REPEAT_S = 0.005
KEEP_ALIVE_S = 0.05


class Said(NamedTuple):
    """A datagram of the client."""

    at: float
    session: int
    counter: int
    packet: stream.Packet


def scene_info(scene_id=1, size=0):
    """The least a client may expect; `size` makes it longer."""
    scene = {"name": "checked", "description": "x" * size, "tools": [{"name": "finger", "parts": [{"name": "tip"}]}]}
    return stream.Item(scene_info=answer.SceneInfo(scene_id=scene_id, scene=scene, hash=bytes(32), rate_hz=1000, clock=1, server_version="script"))


class ScriptedServer:
    """Serves one client, which may begin anew: `session` is the newest it opened."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(POLL_S)
        self.address = "127.0.0.1:%d" % self.socket.getsockname()[1]
        self.said = []
        self.boot_id = 0x1234
        self.opened = []  # session numbers in order
        self.session = 0
        self.answering = True  # acknowledge and answer
        self.forgotten = set()  # sessions that are not served any more
        self.begin(0, None)

    def begin(self, session, source):
        self.session, self.source = session, source
        self.counter, self.applied, self.acked, self.sent_at = 0, 0, 0, 0.0
        self.left = 0
        self.items = []
        self.received = []  # (id, Item) of the client
        self.counters = set()
        self.repeat = True

    # Sending.

    def put(self, *items):
        """Queues Items; returns the id of the last."""
        self.items.extend(items)
        return len(self.items)

    def send(self, counter=None, packet=None, **fields):
        """The next Packet, or the one given, or one with some fields different."""
        if packet is None:
            found, room = [], 1050
            for each in self.items[self.acked:self.acked + 16]:
                room -= each.ByteSize() + 3
                if room < 0:
                    break
                found.append(each)
            packet = stream.Packet(ack=self.applied, first=self.acked + 1, items=found, boot_id=self.boot_id)
            self.left = max(self.left, self.acked + len(found))
            for name in ("ack", "first", "boot_id"):
                if name in fields:
                    setattr(packet, name, fields.pop(name))
            packet.MergeFrom(stream.Packet(**fields))
        if counter is None:
            counter, self.counter = self.counter, self.counter + 1
        self.raw(header(self.session, counter) + packet.SerializeToString())
        self.sent_at = time.monotonic()

    def raw(self, data):
        self.socket.sendto(data, self.source)

    # Hearing.

    def hear(self):
        """The next datagram of the client, its form checked, or None."""
        try:
            data, source = self.socket.recvfrom(4096)
        except (socket.timeout, BlockingIOError, ConnectionRefusedError):
            return None, None
        expect(16 <= len(data) <= 1200, f"a datagram of {len(data)} bytes")
        magic, major, kind, reserved, session, counter = HEADER.unpack_from(data)
        expect((magic, major, kind, reserved) == (MAGIC, MAJOR, PLAIN, 0) and session, f"header {data[:8].hex()}")
        try:
            packet = stream.Packet.FromString(data[16:])
        except DecodeError:
            expect(False, "a body that is not a Packet")
        expect(packet.first >= 1, "a Packet without first")
        expect(not packet.HasField("state") and not packet.HasField("reset"), "a client sends no State and no Reset")
        said = Said(time.monotonic(), session, counter, packet)
        self.said.append(said)
        return said, source

    def serve(self, seconds, until=None):
        """Hears and answers for so long, or until the condition holds; returns whether it held."""
        end = time.monotonic() + seconds
        while until is None or not until():
            if time.monotonic() >= end:
                return until is None
            said, source = self.hear()
            if said is not None:
                self.take(said, source)
            waiting = self.left < len(self.items) or self.acked < len(self.items)
            if self.session and self.repeat and time.monotonic() - self.sent_at > (REPEAT_S if waiting else KEEP_ALIVE_S):
                self.send()
        return True

    def take(self, said, source):
        if said.session in self.forgotten:
            return
        if said.session != self.session:
            expect(said.packet.first == 1 and said.packet.ack == 0, "a new session whose first Packet has not first = 1 and ack = 0")
            expect(said.counter == 0 or not self.answering, f"a new session whose first counter is {said.counter}")
            self.begin(said.session, source)
            self.opened.append(said.session)
            self.put(scene_info(), stream.Item(lease_info={"ttl_ms": 2000}), stream.Item(record_info={"state": 1}))
        expect(said.counter not in self.counters, f"counter {said.counter} was used twice")
        self.counters.add(said.counter)
        packet = said.packet
        expect(packet.ack <= self.left, f"ack {packet.ack} of an Item that was never sent ({self.left})")
        expect(len(packet.items) <= 16, f"{len(packet.items)} Items in a Packet")
        self.acked = max(self.acked, packet.ack)
        fresh = False
        for item_id, item in enumerate(packet.items, packet.first):
            expect(item.ByteSize() <= 1000, f"Item {item_id} has {item.ByteSize()} bytes")
            expect(item_id <= self.applied + 1 or not self.answering, f"Item {item_id} came after {self.applied}")
            if item_id == self.applied + 1 and self.answering:
                expect(not self.received or not self.received[-1][1].HasField("bye"), "an Item after Bye")
                self.applied, fresh = item_id, True
                self.received.append((item_id, item))
                self.answer(item_id, item)
        if fresh:
            self.send()

    def answer(self, item_id, item):
        kind = item.WhichOneof("body")
        if kind in ("bye", "chunk", "pose_batch"):
            return
        payloads = {"acquire": {"lease": {"fence": 1, "yours": True, "ttl_ms": 2000}}, "get_parameters": {"parameters": {}},
                    "list_scenes": {"listing": {}}, "list_gestures": {"listing": {}}, "list_recordings": {"listing": {}},
                    "get_device_info": {"devices": {}}, "run": {"run": {"state_hash": bytes(32)}}}
        self.put(stream.Item(result=answer.Result(item_id=item_id, code=answer.RESULT_CODE_OK, **payloads.get(kind, {}))))

    # What checks ask.

    def open(self, seconds=10):
        """Waits until the client has opened a session and acknowledged the first three Items."""
        expect(self.serve(seconds, lambda: self.session), f"no datagram from the client in {seconds} s")
        expect(self.serve(3, lambda: self.acked >= 3), "SceneInfo, LeaseInfo and RecordInfo were not acknowledged in 3 s")
        return self

    def acknowledged(self, number, seconds=1.0):
        return self.serve(seconds, lambda: self.acked >= number)

    def hush(self):
        """From here on only what the check sends leaves: requests are heard, but neither acknowledged nor answered."""
        self.answering = False
        expect(self.serve(1.0, lambda: self.acked == len(self.items)), "Items were not acknowledged in 1 s")
        self.repeat = False
        return self

    def bye(self):
        """The reason of the client's Bye, wherever it is, or None."""
        return next((item.bye.reason for said in reversed(self.said) if said.session == self.session for item in said.packet.items
                     if item.HasField("bye")), None)

    def of_session(self, begin=0):
        """What the client said in the newest session, from the begin-th datagram of all."""
        return [said for said in self.said[begin:] if said.session == self.session]
