"""One session of a client as a state machine: datagrams and the time go in, datagrams, Items and States come out. No socket, no thread,
no clock of its own, so that tests run it in virtual time. Rules: PROTOCOL.md sections 3, 4, 6 and 7. Times in ns."""
from __future__ import annotations

from typing import List, NamedTuple, Optional, Tuple, Union

from google.protobuf.message import DecodeError

from hapticd import wire
from hapticd.ahead import MOST_AHEAD
from hapticd.clock import OffsetEstimator
from hapticd.errors import ProtocolError, ServerFull, SessionLost, shown_text
from hapticd.items import MOST_ITEMS_IN_PACKET, BacklogFull, Inbox, Outbox
from hapticd.road import KeyedRoad, PlainRoad
from hapticd.v1 import control_pb2, state_pb2, stream_pb2

KEEP_ALIVE_NS = 50_000_000
"""Twice as often as the server needs it, so that one lost datagram does not matter."""
ACK_SPACING_NS = 1_000_000
"""New Items and States are acknowledged at once, but not more often than this."""
CLOCK_EVERY_NS = 200_000_000
"""A Packet asks for the server's time this often."""
BYE_PATIENCE_NS = 1_000_000_000
"""A Bye is repeated for this long."""
MOST_PARTS = 32
"""Of a State."""


class Arrived(NamedTuple):
    """What a datagram brought: Items in order with their ids (None: a blob that does not decode), and a State."""

    items: List[Tuple[int, Optional[stream_pb2.Item]]]
    state: Optional[state_pb2.State]


NOTHING = Arrived([], None)


class Link:
    """A session from the client's side, PLAIN with a number that is random, not 0, and never used twice, or on a keyed road."""

    def __init__(self, road: Union[int, PlainRoad, KeyedRoad], now_ns: int) -> None:
        self._road = PlainRoad(road) if isinstance(road, int) else road
        self.boot_id = 0
        self.clock = OffsetEstimator()
        self.heard_ns = now_ns  # when the last valid datagram came
        self.seen = 0
        self.ended: Optional[control_pb2.Bye] = None  # the server's, or ours after an error of it
        self._announces = True  # until the server is heard: it may send Packets ahead
        self._outbox = Outbox()
        self._inbox = Inbox()
        self._window = wire.CounterWindow()
        self._counter = 0
        self._newest = (0, 0)  # scene_id and tick
        self._highest_state = -1  # counter of the newest State's datagram
        self._state_tick = (0, -1)
        self._last_state: Optional[state_pb2.State] = None  # while a Run waits for us the server repeats it
        self._parts: dict[int, state_pb2.State] = {}
        self._sent_ns = now_ns - KEEP_ALIVE_NS
        self._clock_ns = now_ns - CLOCK_EVERY_NS
        self._to_acknowledge = True  # true at first: the first datagram opens the session
        self._saying_bye = False

    # Sending.

    def submit(self, item: stream_pb2.Item) -> int:
        """Queues an Item and returns its id. Beyond 1024 unacknowledged ones the session ends with Bye BACKLOG."""
        if self._saying_bye:
            raise SessionLost("the session has said Bye")
        try:
            return self._outbox.add(item)
        except BacklogFull as full:
            self.say_bye(control_pb2.BYE_REASON_BACKLOG, str(full))
            raise

    def say_bye(self, reason: control_pb2.ByeReason, message: str = "") -> None:
        """The last Item of this side."""
        if self._saying_bye:
            return
        bye = stream_pb2.Item()
        bye.bye.reason = reason
        bye.bye.message = message
        self._outbox.add_last(bye)
        self._saying_bye = True

    @property
    def session(self) -> int:
        """Its number; 0 while a keyed one is not open."""
        return self._road.session

    @property
    def keyed(self) -> bool:
        return self._road.keyed

    @property
    def backlog(self) -> int:
        """Items not yet acknowledged."""
        return len(self._outbox)

    @property
    def finished(self) -> bool:
        """Nothing is left to say: all is acknowledged, both ways, or no server ever answered."""
        return self.boot_id == 0 or (len(self._outbox) == 0 and not self._to_acknowledge)

    def due_ns(self) -> int:
        """When the next datagram has to leave."""
        if not self._road.is_open:
            return self._road.due_ns()
        due = self._sent_ns + KEEP_ALIVE_NS
        if self._to_acknowledge:
            due = min(due, self._sent_ns + ACK_SPACING_NS)
        repeat = self._outbox.due_ns()
        return due if repeat is None else min(due, repeat)

    def datagram(self, now_ns: int) -> bytes:
        """The datagram to send now, whether it is due or not."""
        if not self._road.is_open:
            return self._road.hello(now_ns)
        self._outbox.prepare(now_ns)
        items = self._outbox.fitting()
        first = self._outbox.leaving_id if items else self._outbox.first
        packet = stream_pb2.Packet(ack=self._inbox.applied, first=first, items=items, seen=self.seen, newest=self._newest[1])
        if self._announces:
            packet.ahead = MOST_AHEAD
        if now_ns - self._clock_ns >= CLOCK_EVERY_NS:
            packet.clock.sent_ns = now_ns
            self._clock_ns = now_ns
        self._outbox.sent(len(items), now_ns)
        self._sent_ns = now_ns
        self._to_acknowledge = False
        counter, self._counter = self._counter, self._counter + 1
        return self._road.seal(counter, packet.SerializeToString())

    # Receiving.

    def receive(self, data: bytes, now_ns: int) -> Arrived:
        """Takes a datagram. SessionLost or ServerFull: forget this link and start again with another number."""
        datagram = self._road.receive(data)
        if datagram is None:
            return NOTHING
        try:
            packet = stream_pb2.Packet.FromString(datagram.body)
        except DecodeError:
            return NOTHING
        if packet.first < 1 or len(packet.items) > MOST_ITEMS_IN_PACKET:
            return NOTHING
        # A server that forgot the session counts from 0 again: its Reset must not fall to the window of counters.
        if packet.HasField("reset"):
            full = packet.reset.reason == stream_pb2.RESET_REASON_FULL
            why = f": {shown_text(packet.reset.message)}" if packet.reset.message else ""
            raise ServerFull("the server has no session left" + why) if full else SessionLost("the server does not know this session" + why)
        if not self._window.is_new(datagram.counter):
            return NOTHING
        self._window.mark(datagram.counter)
        if self.boot_id not in (0, packet.boot_id):
            raise SessionLost("the server was restarted")
        self.boot_id = packet.boot_id
        self.heard_ns = now_ns
        self._announces = False
        return self._apply(packet, datagram.counter, now_ns)

    def _apply(self, packet: stream_pb2.Packet, counter: int, now_ns: int) -> Arrived:
        if packet.HasField("clock") and packet.clock.echoed_ns:
            self.clock.add(packet.clock.echoed_ns, packet.clock.received_ns, packet.clock.sent_ns, now_ns)
        items: List[Tuple[int, Optional[stream_pb2.Item]]] = []
        self._outbox.ahead.allow(packet.ahead)
        try:
            self._outbox.acknowledge(packet.ack, now_ns)
            if self.ended is None:
                items = self._inbox.take(packet)
        except ProtocolError as error:
            self.say_bye(control_pb2.BYE_REASON_PROTOCOL_ERROR, str(error))
            self.ended = control_pb2.Bye(reason=control_pb2.BYE_REASON_PROTOCOL_ERROR, message=str(error))
        # Repeated Items mean that the ack was lost: it is sent again.
        self._to_acknowledge |= len(packet.items) > 0
        for _, item in items:
            if item is not None and item.HasField("bye"):
                self.ended = item.bye
        return Arrived(items, self._take_state(packet.state, counter) if packet.HasField("state") else None)

    def _take_state(self, state: state_pb2.State, counter: int) -> Optional[state_pb2.State]:
        """The State if it is the newest; of one in parts, all of it once the last has come."""
        self.seen += 1
        self._to_acknowledge = True
        place = (state.scene_id, state.tick)
        self._newest = max(self._newest, place)
        if counter < self._highest_state and not (state.part_count > 1 and place == self._state_tick):
            return None
        self._highest_state = max(counter, self._highest_state)
        if place != self._state_tick:
            self._parts = {}
        self._state_tick = place
        if state.part_count <= 1:
            repeated, self._last_state = state == self._last_state, state
            return None if repeated else state
        if state.part_index >= state.part_count or state.part_count > MOST_PARTS:
            return None
        self._parts[state.part_index] = state
        if len(self._parts) < state.part_count:
            return None
        whole = state_pb2.State()
        for index in sorted(self._parts):
            whole.MergeFrom(self._parts[index])
        whole.ClearField("part_index")
        whole.ClearField("part_count")
        return whole
