"""Keyed sessions: the handshake against published vectors (those of the Go library flynn/noise, also used by other Noise libraries), and
a whole session through a gate with keys."""
import hashlib
import pathlib
import secrets
import tempfile
import time
import unittest
from unittest import mock

import support  # noqa: F401
import hapticd
from hapticd import conversation, noise, road, wire
from hapticd.key import ROLES, SessionKey, taken
from keyed_gate import KeyedGate
from model_server import ModelServer

OWN = bytes(range(1, 33))
PSK = b"!verysecretverysecretverysecret!"
VECTORS = pathlib.Path(__file__).parents[2] / "proto/noise/noise_nkpsk0_vectors.txt"


def key(role="control", psk=PSK):
    return SessionKey(ROLES[role], psk, noise.public_half(OWN))


def file_of(role=2, psk=PSK):
    return b"hapticd" + bytes([role]) + psk + noise.public_half(OWN)


def published():
    """Names and bytes of each vector."""
    for block in VECTORS.read_text().split("handshake=")[1:]:
        lines = [line.split("=") for line in block.splitlines()[1:] if "=" in line]
        yield {name: bytes.fromhex(value) for name, value in lines}


class PublishedVectors(unittest.TestCase):
    def test_every_message_of_every_vector_is_met_on_both_sides(self):
        count = 0
        for vector in published():
            count += 1
            prologue, psk, own = vector.get("prologue", b""), vector["preshared_key"], vector["resp_static"]
            client = noise.Handshake(True, psk, prologue, noise.public_half(own), vector["gen_init_ephemeral"])
            server = noise.Handshake(False, psk, prologue, own, vector["gen_resp_ephemeral"])
            first, second = vector["msg_0_ciphertext"], vector["msg_1_ciphertext"]
            self.assertEqual(client.write(payload=vector["msg_0_payload"]), first)
            self.assertEqual(server.read(first), vector["msg_0_payload"])
            self.assertEqual(server.write(first[:32], vector["msg_1_payload"]), second)
            self.assertEqual(client.read(second), vector["msg_1_payload"])
            (send, receive), (server_send, server_receive) = client.split(), server.split()
            for number, out, into in ((2, send, server_receive), (3, server_send, receive)):
                plain, sealed = vector[f"msg_{number}_payload"], vector[f"msg_{number}_ciphertext"]
                self.assertEqual(out.seal(0, b"", plain), sealed)
                self.assertEqual(into.open(0, b"", sealed), plain)
        self.assertEqual(count, 4)

    def test_no_flipped_bit_opens_and_the_true_message_still_does(self):
        client, server = noise.Handshake(True, PSK, b"", noise.public_half(OWN)), noise.Handshake(False, PSK, b"", OWN)
        server.read(first := client.write())
        message = server.write(first[:32])
        for bit in range(8 * len(message)):
            bad = bytearray(message)
            bad[bit // 8] ^= 1 << bit % 8
            # X25519 ignores the highest bit of a public key, the hash does not.
            self.assertIsNone(client.read(bytes(bad)), f"bit {bit}")
        self.assertEqual(client.read(message), b"")

    def test_who_has_the_psk_alone_cannot_pose_as_the_server(self):
        client, posing = noise.Handshake(True, PSK, b"", noise.public_half(OWN)), noise.Handshake(False, PSK, b"", bytes(range(2, 34)))
        self.assertIsNone(posing.read(first := client.write()))
        self.assertIsNone(client.read(posing.write(first[:32])))

    def test_keys_have_32_bytes(self):
        with self.assertRaises(ValueError):
            noise.Handshake(True, b"short", b"", OWN)


class KeyFiles(unittest.TestCase):
    def test_role_psk_and_server_are_read_and_another_role_may_be_named(self):
        self.assertEqual(taken(file_of()), key())
        self.assertEqual(taken(file_of(1)), key("view"))
        self.assertEqual(taken(file_of(1), "control"), key())

    def test_an_old_key_and_what_is_none_are_refused_with_the_remedy(self):
        for data in (PSK, b"", file_of()[:-1], file_of() + b"x", file_of(0), file_of(3), b"H" + file_of()[1:]):
            with self.assertRaises(ValueError) as refused:
                hapticd.Session("127.0.0.1:9", key=data)
            self.assertIn("hapticctl keygen", str(refused.exception))
            self.assertEqual("earlier version" in str(refused.exception), data == PSK)

    def test_a_file_is_named_and_only_its_owner_may_have_access(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "control.key"
            file.write_bytes(file_of())
            file.chmod(0o640)
            with self.assertRaisesRegex(ValueError, f"chmod 600 {file}"):
                taken(file)
            file.chmod(0o600)
            self.assertEqual(taken(str(file)), key())
            file.write_bytes(PSK)
            with self.assertRaisesRegex(ValueError, str(file)):
                taken(file)


class Hello(unittest.TestCase):
    def test_fills_a_datagram_and_is_repeated_with_the_cookie(self):
        door = road.KeyedRoad(key("view"), 0)
        first = door.hello(0)
        self.assertEqual((len(first), first[:16]), (1200, b"H\x01\x01" + bytes(13)))
        self.assertEqual((first[16], first[17]), (3, 0))
        self.assertEqual(first[18:26], hashlib.blake2b(b"KEY ID", key=PSK, digest_size=8).digest())
        mac = hashlib.blake2b(b"HELLO", key=PSK, digest_size=32).digest()
        self.assertEqual(first[74:90], hashlib.blake2b(first[:74], key=mac, digest_size=16).digest())
        self.assertEqual(door.due_ns(), 250_000_000)
        door.receive(wire.encode(wire.KIND_RETRY, 0, 0, b"biscuit"))
        self.assertEqual(door.due_ns(), 0)
        second = door.hello(1)
        self.assertEqual((second[16:18], second[18:25], len(second)), (b"\x03\x07", b"biscuit", 1200))
        self.assertEqual(second[25:81], first[18:74])
        self.assertEqual(second[81:97], hashlib.blake2b(second[:81], key=mac, digest_size=16).digest())
        self.assertEqual(set(second[97:]), {0})
        self.assertFalse(door.is_open)

    def test_once_the_server_has_signed_a_cookie_no_other_is_taken(self):
        door = road.KeyedRoad(key(), 0)
        message = door.hello(0)[26:26 + 48]

        def retry(cookie, psk=PSK, answered=message):
            what = b"RETRYhapticd\x01\x04" + answered[:32] + cookie
            return wire.encode(wire.KIND_RETRY, 0, 0, cookie + hashlib.blake2b(what, key=psk, digest_size=16).digest())

        forged = [secrets.token_bytes(48) for _ in range(50)]
        door.receive(wire.encode(wire.KIND_RETRY, 0, 0, forged[0]))
        self.assertEqual(door.due_ns(), 0)
        door.hello(7)
        for cookie in forged[1:]:
            door.receive(wire.encode(wire.KIND_RETRY, 0, 0, cookie))
            self.assertEqual(door.due_ns(), 7 + road.HELLO_EVERY_NS)  # no flood of them makes it say more
        good = retry(b"c" * 32)
        door.receive(good)
        self.assertEqual(door.due_ns(), 0)
        for bad in [wire.encode(wire.KIND_RETRY, 0, 0, forged[3]), retry(b"d" * 32, psk=bytes(32)),
                    retry(b"d" * 32, answered=secrets.token_bytes(48)), good[:-1], good[:16] + b"x" + good[17:]]:
            door.receive(bad)
            self.assertEqual(door.hello(8)[18:18 + 48], good[16:])

    def test_cookies_of_no_or_too_many_bytes_are_ignored(self):
        door = road.KeyedRoad(key(), 0)
        for cookie in (b"", bytes(65)):
            door.receive(wire.encode(wire.KIND_RETRY, 0, 0, cookie))
            self.assertEqual(door.hello(0)[17], 0)


class ThroughTheGate(unittest.TestCase):
    def setUp(self):
        self.server = ModelServer(True).start()
        self.addCleanup(self.server.stop)
        self.gate = KeyedGate(self.server.address, {3: bytes(32), 4: PSK}, OWN)
        self.addCleanup(self.gate.stop)

    def session(self, **options):
        session = hapticd.Session("%s:%d" % self.gate.address, **options)
        self.addCleanup(session.close)
        return session

    def test_a_session_asks_and_steps(self):
        session = self.session(key=file_of())
        self.assertGreaterEqual(self.gate.retries, 1)
        self.assertLessEqual(self.gate.answered_bytes, self.gate.hello_bytes)
        session.acquire()
        session.subscribe(1)
        self.assertEqual(session.run(poses=[(0, 0.01, 0)] * 300).steps, 300)
        self.assertEqual([state.tick for state in session.states(300, timeout=2)], list(range(300)))
        self.assertEqual(session._connection.link.session, 1000)

    def test_both_roles_have_their_own_keys(self):
        self.session(key=file_of(1, bytes(32))).ping()
        with mock.patch.object(conversation, "SILENCE_NS", 300_000_000), self.assertRaises(hapticd.ServerSilent):
            hapticd.Session("%s:%d" % self.gate.address, key=file_of(), role="view")

    def test_after_silence_hello_is_said_again(self):
        session = self.session(key=file_of())
        with mock.patch.object(conversation, "SILENCE_NS", 300_000_000):
            self.gate.sessions[1000] = (("127.0.0.1", 9), *self.gate.sessions[1000][1:])  # nothing reaches the client any more
            end = time.monotonic() + 5
            while session.epoch < 2 and time.monotonic() < end:
                time.sleep(0.01)
        self.assertEqual(session.epoch, 2)
        session.ping()
        self.assertEqual(session._connection.link.session, 1001)


if __name__ == "__main__":
    unittest.main()
