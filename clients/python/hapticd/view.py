"""What both kinds of session know without asking."""
from __future__ import annotations

import time
from typing import Mapping, Optional

from hapticd.clock import ClockEstimate
from hapticd.conversation import Conversation
from hapticd.v1 import event_pb2, state_pb2


class View:
    """Of the conversation of a session."""

    _connection: Conversation

    @property
    def latest(self) -> Optional[state_pb2.State]:
        """The newest State, or None before the first. Under the real clock one that is older than half a second, and three times as old as
        those of the subscription become, is over: then this is a copy without force, detached, with cause INPUT_STALE. Whoever passes force
        on to a device goes by `force_holds`, which is sooner."""
        return self._connection.present(time.monotonic_ns())

    @property
    def force_holds(self) -> bool:
        """Whether the force of the newest State may still be put on a hand: it came within 20 ms (PROTOCOL.md section 9). Ask before every
        write to a device, and write zero when this is False; subscribe to every tick, or every tenth at most."""
        return self._connection.force_holds(time.monotonic_ns())

    @property
    def soundings(self) -> Mapping[int, event_pb2.StringSounding]:
        """What strings sound like that do, by index: the newest StringSounding of each, as told at its own instant; `sounding_at` carries
        it on. Without a subscription with the section STRINGS a session knows what has changed since it began, with one all that sounds."""
        return self._connection.soundings.by_string

    @property
    def boot_id(self) -> int:
        """Random number of this run of the server."""
        return self._connection.link.boot_id

    @property
    def epoch(self) -> int:
        """Counts the sessions with the server: it grows when the server was restarted and joined again."""
        return self._connection.epoch

    @property
    def states_dropped(self) -> int:
        """States that made room for newer ones before `states()` had read them."""
        return self._connection.states_dropped

    def clock(self) -> Optional[ClockEstimate]:
        """The server's clock relative to time.monotonic_ns(), here and now; None before the first exchange."""
        return self._connection.link.clock.estimate(time.monotonic_ns())
