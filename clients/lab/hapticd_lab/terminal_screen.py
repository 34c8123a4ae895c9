"""The experiment on the terminal: what a person is told and asked, line by line. page_screen.py does the same in a page."""
from __future__ import annotations

import signal
import sys
from typing import Callable

from hapticd_lab.observer import EQUAL, FIRST, SECOND


class Interrupted(Exception):
    """The person ended the session; what was answered is kept."""


INSTRUCTIONS = ("First get used to the device, at a wall and at a sphere. Then two strings, A and B, come one after the other, {trials} times: press each as "
                "often as you like and say which one was stiffer, or that they were equal. At the end there are five questions. You may end at any time: "
                "what was answered is kept.")
CHOICES = {"a": FIRST, "1": FIRST, FIRST: FIRST, "b": SECOND, "2": SECOND, SECOND: SECOND, "e": EQUAL, "=": EQUAL, EQUAL: EQUAL, "again": "", "r": ""}


class TerminalScreen:
    """`ask` and `say`: as input and print are."""

    def __init__(self, ask: Callable[[str], str] = input, say: Callable[[str], None] = print) -> None:
        self._ask_line, self._say = ask, say

    def watch(self, check: Callable[[], None]) -> None:
        """`check` raises when the answer that is waited for cannot count any more: here the caller finds out after it."""

    def _ask(self, question: str) -> str:
        try:
            return self._ask_line(question).strip()
        except EOFError:
            raise Interrupted from None
        except KeyboardInterrupt:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends already, in order
            raise Interrupted from None

    def instruct(self, trials: int, kept: int) -> None:
        """What is going to happen, and where it goes on."""
        self._say(INSTRUCTIONS.format(trials=trials) + (f" It goes on after trial {kept}." if kept else ""))

    def familiarise(self, scene: str) -> bool:
        """True when the scene was touched as long as was wanted; False: engage, and ask again."""
        return self._touched(f"Get used to the device: here is a {scene}. Touch it, press it, slide on it; then press Enter. ")

    def touch(self, trial: int, label: str) -> bool:
        """As familiarise(), with a string."""
        return self._touched(f"Trial {trial}, string {label}: press it; then press Enter. ")

    def _touched(self, question: str) -> bool:
        return self._ask(question).lower() != "engage"

    def choose(self, trial: int) -> str:
        """first, second or equal; empty: both are felt once more."""
        while True:
            given = self._ask("Which one was stiffer? first, second or equal (or: again) ").lower()
            if given in CHOICES:
                return CHOICES[given]
            self._say(f"Trial {trial}: say first, second or equal; or again, to feel both once more.")

    def rate(self, metric: str, explanation: str) -> int:
        """A slider of the questionnaire, 0 to 100."""
        while True:
            given = self._ask(f"{metric} ({explanation}): 0 to 100, 100 is like a real string: ")
            if given.isdecimal() and int(given) <= 100:
                return int(given)
            self._say("Give a whole number from 0 to 100.")

    def no_force(self, why: str) -> None:
        """The device does not engage."""
        self._say(f"The device does not engage ({why}): move it clear of everything, then type engage, which clears a fault too.")

    def kept(self, trial: int, trials: int) -> None:
        """A trial with its answer is on the disk."""
        print(f"trial {trial} of {trials} is kept", flush=True)

    def done(self, summary: str, folder: str) -> None:
        """All is answered and written to the folder."""
        print(summary)

    def stopped(self, why: str) -> None:
        """It ended before its end."""
        print(f"hapticd-lab experiment: {why}", file=sys.stderr)
