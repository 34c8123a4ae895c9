"""Keyed sessions: the handshake against published vectors (those of the Go library flynn/noise, also used by other Noise libraries), and
a whole session through a gate with keys."""
import hashlib
import secrets
import time
import unittest
from unittest import mock

import support  # noqa: F401
import hapticd
from hapticd import conversation, noise, road, wire
from keyed_gate import KeyedGate
from model_server import ModelServer

INITIATOR = bytes(range(0x20, 0x40))
RESPONDER = bytes(range(0x41, 0x61))
PSK = b"!verysecretverysecretverysecret!"
LAST = [("79656c6c6f777375626d6172696e65", "7811d68572ef1cef95b8a84abaa2c04c52c65b6bc7717b20d7d0937fbdd792"),
        ("7375626d6172696e6579656c6c6f77", "ccf5caaaee5fd10189d055e7c7e73eff5c50c424c5186ba83af5921864b95f")]
# Prologue, and the two handshake messages with payload and ciphertext.
VECTORS = [
    ("", [("", "358072d6365880d1aeea329adf9121383851ed21a28e3b75e965d0d2cd1662545ca945ccbc84a56bec9c401b36132676"),
          ("", "64b101b1d0be5a8704bd078f9895001fc03e8e9f9522f188dd128d9846d48466f0eb7ac83b0774a9e2869b41e7740303")]),
    ("", [("746573745f6d73675f30",
           "358072d6365880d1aeea329adf9121383851ed21a28e3b75e965d0d2cd1662544291e8e0931ad8b16a789c6570707bcf7b224b7690859f627dfb"),
          ("746573745f6d73675f31",
           "64b101b1d0be5a8704bd078f9895001fc03e8e9f9522f188dd128d9846d48466871d4367360b3a22ef391c1824a2fc2ef48f53b399433fb6ef10")]),
    ("6e6f74736563726574", [("", "358072d6365880d1aeea329adf9121383851ed21a28e3b75e965d0d2cd166254b06ef00a4d70a332e9d2d7ee208915d8"),
                            ("", "64b101b1d0be5a8704bd078f9895001fc03e8e9f9522f188dd128d9846d48466a69b59729468a7560df3f44a73e23793")]),
]


class PublishedVectors(unittest.TestCase):
    def test_every_message_of_every_vector_is_met_on_both_sides(self):
        for prologue, messages in VECTORS:
            client = noise.Handshake(True, PSK, bytes.fromhex(prologue), INITIATOR)
            server = noise.Handshake(False, PSK, bytes.fromhex(prologue), RESPONDER)
            (payload_1, wanted_1), (payload_2, wanted_2) = ([bytes.fromhex(each) for each in message] for message in messages)
            self.assertEqual(client.write(payload=payload_1), wanted_1)
            self.assertEqual(server.read(wanted_1), payload_1)
            self.assertEqual(server.write(wanted_1[:32], payload_2), wanted_2)
            self.assertEqual(client.read(wanted_2), payload_2)
            (send, receive), (server_send, server_receive) = client.split(), server.split()
            for (plain, sealed), out, into in zip(LAST, (send, server_send), (server_receive, receive)):
                self.assertEqual(out.seal(0, b"", bytes.fromhex(plain)).hex(), sealed)
                self.assertEqual(into.open(0, b"", bytes.fromhex(sealed)).hex(), plain)

    def test_no_flipped_bit_opens_and_the_true_message_still_does(self):
        client, server = noise.Handshake(True, PSK, b""), noise.Handshake(False, PSK, b"")
        server.read(first := client.write())
        message = server.write(first[:32])
        for bit in range(8 * len(message)):
            bad = bytearray(message)
            bad[bit // 8] ^= 1 << bit % 8
            # X25519 ignores the highest bit of a public key, the hash does not.
            self.assertIsNone(client.read(bytes(bad)), f"bit {bit}")
        self.assertEqual(client.read(message), b"")

    def test_keys_have_32_bytes(self):
        with self.assertRaises(ValueError):
            noise.Handshake(True, b"short", b"")


class Hello(unittest.TestCase):
    def test_fills_a_datagram_and_is_repeated_with_the_cookie(self):
        door = road.KeyedRoad(PSK, "view", 0)
        first = door.hello(0)
        self.assertEqual((len(first), first[:16]), (1200, b"H\x01\x01" + bytes(13)))
        self.assertEqual((first[16], first[17]), (1, 0))
        self.assertEqual(door.due_ns(), 250_000_000)
        door.receive(wire.encode(wire.KIND_RETRY, 0, 0, b"biscuit"))
        self.assertEqual(door.due_ns(), 0)
        second = door.hello(1)
        self.assertEqual((second[16:18], second[18:25], len(second)), (b"\x01\x07", b"biscuit", 1200))
        self.assertEqual(second[25:73], first[18:66])
        self.assertEqual(set(second[73:]), {0})
        self.assertFalse(door.is_open)

    def test_once_the_server_has_signed_a_cookie_no_other_is_taken(self):
        door = road.KeyedRoad(PSK, "control", 0)
        message = door.hello(0)[18:18 + 48]

        def retry(cookie, psk=PSK, answered=message):
            what = b"RETRYhapticd\x01\x02" + answered[:32] + cookie
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
        door = road.KeyedRoad(PSK, "control", 0)
        for cookie in (b"", bytes(65)):
            door.receive(wire.encode(wire.KIND_RETRY, 0, 0, cookie))
            self.assertEqual(door.hello(0)[17], 0)


class ThroughTheGate(unittest.TestCase):
    def setUp(self):
        self.server = ModelServer(True).start()
        self.addCleanup(self.server.stop)
        self.gate = KeyedGate(self.server.address, {1: bytes(32), 2: PSK})
        self.addCleanup(self.gate.stop)

    def session(self, **options):
        session = hapticd.Session("%s:%d" % self.gate.address, **options)
        self.addCleanup(session.close)
        return session

    def test_a_session_asks_and_steps(self):
        session = self.session(key=PSK)
        self.assertGreaterEqual(self.gate.retries, 1)
        self.assertLessEqual(self.gate.answered_bytes, self.gate.hello_bytes)
        session.acquire()
        session.subscribe(1)
        self.assertEqual(session.run(poses=[(0, 0.01, 0)] * 300).steps, 300)
        self.assertEqual([state.tick for state in session.states(300, timeout=2)], list(range(300)))
        self.assertEqual(session._connection.link.session, 1000)

    def test_both_roles_have_their_own_keys(self):
        self.session(key=bytes(32), role="view").ping()
        with mock.patch.object(conversation, "SILENCE_NS", 300_000_000), self.assertRaises(hapticd.ServerSilent):
            hapticd.Session("%s:%d" % self.gate.address, key=PSK, role="view")

    def test_after_silence_hello_is_said_again(self):
        session = self.session(key=PSK)
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
