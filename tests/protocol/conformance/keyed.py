"""Section 12 of PROTOCOL.md for peer.py: Noise_NNpsk0_25519_ChaChaPoly_BLAKE2b (the Noise specification, revision 34) as the initiator, and
the datagrams around it. Written from those two documents alone and shared with no client. Needs python3-cryptography."""
import hashlib
import hmac
import secrets
import struct

HELLO, RETRY, WELCOME, DATA = 1, 2, 3, 4
VIEW, CONTROL = 1, 2
DATAGRAM_BYTES = 1200


def header(session, counter, kind):
    return struct.pack("<BBBBIQ", 0x48, 1, kind, 0, session, counter)


def hkdf(chaining, material, count):
    key = hmac.digest(chaining, material, "blake2b")
    outputs = [b""]
    for number in range(1, count + 1):
        outputs.append(hmac.digest(key, outputs[-1] + bytes([number]), "blake2b"))
    return outputs[1:]


def blake2b(data):
    return hashlib.blake2b(data).digest()


def aead(key):
    from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305
    return ChaCha20Poly1305(key[:32])


def nonce(counter):
    return struct.pack("<IQ", 0, counter)


class Handshake:
    """The initiator's side of one handshake, and then its two ciphers."""

    def __init__(self, key, role):
        from cryptography.hazmat.primitives.asymmetric import x25519
        from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
        self.x25519 = x25519
        self.role = role
        self.private = x25519.X25519PrivateKey.from_private_bytes(secrets.token_bytes(32))
        public = self.private.public_key().public_bytes(Encoding.Raw, PublicFormat.Raw)
        self.chaining = b"Noise_NNpsk0_25519_ChaChaPoly_BLAKE2b".ljust(64, b"\0")
        self.hash = blake2b(self.chaining + b"hapticd" + bytes([1, role]))
        self.chaining, hashed, _ = hkdf(self.chaining, key, 3)  # psk
        self.hash = blake2b(self.hash + hashed)
        self.hash = blake2b(self.hash + public)  # e
        self.chaining, cipher = hkdf(self.chaining, public, 2)
        tag = aead(cipher).encrypt(nonce(0), b"", self.hash)
        self.hash = blake2b(self.hash + tag)
        self.message = public + tag
        self.session = 0
        self.sending = self.receiving = None

    def hello(self, cookie=b""):
        body = bytes([self.role, len(cookie)]) + cookie + self.message
        return header(0, 0, HELLO) + body.ljust(DATAGRAM_BYTES - 16, b"\0")

    def welcome(self, datagram):
        """Takes a WELCOME; raises InvalidTag where it does not open."""
        theirs, tag = datagram[16:48], datagram[48:64]
        hashed = blake2b(self.hash + theirs)
        chaining, _ = hkdf(self.chaining, theirs, 2)
        chaining, cipher = hkdf(chaining, self.private.exchange(self.x25519.X25519PublicKey.from_public_bytes(theirs)), 2)
        aead(cipher).decrypt(nonce(0), tag, hashed)
        first, second = hkdf(chaining, b"", 2)
        self.sending, self.receiving = aead(first), aead(second)
        self.session = struct.unpack_from("<I", datagram, 4)[0]

    def seal(self, counter, body):
        front = header(self.session, counter, DATA)
        return front + self.sending.encrypt(nonce(counter), body, front)

    def open(self, datagram):
        """The body of a DATA; raises InvalidTag where it does not open."""
        counter = struct.unpack_from("<Q", datagram, 8)[0]
        return self.receiving.decrypt(nonce(counter), datagram[16:], datagram[:16])
