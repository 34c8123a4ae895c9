"""Lockstep against the daemon: equal bits from equal sessions, and the chain of hashes recomputed from the States themselves."""
import hashlib
import sys
import unittest

import daemon
import hapticd

CANONICAL = ["TOOLS", "DEVICES", "STRINGS", "CONTACTS", "ENERGY", "QUALITY", "STIFFNESS", "GESTURES"]


def drag(ticks):
    """A finger that rests, comes down beside the string and is dragged over it."""
    return [(0.0, 0.0046, -0.02 + 0.0001 * max(0, tick - 220)) for tick in range(ticks)]


def play(session, ticks=640):
    """(States, hash) of one session."""
    session.load_scene("single_string")
    session.subscribe(divisor=1, sections=CANONICAL, max_contacts=256)
    result = session.run(poses=drag(ticks))
    return list(session.states(result.steps)), result


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
        list(self.session.states(400))
        self.session.set("strings[0].tension_n", 60.0)
        result = self.session.run(poses=[down[-1]] * 100)
        force = [row[1] for row in hapticd.columns(self.session.states(result.steps))["wrench_h_w"]]
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


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
