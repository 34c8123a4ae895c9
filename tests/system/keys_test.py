"""Keys against the daemon: made by hapticctl, served by hapticd on every address, used by the clients in C++ (hapticctl) and in Python."""
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from unittest import mock

import daemon
import hapticd
from hapticd import conversation, key, noise, road

HAPTICCTL = os.environ["HAPTICCTL"]


def control(*words):
    """(exit code, what it said)."""
    done = subprocess.run([HAPTICCTL, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60)
    return done.returncode, done.stdout


class Keys(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.keys = pathlib.Path(cls.folder.name) / "keys"
        code, said = control("keygen", str(cls.keys))
        assert code == 0, said
        cls.control_key, cls.view_key = ((cls.keys / name).read_bytes() for name in ("control.key", "view.key"))
        cls.control_psk, cls.view_psk = key.taken(cls.control_key).psk, key.taken(cls.view_key).psk
        cls.played = daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string", "--keys", str(cls.keys),
                                   host="0.0.0.0")
        cls.played.__enter__()
        cls.address = cls.played.address.replace("0.0.0.0", "127.0.0.1")

    @classmethod
    def tearDownClass(cls):
        cls.played.__exit__(None, None, None)
        cls.folder.cleanup()

    def ctl(self, key, *words):
        return control("--server", self.address, "--key", str(self.keys / key), "--timeout", "5", *words)

    def test_both_clients_control_with_the_control_key(self):
        with hapticd.Session(self.address, key=self.control_key) as session:
            session.acquire("python")
            session.load_scene("single_string")
            session.subscribe(divisor=1, sections=["TOOLS"])
            self.assertEqual(session.run(300).steps, 300)
            self.assertEqual([state.tick for state in session.states(300)], list(range(300)))
        self.assertEqual(self.ctl("control.key", "scene", "load", "single_string")[0], 0)
        code, said = self.ctl("control.key", "run", "step", "300")
        self.assertEqual(code, 0, said)
        self.assertIn("300 ticks, next is tick 300", said)

    def test_both_clients_know_who_sent_the_cookie(self):
        host, port = self.address.split(":")
        door = road.KeyedRoad(key.taken(self.control_key), 0)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
            client.settimeout(10)
            client.sendto(door.hello(0), (host, int(port)))
            retry = client.recv(2048)
            message = door.hello(0)[26:26 + 48]
            self.assertTrue(noise.is_tagged_retry(self.control_psk, b"hapticd\x01\x04", message, retry[16:]))
            self.assertFalse(noise.is_tagged_retry(self.view_psk, b"hapticd\x01\x04", message, retry[16:]))
            door.receive(retry)
            client.sendto(door.hello(0), (host, int(port)))
            door.receive(client.recv(2048))
            self.assertTrue(door.is_open)

    def test_the_view_key_looks_and_does_not_control(self):
        code, said = self.ctl("view.key", "status")
        self.assertEqual(code, 0, said)
        code, said = self.ctl("view.key", "stop")
        self.assertEqual(code, 1, said)
        self.assertIn("NOT_PERMITTED", said)
        with hapticd.Session(self.address, key=self.view_key, role="view") as session:
            session.subscribe(divisor=1)
            with self.assertRaises(hapticd.RequestError) as refused:
                session.acquire("viewer")
            self.assertEqual(refused.exception.code, "NOT_PERMITTED")

    def test_without_a_key_or_with_another_nobody_answers(self):
        other = self.keys / "other.key"
        other.write_bytes(self.control_key[:8] + bytes(32) + self.control_key[40:])
        other.chmod(0o600)
        for words in ((), ("--key", str(other)), ("--key", str(self.keys / "view.key"), "--role", "control")):
            code, said = control("--server", self.address, "--timeout", "0.7", *words, "status")
            self.assertEqual(code, 3, said)
            self.assertIn("--key", said)
        with mock.patch.object(conversation, "SILENCE_NS", 700_000_000):
            for options in ({}, {"key": other}, {"key": self.view_key, "role": "control"}):
                with self.assertRaises(hapticd.ServerSilent):
                    hapticd.Session(self.address, **options)

    def test_a_client_has_a_key_of_its_own_for_as_long_as_it_is_there(self):
        code, said = control("keygen", str(self.keys), "--client", "stage", "--role", "control")
        self.assertEqual(code, 0, said)
        code, said = control("keygen", str(self.keys), "--list")
        self.assertEqual((code, said.split()), (0, ["stage", "control"]))
        deadline = time.monotonic() + 10
        while self.ctl("clients/stage.key", "status")[0] != 0:
            self.assertLess(time.monotonic(), deadline, "the daemon does not know the new key")
        with hapticd.Session(self.address, key=self.keys / "clients/stage.key", reconnect=False) as session:
            session.acquire("python")
            self.assertEqual(control("keygen", str(self.keys), "--revoke", "stage")[0], 0)
            with self.assertRaises(hapticd.SessionEnded) as ended:
                while time.monotonic() < deadline + 10:
                    session.ping()
                    time.sleep(0.02)
            self.assertIn("stage was revoked", str(ended.exception))
            self.assertEqual(ended.exception.reason, "REVOKED")
        code, said = control("keygen", str(self.keys), "--list")
        self.assertEqual((code, said), (0, ""))
        self.assertEqual(control("keygen", str(self.keys), "--revoke", "stage")[0], 1)
        with mock.patch.object(conversation, "SILENCE_NS", 700_000_000), self.assertRaises(hapticd.ServerSilent):
            hapticd.Session(self.address, key=b"hapticd\x02" + bytes(32) + self.control_key[40:])

    def test_an_old_key_is_refused_by_name_and_keygen_keeps_its_psk(self):
        with tempfile.TemporaryDirectory() as folder:
            old = pathlib.Path(folder) / "keys"
            old.mkdir(mode=0o700)
            for name, psk in (("view.key", b"v" * 32), ("control.key", b"c" * 32)):
                (old / name).write_bytes(psk)
                (old / name).chmod(0o600)
            code, said = control("--key", str(old / "view.key"), "status")
            self.assertEqual(code, 1, said)
            self.assertIn(f"{old}/view.key: a key of an earlier version", said)
            self.assertIn("hapticctl keygen", said)
            code, said = daemon.run("--scene", "sphere", "--check", "--keys", str(old))
            self.assertEqual(code, 1, said)
            self.assertIn("hapticctl keygen", said)
            self.assertEqual(control("keygen", str(old))[0], 0)
            self.assertEqual(daemon.run("--scene", "sphere", "--check", "--keys", str(old))[0], 0)
            self.assertEqual(key.taken(old / "view.key").psk, b"v" * 32)

    def test_keys_that_cannot_be_used_are_refused_with_the_remedy(self):
        with tempfile.TemporaryDirectory() as folder:
            bad = pathlib.Path(folder) / "keys"
            code, text = daemon.run("--scene", "sphere", "--check", "--keys", str(bad))
            self.assertEqual(code, 1, text)
            self.assertIn("hapticctl keygen", text)
            self.assertEqual(control("keygen", str(bad))[0], 0)
            self.assertEqual(daemon.run("--scene", "sphere", "--check", "--keys", str(bad))[0], 0)
            (bad / "view.key").chmod(0o644)
            code, text = daemon.run("--scene", "sphere", "--check", "--keys", str(bad))
            self.assertEqual(code, 1, text)
            self.assertIn(f"chmod 600 {bad}/view.key", text)
            code, said = control("--key", str(bad / "view.key"), "status")
            self.assertEqual(code, 1, said)
            self.assertIn("chmod 600", said)
            config = pathlib.Path(folder) / "my.textproto"
            config.write_text(f'scene: "sphere"\nkeys: "{bad}"\n')
            self.assertEqual(daemon.run("--config", str(config), "--check")[0], 1)
            (bad / "view.key").chmod(0o600)
            self.assertEqual(daemon.run("--config", str(config), "--check")[0], 0)
            code, said = control("keygen", str(bad))
            self.assertEqual(code, 1, said)
            self.assertIn("exists already", said)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
