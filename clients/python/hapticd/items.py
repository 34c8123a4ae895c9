"""Items, exactly once and in order, and the blobs too long for one: PROTOCOL.md sections 4 and 5. No socket and no clock: the caller
says what time it is, in ns. One Outbox and one Inbox per session."""
from __future__ import annotations

from collections import deque
from itertools import islice
from typing import Deque, List, NamedTuple, Optional, Tuple

from google.protobuf.message import DecodeError

from hapticd import wire
from hapticd.ahead import REPEAT_AFTER_NS, REPEAT_EVERY_NS, PacketsAhead
from hapticd.errors import ProtocolError
from hapticd.v1 import stream_pb2

MOST_ITEMS_IN_PACKET = 16
MOST_UNACKNOWLEDGED = 1024
MOST_ITEM_BYTES = 1000
CHUNK_BYTES = 900
MOST_BLOB_BYTES = 4 * 1024 * 1024
_FIXED_FIELDS_BYTES = 80
"""All of a Packet but its Items, at most: ack, first, clock, seen, newest, ahead."""
_TAG_BYTES = 16
ITEM_ROOM = wire.MOST_DATAGRAM_BYTES - wire.HEADER_BYTES - _TAG_BYTES - _FIXED_FIELDS_BYTES


class BacklogFull(Exception):
    """1024 Items wait for an acknowledgement: the session has to end."""


class _Waiting(NamedTuple):
    item: stream_pb2.Item
    size: int  # in a Packet: tag and length included


def _size_in_packet(item: stream_pb2.Item) -> int:
    size = item.ByteSize()
    return size + 2 + (size > 127)


class Outbox:
    """The Items that the peer has not acknowledged, which of them a Packet takes, and when to repeat them. A Packet begins with the oldest;
    where the peer takes Packets ahead and one does not hold all, with the next Item that is not under way."""

    def __init__(self) -> None:
        self.first = 1
        self.ahead = PacketsAhead()
        self._waiting: Deque[_Waiting] = deque()
        self._pieces = 0  # Chunks in _waiting: a blob may be longer than the backlog, and waits piece by piece
        self._blobs = 0
        self._left = 0  # id of the newest Item that has left at least once
        self._newest_left_ns = 0
        self._sent_ns = 0
        self._repeats = 0

    def __len__(self) -> int:
        return len(self._waiting)

    @property
    def last(self) -> int:
        """Id of the newest Item, 0 before the first."""
        return self.first + len(self._waiting) - 1

    def add(self, item: stream_pb2.Item) -> int:
        """Takes an Item of any length; returns the id its Result will carry. ValueError beyond 4 MiB."""
        if item.ByteSize() > MOST_ITEM_BYTES:
            self._add_blob(item.SerializeToString())
            return self.last
        if len(self._waiting) - self._pieces >= MOST_UNACKNOWLEDGED:
            raise BacklogFull(f"{MOST_UNACKNOWLEDGED} Items are not acknowledged")
        return self.add_last(item)

    def add_last(self, item: stream_pb2.Item) -> int:
        """Takes a Bye, for which there is always room: it takes the place of the Item that was one too many."""
        self._waiting.append(_Waiting(item, _size_in_packet(item)))
        return self.last

    def _add_blob(self, blob: bytes) -> None:
        if len(blob) > MOST_BLOB_BYTES:
            raise ValueError(f"an Item has at most {MOST_BLOB_BYTES} bytes, not {len(blob)}")
        self._blobs += 1
        for offset in range(0, len(blob), CHUNK_BYTES):
            piece = stream_pb2.Item()
            piece.chunk.blob = self._blobs
            piece.chunk.kind = stream_pb2.CHUNK_KIND_ITEM
            piece.chunk.offset = offset
            piece.chunk.total = len(blob)
            piece.chunk.bytes = blob[offset:offset + CHUNK_BYTES]
            self._waiting.append(_Waiting(piece, _size_in_packet(piece)))
            self._pieces += 1

    def acknowledge(self, ack: int, now_ns: int) -> None:
        """Forgets what the peer has. A smaller ack than before is a late datagram and means nothing."""
        if ack > self._left:
            raise ProtocolError(f"ack {ack} of an Item that was never sent")
        if ack < self.first:
            return
        self.ahead.acknowledge(ack, now_ns)
        if self.ahead.allowed:
            self._newest_left_ns, self._repeats = now_ns, 0
        while self.first <= ack:
            self._pieces -= self._waiting.popleft().item.HasField("chunk")
            self.first += 1

    @property
    def _fits_one_packet(self) -> bool:
        """All fits into one Packet, or may not leave in several."""
        few = len(self._waiting) <= MOST_ITEMS_IN_PACKET
        return not self.ahead.allowed or (few and sum(waiting.size for waiting in self._waiting) <= ITEM_ROOM)

    @property
    def leaving_id(self) -> int:
        """Packet.first of a Packet with Items that leaves now."""
        return self.first if self._fits_one_packet else self.ahead.next_id

    def prepare(self, now_ns: int) -> None:
        """Before a Packet is made: what is late leaves again, from the oldest Item on."""
        if not self._fits_one_packet and self.ahead.due_ns is not None and self.ahead.due_ns <= now_ns:
            self.ahead.turn_back(now_ns)

    def fitting(self) -> List[stream_pb2.Item]:
        """The Items from `leaving_id` on, as many as a Packet takes, 16 at most; none when no further Packet may leave."""
        if not self._fits_one_packet and not self.ahead.room:
            return []
        begin, room = self.leaving_id - self.first, ITEM_ROOM
        items: List[stream_pb2.Item] = []
        for waiting in islice(self._waiting, begin, begin + MOST_ITEMS_IN_PACKET):
            room -= waiting.size
            if room < 0:
                break
            items.append(waiting.item)
        return items

    def sent(self, count: int, now_ns: int) -> None:
        """A Packet with `count` Items from `leaving_id` on leaves now."""
        if count == 0:
            return
        further, first = not self._fits_one_packet, self.leaving_id
        newest = first + count - 1
        self.ahead.left(first, newest, now_ns)
        if newest > self._left:
            self._left = newest
            self._newest_left_ns = now_ns
            self._repeats = 0
        elif not further:
            self._repeats += 1
        self._sent_ns = now_ns

    def due_ns(self) -> Optional[int]:
        """When the next Packet has to leave for the sake of the Items; 0 = at once, None = nothing waits."""
        if not self._waiting:
            return None
        if not self._fits_one_packet:
            return 0 if self.ahead.room and self.ahead.next_id < self.first + len(self._waiting) else self.ahead.due_ns
        if self.first + len(self.fitting()) - 1 > self._left:
            return 0
        if self._repeats < len(REPEAT_AFTER_NS):
            return self._newest_left_ns + REPEAT_AFTER_NS[self._repeats]
        return self._sent_ns + REPEAT_EVERY_NS


class Inbox:
    """Applies the peer's Items once each, in order, and puts blobs together."""

    def __init__(self) -> None:
        self.applied = 0
        self._blob = bytearray()
        self._blob_id = 0
        self._blob_total = 0
        self._blob_kind = 0

    def take(self, packet: stream_pb2.Packet) -> List[Tuple[int, Optional[stream_pb2.Item]]]:
        """New Items with their ids; a blob's id is that of its last Chunk, and a blob that does not decode is None."""
        taken: List[Tuple[int, Optional[stream_pb2.Item]]] = []
        for item_id, item in enumerate(packet.items, packet.first):
            if item_id <= self.applied:
                continue
            if item_id > self.applied + 1:
                break  # it came early, as was announced that it may
            self.applied = item_id
            if not item.HasField("chunk"):
                taken.append((item_id, item))
            elif self._add_piece(item.chunk):
                taken.append((item_id, self._decode_blob()))
        return taken

    def _add_piece(self, piece: stream_pb2.Chunk) -> bool:
        """True with the last piece of a blob."""
        if not self._blob:
            self._blob_id += 1
            self._blob_total, self._blob_kind = piece.total, piece.kind
        fits = (piece.blob == self._blob_id and piece.kind == self._blob_kind and piece.total == self._blob_total
                and 1 <= piece.total <= MOST_BLOB_BYTES and piece.offset == len(self._blob) and 1 <= len(piece.bytes) <= CHUNK_BYTES
                and piece.offset + len(piece.bytes) <= piece.total)
        if not fits:
            raise ProtocolError(f"Chunk of blob {piece.blob} at {piece.offset} does not continue blob {self._blob_id} at {len(self._blob)}")
        self._blob += piece.bytes
        return len(self._blob) == piece.total

    def _decode_blob(self) -> Optional[stream_pb2.Item]:
        blob, self._blob = bytes(self._blob), bytearray()
        if self._blob_kind != stream_pb2.CHUNK_KIND_ITEM:
            return stream_pb2.Item()  # of a later version: as an Item without a body
        try:
            item = stream_pb2.Item.FromString(blob)
        except DecodeError:
            return None
        if item.HasField("chunk"):
            raise ProtocolError(f"blob {self._blob_id} contains a Chunk")
        return item
