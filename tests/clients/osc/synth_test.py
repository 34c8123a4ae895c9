#!/usr/bin/python3
"""The examples of haptic-osc in the programs they are written for: a model of the daemon plucks, haptic-osc sends, SuperCollider or Pd plays to
a JACK server with its dummy card, and what is captured there has the pitch of each string. What is not installed is skipped.
usage: synth_test.py HAPTIC_OSC"""
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import numpy

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
sys.path[:0] = [os.path.join(ROOT, "tests", each) for each in ("clients/audio", "protocol/conformance", "support")]

import jack_rig  # noqa: E402
import skipping  # noqa: E402
from model_server import ModelServer  # noqa: E402

HAPTIC_OSC = sys.argv.pop(1)
EXAMPLES = os.path.join(ROOT, "clients", "osc", "examples")
TUNING = [65.4, 73.4, 87.3, 98.0, 110.0, 130.8, 146.8]
SPACING_S = 0.8
DECAY_S = 0.1
ATTEMPTS = 3


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def pitch(sound, frame, near_hz):
    """Frequency within 30 % of near_hz whose period the sound repeats best, Hz, by correlation with itself; and how well, at most 1."""
    piece = sound.samples[frame:frame + int(0.15 * jack_rig.RATE)]
    lags = range(int(jack_rig.RATE / near_hz / 1.3), int(jack_rig.RATE / near_hz * 1.3))
    alike = [numpy.dot(piece[lag:], piece[:-lag]) / numpy.sqrt(numpy.dot(piece[lag:], piece[lag:]) * numpy.dot(piece[:-lag], piece[:-lag]) + 1e-30)
             for lag in lags]
    best = int(numpy.argmax(alike))
    return jack_rig.RATE / lags[best], alike[best]


class Synth:
    """A synthesizer, in a process group of its own: sclang starts others."""

    def __init__(self, folder, *words, ready):
        environment = dict(jack_rig.ENVIRONMENT, HOME=folder, XDG_RUNTIME_DIR=folder, QT_QPA_PLATFORM="offscreen", QTWEBENGINE_DISABLE_SANDBOX="1")
        self.process = subprocess.Popen(words, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                        start_new_session=True)
        self.ready, self.lines = ready, []

    def __enter__(self):
        for line in self.process.stdout:
            self.lines.append(line)
            if self.ready in line:
                return self
        raise RuntimeError("".join(self.lines))

    def __exit__(self, *_):
        os.killpg(self.process.pid, signal.SIGTERM)
        try:
            self.process.communicate(timeout=10)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.communicate()


class Examples(unittest.TestCase):
    def setUp(self):
        self.model = ModelServer(virtual=False)
        del self.model.world.scene.strings[:]
        for number, frequency in enumerate(TUNING):
            self.model.world.scene.strings.add(name=f"string {number}", frequency_hz=frequency)
        self.model.start()

    def tearDown(self):
        self.model.stop()

    def pluck(self, string):
        t_ns = time.monotonic_ns()
        for remote in self.model.remotes.values():
            self.model.tell(remote, tone={"t_ns": t_ns, "string_index": string, "frequency_hz": TUNING[string], "level": 0.8, "lambda": 0.13,
                                          "decay_s": DECAY_S})
        return t_ns * 1e-9

    def heard(self, port, delay_s):
        """Pitch, how well it repeats, and onset after the pluck, of each string."""
        with jack_rig.Capture(port) as capture:
            time.sleep(0.3)
            plucks = []
            for string in range(len(TUNING)):
                plucks.append(self.pluck(string))
                time.sleep(SPACING_S)
        found = []
        for string, t_s in enumerate(plucks):
            onset = capture.sound.onset(t_s + delay_s, before_s=min(0.05, delay_s), after_s=SPACING_S - 0.3)
            self.assertIsNotNone(onset, f"no sound at pluck {string}")
            found.append((*pitch(capture.sound, onset + int(0.03 * jack_rig.RATE), TUNING[string]), capture.sound.time_of(onset) - t_s))
        return found

    def check(self, port, to, delay_s):
        """Every string is heard in tune; a piece that a busy machine breaks may be played again."""
        host, server_port = self.model.address
        with jack_rig.Program(HAPTIC_OSC, "--server", f"{host}:{server_port}", "--to", to, "--delay", str(delay_s), "--rate", "0") as bridge:
            bridge.wait_for("playing")
            time.sleep(0.5)
            for _ in range(ATTEMPTS):
                found = self.heard(port, delay_s)
                if all(abs(hz / wanted - 1) < 0.02 and alike > 0.8 for (hz, alike, _), wanted in zip(found, TUNING)):
                    break
        delays_ms = [delay * 1e3 for _, _, delay in found]
        print(f"{port}: {' '.join(f'{hz:.1f}' for hz, _, _ in found)} Hz, heard {numpy.median(delays_ms):.1f} ms after the pluck (rms about it "
              f"{numpy.std(delays_ms):.1f} ms)")
        for (hz, alike, _), wanted in zip(found, TUNING):
            self.assertLess(abs(hz / wanted - 1), 0.02, f"{hz} Hz instead of {wanted}")
            self.assertGreater(alike, 0.8)

    @unittest.skipUnless(shutil.which("sclang") and shutil.which("scsynth"), "SuperCollider is not installed")
    def test_supercollider_plays_every_pluck_at_its_pitch(self):
        port = free_port()
        with tempfile.TemporaryDirectory() as folder, jack_rig.Jack(1024), Synth(
                folder, "sclang", "-D", "-u", str(port), os.path.join(EXAMPLES, "haptic.scd"), ready="haptic: listening at port"):
            self.check("SuperCollider:out_1", f"127.0.0.1:{port}", 0.2)

    @unittest.skipUnless(shutil.which("pd"), "Pd is not installed")
    def test_pd_plays_every_pluck_at_its_pitch(self):
        with tempfile.TemporaryDirectory() as folder, jack_rig.Jack(1024), Synth(
                folder, "pd", "-nogui", "-verbose", "-stderr", "-jack", "-noadc", "-channels", "2", "-r", str(jack_rig.RATE),
                os.path.join(EXAMPLES, "haptic.pd"), ready="haptic.pd"):
            time.sleep(2.0)
            self.check("pure_data:output_1", "127.0.0.1:9000", 0)


if __name__ == "__main__":
    skipping.main()
