#!/usr/bin/python3
"""A model of a server, for testing the checkers and clients where no daemon runs: the protocol of PROTOCOL.md over a toy world. It is no
second daemon: one thread, no force, no speed. usage: model_server.py [HOST:PORT] [--virtual]"""
import collections
import random
import socket
import sys
import threading
import time

from google.protobuf.message import DecodeError

import model_requests
import model_world
from model_requests import INVALID, NEEDS_LEASE, NOT_OWNER, OK, UNSUPPORTED
from peer import HEADER, header
from schema import answer, control, stream

SESSIONS = 32
LOOKERS = 24
SENT_BY_SERVERS = ("tone", "contact", "string_radius", "string_sounding", "fault", "result", "lease_info", "record_info", "scene_info")
AHEAD = 32
LATE_S = 0.01
REPEATS_S = (0.001, 0.003, 0.007, 0.015, 0.031)


class Broken(Exception):
    """The client broke the protocol."""


class Remote:
    """One session."""

    def __init__(self, source, number, now):
        self.source, self.number, self.heard = source, number, now
        self.counter = self.applied = self.acked = self.left = self.repeats = 0
        self.items, self.counters, self.requests = [], set(), collections.deque()
        self.sent = self.first_left = now - 1
        self.blob, self.blobs, self.clock, self.subscription = b"", 0, None, None
        self.newest, self.state, self.state_sent, self.fresh, self.bye_at, self.total = 0, None, now, False, None, 0
        self.unseen = collections.deque()  # ticks of the States beyond newest
        self.asked = False
        self.ahead, self.next, self.packets, self.moved = 0, 0, [], now  # Packets that it takes ahead; the id after which the next one begins;
        # last ids of those under way; when that was acknowledged last, or sent back


class ModelServer:
    """Binds on construction; `start` runs it in a thread, `step` does one poll."""

    def __init__(self, virtual=True, port=0, host="127.0.0.1"):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((host, port))
        self.socket.settimeout(0.0005)
        self.address = self.socket.getsockname()
        self.world = model_world.World(virtual)
        self.boot_id = random.randrange(1, 2**32)
        self.remotes, self.resets, self.files = {}, {}, {}
        self.fence, self.grants, self.owner, self.holder, self.taken_from, self.reason = 0, 0, None, "", "", ""
        self.running = None  # [remote, item id, steps left, done, held]
        self.stopping = self.lease_news = False
        self.thread = threading.Thread(target=self.loop, daemon=True)

    def start(self):
        self.thread.start()
        return self

    def stop(self):
        self.stopping = True
        self.thread.join()
        self.socket.close()

    def loop(self):
        while not self.stopping:
            self.step()

    def step(self):
        for _ in range(64):
            try:
                data, source = self.socket.recvfrom(2048)
            except (socket.timeout, BlockingIOError):
                break
            self.receive(data, source, time.monotonic())
        now = time.monotonic()
        self.run_time()
        for remote in list(self.remotes.values()):
            self.serve(remote, now)
        if self.lease_news:
            self.tell_lease()

    # Datagrams in.

    def receive(self, data, source, now):
        if not 16 <= len(data) <= 1200:
            return
        magic, major, kind, reserved, number, counter = HEADER.unpack_from(data)
        if (magic, major, kind, reserved) != (0x48, 1, 5, 0) or number == 0:
            return
        remote = self.remotes.get((source, number))
        if remote and (counter in remote.counters or counter + 2048 <= max(remote.counters)):
            return
        try:
            packet = stream.Packet.FromString(data[16:])
        except DecodeError:
            return
        if packet.first < 1 or len(packet.items) > 16:
            return
        if remote is None:
            begins = packet.first == 1 and packet.ack == 0
            full = len(self.remotes) >= SESSIONS and not (begins and self.make_room())
            if not begins or full:
                self.reset(source, number, now, stream.RESET_REASON_FULL if full else stream.RESET_REASON_UNKNOWN_SESSION)
                return
            remote = self.remotes[source, number] = Remote(source, number, now)
            self.tell(remote, scene_info=self.scene_info())
            self.tell(remote, lease_info=self.lease_info(remote))
            self.tell(remote, record_info=answer.RecordInfo(state=answer.RECORD_STATE_IDLE))
        remote.counters.add(counter)
        remote.heard = now
        try:
            self.apply(remote, packet, now)
        except Broken as error:
            self.end(remote, control.BYE_REASON_PROTOCOL_ERROR, str(error))

    def make_room(self):
        """Of the sessions that never asked for control, the first one beyond the places they keep goes."""
        lookers = [remote for remote in self.remotes.values() if not remote.asked and remote.bye_at is None]
        if len(lookers) <= LOOKERS:
            return False
        remote = self.remotes.pop((lookers[LOOKERS].source, lookers[LOOKERS].number))
        self.reset(remote.source, remote.number, time.monotonic(), stream.RESET_REASON_FULL)
        return True

    def reset(self, source, number, now, reason):
        if now - self.resets.get(source, 0) < 0.1:
            return
        self.resets[source] = now
        packet = stream.Packet(first=1, boot_id=self.boot_id, reset=stream.Reset(reason=reason))
        self.socket.sendto(header(number, 0) + packet.SerializeToString(), source)

    def apply(self, remote, packet, now):
        remote.ahead = max(remote.ahead, self.taken_ahead(packet))
        if packet.ack > remote.left:
            raise Broken("ack of an Item never sent")
        if packet.ack > remote.acked:
            remote.acked, remote.next, remote.moved = packet.ack, max(remote.next, packet.ack), now
            remote.packets = [last for last in remote.packets if last > packet.ack]
        remote.newest = max(remote.newest, packet.newest)
        while remote.unseen and remote.unseen[0] <= remote.newest:
            remote.unseen.popleft()
        if packet.HasField("clock"):
            remote.clock = (packet.clock.sent_ns, time.monotonic_ns())
        if remote.bye_at is not None:
            return
        for item_id, item in enumerate(packet.items, packet.first):
            if item_id <= remote.applied:
                continue
            if item_id > remote.applied + 1:
                remote.fresh = self.skips(remote)
                break
            remote.applied, remote.fresh = item_id, True
            if item.HasField("chunk"):
                item = self.piece(remote, item.chunk)
            if item is not None:
                self.take(remote, item_id, item)

    @staticmethod
    def taken_ahead(packet):
        """Packets that the client takes ahead."""
        return min(packet.ahead, AHEAD)

    @staticmethod
    def skips(remote):
        """Whether Items that come early are skipped."""
        if not remote.ahead:
            raise Broken("Items were dropped")
        return True

    def piece(self, remote, chunk):
        remote.blobs += not remote.blob
        remote.total = remote.total if remote.blob else (chunk.kind, chunk.total)
        if (chunk.blob, chunk.offset, (chunk.kind, chunk.total)) != (remote.blobs, len(remote.blob), remote.total) or not (
                1 <= len(chunk.bytes) <= 900 and chunk.offset + len(chunk.bytes) <= chunk.total <= 1 << 22):
            raise Broken("a Chunk out of place")
        remote.blob += chunk.bytes
        if len(remote.blob) < chunk.total:
            return None
        blob, remote.blob = remote.blob, b""
        if chunk.kind != stream.CHUNK_KIND_ITEM:
            return stream.Item()
        try:
            item = stream.Item.FromString(blob)
        except DecodeError:
            return INVALID
        if item.HasField("chunk"):
            raise Broken("a Chunk in a Chunk")
        return item

    def take(self, remote, item_id, item):
        kind = None if item is INVALID else item.WhichOneof("body")
        remote.asked = remote.asked or kind in NEEDS_LEASE or kind in ("acquire", "stop")
        if kind == "bye":
            self.lose_lease(remote)
            remote.bye_at = time.monotonic()
        elif kind == "stop" or kind == "run" and item.run.mode == control.RUN_MODE_STOP and self.running:
            self.request(remote, item_id, item)
        else:
            remote.requests.append((item_id, item))

    # Requests.

    def request(self, remote, item_id, item):
        kind = None if item is INVALID else item.WhichOneof("body")
        if item is INVALID or kind is None or kind in SENT_BY_SERVERS:
            self.result(remote, item_id, INVALID if item is INVALID else UNSUPPORTED)
            return
        if kind in NEEDS_LEASE and (self.owner is not remote or item.fence not in (0, self.fence)):
            self.result(remote, item_id, NOT_OWNER, message="take the lease first")
            return
        handler = getattr(model_requests, "do_" + kind, None)
        code, fields = handler(self, remote, item_id, getattr(item, kind)) if handler else (OK, {})
        if code is not None:
            self.result(remote, item_id, code, **fields)

    def run_time(self):
        """Advances the ticks that are due, and sends the States of each."""
        for _ in range(self.world.due_ticks()):
            self.world.step()
            self.show()
        if self.running is None:
            return
        remote, item_id, left, _, _ = self.running
        for _ in range(min(left, 200)):
            subscribed = remote.subscription is not None and self.remotes.get((remote.source, remote.number)) is remote
            if subscribed and len(remote.unseen) >= 64:
                return
            self.running[4] += self.world.step()
            self.running[2] -= 1
            self.running[3] += 1
            self.show()
        if self.running[2] == 0:
            self.end_run()

    def end_run(self):
        if self.running:
            remote, item_id, _, done, held = self.running
            self.running = None
            self.result(remote, item_id, OK, run={"steps": done, "next_tick": self.world.tick, "state_hash": self.world.hash,
                                                  "held_inputs": held})

    def show(self):
        for remote in self.remotes.values():
            if remote.subscription is not None and self.world.newest.tick % remote.subscription.divisor == 0 and remote.bye_at is None:
                remote.state = model_world.section(self.world.newest, remote.subscription)
                remote.unseen.append(self.world.newest.tick)
                if time.monotonic() - remote.heard < 3 or time.monotonic() - remote.state_sent > 0.1:
                    self.send(remote, remote.state)

    # Items and datagrams out.

    def scene_info(self):
        world = self.world
        return answer.SceneInfo(scene_id=world.scene_id, scene=world.scene, hash=bytes(32), rate_hz=1000, clock=world.clock, server_version="model",
                                quality_in_force={"level": 3}, solver_in_force={"max_substeps": 32, "stop_step_m": 1e-6},
                                parameters=[{"path": path, "minimum": low, "maximum": high} for path, (low, high) in model_world.LIVE.items()])

    def lease_info(self, remote):
        told = {"taken_from": self.taken_from, "reason": self.reason} if self.owner else {}
        return answer.LeaseInfo(fence=self.fence, holder=self.holder, yours=self.owner is remote and self.owner is not None, ttl_ms=2000, **told)

    def tell_lease(self):
        self.lease_news = False
        for each in self.remotes.values():
            self.tell(each, lease_info=self.lease_info(each))

    def lose_lease(self, remote):
        if self.owner is remote:
            self.owner, self.fence, self.holder = None, 0, ""
            self.world.queued, self.world.last_tick = {}, -1
            self.lease_news = True

    def result(self, remote, item_id, code, **fields):
        if code != OK:
            fields.setdefault("message", "the model refuses")
        self.tell(remote, result=answer.Result(item_id=item_id, code=code, **fields))

    def tell(self, remote, **body):
        """Queues an Item; the backlog ends the session."""
        if remote.bye_at is not None:
            return
        if len(remote.items) - remote.acked >= 1024:
            self.end(remote, control.BYE_REASON_BACKLOG, "1024 Items are not acknowledged")
        else:
            remote.items.append(stream.Item(**body))

    def end(self, remote, reason, message):
        if remote.bye_at is None:
            remote.items.append(stream.Item(bye=control.Bye(reason=reason, message=message)))
            remote.bye_at = time.monotonic()
            self.lose_lease(remote)

    def serve(self, remote, now):
        """Carries out requests, sends what is due, forgets who is silent or has said Bye."""
        silent = now - remote.heard
        if remote is self.owner and silent > 2 and not self.running:
            self.lose_lease(remote)
        if silent > 10:
            self.end(remote, control.BYE_REASON_SILENCE, "")
        if remote.bye_at is not None and now - remote.bye_at > 1:
            self.lose_lease(remote)
            del self.remotes[remote.source, remote.number]
            return
        while remote.requests and not (self.running and self.running[0] is remote):
            self.request(remote, *remote.requests.popleft())
        last = len(self.fitting(remote, 1100)) + remote.acked
        if remote.ahead and last < len(remote.items):
            self.send_ahead(remote, now)
            return
        due = remote.sent + 0.05
        if last > remote.acked and remote.repeats < len(REPEATS_S):
            due = min(due, remote.first_left + REPEATS_S[remote.repeats])
        waits = self.running and self.running[0] is remote and remote.state is not None
        if last > remote.left or remote.fresh or now >= due:
            self.send(remote, remote.state if waits and now >= due else None)

    def send_ahead(self, remote, now):
        """As many Packets as the client takes, each from where the one before it ended; again from the oldest Item on when that is late."""
        if now - remote.moved > LATE_S:
            remote.packets, remote.next, remote.moved = [], remote.acked, now
        while remote.next < len(remote.items) and len(remote.packets) < (remote.ahead if remote.acked else 1):
            self.send(remote, None, remote.next)
            remote.packets.append(remote.next)
        if remote.fresh:
            self.send(remote, None, remote.left, 0)

    def fitting(self, remote, room, begin=None):
        """The unacknowledged Items that fit, from the oldest on, or from the one after `begin`."""
        begin = remote.acked if begin is None else begin
        found = []
        for each in remote.items[begin:begin + 16]:
            room -= each.ByteSize() + 3
            if room < 0:
                break
            found.append(each)
        return found

    def send(self, remote, shown, begin=None, room=1150):
        begin = remote.acked if begin is None else begin
        now = time.monotonic()
        packet = stream.Packet(ack=remote.applied, first=begin + 1, boot_id=self.boot_id)
        remote.heard_it = remote.acked > 0
        if remote.ahead and not remote.heard_it:
            packet.ahead = AHEAD
        if remote.clock is not None:
            packet.clock.echoed_ns, packet.clock.received_ns = remote.clock
            packet.clock.sent_ns = time.monotonic_ns()
        if shown is not None:
            packet.state.CopyFrom(shown)
            remote.state_sent = now
        packet.items.extend(self.fitting(remote, room - packet.ByteSize(), begin))
        newest = begin + len(packet.items)
        remote.next = max(remote.next, newest)
        if newest > remote.left:
            remote.left, remote.first_left, remote.repeats = newest, now, 0
        else:
            remote.repeats += 1
        remote.sent, remote.fresh = now, False
        data = header(remote.number, remote.counter) + packet.SerializeToString()
        remote.counter += 1
        self.socket.sendto(data, remote.source)


def main():
    addresses = [each for each in sys.argv[1:] if not each.startswith("-")]
    host, port = (addresses or ["127.0.0.1:47800"])[0].rsplit(":", 1)
    server = ModelServer("--virtual" in sys.argv, int(port), host)
    print(f"a model server at {server.address[0]}:{server.address[1]}", flush=True)
    server.loop()


if __name__ == "__main__":
    main()
