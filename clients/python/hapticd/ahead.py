"""Which Packets of Items are under way where the peer takes some before the oldest is acknowledged: PROTOCOL.md, section 4. It keeps none
that comes early, so all begin again with the oldest Item where one was lost. How many are under way grows from one, and is halved then: a road
that loses much, or reorders, bears few. No socket and no clock. Times in ns."""
from __future__ import annotations

from collections import deque
from typing import Deque, Optional

MOST_AHEAD = 32
"""Packets of Items under way, at most; what this client announces."""
REPEAT_AFTER_NS = tuple(ms * 1_000_000 for ms in (1, 3, 7, 15, 31))
"""Instants of the repeats after the newest Item first left; then every REPEAT_EVERY_NS."""
REPEAT_EVERY_NS = 50_000_000
_SHARE_OF_NEW = 8  # of a new round trip in the mean
_SHARE_OF_DOUBTFUL = 64  # of one after a repeat, which may have been shorter


class PacketsAhead:
    """Those of one direction of a session."""

    def __init__(self) -> None:
        self.next_id = 1  # of the Item that the next Packet begins with
        self.due_ns: Optional[int] = None  # when the oldest Item leaves again; None: nothing is under way
        self._most = 0
        self._width = 1  # Packets at a time that the road bears
        self._borne = 0  # acknowledged since it grew
        self._steep = True  # it grows with every Packet, for it was never too wide
        self._last_ids: Deque[int] = deque()  # of the Packets under way
        self._acknowledged = 0
        self._highest = 0  # id that left
        self._turns = 0  # since Items were acknowledged,
        self._moved_ns = 0  # which was then; or since the first of those under way left
        self._timed_id = 0  # the last Item of a Packet that is timed; 0: none
        self._timed_ns = 0
        self._round_trip_ns = 0

    @property
    def allowed(self) -> bool:
        """The peer takes Packets ahead."""
        return self._most > 0

    def allow(self, packets: int) -> None:
        """The peer announces so many; the largest number counts."""
        self._most = max(self._most, min(packets, MOST_AHEAD))

    @property
    def room(self) -> bool:
        """Another Packet may leave."""
        return len(self._last_ids) < min(self._width, self._most)

    def _wait_ns(self) -> int:
        """One Packet costs little and is repeated as without all this; several when they are late."""
        pause_ns = REPEAT_EVERY_NS
        if self._turns < len(REPEAT_AFTER_NS):
            pause_ns = REPEAT_AFTER_NS[self._turns] - (REPEAT_AFTER_NS[self._turns - 1] if self._turns else 0)
        return pause_ns if self._width == 1 else 2 * self._round_trip_ns + pause_ns

    def left(self, first: int, last: int, now_ns: int) -> None:
        """A Packet with these Items leaves: from the oldest unacknowledged one on all begin anew with it, else `first` is `next_id`."""
        anew = first == self._acknowledged + 1
        if anew:
            self._last_ids.clear()
        self._last_ids.append(last)
        self.next_id = last + 1
        if last > self._highest and self._timed_id == 0:
            self._timed_id, self._timed_ns = last, now_ns
        self._highest = max(self._highest, last)
        if self.due_ns is None:
            self._moved_ns = now_ns
        if anew or self.due_ns is None:
            self.due_ns = now_ns + self._wait_ns()

    def acknowledge(self, ack: int, now_ns: int) -> None:
        """Items that had not been are acknowledged, up to `ack`."""
        while self._last_ids and self._last_ids[0] <= ack:
            self._last_ids.popleft()
            self._widen()
        self._learn_round_trip(ack, now_ns)
        self._acknowledged, self._moved_ns = ack, now_ns
        self.next_id = max(self.next_id, ack + 1)
        self._turns = 0
        self.due_ns = None if ack == self._highest else now_ns + self._wait_ns()

    def _widen(self) -> None:
        """A Packet was acknowledged: one more at a time, or later one more for all of them."""
        self._borne += 1
        if self._borne >= (1 if self._steep else self._width):
            self._borne, self._width = 0, min(self._width + 1, MOST_AHEAD)

    def _learn_round_trip(self, ack: int, now_ns: int) -> None:
        """Of what has left twice nobody knows which one is acknowledged."""
        timed = 0 < self._timed_id <= ack
        if not timed and self._turns == 0:
            return
        taken_ns = min(now_ns - (self._timed_ns if timed else self._moved_ns), REPEAT_EVERY_NS)
        share = _SHARE_OF_NEW if timed else _SHARE_OF_DOUBTFUL
        self._round_trip_ns += (taken_ns - self._round_trip_ns) // share if self._acknowledged else taken_ns
        if timed:
            self._timed_id = 0

    def turn_back(self, now_ns: int) -> None:
        """The oldest Item leaves next, and the others again after it."""
        self._last_ids.clear()
        self.next_id = self._acknowledged + 1
        self._steep = self._steep and self._width == 1
        self._width = max(self._width // 2, 1) if self._turns == 0 else 1
        self._borne = self._timed_id = 0
        self._turns += 1
        self.due_ns = now_ns + self._wait_ns()
