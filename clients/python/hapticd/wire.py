"""The datagram's header and the window of counters already received: PROTOCOL.md section 2. Pure functions of bytes; no socket, no
clock. Counters are per direction and per session."""
from __future__ import annotations

import struct
from typing import NamedTuple, Optional

MOST_DATAGRAM_BYTES = 1200
HEADER_BYTES = 16
MAGIC = 0x48
MAJOR = 1
KIND_HELLO, KIND_RETRY, KIND_WELCOME, KIND_DATA, KIND_PLAIN = 1, 2, 3, 4, 5
WINDOW = 2048
"""Counters below the largest received one by this much are too old to tell whether they were seen."""

_HEADER = struct.Struct("<BBBBIQ")


class Datagram(NamedTuple):
    """A datagram whose header is in order."""

    kind: int
    session: int
    counter: int
    body: bytes


def encode(kind: int, session: int, counter: int, body: bytes) -> bytes:
    """Header and body. ValueError beyond 1200 bytes: such a datagram must not exist."""
    if HEADER_BYTES + len(body) > MOST_DATAGRAM_BYTES:
        raise ValueError(f"a datagram has at most {MOST_DATAGRAM_BYTES} bytes, not {HEADER_BYTES + len(body)}")
    return _HEADER.pack(MAGIC, MAJOR, kind, 0, session, counter) + body


def decode(data: bytes, kind: int = KIND_PLAIN) -> Optional[Datagram]:
    """The parts of a datagram of the expected kind, or None where it is to be dropped without a word (steps 1 and 2)."""
    if not HEADER_BYTES <= len(data) <= MOST_DATAGRAM_BYTES:
        return None
    magic, major, found, zero, session, counter = _HEADER.unpack_from(data)
    if (magic, major, found, zero) != (MAGIC, MAJOR, kind, 0):
        return None
    return Datagram(found, session, counter, data[HEADER_BYTES:])


class CounterWindow:
    """Which counters have been received. `is_new` first, `mark` only once the datagram has opened (steps 4 and 6)."""

    def __init__(self) -> None:
        self._largest = -1
        self._bits = 0  # bit i = counter _largest - i has been received

    def is_new(self, counter: int) -> bool:
        age = self._largest - counter
        if age < 0:
            return True
        return age < WINDOW and not (self._bits >> age) & 1

    def mark(self, counter: int) -> None:
        age = self._largest - counter
        if age >= 0:
            self._bits |= 1 << age
            return
        shift = min(-age, WINDOW)
        self._bits = ((self._bits << shift) | 1) & ((1 << WINDOW) - 1)
        self._largest = counter
