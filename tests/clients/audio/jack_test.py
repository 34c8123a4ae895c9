#!/usr/bin/python3
"""haptic-audio with a real JACK server (its dummy sound card) and a model of the daemon: what is captured, what is said when servers are
not there. usage: jack_test.py HAPTIC_AUDIO

A busy machine drops blocks of the dummy card, and with them pieces of a tone: such a tone is played again. A wrong pitch stays wrong."""
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
import wave

import numpy

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tests", "protocol", "conformance"))

from model_server import ModelServer  # noqa: E402

HAPTIC_AUDIO = sys.argv.pop(1)
RATE = 48000
TUNING = [65.4, 73.4, 87.3, 98.0, 110.0, 130.8, 146.8]
NAMES = ["C2", "D2", "F2", "G2", "A2", "C3", "D3"]
DECAY_S = 0.5  # of the recordings that are shipped
RINGS_S, SPACING_S = 0.5, 0.7  # then a finger damps the string
NAME = f"hapticd-test-{os.getpid()}"
ENVIRONMENT = dict(os.environ, JACK_DEFAULT_SERVER=NAME, JACK_NO_AUDIO_RESERVATION="1", JACK_NO_START_SERVER="1")
FULL = float(os.environ.get("HAPTICD_TEST_SCALE", "0.1")) >= 1


def command(*words, **options):
    return subprocess.Popen(words, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)


class Jack:
    """A JACK server with the dummy card, for the length of the block."""

    def __init__(self, block=4096):
        self.block = block

    def __enter__(self):
        self.process = subprocess.Popen(["jackd", "--no-realtime", "-n", NAME, "-d", "dummy", "-r", str(RATE), "-p", str(self.block)],
                                        env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        subprocess.run(["jack_wait", "-s", NAME, "-w", "-t", "30"], env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                       check=True)
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


class LossySocket:
    """Loses a share of the datagrams of both directions."""

    def __init__(self, socket, share):
        self.socket, self.share, self.random = socket, share, random.Random(1)

    def recvfrom(self, size):
        while True:
            data = self.socket.recvfrom(size)
            if self.random.random() >= self.share:
                return data

    def sendto(self, data, address):
        if self.random.random() >= self.share:
            self.socket.sendto(data, address)

    def close(self):
        self.socket.close()


class Player:
    """haptic-audio, playing what `tone` tells it; `log` has its lines after the block."""

    def __init__(self, *options, loss=0.0):
        self.model = ModelServer(virtual=False)
        self.model.socket = LossySocket(self.model.socket, loss)
        del self.model.world.scene.strings[:]
        for name, frequency in zip(NAMES, TUNING):
            self.model.world.scene.strings.add(name=name, frequency_hz=frequency)
        self.options = options

    def __enter__(self):
        self.model.start()
        host, port = self.model.address
        self.process = command(HAPTIC_AUDIO, "--server", f"{host}:{port}", *self.options)
        self.lines = []
        self.wait_for("hears hapticd")
        return self

    def wait_for(self, text):
        for line in self.process.stdout:
            self.lines.append(line)
            if text in line:
                return
        raise RuntimeError(f"haptic-audio never said '{text}':\n" + "".join(self.lines))

    def tone(self, string, level):
        """Plucks now; the instant on the daemon's clock, s."""
        t_ns = time.monotonic_ns()
        for remote in self.model.remotes.values():
            self.model.tell(remote, tone={"t_ns": t_ns, "string_index": string, "frequency_hz": TUNING[string], "level": level,
                                          "lambda": 0.13, "decay_s": DECAY_S})
        return t_ns * 1e-9

    def damp(self, string):
        """A finger touches the ringing string."""
        for remote in self.model.remotes.values():
            self.model.tell(remote, string_radius={"t_ns": time.monotonic_ns(), "string_index": string, "phase": "STRING_RADIUS_PHASE_DAMP",
                                                   "r_max_m": 1e-3, "decay_s": 0.015})

    def end(self):
        if self.process.poll() is None:
            self.process.terminate()
        self.lines.append(self.process.communicate(timeout=30)[0] or "")
        return self.process.returncode

    def __exit__(self, *_):
        self.code = self.end()
        self.model.stop()
        self.log = "".join(self.lines)

    def counts(self):
        """Tones, played, late."""
        return [int(number) for number in re.search(r"tones (\d+), played (\d+), late (\d+)", self.log).groups()]


def captured(player, plucks):
    """Plays (string, level) one after the other; the sound captured, and the instant of each in it, s."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "captured.wav")
        length = int(len(plucks) * SPACING_S + 4)
        recorder = command("jack_rec", "-f", path, "-d", str(length), "-b", "32", "haptic-audio:out")
        time.sleep(1.0)
        instants = []
        for string, level in plucks:
            instants.append(player.tone(string, level))
            time.sleep(RINGS_S)
            player.damp(string)
            time.sleep(SPACING_S - RINGS_S)
        recorder.communicate(timeout=length + 60)
        with wave.open(path) as file:
            sound = numpy.frombuffer(file.readframes(file.getnframes()), dtype="<i4") / 2.0**31
    first = numpy.argmax(numpy.abs(sound) > 1e-4) / RATE
    return sound, [first + instant - instants[0] for instant in instants]


def sine(sound, frequency, begin_s, length_s):
    first, size = int(begin_s * RATE), int(length_s * RATE)
    piece = sound[first:first + size]
    frames = numpy.arange(first, first + len(piece))
    return numpy.sum(piece * numpy.hanning(len(piece)) * numpy.exp(-2j * numpy.pi * frequency * frames / RATE))


def cents_off(sound, frequency, begin_s):
    """By how many cents the sine near `frequency` differs from it: how its phase advances between two windows. Infinite when its amplitude
    does not decay between them as told: then a piece is missing."""
    turn = sine(sound, frequency, begin_s + 0.12, 0.2) / sine(sound, frequency, begin_s + 0.02, 0.2)
    if abs(abs(turn) * numpy.exp(0.1 / DECAY_S) - 1) > 0.03:
        return numpy.inf
    return 1200 * numpy.log2(1 + numpy.angle(turn) / (2 * numpy.pi * 0.1) / frequency)


def rms(sound, begin_s, length_s=0.3):
    first = int(begin_s * RATE)
    return float(numpy.sqrt(numpy.mean(sound[first:first + int(length_s * RATE)] ** 2)))


def onset(sound, near_s):
    """The first frame that stands out of what was before, s."""
    first = int((near_s - 0.1) * RATE)
    before = max(numpy.max(numpy.abs(sound[max(first - 960, 0):first]), initial=0.0), 1e-6)
    return (first + numpy.argmax(numpy.abs(sound[first:first + int(0.25 * RATE)]) > 1.5 * before)) / RATE


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

    def test_seven_strings_are_captured_in_tune_and_as_loud_as_their_level(self):
        levels = [n / 10 for n in range(1, 11)] if FULL else [0.1, 0.5, 1.0]
        for source in (["--synth"], []):
            left = [(string, level) for level in levels for string in range(7)]
            found = []
            with Jack(), Player(*source, "--delay-ms", "300") as player:
                for _ in range(5):
                    sound, begins = captured(player, left)
                    left, played = [], left
                    for (string, level), about_s in zip(played, begins):
                        begin_s = onset(sound, about_s)
                        if abs(cents_off(sound, TUNING[string], begin_s)) < 1:
                            found.append((level, rms(sound, begin_s)))
                        else:
                            left.append((string, level))
                    if not left:
                        break
            self.assertEqual(left, [], player.log)
            self.assertEqual(player.code, 0)
            self.assertEqual(player.counts()[0], player.counts()[1])
            self.assertNotIn("computed instead", player.log)
            level, loudness = numpy.array(found).T
            slope, intercept = numpy.polyfit(level, loudness, 1)
            rest = loudness - slope * level - intercept
            r_squared = 1 - numpy.sum(rest**2) / numpy.sum((loudness - loudness.mean()) ** 2)
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
        self.assertRegex(player.log, r"8.0 ms are too short .* --delay-ms 257")

    def test_no_tone_is_lost_when_every_fifth_datagram_is_and_the_jitter_is_reported(self):
        count = 100 if FULL else 20
        for loss in (0.0, 0.2):
            with Jack(256), Player("--synth", "--delay-ms", "40", loss=loss) as player:
                time.sleep(2.0)
                sound, begins = captured(player, [(n % 7, 0.5) for n in range(count)])
            tones, played, late = player.counts()
            self.assertEqual((tones, played), (count, count), player.log)
            errors = numpy.array([onset(sound, begin_s) - begin_s for begin_s in begins])
            errors = (errors - numpy.median(errors)) * 1e3
            print(f"loss {loss}: onsets of {count} tones: rms {errors.std():.3f} ms, p99 {numpy.percentile(abs(errors), 99):.3f} ms, "
                  f"{late} late")

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
                sound, begins = captured(player, [(3, 0.5)] * 3)
                best = min(abs(cents_off(sound, TUNING[3], onset(sound, begin_s))) for begin_s in begins)
                self.assertLess(best, 1)


if __name__ == "__main__":
    if any(shutil.which(program) is None for program in ("jackd", "jack_rec", "jack_wait")):
        print("SKIPPED: jackd2 is not installed")
        sys.exit(0)
    unittest.main()
