#!/usr/bin/python3
"""haptic-audio with a real JACK server (its dummy sound card) and a model of the daemon: what is captured, what is said when servers are
not there. usage: jack_test.py HAPTIC_AUDIO

A tone that does not decay as told has been broken by a busy machine and is played again. A wrong pitch stays wrong."""
import json
import os
import pathlib
import sys
import tempfile
import time
import unittest

import jsonschema
import numpy

from jack_player import DECAY_S, HAPTIC_AUDIO, NAMES, TUNING, Player
from jack_rig import Capture, Jack, Program, command, line_through

SCHEMA = pathlib.Path(__file__).resolve().parents[3] / "deploy/schema/audio_ports.schema.json"
RINGS_S, SPACING_S = 0.45, 0.65  # then a finger damps the string
FULL = float(os.environ.get("HAPTICD_TEST_SCALE", "0.1")) >= 1


def captured(player, plucks, rings_s=RINGS_S, spacing_s=SPACING_S):
    """Plays (string, level) one after the other; the sound captured, and the instant of each, s."""
    with Capture() as capture:
        instants = []
        for string, level in plucks:
            instants.append(player.tone(string, level))
            time.sleep(rings_s)
            player.damp(string)
            time.sleep(spacing_s - rings_s)
        time.sleep(0.8)
    return capture.sound, instants


class WithoutServer(unittest.TestCase):
    def test_no_jack_server_is_said_with_the_remedy(self):
        for option in ([], ["--list"]):
            process = command(HAPTIC_AUDIO, *option)
            text, _ = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 3, text)
            self.assertRegex(text, "no JACK server runs. Start one: jackd .*pw-jack haptic-audio")
            self.assertEqual(text.count("\n"), 1, "libjack's own complaints are not shown")

    def test_a_command_line_that_makes_no_sense_ends_with_2(self):
        for options in (["--delay-ms", "-1"], ["--server", "a:b"], ["--synth", "--tones", "x"], ["--recording", "x"], ["--bad"]):
            process = command(HAPTIC_AUDIO, *options)
            text, _ = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 2, text)

    def test_a_bad_file_ends_with_1_and_is_named(self):
        for options in (["--tones", "no_folder"], ["--render", "a.mp3"], ["--render", "no_folder/a.wav"],
                        ["--render", os.devnull + ".wav", "--recording", "no_file.mcap"]):
            process = command(HAPTIC_AUDIO, *options)
            text, _ = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 1, text)
            self.assertRegex(text, "no_folder|a.mp3|no_file.mcap")


class WithServer(unittest.TestCase):
    def test_list_names_the_ports(self):
        with Jack():
            process = command(HAPTIC_AUDIO, "--list")
            text, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, text)
        self.assertRegex(text, r"48000 Hz, blocks of 4096\n(?s:.*)audio hardware  system:playback_1\n")

    def test_the_list_for_programs_is_as_its_schema_says(self):
        with Jack():
            process = command(HAPTIC_AUDIO, "--list", "--json")
            text, _ = process.communicate(timeout=60)
        self.assertEqual((process.returncode, text.count("\n")), (0, 1), text)
        listed = json.loads(text)
        schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
        self.assertEqual(sorted(schema["required"]), sorted(listed))
        self.assertIn({"port": "system:playback_1", "hardware": True}, listed["playback"])
        jsonschema.validate(listed, schema)

    def test_a_daemon_that_is_not_there_is_named_with_the_remedy(self):
        with Jack(), Program(HAPTIC_AUDIO, "--synth", "--server", "127.0.0.1:9") as player:
            player.wait_for("no daemon answers at 127.0.0.1:9 yet; waiting for it. Start hapticd")
        self.assertEqual(player.code, 0)

    def test_seven_strings_are_captured_in_tune_and_as_loud_as_their_level(self):
        levels = [n / 10 for n in range(1, 11)] if FULL else [0.1, 0.5, 1.0]
        for source in (["--synth"], []):
            left = [(string, level) for level in levels for string in range(7)]
            found = []
            with Jack(), Player(*source, "--delay-ms", "300") as player:
                for _ in range(5):
                    sound, instants = captured(player, left)
                    left, played = [], left
                    for (string, level), instant in zip(played, instants):
                        begin = sound.onset(instant + 0.3)
                        if begin is not None and abs(sound.cents_off(TUNING[string], begin, DECAY_S)) < 1:
                            found.append((level, sound.rms(begin)))
                        else:
                            left.append((string, level))
                    if not left:
                        break
            self.assertEqual(left, [], player.log)
            self.assertEqual(player.code, 0)
            self.assertEqual(player.counts()[0], player.counts()[1])
            self.assertNotIn("computed instead", player.log)
            level, loudness = numpy.array(found).T
            r_squared, slope, intercept = line_through(level, loudness)
            print(f"{' '.join(source)} {len(found)} tones: R^2 {r_squared:.5f}, intercept {intercept / slope:.4f}", player.log)
            self.assertGreater(r_squared, 0.99)
            self.assertLess(abs(intercept), 0.02 * slope)

    def test_strings_without_a_recording_are_named_and_computed(self):
        with tempfile.TemporaryDirectory() as folder:
            with Jack(), Player("--tones", folder, "--delay-ms", "300") as player:
                player.tone(0, 1.0)
                time.sleep(0.5)
        for name in NAMES:
            self.assertIn(f"{name}.wav: is missing", player.log)
        self.assertEqual(player.counts()[:2], [1, 1])

    def test_a_delay_that_the_sound_card_cannot_keep_is_said(self):
        with Jack(), Player("--synth", "--delay-ms", "8") as player:
            pass
        self.assertRegex(player.log, r"8.0 ms are too short .* --delay-ms 172")

    def test_no_tone_is_lost_when_every_fifth_datagram_is_and_the_jitter_is_reported(self):
        count = 100 if FULL else 20
        for loss, source in ((0.0, ["--synth"]), (0.2, ["--synth"]), (0.2, [])):
            with Jack(256), Player(*source, "--delay-ms", "40", loss=loss) as player:
                time.sleep(2.0)  # clocks are exchanged
                sound, instants = captured(player, [(n % 7, 0.5) for n in range(count)], 0.1, 0.25)
            tones, played, late = player.counts()
            self.assertEqual((tones, played), (count, count), player.log)
            onsets = [(sound.onset(instant + 0.04), instant) for instant in instants]
            errors_ms = numpy.array([sound.time_of(onset) - instant - 0.04 for onset, instant in onsets if onset is not None]) * 1e3
            print(f"{' '.join(source)} loss {loss}: {len(errors_ms)} onsets of {count} tones: late by {numpy.median(errors_ms):.3f} ms (median), rms "
                  f"{errors_ms.std():.3f} ms, p99 {numpy.percentile(abs(errors_ms - numpy.median(errors_ms)), 99):.3f} ms, {late} late")

    def test_a_jack_server_that_goes_and_comes_again_is_played_on(self):
        with Jack():
            with Player("--synth", "--delay-ms", "300") as player:
                pass
        self.assertEqual(player.code, 0)
        first = Jack().__enter__()
        with Player("--synth", "--delay-ms", "300") as player:
            first.__exit__()
            player.wait_for("the JACK server has gone")
            with Jack():
                player.wait_for("plays by JACK")
                sound, instants = captured(player, [(3, 0.5)] * 3)
                onsets = [sound.onset(instant + 0.3) for instant in instants]
                best = min(abs(sound.cents_off(TUNING[3], onset, DECAY_S)) for onset in onsets if onset is not None)
                self.assertLess(best, 1)


if __name__ == "__main__":
    unittest.main()
