"""What a session knows of strings that sound, by events and by States, against messages numbered by hand and decays written out; and the same
over a socket, for one who joins in the middle."""
import math
import random
import unittest

import support
import hapticd
from hapticd.soundings import Soundings
from hapticd.v1 import answer_pb2, event_pb2, state_pb2
from model_server import ModelServer

T0 = 5_000_000_000


def message(number, string=1, partials=(0.003, 0.001), **fields):
    return event_pb2.StringSounding(t_ns=T0, string_index=string, number=number, lambda_to=1, frequency_hz=98, partials_m=partials,
                                    decays_s=(2, 0.5)[:len(partials)], **fields)


def repeating(*soundings, scene_id=1):
    state = state_pb2.State(scene_id=scene_id)
    state.strings.add(string_index=7)
    for sounding in soundings:
        state.strings.add(string_index=sounding.string_index, sounding=sounding)
    return state


class Known(unittest.TestCase):
    def setUp(self):
        self.soundings = Soundings()
        self.soundings.begin(answer_pb2.SceneInfo(scene_id=1))

    def numbers(self):
        return {index: each.number for index, each in self.soundings.by_string.items()}

    def test_the_newest_number_counts_wherever_it_came_from(self):
        for seed in range(support.scaled(200)):
            self.soundings.begin(answer_pb2.SceneInfo(scene_id=1))
            chance = random.Random(seed)
            first = chance.choice([1, 2**31 - 3, 2**32 - 3])
            order = [chance.randrange(8) for _ in range(8)]
            for k in order:
                told = message((first + k) % 2**32)
                if chance.random() < 0.5:
                    self.soundings.take(told)
                else:
                    self.soundings.take_state(repeating(told))
            self.assertEqual(self.numbers(), {1: (first + max(order)) % 2**32})

    def test_what_is_silent_is_not_there_and_a_late_state_does_not_bring_it_back(self):
        self.soundings.take(message(4))
        self.soundings.take(message(5, partials=()))
        self.soundings.take_state(repeating(message(4), message(1, string=0)))
        self.assertEqual(self.numbers(), {0: 1})

    def test_a_message_that_no_string_can_have_changes_nothing(self):
        bad = [message(1, string=1024), message(1, cents_per_s=1e6), message(1, partials=(0.003, 2)), message(1, partials=(math.nan,))]
        for change in (dict(frequency_hz=0), dict(frequency_hz=3e4), dict(decays_s=[2]), dict(decays_s=[2, 0]), dict(decays_s=[2, -1])):
            bad.append(message(1))
            for name in change:
                bad[-1].ClearField(name)
            bad[-1].MergeFrom(event_pb2.StringSounding(**change))
        for told in bad:
            self.soundings.take(told)
            self.assertEqual(hapticd.sounding_at(told, T0 + 10**12).SerializeToString(), told.SerializeToString())
        self.assertEqual(self.numbers(), {})

    def test_another_scene_begins_anew_and_states_of_a_third_say_nothing(self):
        self.soundings.take(message(9))
        self.soundings.begin(answer_pb2.SceneInfo(scene_id=2))
        self.assertEqual(self.numbers(), {})
        self.soundings.take_state(repeating(message(9), scene_id=1))
        self.assertEqual(self.numbers(), {})
        self.soundings.take_state(repeating(message(1), scene_id=2))
        self.assertEqual(self.numbers(), {1: 1})


class CarriedOn(unittest.TestCase):
    def test_partials_decay_each_by_its_own_and_the_pitch_glides_for_100_ms(self):
        told = message(1, cents_per_s=-240, phases_rad=(0.1, 0.2))
        for since_s, cents in ((0.05, -12), (0.1, -24), (0.7, -24)):
            now = hapticd.sounding_at(told, T0 + round(since_s * 1e9))
            self.assertEqual(now.t_ns, T0 + round(since_s * 1e9))
            self.assertAlmostEqual(now.frequency_hz, 98 * math.exp(cents / 1200 * math.log(2)), delta=1e-5)
            for partial, first, decay_s in zip(now.partials_m, (0.003, 0.001), (2, 0.5)):
                self.assertAlmostEqual(partial, first * math.exp(-since_s / decay_s), delta=1e-9)
            self.assertEqual(len(now.phases_rad), 0)
        self.assertEqual(hapticd.sounding_at(told, T0 - 1), told)

    def test_in_two_steps_it_comes_to_the_same_once_the_glide_is_over(self):
        told = message(1, cents_per_s=300)
        once = hapticd.sounding_at(told, T0 + 900_000_000)
        twice = hapticd.sounding_at(hapticd.sounding_at(told, T0 + 200_000_000), T0 + 900_000_000)
        self.assertAlmostEqual(once.frequency_hz, twice.frequency_hz, delta=1e-4)
        self.assertAlmostEqual(once.partials_m[0], twice.partials_m[0], delta=1e-9)


class Joining(unittest.TestCase):
    def test_a_session_that_joins_while_a_string_rings_knows_what_sounds_and_follows_it(self):
        server = ModelServer(virtual=True).start()
        self.addCleanup(server.stop)
        world, made = server.world, server.world._state

        def ringing():
            state = made()
            state.strings.add(string_index=1, sounding=message(6))
            return state
        world._state = ringing
        session = hapticd.Session(f"{server.address[0]}:{server.address[1]}")
        self.addCleanup(session.close)
        session.acquire()
        self.assertEqual(session.soundings, {})
        session.subscribe(divisor=1, sections=["STRINGS"])
        session.run(steps=3)
        self.assertEqual({index: each.number for index, each in session.soundings.items()}, {1: 6})
        for remote in server.remotes.values():
            server.tell(remote, string_sounding=message(7, partials=()))
        self.assertEqual([event.kind for event in session.events(timeout=2.0) if event.kind == "string_sounding"], ["string_sounding"])
        session.run(steps=3)
        self.assertEqual(session.soundings, {})
        session.load_scene("wall")
        session.run(steps=1)
        self.assertEqual([each.number for each in session.soundings.values()], [6])


if __name__ == "__main__":
    unittest.main()
