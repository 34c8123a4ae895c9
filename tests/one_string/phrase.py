"""A phrase for the ear: an open string, a harmonic, a stop that glides up, a vibrato, a stop on a fret. It becomes the sound file of the page, and
its pitch is taken out of the sound and drawn over what the daemon told."""
import struct

import hearing
import numpy as np
from measures import REACH_M, STOP_REACH_M, STOP_TIP_M, partials_at
from playing import LENGTH_M, STRING_M, TICK_NS, Hand, String, line, x_of

RATE_HZ = 22050
PEAK = 0.8
STRING = {"hz": 130.8, "decay_s": 1.33, "loss_n2": 0.015, "stretch_n": 750.0, "touch": ("fret",)}  # as C3 of the Guqin
STOP, TOUCH, PLECTRUM = range(3)
PLUCK_AT, STOP_AT, GLIDE_M, SHAKE_M, SHAKE_HZ = 0.9, 0.4, 0.08, 0.006, 5.0
# So low that the string meets it nowhere else in the phrase, and where the finger presses behind it.
FRET_AT, FRET_BELOW_M, FRET_RADIUS_M, BEHIND_M, PRESSED_M = 0.25, 0.005, 0.001, 0.025, 0.0085
STOP_DEPTH_M, SKIN_N_PER_M, SKIN_M = 0.005, 25.0, 1e-3
AWAY = {STOP: (x_of(STOP_AT), STOP_REACH_M + 0.015, 0.0), TOUCH: (x_of(0.5), REACH_M + 0.01, 0.0), PLECTRUM: (x_of(PLUCK_AT), 3e-3, -0.03)}


def fret():
    """Its text in a scene."""
    x, y = x_of(FRET_AT), -FRET_BELOW_M - STRING_M - FRET_RADIUS_M
    return f'lines {{ name: "fret" radius_m: {FRET_RADIUS_M} points_w_m: [{x!r}, {y!r}, -0.03, {x!r}, {y!r}, 0.03] }}\n'


class Score:
    """Rows of three hands; who is not told otherwise stays where it is."""

    def __init__(self):
        self.rows = {hand: [AWAY[hand]] for hand in AWAY}
        self.words = []  # (ms, what begins)

    def play(self, word=None, **ways):
        """All hands until the longest way is done: stop=..., touch=..., plectrum=..."""
        if word:
            self.words.append((len(self.rows[STOP]), word))
        named = {"stop": STOP, "touch": TOUCH, "plectrum": PLECTRUM}
        longest = max(len(way) for way in ways.values())
        for name, hand in named.items():
            way = list(ways.get(name, ()))
            self.rows[hand] += way + [(way or self.rows[hand])[-1]] * (longest - len(way))

    def wait(self, ms, word=None):
        self.play(word, plectrum=[self.rows[PLECTRUM][-1]] * ms)

    def pluck(self, word, bent=0.0, speed=0.8):
        """With the plectrum, whose height is as far into the string as into a straight one, and back to the near side above the string."""
        x, low = x_of(PLUCK_AT), 3e-3 - bent
        way = line((x, low, -0.03), (x, low, 0.03), speed)
        for goal in ((x, 0.03, 0.03), (x, 0.03, -0.03), (x, low, -0.03)):
            way += line(way[-1], goal, 0.6)
        self.play(word, plectrum=line(self.rows[PLECTRUM][-1], (x, low, -0.03), 0.1) + way)


def compose():
    score = Score()
    score.wait(100)
    score.pluck("open string")
    score.wait(450)
    low = (x_of(0.5), REACH_M - SKIN_M, 0.0)
    score.play("touched at 1/2", touch=line(AWAY[TOUCH], low, 0.1))
    score.wait(300)
    score.pluck("harmonic")
    score.play("lifted", touch=line(low, AWAY[TOUCH], 0.03))
    score.wait(300)
    low = (x_of(STOP_AT), STOP_REACH_M - STOP_DEPTH_M, 0.0)
    score.play("stopped", stop=line(AWAY[STOP], low, 0.1))
    score.wait(200)
    score.pluck("plucked", bent=0.9 * STOP_DEPTH_M * (1 - PLUCK_AT) / (1 - STOP_AT))
    high = (x_of(STOP_AT) + GLIDE_M, low[1], 0.0)
    score.play("glide", stop=line(low, high, GLIDE_M / 0.6))
    score.pluck("plucked", bent=0.9 * STOP_DEPTH_M * (1 - PLUCK_AT) / (1 - STOP_AT - GLIDE_M / LENGTH_M))
    score.play("vibrato", stop=[(high[0] + SHAKE_M * np.sin(2e-3 * np.pi * SHAKE_HZ * k), high[1], 0.0) for k in range(1000)])
    score.wait(200)
    behind = (x_of(FRET_AT) - BEHIND_M, STOP_REACH_M - PRESSED_M, 0.0)
    above, over = (high[0], AWAY[STOP][1], 0.0), (behind[0], AWAY[STOP][1], 0.0)
    score.play("lifted", stop=line(score.rows[STOP][-1], above, 0.1) + line(above, over, 0.6))
    score.play("on a fret", stop=line(over, behind, 0.1))
    score.wait(200)
    score.pluck("plucked", bent=FRET_BELOW_M * (1 - PLUCK_AT) / (1 - FRET_AT))
    score.wait(600)
    return score


def pitch_of(told, t_ns):
    """Hz of what sounds: the first partial that is within 20 dB of the loudest counts as its pitch. NaN where it is silent."""
    past = [each for each in told if each.t_ns <= t_ns]
    if not past:
        return np.nan
    last = max(past, key=lambda each: each.number)
    levels = partials_at(last, t_ns)
    if not len(levels) or levels.max() < 1e-5:
        return np.nan
    first = 1 + int(np.nonzero(levels > 0.1 * levels.max())[0][0])
    return first * last.frequency_hz * 2 ** (last.cents_per_s * min(1e-9 * (t_ns - last.t_ns), 0.1) / 1200)


def write_wav(path, sound):
    """16 bits, one channel."""
    samples = np.round(32767 * PEAK * sound / np.max(np.abs(sound))).astype("<i2").tobytes()
    head = struct.pack("<4sI4s4sIHHIIHH4sI", b"RIFF", 36 + len(samples), b"WAVE", b"fmt ", 16, 1, 1, RATE_HZ, 2 * RATE_HZ, 2, 16, b"data", len(samples))
    path.write_bytes(head + samples)


def measure(stage, path):
    """Plays it, writes the sound, and gives the pitch told and heard."""
    score = compose()
    hands = [Hand(score.rows[STOP], radius=STOP_TIP_M), Hand(score.rows[TOUCH], skin=(SKIN_N_PER_M, 0.2)), Hand(score.rows[PLECTRUM])]
    take = stage.play(hands, [String(**STRING)], fret(), sections=("TOOLS",), record=True)
    end_s = 1e-9 * (len(score.rows[STOP]) * TICK_NS - take.begin_ns)
    sound = stage.render(take, RATE_HZ)[:round(end_s * RATE_HZ)]
    write_wav(path, sound)
    times = np.arange(0.05, end_s - 0.05, 0.01)
    told = [pitch_of(take.told, take.begin_ns + round(1e9 * t)) for t in times]
    heard = [hearing.pitch(sound, RATE_HZ, t) for t in times]
    both = [(float(hearing.cents(b, a)), t) for a, b, t in zip(told, heard, times) if np.isfinite(a) and np.isfinite(b)]
    return {"times": times.tolist(), "told": told, "heard": heard, "words": [(1e-3 * ms - 1e-9 * take.begin_ns, word) for ms, word in score.words],
            "seconds": end_s, "bytes": path.stat().st_size, "tones": len(take.tones), "messages": len(take.told), "kinds": [t.tool_id for t in take.tones],
            "within_10_cents": sum(abs(c) < 10 for c, _ in both) / max(1, len(both)), "looked": len(both), "worst": sorted((abs(c) for c, _ in both), reverse=True)[:1],
            "sound": hearing.outline(sound, RATE_HZ, 0.0, 0.015)}
