"""Lockstep against the daemon: equal bits from equal sessions, and the chain of hashes recomputed from the States themselves."""
import hashlib
import math
import sys
import threading
import unittest

import daemon
import hapticd
from hapticd.v1 import state_pb2
from lossy_proxy import LossyProxy

CANONICAL = ["TOOLS", "DEVICES", "STRINGS", "CONTACTS", "ENERGY", "QUALITY", "STIFFNESS", "GESTURES"]


def drag(ticks):
    """A finger that rests, comes down beside the string and is dragged over it."""
    return [(0.0, 0.0046, -0.02 + 0.0001 * max(0, tick - 220)) for tick in range(ticks)]


def play(session, ticks=640):
    """(States, hash) of one session."""
    session.load_scene("single_string")
    session.subscribe(divisor=1, sections=CANONICAL, max_contacts=256)
    result = session.run(poses=drag(ticks))
    return result.states, result


class Lockstep(daemon.LockstepCase):
    def test_the_hash_is_that_of_the_canonical_states(self):
        states, result = play(self.session)
        self.assertEqual([state.tick for state in states], list(range(640)))
        chain = bytes(32)
        for state in states:
            canonical = type(state)()
            canonical.CopyFrom(state)
            for field in ("scene_id", "contacts_total", "strings_total", "part_index", "part_count"):
                canonical.ClearField(field)
            for string in canonical.strings:
                string.ClearField("sounding")
            chain = hashlib.blake2b(chain + canonical.SerializeToString(deterministic=True), digest_size=32).digest()
        self.assertEqual(chain, result.state_hash)

    def test_two_sessions_with_the_same_poses_have_the_same_states(self):
        first, one = play(self.session)
        second, two = play(self.session)
        self.assertEqual(one.state_hash, two.state_hash)
        for a, b in zip(first, second):
            b.scene_id = a.scene_id
            self.assertEqual(a, b)

    def test_a_drag_sounds_once_with_the_pitch_of_the_string(self):
        list(self.session.events(timeout=0))
        play(self.session)
        tones = [event.body for event in self.session.events(timeout=0) if event.kind == "tone"]
        self.assertEqual([round(tone.frequency_hz, 1) for tone in tones], [65.4])

    def test_tension_changed_in_flight_is_felt_without_a_step(self):
        self.session.load_scene("single_string")
        self.session.subscribe(divisor=1, sections=["TOOLS"])
        down = [(0.0, 0.012 - 0.0001 * min(tick, 120), 0.0) for tick in range(400)]
        self.session.run(poses=down)
        self.session.set("strings[0].tension_n", 60.0)
        result = self.session.run(poses=[down[-1]] * 100)
        force = [row[1] for row in result.table()["wrench_h_w"]]
        self.assertGreater(force[-1], 1.2 * force[0])
        self.assertLess(max(b - a for a, b in zip(force, force[1:])), 0.05 * force[-1])
        self.assertEqual(self.session.get("strings[0].tension_n"), 60.0)

    def test_a_bad_assignment_changes_nothing_of_its_request(self):
        self.session.load_scene("single_string")
        with self.assertRaises(hapticd.RequestError) as refused:
            self.session.set({"strings[0].tension_n": 40.0, "strings[0].youngs_modulus_pa": -1.0})
        self.assertEqual(refused.exception.path, "strings[0].youngs_modulus_pa")
        self.assertEqual(self.session.get("strings[0].tension_n"), 30.0)
        for path in ("strings[7].tension_n", "strings[0].radius_m", "no_such_field"):
            with self.assertRaises(hapticd.RequestError):
                self.session.set(path, 1.0)


def sweeps(count):
    """A finger at 3 m/s over all strings of strings_100, to and fro: more events than a client acknowledges meanwhile."""
    corners = [(0, 0.03, -0.6)] + [(0, 0.004, -0.6 if k % 2 == 0 else 0.6) for k in range(count + 1)]
    for a, b in zip(corners, corners[1:]):
        ticks = max(1, round(math.dist(a, b) / 3 * 1000))
        for k in range(ticks):
            yield [x + (y - x) * k / ticks for x, y in zip(a, b)]


class ManyEvents(unittest.TestCase):
    """Events faster than they are acknowledged: virtual time waits."""

    @classmethod
    def setUpClass(cls):
        cls.poses = list(sweeps(7))

    def setUp(self):
        self.played = daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "strings_100")
        self.played.__enter__()
        self.addCleanup(self.played.__exit__, None, None, None)

    def play(self, session):
        """(hash, tones, contacts) of the sweeps."""
        session.acquire("test")
        session.load_scene("strings_100")
        list(session.events(timeout=0))
        result = session.run(poses=self.poses)
        self.assertEqual((result.steps, result.held_inputs), (len(self.poses), 0))
        session.ping()
        events = [(event.kind, event.body.t_ns) for event in session.events(timeout=0.2) if event.kind in ("tone", "contact")]
        return result.state_hash, events

    def test_quick_and_slow_clients_get_the_same_bits_and_every_event(self):
        with hapticd.Session(self.played.address, reconnect=False) as session:
            first = self.play(session)
            session.subscribe(divisor=1, sections=["TOOLS"])
            self.assertEqual(self.play(session), first)
        self.assertGreater(len(first[1]), 2000)
        for road in ({"loss": 0.3, "twice": 0.2, "jitter_s": 0.01}, {"loss": 0, "twice": 0, "jitter_s": 0.004}):
            with LossyProxy(self.played.address, **road) as proxy, hapticd.Session(proxy.address, reconnect=False) as session:
                self.assertEqual(self.play(session), first, road)

    def test_who_looks_on_misses_no_event_either_unless_it_hangs(self):
        with hapticd.Session(self.played.address, reconnect=False) as session:
            with hapticd.Session(self.played.address, reconnect=False) as viewer, hapticd.Session(self.played.address, reconnect=False) as hung:
                with hung._connection.changed:
                    hung._connection._stopping = True  # its thread ends: nothing is acknowledged any more
                played = self.play(session)
                viewer.ping()
                events = [(event.kind, event.body.t_ns) for event in viewer.events(timeout=0.2) if event.kind in ("tone", "contact")]
                self.assertEqual(events, played[1])

    def test_a_stop_is_obeyed_while_time_waits(self):
        runner = hapticd.Session(self.played.address, reconnect=False)
        runner.acquire("test")
        runner.poses(self.poses[:4000])
        runner.ping()
        silent = threading.Event()
        send_due = runner._connection._send_due
        runner._connection._send_due = lambda: 0.02 if silent.is_set() else send_due()
        thread = threading.Thread(target=lambda: runner.run(steps=4000))
        with hapticd.Session(self.played.address) as other:
            other.subscribe(1)
            thread.start()
            next(other.states())
            silent.set()  # from here on it acknowledges nothing
            *_, last = other.states(timeout=0.5)  # until time stands still
            waits_at = last.tick
            self.assertTrue(thread.is_alive())
            other.stop()
            self.assertEqual([state.loop_state for state in other.states(timeout=1)][-1], state_pb2.LOOP_STATE_FAULT)
            self.assertEqual(other.latest.tick, waits_at + 1)
            silent.clear()
            thread.join(10)
            self.assertFalse(thread.is_alive())
        runner.close()


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
