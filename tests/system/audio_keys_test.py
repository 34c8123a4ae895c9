"""haptic-audio with a daemon that has keys: the view key lets it hear a tone and play it to JACK's dummy card; without a key, or with another
daemon's, it hears nothing and says what it
may want."""
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

import daemon
import hapticd

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "clients/audio"), str(pathlib.Path(__file__).resolve().parent / "shows")]
import jack_rig  # noqa: E402
import seven_strings  # noqa: E402

HAPTIC_AUDIO, HAPTICCTL = os.environ["HAPTIC_AUDIO"], os.environ["HAPTICCTL"]


def keys_in(folder):
    subprocess.run([HAPTICCTL, "keygen", str(folder)], check=True, stdout=subprocess.DEVNULL)
    return folder


class Keyed(unittest.TestCase):
    def test_who_has_the_view_key_hears_the_tone_and_nobody_else(self):
        with tempfile.TemporaryDirectory() as folder:
            keys, others = keys_in(pathlib.Path(folder) / "keys"), keys_in(pathlib.Path(folder) / "others")
            with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string", "--keys", str(keys)) as played, \
                    jack_rig.Jack(), \
                    jack_rig.Program(HAPTIC_AUDIO, "--server", played.address, "--synth", "--name", "without") as without, \
                    jack_rig.Program(HAPTIC_AUDIO, "--server", played.address, "--synth", "--name", "wrong", "--key", str(others / "view.key")) as wrong, \
                    jack_rig.Program(HAPTIC_AUDIO, "--server", played.address, "--synth", "--name", "right", "--key", str(keys / "view.key")) as right:
                right.wait_for("hears hapticd")
                for deaf in (without, wrong):
                    deaf.wait_for("give one of them with --key")
                with hapticd.Session(played.address, key=(keys / "control.key").read_bytes()) as session:
                    self.pluck(session)
                time.sleep(1.0)
        self.assertEqual(right.counts()[:2], [1, 1], right.log)
        for deaf in (without, wrong):
            self.assertNotIn("hears hapticd", deaf.log)
            self.assertEqual(deaf.counts()[:2], [0, 0], deaf.log)

    def pluck(self, session):
        session.acquire("test")
        session.load_scene(seven_strings.scene(2.0))
        string = seven_strings.strings()[0]
        above, held = seven_strings.over(string), seven_strings.pressed(string, 0.003)
        session.run(poses=[above] * 300 + seven_strings.towards(above, held) + [held] * 300 + [above] * 100)
        tones = [event for event in session.events(timeout=0.5) if event.kind == "tone"]
        self.assertEqual(len(tones), 1)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
