"""Who joins while a string rings learns from States what sounds: what everybody was told before, in the first State and ten times a second, and
the States and hashes of those who count on them stay what they were."""
import unittest

import daemon
import hapticd

DRAG_TICKS = 640


def drag(ticks):
    """A finger that rests, comes down beside the string and is dragged over it."""
    return [(0.0, 0.0046, -0.02 + 0.0001 * max(0, tick - 220)) for tick in range(ticks)]


def without_phases(sounding):
    told = type(sounding)()
    told.CopyFrom(sounding)
    told.ClearField("phases_rad")
    return told


class Joining(daemon.LockstepCase):
    def setUp(self):
        self.session.load_scene("single_string")
        list(self.session.events(timeout=0))
        self.told = []
        self.run_on(DRAG_TICKS, poses=drag(DRAG_TICKS))
        self.assertTrue(self.told, "no string was told to sound")

    def run_on(self, steps, **poses):
        """Lets time pass; `told` has the StringSoundings of it."""
        result = self.session.run(**poses) if poses else self.session.run(steps=steps)
        self.told += [event.body for event in result.events if event.kind == "string_sounding"]
        return result

    def join(self, **subscription):
        late = hapticd.Session(self.played.address)
        self.addCleanup(late.close)
        late.subscribe(**subscription)
        return late

    def test_the_first_state_has_what_was_told_last_and_so_has_one_in_100_ms(self):
        late = self.join(divisor=1, sections=["STRINGS"])
        before = self.told[-1]
        self.run_on(350)
        states = list(late.states(count=350, timeout=2.0))
        self.assertEqual([state.tick for state in states], list(range(DRAG_TICKS, DRAG_TICKS + 350)))
        repeated = {state.tick: string.sounding for state in states for string in state.strings if string.HasField("sounding")}
        self.assertEqual(sorted(repeated), [DRAG_TICKS, 700, 800, 900])
        self.assertEqual(repeated[DRAG_TICKS], without_phases(before))
        ends = {state.tick: state.t_ns for state in states}
        for tick, sounding in repeated.items():
            newest = [each for each in self.told if each.t_ns <= ends[tick]][-1]
            self.assertEqual(sounding, without_phases(newest))

    def test_who_joined_late_comes_to_know_the_same_as_who_was_there(self):
        late = self.join(divisor=10, sections=["STRINGS"])
        self.run_on(200)
        list(late.states(count=20, timeout=2.0))
        here, there = self.session.soundings, late.soundings
        self.assertEqual({index: each.number for index, each in here.items()}, {index: each.number for index, each in there.items()})
        now_ns = late.latest.t_ns
        for index, sounding in here.items():
            self.assertEqual(hapticd.sounding_at(sounding, now_ns), hapticd.sounding_at(there[index], now_ns))

    def test_without_strings_nothing_is_repeated_and_the_hash_does_not_know_who_listens(self):
        late = self.join(divisor=1, sections=["TOOLS"])
        alone = self.run_on(50).state_hash
        self.assertFalse(any(state.strings for state in late.states(count=50, timeout=2.0)))
        self.session.load_scene("single_string")
        self.session.run(poses=drag(DRAG_TICKS))
        self.join(divisor=1, sections=["STRINGS"])
        self.assertEqual(self.session.run(steps=50).state_hash, alone)


if __name__ == "__main__":
    unittest.main()
