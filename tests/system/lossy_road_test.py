"""Exactly once and in order over real sockets that lose 40 %, double and reorder: the daemon, the clients in Python and C++, PLAIN and with
keys, through lossy_proxy.py. What arrived is seen by what it did: the same poses give the same bits only if each came once and in order."""
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

import daemon
import hapticd
from lossy_proxy import LossyProxy

HAPTICCTL = os.environ["HAPTICCTL"]
OPTIONS = ("--clock", "virtual", "--device", "scripted", "--scene", "single_string")
TICKS = 640


def drag(tick):
    """A finger that rests, comes down beside the string and is dragged over it, with every tick a pose of its own."""
    return (1e-6 * tick, 0.0046, -0.02 + 0.0001 * max(0, tick - 220))


class LossyRoad(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.keys = pathlib.Path(cls.folder.name) / "keys"
        subprocess.run([HAPTICCTL, "keygen", str(cls.keys)], check=True, stdout=subprocess.DEVNULL)
        cls.poses = pathlib.Path(cls.folder.name) / "poses.csv"
        cls.poses.write_text("".join("%r,%r,%r\n" % drag(tick) for tick in range(TICKS)))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def daemon(self, keyed, **more):
        return daemon.Daemon(*OPTIONS, *(("--keys", str(self.keys)) if keyed else ()), **more)

    def key(self, keyed):
        return (self.keys / "control.key").read_bytes() if keyed else None

    def check_bad(self, proxy):
        self.assertGreater(proxy.taken, 60)
        self.assertGreater(proxy.lost, 0.3 * proxy.taken)
        self.assertGreater(proxy.doubled, 0.1 * proxy.taken)
        self.assertGreater(proxy.overtaken, 0)

    def played(self, session):
        """(hash of all States, tones, fencing number) of one session."""
        for _ in range(5):  # each Acquire that is carried out counts
            session.acquire("test")
            session.release()
        session.acquire("test")
        session.load_scene("single_string")
        result = session.run(poses=[drag(tick) for tick in range(TICKS)])
        self.assertEqual((result.steps, result.held_inputs), (TICKS, 0))
        session.ping()
        tones = [(event.body.t_ns, event.body.frequency_hz) for event in session.events(timeout=0.2) if event.kind == "tone"]
        return result.state_hash, tones, session.lease.fence

    def test_python_gets_the_same_bits_and_tones_as_over_a_good_road(self):
        for keyed in (False, True):
            with self.subTest(keyed=keyed), self.daemon(keyed) as played:
                with hapticd.Session(played.address, key=self.key(keyed)) as session:
                    clean = self.played(session)
                self.assertGreaterEqual(len(clean[1]), 1)
                self.assertEqual(clean[2], 6)
                with LossyProxy(played.address) as proxy:
                    with hapticd.Session(proxy.address, reconnect=False, key=self.key(keyed)) as session:
                        lossy = self.played(session)
                    self.check_bad(proxy)
                self.assertEqual(lossy[:2], clean[:2])
                self.assertEqual(lossy[2], clean[2] + 6)

    def hapticctl(self, address, keyed, *words):
        key = ("--key", str(self.keys / "control.key")) if keyed else ()
        done = subprocess.run([HAPTICCTL, "--server", address, *key, "--timeout", "20", *words], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout

    def test_cpp_gets_the_same_bits_as_over_a_good_road(self):
        for keyed in (False, True):
            hashes = []
            for lossy in (False, True):
                with self.subTest(keyed=keyed, lossy=lossy), self.daemon(keyed) as played, LossyProxy(played.address) as proxy:
                    address = proxy.address if lossy else played.address
                    said = self.hapticctl(address, keyed, "pose", str(self.poses))
                    self.assertIn(f"{TICKS} poses sent, 0 ticks without one", said)
                    hashes.append(self.hapticctl(address, keyed, "run", "step", "1"))
                    if lossy:
                        self.check_bad(proxy)
            self.assertEqual(hashes[0], hashes[1])
            self.assertIn("hash", hashes[0])

    def failures_until_joined(self, session):
        """Pings until the session after this one answers; how many failed. Nobody is told that all is well when it is not."""
        failures, end = 0, time.monotonic() + 20
        while time.monotonic() < end:
            try:
                session.ping()
                if session.epoch == 2:
                    return failures
            except (hapticd.SessionLost, hapticd.ServerSilent):
                failures += 1
        self.fail("the new daemon was not joined in 20 s")

    def test_a_restarted_daemon_is_found_and_joined_anew(self):
        for keyed in (False, True):
            with self.subTest(keyed=keyed), self.daemon(keyed) as first:
                port = int(first.address.rsplit(":", 1)[1])
                with LossyProxy(first.address) as proxy, hapticd.Session(proxy.address, key=self.key(keyed)) as session:
                    session.acquire("test")
                    before = session.boot_id
                    first.end(daemon.signal.SIGKILL)
                    with self.daemon(keyed, port=port):
                        self.assertGreaterEqual(self.failures_until_joined(session), 1)
                        self.assertEqual(session.epoch, 2)
                        self.assertNotIn(session.boot_id, (0, before))
                        self.assertFalse(session.lease.yours)
                        session.acquire("test")


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
