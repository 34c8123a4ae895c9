"""A live tension moves the pitch of a string whose density is given, as a peg does, and no other's: in its tone and in the vibration that is
felt. Truth: f = sqrt(T / mu) / (2 L)."""
import math
import unittest

import daemon
import hapticd

LENGTH_M = 1.1
DENSITY_KG_PER_M = 1.45e-3
TIP_M, RADIUS_M = 0.005, 3.4e-4
TOUCH_M = TIP_M + RADIUS_M
STRING = (f'strings {{ name: "A" p_wa_m: [{-LENGTH_M / 2}, 0, 0] p_wb_m: [{LENGTH_M / 2}, 0, 0] radius_m: {RADIUS_M} tension_n: 30 decay_s: 100\n'
          " touch_decay_s: 100 max_level: STRING_LEVEL_FUNDAMENTAL %s }\n")
SCENE = (f'name: "tuned"\ntools {{ name: "finger" parts {{ name: "tip" shape {{ spheres {{ centre_m: [0, 0, 0] radius_m: {TIP_M} }} }} }}\n'
         f" pose_wg {{ p_m: [0, {TOUCH_M + 0.012}, 0] }} }}\nvibration {{}}\ntones {{}}\n") + STRING
LISTENING = 600


def line(begin, end, speed_m_per_s):
    ticks = max(1, math.ceil(abs(end - begin) / (speed_m_per_s * 1e-3)))
    return [(0.0, begin + (end - begin) * (k + 1) / ticks, 0.0) for k in range(ticks)]


def pluck():
    """Down on the string, up at once, and back onto it to feel it ring."""
    clear, deep, listen = TOUCH_M + 0.012, TOUCH_M - 0.004, TOUCH_M - 0.001
    rows = line(clear, deep, 0.2) + line(deep, clear, 1.2) + line(clear, listen, 0.2)
    return rows + [rows[-1]] * LISTENING


def strongest_hz(wave):
    """Frequency of the strongest vibration between 30 and 120 Hz, sampled each ms, to 0.05 Hz."""
    mean = sum(wave) / len(wave)
    windowed = [(value - mean) * (1.0 - math.cos(2.0 * math.pi * (k + 0.5) / len(wave))) for k, value in enumerate(wave)]

    def power(hz):
        turn = 2e-3 * math.pi * hz
        return (sum(value * math.cos(turn * k) for k, value in enumerate(windowed)) ** 2
                + sum(value * math.sin(turn * k) for k, value in enumerate(windowed)) ** 2)
    return max((30.0 + 0.05 * k for k in range(1801)), key=power)


class Peg(daemon.LockstepCase):
    def heard(self):
        """(Tone.frequency_hz, frequency felt) of a pluck."""
        list(self.session.events(timeout=0))
        result = self.session.run(poses=pluck())
        tones = [event.body for event in self.session.events(timeout=0) if event.kind == "tone"]
        self.assertEqual(len(tones), 1)
        return tones[0].frequency_hz, strongest_hz([row[1] for row in result.table()["wrench_h_w"]][-LISTENING:])

    def both(self, words, tension_n):
        """What is heard before and after the live tension, and what frequency_hz is told to be then."""
        self.session.load_scene(SCENE % words)
        self.session.subscribe(divisor=1, sections=["TOOLS"])
        before = self.heard()
        self.session.set("strings[0].tension_n", tension_n)
        self.session.run(poses=[(0.0, TOUCH_M + 0.012, 0.0)] * 500)
        return before, self.heard(), self.session.get("strings[0].frequency_hz")

    def check(self, heard, frequency_hz):
        self.assertAlmostEqual(heard[0], frequency_hz, delta=1e-4 * frequency_hz)
        self.assertAlmostEqual(heard[1], frequency_hz, delta=5e-3 * frequency_hz)

    def test_with_a_density_the_tension_tunes(self):
        for words in (f"linear_density_kg_per_m: {DENSITY_KG_PER_M}",
                      f"frequency_hz: {math.sqrt(30.0 / DENSITY_KG_PER_M) / 2.0 / LENGTH_M} tuning: TUNING_TENSION"):
            for tension_n in (20.0, 50.0):
                with self.subTest(words=words, tension_n=tension_n):
                    before, after, told_hz = self.both(words, tension_n)
                    self.check(before, math.sqrt(30.0 / DENSITY_KG_PER_M) / (2.0 * LENGTH_M))
                    truth_hz = math.sqrt(tension_n / DENSITY_KG_PER_M) / (2.0 * LENGTH_M)
                    self.check(after, truth_hz)
                    self.assertAlmostEqual(told_hz, truth_hz, places=6)

    def test_with_a_frequency_the_pitch_holds(self):
        for words in ("frequency_hz: 70", "frequency_hz: 70 tuning: TUNING_FREQUENCY"):
            before, after, told_hz = self.both(words, 50.0)
            self.check(before, 70.0)
            self.check(after, 70.0)
            self.assertEqual(told_hz, 70.0)

    def test_a_pitch_that_follows_is_not_set(self):
        self.session.load_scene(SCENE % f"linear_density_kg_per_m: {DENSITY_KG_PER_M}")
        with self.assertRaises(hapticd.RequestError) as refused:
            self.session.set("strings[0].frequency_hz", 70.0)
        self.assertEqual(refused.exception.path, "strings[0].frequency_hz")
        self.assertIn("tension_n", str(refused.exception))


if __name__ == "__main__":
    unittest.main()
