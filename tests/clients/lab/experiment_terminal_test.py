"""hapticctl experiment --live in a pseudo-terminal, as a person runs it: instructions, wall and sphere, every trial, a key that interrupts, the
going on, the five questions. usage: experiment_terminal_test.py HAPTICCTL"""
import csv
import os
import pathlib
import pty
import re
import select
import sys
import tempfile
import time
import unittest

from hapticd_lab import player
from hapticd_lab.published import TABLE_2
from hapticd_lab.trials import plan

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "hapticctl"
PATIENCE_S = 60.0
PRESSES, PRESS_S = 10, 3.0
"""How often and how long after each other a person presses Ctrl-C, at most."""
ANSWERS = (("first", "first"), ("E", "equal"), ("b", "second"), ("=", "equal"), ("2", "second"), ("a", "first"))


class Terminal:
    """A program at a terminal of its own: what it says is read as it comes, what is typed is echoed as a terminal does."""

    def __init__(self, *words):
        self.said, self._read, self._over = "", 0, False
        self._pid, self._terminal = pty.fork()
        if self._pid == 0:
            os.execv(words[0], words)

    def expect(self, pattern):
        """The match in what it says from here on."""
        end = time.monotonic() + PATIENCE_S
        while True:
            match = re.compile(pattern).search(self.said, self._read)
            if match:
                self._read = match.end()
                return match
            if time.monotonic() > end or not self._more():
                raise AssertionError(f"{pattern!r} was not said after: {self.said[self._read:]!r}")

    def interrupt(self, pattern):
        """Ctrl-C until it says so: one that comes between the prompt and the reading of the line is heard with the next key only."""
        presses = 0
        while not re.search(pattern, self.said[self._read:]) and not self._over and presses < PRESSES:
            presses += 1
            self.type("\x03")
            while not re.search(pattern, self.said[self._read:]) and self._more(PRESS_S):
                pass
        self.expect(pattern)

    def _more(self, patience_s=PATIENCE_S):
        if not select.select([self._terminal], [], [], patience_s)[0]:
            return False
        try:
            self.said += os.read(self._terminal, 4096).decode()
            return True
        except OSError:  # the other end is closed
            self._over = True
            return False

    def type(self, text):
        os.write(self._terminal, text.encode())

    def end(self):
        """Exit code, when it has ended."""
        while self._more():
            pass
        status = os.waitpid(self._pid, 0)[1]
        os.close(self._terminal)
        return os.waitstatus_to_exitcode(status)


class Live(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name) / "p1"
        daemon = player.Daemon("--device", "simulated", "--scene", "wall", program=str(pathlib.Path(PROGRAM).resolve().parent / "hapticd"))
        self.addCleanup(daemon.__exit__)
        self.address = daemon.__enter__().address

    def begin(self, *options):
        return Terminal(PROGRAM, "--server", self.address, "experiment", *options, "--output", str(self.folder))

    def rows(self, name):
        with open(self.folder / name, newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def feel(self, terminal, trial):
        for label in "AB":
            terminal.expect(f"Trial {trial}, string {label}: press it")
            terminal.type("\r")
        terminal.expect(r"Which one was stiffer\?.*\) ")

    def test_a_person_goes_through_all_of_it_with_an_interruption_by_key(self):
        terminal = self.begin("--live", "--participant", "P1", "--seed", "5", "--repetitions", "1")
        terminal.expect("First get used to the device.* 9 times")
        for scene in ("wall", "sphere"):
            terminal.expect(f"here is a {scene}")
            terminal.type("\r")
        for trial in range(1, 5):
            self.feel(terminal, trial)
            terminal.type(f"{ANSWERS[trial % 6][0]}\r")
            terminal.expect(f"trial {trial} of 9 is kept")
        terminal.expect("Trial 5, string A")
        terminal.type("engage\r")  # engages anew, and asks again
        self.feel(terminal, 5)
        terminal.interrupt("interrupted; 4 of 9 trials are kept")
        self.assertEqual(terminal.end(), 130)
        self.assertEqual(len(self.rows("trials.csv")), 4)

        terminal = self.begin("--resume")
        terminal.expect("goes on after trial 4")
        for trial in range(5, 10):
            self.feel(terminal, trial)
            if trial == 6:
                terminal.type("neither\r")
                terminal.expect("say first, second or equal")
                terminal.type("again\r")
                self.feel(terminal, 6)
            terminal.type(f"{ANSWERS[trial % 6][0]}\r")
            terminal.expect(f"trial {trial} of 9 is kept")
        for score, metric in enumerate(TABLE_2):
            terminal.expect(f"{metric} \\(.*0 to 100.*: ")
            terminal.type(f"10{score}\r" if score else "\x7f100\r")  # 101 and more are none
            if score:
                terminal.expect("whole number from 0 to 100")
                terminal.type(f"{score}\r")
        terminal.expect("# Experiment of Table 1: P1")
        self.assertEqual(terminal.end(), 0)
        self.check_files()

    def check_files(self):
        rows = self.rows("trials.csv")
        self.assertEqual([row["answer"] for row in rows], [ANSWERS[trial % 6][1] for trial in range(1, 10)])
        planned = [(str(each.trial), each.parameter, f"{each.increment:g}", each.stiffer) for each in plan(5, 1)]
        self.assertEqual([(row["trial"], row["parameter"], row["increment"], row["stiffer"]) for row in rows], planned)
        self.assertEqual([row["score"] for row in self.rows("questionnaire.csv")], ["100", "1", "2", "3", "4"])
        ticks = {path.name for path in (self.folder / "ticks").iterdir()}
        self.assertEqual(ticks, {"wall.csv", "sphere.csv"} | {f"{trial:03}_{label}.csv" for trial in range(1, 10) for label in "AB"})


if __name__ == "__main__":
    unittest.main()
