#!/usr/bin/python3
"""haptic-audio when the server changes under it: sample rate and blocks, overruns. The server is scripted_jack.cpp in the place of libjack, so
that a test says when what changes; what was played is read as samples of the rate that the server had. usage: jack_changes_test.py HAPTIC_AUDIO
SCRIPTED_LIBRARY"""
import os
import struct
import sys
import tempfile
import time
import unittest

import jack_rig
import numpy

from jack_player import DECAY_S, TUNING, Player

LIBRARY = os.path.abspath(sys.argv.pop(1))
LONGEST_S = 60
CLOCKS_S = 0.004
"""How far the client's idea of the server's clock may be off on a busy machine, either way: half of the shortest round trip it has seen."""


class Scripted(Player):
    """haptic-audio with a scripted JACK server, for the length of the block."""

    def __init__(self, *options, rate=48000):
        self.folder = tempfile.TemporaryDirectory(prefix="hapticd-jack-")
        self.out, self.orders = (os.path.join(self.folder.name, name) for name in ("out", "orders"))
        os.mkfifo(self.orders)
        os.symlink(LIBRARY, os.path.join(self.folder.name, "libjack.so.0"))
        jack_rig.ENVIRONMENT.update(LD_LIBRARY_PATH=self.folder.name, SCRIPTED_JACK_OUT=self.out, SCRIPTED_JACK_ORDERS=self.orders,
                                    SCRIPTED_JACK_RATE=str(rate))
        super().__init__("--no-connect", *options)

    def __exit__(self, *error):
        super().__exit__(*error)
        self.blocks = read_blocks(self.out)
        self.folder.cleanup()

    def order(self, line):
        with open(self.orders, "w", encoding="ascii") as orders:
            orders.write(line + "\n")


def read_blocks(path):
    """(rate, begin s of CLOCK_MONOTONIC, samples) of each block."""
    with open(path, "rb") as file:
        data = file.read()
    found, at = [], 0
    while at + 16 <= len(data):
        rate, frames, begin_us = struct.unpack_from("<iiq", data, at)
        found.append((rate, begin_us * 1e-6, numpy.frombuffer(data, "<f4", frames, at + 16).astype(float)))
        at += 16 + 4 * frames
    return found


def runs_of(blocks):
    """Blocks of one rate each, one after the other, as (rate, samples)."""
    runs = []
    for rate, _, samples in blocks:
        if not runs or runs[-1][0] != rate:
            runs.append((rate, []))
        runs[-1][1].append(samples)
    return [(rate, numpy.concatenate(pieces)) for rate, pieces in runs]


def cents_off(samples, rate, frequency, begin_s, window_s=0.25, apart_s=0.15):
    """By how many cents the sine near `frequency` differs from it."""
    def sine(from_s):
        first = int(from_s * rate)
        piece = samples[first:first + int(window_s * rate)]
        return numpy.sum(piece * numpy.hanning(len(piece)) * numpy.exp(-2j * numpy.pi * frequency * numpy.arange(first, first + len(piece)) / rate))
    turn = sine(begin_s + apart_s) / sine(begin_s)
    assert abs(abs(turn) * numpy.exp(apart_s / DECAY_S) - 1) < 0.05, "the sine does not decay as told"
    return 1200 * numpy.log2(1 + numpy.angle(turn) / (2 * numpy.pi * apart_s) / frequency)


def tones_of(samples, rate, count):
    """Begin of each of `count` tones, s, which stand 0.8 s apart: where sound follows on 20 ms of less than a tenth of it."""
    loud = numpy.abs(samples) > 1e-3
    begins, at = [], 0
    while len(begins) < count and loud[at:].any():
        at += int(numpy.argmax(loud[at:]))
        begins.append(at / rate)
        at += int(0.65 * rate)
    return begins


class Changes(unittest.TestCase):
    def play(self, player, strings):
        for string in strings:
            player.tone(string, 1.0)
            time.sleep(0.55)
            player.damp(string)
            time.sleep(0.25)

    def judge(self, samples, rate, strings):
        begins = tones_of(samples, rate, len(strings))
        self.assertEqual(len(begins), len(strings), f"{rate} Hz: tones begin at {begins}")
        for string, begin_s in zip(strings, begins):
            off = cents_off(samples, rate, TUNING[string], begin_s + 0.03)
            self.assertLess(abs(off), 0.1, f"{TUNING[string]} Hz at {rate} Hz is off by {off:.2f} cents")

    def test_the_pitch_stays_whatever_the_sample_rate_is_and_becomes(self):
        for source in ([], ["--synth"]):
            rates = [44100, 48000, 96000, 44100]
            with Scripted("--delay-ms", "100", *source, rate=rates[0]) as player:
                self.play(player, [0, 3, 6])
                for rate in rates[1:]:
                    player.tone(2, 1.0, 3.0)  # rings when the rate changes
                    time.sleep(0.5)
                    player.order(f"rate {rate}")
                    player.wait_for(f"the sample rate has changed: {rate} Hz")
                    time.sleep(0.2)
                    self.play(player, [0, 3, 6])
            self.assertEqual(player.log.count("a client opens"), 1, "what people have connected stays connected")
            runs = runs_of(player.blocks)
            self.assertEqual([rate for rate, _ in runs], rates)
            for rate, samples in runs:
                self.judge(samples, rate, [0, 3, 6])
            self.assertEqual(player.counts()[0], player.counts()[1], player.log)
            self.assertEqual(player.code, 0)

    def test_what_rang_at_the_old_rate_never_sounds_at_another_pitch(self):
        with Scripted("--synth", "--delay-ms", "50") as player:
            player.tone(3, 1.0, 5.0)
            time.sleep(0.4)
            player.order("rate 32000")
            player.wait_for("the sample rate has changed: 32000 Hz")
            time.sleep(0.3)
        (_, before), (_, after) = runs_of(player.blocks)
        self.assertGreater(numpy.abs(before).max(), 0.01)
        self.assertEqual(numpy.abs(after).max(), 0.0)

    def test_a_string_that_rang_before_is_heard_once_and_again_at_another_rate(self):
        player = Scripted("--synth", "--delay-ms", "50")
        world, made = player.model.world, player.model.world._state

        def ringing():
            state = made()
            sounding = {"t_ns": max(0, state.t_ns - 200_000_000), "string_index": 3, "number": 5, "lambda_to": 1, "frequency_hz": TUNING[3],
                        "partials_m": [5e-3], "decays_s": [DECAY_S]}
            state.strings.add(string_index=3, phase="STRING_PHASE_RINGING", radius_m=0.001, sounding=sounding)
            return state
        world._state = ringing
        with player:
            time.sleep(1.0)
            player.order("rate 32000")
            player.wait_for("the sample rate has changed: 32000 Hz")
            time.sleep(1.0)
        runs = runs_of(player.blocks)
        self.assertEqual([rate for rate, _ in runs], [48000, 32000])
        for rate, samples in runs:
            self.judge(samples, rate, [3])
            # Begun once: from its onset on it only decays.
            onset = int(tones_of(samples, rate, 1)[0] * rate)
            window = rate // 20
            loud = [numpy.sqrt(numpy.mean(samples[at:at + window] ** 2)) for at in range(onset + window, len(samples) - window, window)]
            self.assertGreater(len(loud), 8)
            for before, after in zip(loud, loud[1:]):
                self.assertLess(after, before, f"it grows louder again at {rate} Hz")

    def test_a_tone_that_waits_while_the_rate_changes_is_played_at_its_instant(self):
        with Scripted("--synth", "--delay-ms", "1000") as player:
            time.sleep(2.0)  # clocks are exchanged
            instant_s = player.tone(3, 1.0)
            time.sleep(0.2)
            player.order("rate 44100")
            player.wait_for("the sample rate has changed: 44100 Hz")
            time.sleep(1.5)
        self.assertEqual(player.counts()[:2], [1, 1], player.log)
        onset_s = next(begin_s + numpy.argmax(numpy.abs(samples) > 1e-4) / rate + 128 / rate
                       for rate, begin_s, samples in player.blocks if (numpy.abs(samples) > 1e-4).any())
        if player.counts()[2] == 0:  # a busy machine may be late; it is counted then
            self.assertLess(abs(onset_s - instant_s - 1.0), 0.005)
        self.assertGreater(onset_s - instant_s - 1.0, -0.005)

    def test_blocks_that_grow_beyond_the_delay_are_said_with_the_delay_that_would_do(self):
        with Scripted("--synth", "--delay-ms", "8") as player:
            self.assertNotIn("too short", "".join(player.lines))
            player.order("block 1024")  # 2 x 1024 of latency and one block to wait for: 64 ms, and 1 for the network
            player.wait_for("8.0 ms are too short for blocks of 1024, so some tones will be late. Start JACK with smaller ones, or use --delay-ms 65")
            player.order("block 64")
            player.wait_for("8.0 ms suffice for blocks of 64")

    def test_a_delay_that_nobody_has_given_follows_the_blocks_and_says_so(self):
        with Scripted("--synth") as player:
            player.order("block 1024")
            player.wait_for("blocks of 1024 need a delay of 65 ms")
            time.sleep(1.0)
            instants_s = []
            for _ in range(5):
                instants_s.append(player.tone(3, 1.0))
                time.sleep(0.55)
                player.damp(3)
                time.sleep(0.25)
            player.order("block 64")
            player.wait_for("from now on tones are heard 8 ms after they happen")
        blocks = [block for block in player.blocks if len(block[2]) == 1024]
        samples = numpy.concatenate([block[2] for block in blocks])
        onsets_s = []
        for begin_s in tones_of(samples, 48000, 5):
            frame = int(begin_s * 48000)
            onsets_s.append(blocks[frame // 1024][1] + (frame % 1024 + 2048) / 48000)
        self.assertEqual(len(onsets_s), 5)
        for onset_s, instant_s in zip(onsets_s, instants_s):
            self.assertGreater(onset_s - instant_s, 0.065 - CLOCKS_S)
        tones, played, late = player.counts()
        self.assertEqual(tones, played)
        if late == 0:
            self.assertLess(max(onset_s - instant_s for onset_s, instant_s in zip(onsets_s, instants_s)), 0.065 + CLOCKS_S)

    def test_overruns_and_late_tones_are_said_without_being_asked_for(self):
        with Scripted("--synth", "--delay-ms", "0") as player:
            for _ in range(3):
                player.order("xrun")
            player.wait_for("JACK has counted 3 overruns")
        with Scripted("--synth", "--delay-ms", "0") as player:
            player.tone(3, 1.0)
            player.wait_for("1 of 1 tones have been late")


if __name__ == "__main__":
    unittest.main()
