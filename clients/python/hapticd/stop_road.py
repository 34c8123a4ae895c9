"""The Stop road: zero force at once, past all that the daemon's network thread has to do, and the heartbeat of a dead-man (PROTOCOL.md
section 17). Datagrams of 64 bytes, with a tag of stop.key at the end; from this machine a Stop needs no key."""
from __future__ import annotations

import hashlib
import hmac
import secrets
import socket
import struct
import threading
import time
from dataclasses import dataclass
from typing import Optional, Union

STOP, QUERY, HEARTBEAT, LEAVE = 1, 2, 3, 4
ANSWER = 0x80
DONE, CHALLENGE, OTHER_DAEMON, KEY_NEEDED, OUT_OF_RANGE, FULL, UNKNOWN_KIND = 1, 2, 3, 4, 5, 6, 7
ASKED, LATCHED = 1, 2
DEFAULT_PORT = 47801
AGAIN_S = 0.01
# How long a Stop that the daemon has is followed until its loop has latched it.
FOLLOW_S = 0.1
_LAYOUT = struct.Struct("<cBBBHHBBBBIQQ16s")
_TAG_BYTES = 16


@dataclass(frozen=True)
class Answer:
    """What the daemon says."""

    kind: int
    code: int
    session_port: int
    timeout_ms: int
    latch: int
    loop_state: int
    cause: int
    heartbeats: int
    tick: int
    client: int
    number: int
    challenge: bytes


def _tag(body: bytes, key: Optional[bytes]) -> bytes:
    return hashlib.blake2b(body, key=key, digest_size=_TAG_BYTES).digest() if key else bytes(_TAG_BYTES)


def encode_request(kind: int, client: int, number: int, challenge: bytes = bytes(16), session_port: int = 0, timeout_ms: int = 0,
                   key: Optional[bytes] = None) -> bytes:
    body = _LAYOUT.pack(b"S", 1, kind, 0, session_port, timeout_ms, 0, 0, 0, 0, 0, client, number, challenge)
    return body + _tag(body, key)


def decode_answer(data: bytes, key: Optional[bytes] = None) -> Optional[Answer]:
    """The answer, or None where it is none that `key` made; without a key, where it has a tag."""
    if len(data) != _LAYOUT.size + _TAG_BYTES or not hmac.compare_digest(_tag(data[:_LAYOUT.size], key), data[_LAYOUT.size:]):
        return None
    mark, version, kind, *rest = _LAYOUT.unpack(data[:_LAYOUT.size])
    return Answer(kind & ~ANSWER, *rest) if (mark, version) == (b"S", 1) and kind & ANSWER else None


class StopRoad:
    """Questions to the road at `host` and `port`. `session_port` is that of the daemon's sessions; 0: whoever answers is meant. One thread."""

    def __init__(self, host: str = "127.0.0.1", port: int = DEFAULT_PORT, session_port: int = 0, key: Optional[bytes] = None) -> None:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        self._socket = socket.socket(family, kind, protocol)
        self._socket.connect(address)
        self._session_port = session_port
        self._key = key
        self._client = secrets.randbits(63) + 1
        self._number = 0
        self._challenge = bytes(16)

    def close(self) -> None:
        self._socket.close()

    def __enter__(self) -> StopRoad:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def send(self, kind: int, timeout_ms: int = 0) -> bytes:
        """One datagram leaves; it is returned."""
        self._number += 1
        data = encode_request(kind, self._client, self._number, self._challenge, self._session_port, timeout_ms, self._key)
        try:
            self._socket.send(data)
        except OSError:
            pass  # nobody is there yet, or a datagram before found nobody
        return data

    def receive(self, wait_s: float) -> Optional[Answer]:
        """The next answer that is authentic, or None when none comes in time."""
        end = time.monotonic() + wait_s
        while True:
            self._socket.settimeout(max(0.0001, end - time.monotonic()))
            try:
                answer = decode_answer(self._socket.recv(256), self._key)
            except OSError:
                answer = None
            if answer and answer.client == self._client and 0 < answer.number <= self._number:
                if self._key:
                    self._challenge = answer.challenge
                return answer
            if time.monotonic() >= end:
                return None

    def ask(self, kind: int, timeout: float = 1.0, timeout_ms: int = 0) -> Optional[Answer]:
        """Asks every 10 ms, with the challenge that it is given, until it is answered; None when nobody answers for `timeout` s."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            self.send(kind, timeout_ms)
            answer = self.receive(AGAIN_S)
            if answer and answer.code != CHALLENGE:
                return answer
        return None

    def stop(self, timeout: float = 1.0) -> Optional[Answer]:
        """Zero force at once. Waits until the loop has latched it, 0.1 s at most once the daemon has it. None: nobody answers."""
        answer = self.ask(STOP, timeout)
        end = time.monotonic() + FOLLOW_S
        while answer and answer.code == DONE and answer.latch == ASKED and time.monotonic() < end:
            answer = self.ask(QUERY, FOLLOW_S) or answer
        return answer

    def query(self, timeout: float = 1.0) -> Optional[Answer]:
        """Whether a fault is latched, and in what state the loop is."""
        return self.ask(QUERY, timeout)


def stop(server: str = "127.0.0.1:47800", port: int = DEFAULT_PORT, key: Optional[bytes] = None, timeout: float = 1.0) -> Optional[Answer]:
    """Stops the daemon whose sessions are at `server`, HOST:PORT, over its Stop road; latched until a Clear. None: its road does not answer,
    or another daemon's does; then a session's `stop()` is left."""
    host, _, session_port = server.rpartition(":")
    with StopRoad(host.strip("[]"), port, int(session_port), key) as road:
        answer = road.stop(timeout)
    return answer if answer and answer.code == DONE else None


class Heartbeat:
    """A dead-man: while the block runs the daemon holds the force on only as long as it hears from here. `timeout_ms`, 50 to 1000: how long it
    may hear nothing. While `held` is cleared nothing is sent, as from a hand that has let go. The block's end is said, and not missed."""

    def __init__(self, key: bytes, host: str = "127.0.0.1", port: int = DEFAULT_PORT, session_port: int = 0, timeout_ms: int = 200) -> None:
        self._road = StopRoad(host, port, session_port, key)
        self._timeout_ms = timeout_ms
        self._ended = threading.Event()
        self.held = threading.Event()
        self.held.set()
        self.answer: Union[Answer, None] = None
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _run(self) -> None:
        every_s = self._timeout_ms / 1000 / 5
        while not self._ended.wait(every_s):
            if not self.held.is_set():
                continue
            self.answer = self._road.ask(HEARTBEAT, every_s, self._timeout_ms) or self.answer

    def __enter__(self) -> Heartbeat:
        self.answer = self._road.ask(HEARTBEAT, timeout_ms=self._timeout_ms)
        if self.answer is None or self.answer.code != DONE:
            self._road.close()
            raise ConnectionError("the Stop road does not take the heartbeat" + (f": code {self.answer.code}" if self.answer else ""))
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
        self._road.ask(LEAVE)
        self._road.close()
