"""The programs of clients/README.md: they do what it says, in both languages the same, and it shows them as they are."""
import os
import pathlib
import re
import subprocess
import sys
import unittest

import daemon
import hapticd

SOURCE = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = SOURCE / "clients" / "examples"
TONES = 8


def line(tone):
    return f"string {tone.string_index} sounds at {tone.frequency_hz:.2f} Hz, level {tone.level:.2f}"


class Examples(unittest.TestCase):
    def test_both_hear_each_tone_once_in_order_and_the_touch_before_it(self):
        programs = [[os.environ["HAPTICD_LISTEN"]], [sys.executable, "-B", str(EXAMPLES / "listen.py")]]
        with daemon.Daemon() as played, hapticd.Session(played.address) as session:
            running = [subprocess.Popen([*program, played.address, str(TONES)], stdout=subprocess.PIPE, text=True) for program in programs]
            printed = [process.communicate(timeout=120)[0].splitlines() for process in running]
            played_tones = [line(event.body) for event in session.events(timeout=0) if event.kind == "tone"]
        for process, lines in zip(running, printed):
            self.assertEqual(process.returncode, 0)
            self.assertIn("tool 0 touches", lines)
            heard = [each for each in lines if "sounds" in each]
            self.assertEqual(len(heard), TONES)
            self.assertIn(heard, [played_tones[k:k + TONES] for k in range(len(played_tones))])

    def test_they_are_as_short_as_it_says_and_stand_there_word_for_word(self):
        text = (SOURCE / "clients" / "README.md").read_text(encoding="utf-8")
        blocks = re.findall(r"```(?:cpp|python)\n(.*?)```", text, re.DOTALL)
        for name, longest in (("listen.cpp", 60), ("listen.py", 20)):
            source = (EXAMPLES / name).read_text(encoding="utf-8")
            self.assertLessEqual(len(source.splitlines()), longest)
            self.assertIn(source, blocks)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
