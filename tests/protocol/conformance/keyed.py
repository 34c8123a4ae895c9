"""Section 12 of PROTOCOL.md for peer.py: Noise_NKpsk0_25519_ChaChaPoly_BLAKE2b (the Noise specification, revision 34) as the initiator, that
of before, NNpsk0, and the datagrams around them. Written from those two documents alone and shared with no client. Needs python3-cryptography."""
import hashlib
import hmac
import secrets
import struct

HELLO, RETRY, WELCOME, DATA = 1, 2, 3, 4
OLD_VIEW, OLD_CONTROL, VIEW, CONTROL = 1, 2, 3, 4
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


def key_in(file):
    """(role, psk, server) of a key file."""
    assert len(file) == 72 and file[:7] == b"hapticd"
    return file[7], file[8:40], file[40:]


class Handshake:
    """The initiator's side of one handshake, and then its two ciphers. `key`: the psk and the server's public key."""

    def __init__(self, key, role):
        from cryptography.hazmat.primitives.asymmetric import x25519
        from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
        self.x25519 = x25519
        self.role = role
        psk, server = key
        old = role in (OLD_VIEW, OLD_CONTROL)
        self.private = x25519.X25519PrivateKey.from_private_bytes(secrets.token_bytes(32))
        public = self.private.public_key().public_bytes(Encoding.Raw, PublicFormat.Raw)
        name = b"Noise_NNpsk0_25519_ChaChaPoly_BLAKE2b" if old else b"Noise_NKpsk0_25519_ChaChaPoly_BLAKE2b"
        self.chaining = name.ljust(64, b"\0")
        self.hash = blake2b(self.chaining + b"hapticd" + bytes([1, role]))
        if not old:
            self.hash = blake2b(self.hash + server)  # s, before the first message
        self.chaining, hashed, _ = hkdf(self.chaining, psk, 3)  # psk
        self.hash = blake2b(self.hash + hashed)
        self.hash = blake2b(self.hash + public)  # e
        self.chaining, cipher = hkdf(self.chaining, public, 2)
        if not old:
            self.chaining, cipher = hkdf(self.chaining, self.shared(server), 2)  # es
        tag = aead(cipher).encrypt(nonce(0), b"", self.hash)
        self.hash = blake2b(self.hash + tag)
        self.message = public + tag
        self.key_id = b"" if old else hashlib.blake2b(b"KEY ID", key=psk, digest_size=8).digest()
        self.hello_key = None if old else hashlib.blake2b(b"HELLO", key=psk, digest_size=32).digest()
        self.session = 0
        self.sending = self.receiving = None

    def shared(self, theirs):
        return self.private.exchange(self.x25519.X25519PublicKey.from_public_bytes(theirs))

    def hello(self, cookie=b""):
        before = header(0, 0, HELLO) + bytes([self.role, len(cookie)]) + cookie + self.key_id + self.message
        tag = b"" if self.hello_key is None else hashlib.blake2b(before, key=self.hello_key, digest_size=16).digest()
        return (before + tag).ljust(DATAGRAM_BYTES, b"\0")

    def welcome(self, datagram):
        """Takes a WELCOME; raises InvalidTag where it does not open."""
        theirs, tag = datagram[16:48], datagram[48:64]
        hashed = blake2b(self.hash + theirs)
        chaining, _ = hkdf(self.chaining, theirs, 2)
        chaining, cipher = hkdf(chaining, self.shared(theirs), 2)
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
