"""How the datagrams of a session look on the wire: PLAIN as they are (PROTOCOL.md section 3), or DATA under a key (section 12). A road
turns a Packet's bytes into a datagram and back; a keyed road first has to be opened by HELLO and WELCOME. Times in ns."""
from __future__ import annotations

from typing import Callable, Optional

from hapticd import wire
from hapticd.key import SessionKey

HELLO_EVERY_NS = 250_000_000
NOISE_MESSAGE_BYTES = 48
MOST_COOKIE_BYTES = 64
ROLE_OF_KNOWN_SERVER = 2
"""A HELLO of NKpsk0 has the role and this."""


class PlainRoad:
    """PLAIN: open from the first."""

    keyed = False
    tag_bytes = 0

    def __init__(self, session: int) -> None:
        self.session = session

    @property
    def is_open(self) -> bool:
        return True

    def due_ns(self) -> int:
        return 0

    def hello(self, now_ns: int) -> bytes:
        raise AssertionError("a PLAIN session says no HELLO")

    def seal(self, counter: int, body: bytes) -> bytes:
        return wire.encode(wire.KIND_PLAIN, self.session, counter, body)

    def receive(self, data: bytes) -> Optional[wire.Datagram]:
        """The datagram, or None where it is to be dropped."""
        datagram = wire.decode(data)
        return datagram if datagram is not None and datagram.session == self.session else None


class KeyedRoad:
    """DATA under a key. The server chooses the session's number. `ephemeral` is for tests."""

    keyed = True

    def __init__(self, key: SessionKey, now_ns: int, ephemeral: Optional[bytes] = None) -> None:
        from hapticd import noise  # needs python3-cryptography, which PLAIN sessions do without
        self.tag_bytes = noise.TAG_BYTES
        self.session = 0
        self._role = key.role + ROLE_OF_KNOWN_SERVER
        prologue = b"hapticd\x01" + bytes([self._role])
        self._handshake = noise.Handshake(True, key.psk, prologue, key.server, ephemeral)
        self._message = self._handshake.write()
        self._key_id = noise.key_id(key.psk)
        self._tag: Callable[[bytes], bytes] = lambda before: noise.hello_tag(key.psk, before)
        self._is_tagged: Callable[[bytes], bool] = lambda body: noise.is_tagged_retry(key.psk, prologue, self._message, body)
        self._cookie, self._cookie_is_tagged = b"", False
        self._due_ns = now_ns
        self._ciphers: Optional[tuple[noise.Cipher, noise.Cipher]] = None

    @property
    def is_open(self) -> bool:
        return self._ciphers is not None

    def due_ns(self) -> int:
        """When the next HELLO has to leave."""
        return self._due_ns

    def hello(self, now_ns: int) -> bytes:
        """A HELLO, filled up with zeros so that no answer to it is longer."""
        self._due_ns = now_ns + HELLO_EVERY_NS
        body = bytes([self._role, len(self._cookie)]) + self._cookie + self._key_id + self._message
        before = wire.encode(wire.KIND_HELLO, 0, 0, body)
        return (before + self._tag(before)).ljust(wire.MOST_DATAGRAM_BYTES, b"\0")

    def seal(self, counter: int, body: bytes) -> bytes:
        assert self._ciphers is not None
        header = wire.encode(wire.KIND_DATA, self.session, counter, b"")
        return header + self._ciphers[0].seal(counter, header, body)

    def receive(self, data: bytes) -> Optional[wire.Datagram]:
        """The datagram, opened, or None. RETRY and WELCOME are for the road itself."""
        if self._ciphers is None:
            self._shake_hands(data)
            return None
        datagram = wire.decode(data, wire.KIND_DATA)
        if datagram is None or datagram.session != self.session or len(datagram.body) < self.tag_bytes:
            return None
        body = self._ciphers[1].open(datagram.counter, data[:wire.HEADER_BYTES], datagram.body)
        return None if body is None else datagram._replace(body=body)

    def _take_cookie(self, cookie: bytes) -> None:
        """A RETRY without a tag may be of anybody who knows where this client is. It is believed, for the sake of servers that make no
        tags, until one with a tag has come; and but for the first one it makes no HELLO leave earlier, so that a flood of them neither
        hurries nor holds up the handshake."""
        tagged = self._is_tagged(cookie)
        if self._cookie_is_tagged and not tagged:
            return
        if cookie != self._cookie and (tagged or not self._cookie):
            self._due_ns = 0
        self._cookie, self._cookie_is_tagged = cookie, tagged

    def _shake_hands(self, data: bytes) -> None:
        retry = wire.decode(data, wire.KIND_RETRY)
        if retry is not None and retry.session == 0 and 1 <= len(retry.body) <= MOST_COOKIE_BYTES:
            self._take_cookie(retry.body)
        welcome = wire.decode(data, wire.KIND_WELCOME)
        if welcome is not None and len(welcome.body) == NOISE_MESSAGE_BYTES and self._handshake.read(welcome.body) == b"":
            self.session = welcome.session
            self._ciphers = self._handshake.split()
