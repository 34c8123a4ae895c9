"""The experiment in a page: each ExperimentScreen goes out as a line of JSON, each ExperimentAnswer comes in as one, through haptic-web
(proto/hapticd/v1/experiment.proto). An answer counts for the screen whose number it names, so that a button pressed twice answers once."""
from __future__ import annotations

import json
import os
import select
import sys
from typing import Any, Callable

from google.protobuf import json_format

from hapticd.v1 import experiment_pb2 as wire
from hapticd_lab.observer import EQUAL, FIRST, SECOND
from hapticd_lab.terminal_screen import INSTRUCTIONS, Interrupted

LOOK_S = 0.25
"""How often it is looked whether the answer can still count."""
LONGEST_TEXT = 4000
CHOICES = {wire.EXPERIMENT_REPLY_FIRST: FIRST, wire.EXPERIMENT_REPLY_SECOND: SECOND, wire.EXPERIMENT_REPLY_EQUAL: EQUAL, wire.EXPERIMENT_REPLY_AGAIN: ""}


class PageScreen:
    """`incoming`, `outgoing`: descriptors. What anyone else prints goes to standard error from now on."""

    def __init__(self, participant: str, incoming: int = 0, outgoing: int = 1) -> None:
        self._in, self._out = incoming, outgoing
        self._participant, self._number, self._trials, self._kept, self._notice = participant, 0, 0, 0, ""
        self._read, self._check = b"", lambda: None
        sys.stdout = sys.stderr

    def watch(self, check: Callable[[], None]) -> None:
        """`check` raises when the answer that is waited for cannot count any more."""
        self._check = check

    def _show(self, stage: str, **more: Any) -> None:
        self._number += 1
        screen = wire.ExperimentScreen(number=self._number, stage=getattr(wire, f"EXPERIMENT_STAGE_{stage}"), participant=self._participant,
                                       trials=self._trials, kept=self._kept, notice=self._notice[:400], **more)
        self._notice = ""
        line = (json.dumps(json_format.MessageToDict(screen)) + "\n").encode("utf-8")
        try:
            while line:
                line = line[os.write(self._out, line):]
        except OSError:
            raise Interrupted from None

    def _line(self) -> bytes:
        while b"\n" not in self._read:
            if not select.select([self._in], [], [], LOOK_S)[0]:
                self._check()
                continue
            data = os.read(self._in, 4096)
            if not data:
                raise Interrupted
            self._read += data
        line, _, self._read = self._read.partition(b"\n")
        return line

    def _answer(self, *wanted: int) -> wire.ExperimentAnswer:
        while True:
            try:
                answer = json_format.Parse(self._line(), wire.ExperimentAnswer())
            except (json_format.ParseError, UnicodeDecodeError) as error:
                print(f"no answer: {error}", file=sys.stderr)
                continue
            if answer.number == self._number and answer.reply in wanted:
                return answer

    def instruct(self, trials: int, kept: int) -> None:
        """What is going to happen, and where it goes on."""
        self._trials, self._kept = trials, kept
        self._show("INSTRUCT", text=INSTRUCTIONS.format(trials=trials))
        self._answer(wire.EXPERIMENT_REPLY_NEXT)

    def _touched(self, stage: str, name: str) -> bool:
        self._show(stage, object=name)
        return self._answer(wire.EXPERIMENT_REPLY_NEXT, wire.EXPERIMENT_REPLY_ENGAGE).reply == wire.EXPERIMENT_REPLY_NEXT

    def familiarise(self, scene: str) -> bool:
        """True when the scene was touched as long as was wanted; False: engage, and ask again."""
        return self._touched("FAMILIARISE", scene)

    def touch(self, _trial: int, label: str) -> bool:
        """As familiarise(), with a string."""
        return self._touched("TOUCH", label)

    def choose(self, _trial: int) -> str:
        """first, second or equal; empty: both are felt once more."""
        self._show("COMPARE")
        return CHOICES[self._answer(*CHOICES).reply]

    def rate(self, metric: str, explanation: str) -> int:
        """A slider of the questionnaire, 0 to 100."""
        self._show("RATE", object=metric, text=explanation)
        while True:
            answer = self._answer(wire.EXPERIMENT_REPLY_SCORE)
            if answer.score <= 100:
                return answer.score

    def no_force(self, why: str) -> None:
        """The device does not engage: said with the next screen."""
        self._notice = f"The device does not engage ({why}): move it clear of everything, then press Engage, which clears a fault too."

    def kept(self, trial: int, trials: int) -> None:
        """A trial with its answer is on the disk."""
        self._kept, self._trials = trial, trials

    def done(self, summary: str, folder: str) -> None:
        """All is answered and written to the folder."""
        self._last("DONE", text=summary[:LONGEST_TEXT], folder=folder)

    def stopped(self, why: str) -> None:
        """It ended before its end."""
        print(f"hapticd-lab experiment: {why}", file=sys.stderr)
        self._last("STOPPED", text=why[:LONGEST_TEXT])

    def _last(self, stage: str, **more: Any) -> None:
        try:
            self._show(stage, **more)
        except Interrupted:
            pass  # nobody looks any more; the files are whole
