"""Noise_NKpsk0_25519_ChaChaPoly_BLAKE2b of the Noise specification, revision 34: the handshake of keyed sessions (PROTOCOL.md section
12) and the two keys it ends with, and what of a HELLO is outside of it. Needs python3-cryptography. Pattern: <- s   ...   -> psk, e, es
<- e, ee."""
from __future__ import annotations

import hashlib
import hmac
import secrets
from typing import Optional, Tuple

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey, X25519PublicKey
from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

NAME = b"Noise_NKpsk0_25519_ChaChaPoly_BLAKE2b"
HASH_BYTES = 64
KEY_BYTES = 32
TAG_BYTES = 16


def _hmac(key: bytes, data: bytes) -> bytes:
    return hmac.new(key, data, hashlib.blake2b).digest()


def _hkdf(chaining_key: bytes, material: bytes, count: int) -> Tuple[bytes, ...]:
    temporary = _hmac(chaining_key, material)
    outputs, last = [], b""
    for number in range(1, count + 1):
        last = _hmac(temporary, last + bytes([number]))
        outputs.append(last)
    return tuple(outputs)


def public_half(private: bytes) -> bytes:
    """The public half of a private key."""
    return X25519PrivateKey.from_private_bytes(private).public_key().public_bytes(Encoding.Raw, PublicFormat.Raw)


def key_id(psk: bytes) -> bytes:
    """Names a psk in a HELLO, and tells nothing of it."""
    return hashlib.blake2b(b"KEY ID", key=psk, digest_size=8).digest()


def hello_tag(psk: bytes, before: bytes) -> bytes:
    """The MAC of a HELLO, over all of it before the tag."""
    key = hashlib.blake2b(b"HELLO", key=psk, digest_size=KEY_BYTES).digest()
    return hashlib.blake2b(before, key=key, digest_size=TAG_BYTES).digest()


def is_tagged_retry(psk: bytes, prologue: bytes, message: bytes, body: bytes) -> bool:
    """Whether the last 16 bytes of a RETRY's body are the tag, made with the psk, of what is before them: the server answers `message`."""
    cookie, tag = body[:-TAG_BYTES], body[-TAG_BYTES:]
    what = b"RETRY" + prologue + message[:KEY_BYTES] + cookie
    return len(cookie) > 0 and hmac.compare_digest(tag, hashlib.blake2b(what, key=psk, digest_size=TAG_BYTES).digest())


class Cipher:
    """One direction of the transport phase."""

    def __init__(self, key: bytes) -> None:
        self._cipher = ChaCha20Poly1305(key)

    def seal(self, n: int, associated: bytes, plain: bytes) -> bytes:
        return self._cipher.encrypt(bytes(4) + n.to_bytes(8, "little"), plain, associated)

    def open(self, n: int, associated: bytes, sealed: bytes) -> Optional[bytes]:
        """The plain bytes, or None where the tag does not verify."""
        try:
            return self._cipher.decrypt(bytes(4) + n.to_bytes(8, "little"), sealed, associated)
        except InvalidTag:
            return None


class Handshake:
    """Either side of one handshake. `responder` is the responder's own key: its public half for the initiator, its private half for
    itself. `ephemeral` is the private key, random unless a test vector gives it."""

    def __init__(self, initiator: bool, psk: bytes, prologue: bytes, responder: bytes, ephemeral: Optional[bytes] = None) -> None:
        if len(psk) != KEY_BYTES or len(responder) != KEY_BYTES:
            raise ValueError(f"a key has {KEY_BYTES} bytes, not {len(psk)} or {len(responder)}")
        self._initiator = initiator
        self._responder = responder
        self._private = X25519PrivateKey.from_private_bytes(ephemeral or secrets.token_bytes(KEY_BYTES))
        self.public = self._private.public_key().public_bytes(Encoding.Raw, PublicFormat.Raw)
        self._hash = NAME.ljust(HASH_BYTES, b"\0")
        self._chaining = self._hash
        self._key = b""
        self._mix_hash(prologue)
        self._mix_hash(responder if initiator else public_half(responder))
        self._chaining, hashed, key = _hkdf(self._chaining, psk, 3)
        self._mix_hash(hashed)
        self._key = key[:KEY_BYTES]

    def _mix_hash(self, data: bytes) -> None:
        self._hash = hashlib.blake2b(self._hash + data).digest()

    def _mix_key(self, material: bytes) -> None:
        self._chaining, key = _hkdf(self._chaining, material, 2)
        self._key = key[:KEY_BYTES]

    def _ephemeral(self, public: bytes) -> None:
        """Token e of a pattern with a psk: hashed, and mixed into the key too."""
        self._mix_hash(public)
        self._mix_key(public)

    def _exchange(self, private: X25519PrivateKey, public: bytes) -> None:
        """Token ee or es."""
        self._mix_key(private.exchange(X25519PublicKey.from_public_bytes(public)))

    def _exchange_first(self, initiator: bytes) -> None:
        """Token es; `initiator` is the ephemeral public key of that side."""
        if self._initiator:
            self._exchange(self._private, self._responder)
        else:
            self._exchange(X25519PrivateKey.from_private_bytes(self._responder), initiator)

    def write(self, theirs: bytes = b"", payload: bytes = b"") -> bytes:
        """This side's message. The responder gives the initiator's public key, the first 32 bytes of message 1."""
        self._ephemeral(self.public)
        if self._initiator:
            self._exchange_first(self.public)
        else:
            self._exchange(self._private, theirs)
        sealed = Cipher(self._key).seal(0, self._hash, payload)
        self._mix_hash(sealed)
        return self.public + sealed

    def read(self, message: bytes) -> Optional[bytes]:
        """The payload of the other side's message, or None where it does not open. A failed read leaves no trace: the true message may
        still come."""
        before = (self._hash, self._chaining, self._key)
        if len(message) >= KEY_BYTES + TAG_BYTES:
            public, sealed = message[:KEY_BYTES], message[KEY_BYTES:]
            try:
                self._ephemeral(public)
                if self._initiator:
                    self._exchange(self._private, public)
                else:
                    self._exchange_first(public)
                payload = Cipher(self._key).open(0, self._hash, sealed)
            except ValueError:  # a public key of low order
                payload = None
            if payload is not None:
                self._mix_hash(sealed)
                return payload
        self._hash, self._chaining, self._key = before
        return None

    def split(self) -> Tuple[Cipher, Cipher]:
        """Ciphers of this side's sending and receiving."""
        first, second = (Cipher(key[:KEY_BYTES]) for key in _hkdf(self._chaining, b"", 2))
        return (first, second) if self._initiator else (second, first)
