"""A scene of megabytes is told to a client, and sent to the daemon, 32 Packets at a time; one that announces nothing gets one Packet per round trip.
Counted are Packets and round trips, never seconds."""
import pathlib
import sys
import unittest

import daemon
import hapticd

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "protocol" / "conformance"))
import peer  # noqa: E402  (the client taken apart)

POINTS = 133_000
"""Of one line: 24 bytes each as SceneInfo tells them, two characters a number in the text."""
FINGER = 'tools { name: "f" parts { name: "t" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } pose_wg { p_m: [0, 1, 0] } }\n'
LARGE = FINGER + 'name: "large" lines { name: "l" radius_m: 0.001 points_w_m: [' + ",".join(["1", "2", "1"] * POINTS) + "] }\n"
OPTIONS = ("--clock", "virtual", "--device", "scripted")


class Trips(peer.Peer):
    """Hears all that has come before it says what it has: one Packet a round trip."""

    def trips(self, done, most):
        """Round trips until the condition holds."""
        for trip in range(most):
            if done():
                return trip
            self.send()
            self.hear_all()
        peer.expect(done(), f"not there after {most} round trips")
        return most

    def hear_all(self):
        """Takes what comes until nothing does for 2 ms; 1 s for the first."""
        heard = self.hear(1.0)
        while heard is not None:
            self._take(heard)
            heard = self.hear(0.002)


class LargeScene(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.played = daemon.Daemon(*OPTIONS, "--scene", "single_string")
        cls.played.__enter__()
        cls.addClassCleanup(cls.played.__exit__, None, None, None)
        with hapticd.Session(cls.played.address) as session:
            session.acquire("test")
            cls.told = session.load_scene(LARGE)

    def connected(self, ahead):
        host, port = self.played.address.rsplit(":", 1)
        client = Trips((host, int(port)))
        client.ahead = ahead
        self.addCleanup(client.close)
        return client

    def test_the_scene_goes_up_and_comes_down_as_it_was(self):
        self.assertEqual(len(self.told.scene.lines[0].points_w_m), 3 * POINTS)
        self.assertGreater(self.told.ByteSize(), 3_190_000)
        with hapticd.Session(self.played.address) as late:
            self.assertEqual(late.scene.scene, self.told.scene)

    def test_who_takes_32_packets_ahead_hears_it_in_a_twentieth_of_as_many_round_trips(self):
        chunks = -(-self.told.ByteSize() // 900)
        client = self.connected(32)
        trips = client.trips(lambda: client.of_kind("scene_info"), chunks)
        self.assertEqual(client.of_kind("scene_info")[0].scene, self.told.scene)
        self.assertLess(trips, chunks // 20)
        with_items = sum(bool(heard.packet.items) for heard in client.heard)
        self.assertLess(with_items, 3 * chunks)  # on a machine that is late now and then some leave again
        client.bye()

    def test_who_announces_nothing_hears_one_piece_at_a_time(self):
        client = self.connected(0)
        trips = client.trips(lambda: client.applied >= 200, 2000)
        self.assertGreaterEqual(trips, 100)  # the 2 ms of silence let a Packet and its successor pass now and then
        client.bye()


if __name__ == "__main__":
    unittest.main()
