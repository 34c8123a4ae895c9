"""A string is stopped, plucked, and the stop slides or shakes: what the daemon tells is the pitch of the part, f / (1 - lambda) of a string that does
not stretch, and what haptic-audio makes of the recording sounds so. Truth: that closed form, and the phase of a sine taken out of the sound."""
import array
import cmath
import math
import pathlib
import random
import secrets
import statistics
import subprocess
import sys
import tempfile
import unittest

import daemon
import hapticd

AUDIO = sys.argv.pop()
LENGTH_M, STRING_M, STOP_TIP_M, TIP_M = 1.1, 3.4e-4, 0.015, 0.005
RATE_HZ = 48000
SLIDE_MS, AFTER_MS, SHAKE_M, SHAKE_HZ = 600, 900, 0.004, 4.0
SCENE = ('name: "stopped"\n'
         'tools {{ tool_id: 0 name: "stop" parts {{ name: "p" shape {{ spheres {{ centre_m: [0, 0, 0] radius_m: 0.015 }} }} }} pose_wg {{ p_m: [{x0}, 0.03, 0] }}\n'
         " coupling {{ kt_n_per_m: 1000 length_m: 1 }} }}\n"
         'tools {{ tool_id: 1 name: "plectrum" parts {{ name: "p" shape {{ spheres {{ centre_m: [0, 0, 0] radius_m: 0.005 }} }} }}\n'
         " pose_wg {{ p_m: [{x1}, 0.02, -0.03] }} coupling {{ kt_n_per_m: 1000 length_m: 1 }} }}\n"
         'strings {{ name: "A" p_wa_m: [-0.55, 0, 0] p_wb_m: [0.55, 0, 0] radius_m: 0.00034 axial_stiffness_n: 1 frequency_hz: {hz} decay_s: 2 }}\n'
         "vibration {{}} tones {{}}\n")


def cents(a, b):
    return 1200 * math.log2(a / b)


class Play:
    """What both hands do, row by row: the stop goes down at `begin`, the plectrum plucks beyond it, then the stop moves."""

    def __init__(self, seed):
        draw = random.Random(seed)
        self.hz = draw.uniform(60, 110)
        self.begin = draw.uniform(0.3, 0.5)
        self.pluck = draw.uniform(0.8, 0.92)
        self.depth = draw.uniform(0.004, 0.007)
        way = draw.uniform(-0.1, 0.1)
        shakes = draw.random() < 0.5
        self.where = [self.begin + (SHAKE_M / LENGTH_M * math.sin(2e-3 * math.pi * SHAKE_HZ * k) if shakes else way / LENGTH_M * min(1, k / SLIDE_MS))
                      for k in range(AFTER_MS)]
        down, rest = 120, 200
        stop_y = STOP_TIP_M + STRING_M
        stop = [(self.begin, 0.03 + (stop_y - self.depth - 0.03) * (k + 1) / down) for k in range(down)] + [(self.begin, stop_y - self.depth)] * rest
        away = (0.02, -0.03)
        # The plectrum is as far into the bent string as it would be into a straight one.
        bent = 0.8 * self.depth * (1 - self.pluck) / (1 - self.begin)
        level = TIP_M + STRING_M - 0.0025 - bent
        pluck = [away] * (down + rest) + [(level, -0.03 + 0.06 * (k + 1) / 75) for k in range(75)] + [(0.03, 0.03)]
        stop += [stop[-1]] * (len(pluck) - len(stop))
        self.plucked = len(pluck)
        stop += [(share, stop_y - self.depth) for share in self.where]
        pluck += [pluck[-1]] * len(self.where)
        self.rows = {0: [(self.x(share), y, 0.0) for share, y in stop], 1: [(self.x(self.pluck), y, z) for y, z in pluck]}

    @staticmethod
    def x(share):
        return (share - 0.5) * LENGTH_M

    def scene(self):
        return SCENE.format(x0=self.x(self.begin), x1=self.x(self.pluck), hz=self.hz)

    def truth_hz(self, k):
        """Of the part beyond the stop, `k` ticks after it began to move."""
        return self.hz / (1 - self.where[max(0, min(k, AFTER_MS - 1))])


def reckoned_hz(told, t_ns):
    """What a client goes on with: a glide for at most 100 ms."""
    last = max((each for each in told if each.t_ns <= t_ns), key=lambda each: each.t_ns)
    return last.frequency_hz * 2 ** (last.cents_per_s * min(1e-9 * (t_ns - last.t_ns), 0.1) / 1200)


def heard_hz(sound, at_s, guess_hz):
    """Of the sine near `guess_hz` about an instant: how its phase advances in 10 ms."""
    size, apart = round(0.06 * RATE_HZ), round(0.01 * RATE_HZ)
    first = round(at_s * RATE_HZ) - (size + apart) // 2
    window = [0.5 - 0.5 * math.cos(2 * math.pi * i / size) for i in range(size)]
    for _ in range(3):
        turn = -2j * math.pi * guess_hz / RATE_HZ
        early, late = (sum(window[i] * sound[begin + i] * cmath.exp(turn * (begin + i)) for i in range(size)) for begin in (first, first + apart))
        guess_hz += cmath.phase(late / early) / (2 * math.pi * apart / RATE_HZ)
    return guess_hz


class Stops(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def play(self, play):
        recording = self.folder / "take.mcap"
        recording.unlink(missing_ok=True)
        scene = self.folder / "stopped.textproto"
        scene.write_text(play.scene(), encoding="utf-8")
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", str(scene), "--record", str(recording)) as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                count = len(play.rows[0])
                for first in range(0, count, 500):
                    for tool_id, rows in play.rows.items():
                        session.poses(rows[first:first + 500], first_tick=first, tool_id=tool_id)
                    session.run(min(500, count - first))
                events = list(session.events(timeout=0))
            self.assertEqual(played.end(), 0, played.log)
        # A rendered recording begins with its first event that is heard.
        self.begin_ns = min(e.body.t_ns for e in events if e.kind in ("tone", "string_sounding", "string_radius"))
        return [e.body for e in events if e.kind == "tone"], [e.body for e in events if e.kind == "string_sounding"], recording

    def sound_of(self, recording):
        file = self.folder / "take.wav"
        subprocess.run([AUDIO, "--render", file, "--recording", recording, "--synth"], check=True, capture_output=True)
        wave = file.read_bytes()
        at = wave.index(b"data")
        return array.array("f", wave[at + 8:at + 8 + int.from_bytes(wave[at + 4:at + 8], "little")])

    def check(self, play):
        tones, told, recording = self.play(play)
        self.assertEqual([tone.tool_id for tone in tones], [1])
        tone = tones[0]
        self.assertLess(abs(cents(tone.frequency_hz, play.truth_hz(0))), 8)
        self.assertAlmostEqual(tone.lambda_ if hasattr(tone, "lambda_") else getattr(tone, "lambda"), play.pluck, delta=0.01)
        after = [each for each in told if each.t_ns > tone.t_ns]
        self.assertLess(len(after), 100 * AFTER_MS / 1000)
        sound = self.sound_of(recording)
        flats = []
        for k in range(120, SLIDE_MS + 120, 40):
            if abs(k - SLIDE_MS) < 60:
                continue  # the stop comes to rest within the window
            t_ns = (play.plucked + k) * 1_000_000
            hz = reckoned_hz(after, t_ns)
            self.assertLess(abs(cents(hz, play.truth_hz(k))), 8, f"told {k} ms after the pluck")
            flats.append(cents(heard_hz(sound, 1e-9 * (t_ns - self.begin_ns), hz), play.truth_hz(k)))
        # Flesh holds a string in the air some cents flat; about that the sound follows.
        middle = statistics.median(flats)
        self.assertLess(abs(middle), 8)
        self.assertLess(max(abs(flat - middle) for flat in flats), 8, flats)

    def test_a_stop_that_moves_after_the_pluck_is_told_and_heard_at_its_pitch(self):
        for seed in (1, secrets.randbits(32), secrets.randbits(32)):
            with self.subTest(seed=seed):
                self.check(Play(seed))


if __name__ == "__main__":
    unittest.main(verbosity=2)
