"""Makes figures, each in a process of its own, as many at once as asked for. A figure that fails, or whose process dies, costs no
other; SIGINT and SIGTERM end what runs and leave what is finished."""
from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import pathlib
import signal
import sys
import time
import traceback
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Sequence

from hapticd_lab.figure import Figure, Spec
from hapticd_lab.outcome import Outcome, write_figure
from hapticd_lab.progress import Progress

RENEW_S = 1.0
"""How often the line on a terminal is renewed."""
END_S = 10.0
"""What a process gets to end hapticd and itself before it is killed."""

LabMaker = Callable[[Spec, pathlib.Path], Any]
"""A context manager for the Lab that a figure is made with, for the figure's folder."""


def make(spec: Spec, folder: pathlib.Path, open_lab: LabMaker) -> Outcome:
    """Makes one figure, here. What it raises becomes the error of the outcome."""
    folder.mkdir(parents=True, exist_ok=True)
    for of_an_earlier_run in ("claims.csv", "error.txt"):
        (folder / of_an_earlier_run).unlink(missing_ok=True)
    figure = Figure(spec.id, spec.title, spec.paper)
    begin = time.monotonic()
    try:
        with open_lab(spec, folder) as lab:
            spec.make(lab, figure)
        outcome = write_figure(figure, spec, folder)
    except Exception as error:  # whatever it is, the other figures are made
        (folder / "error.txt").write_text(traceback.format_exc(), encoding="utf-8")
        outcome = Outcome(spec.id, spec.title, spec.paper, error=f"{type(error).__name__}: {error}".splitlines()[0])
    outcome.elapsed_s = time.monotonic() - begin
    return outcome


def _terminate(*_: Any) -> None:
    sys.exit(128 + signal.SIGTERM)


def _child(spec: Spec, folder: pathlib.Path, open_lab: LabMaker, pipe: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears it, and says SIGTERM
    signal.signal(signal.SIGTERM, _terminate)
    pipe.send(make(spec, folder, open_lab))


@dataclass
class _Running:
    spec: Spec
    process: Any
    pipe: Any
    begin: float

    def outcome(self) -> Outcome:
        """What it sent; or how it died."""
        try:
            found = self.pipe.recv()
        except EOFError:
            self.process.join()
            return Outcome(self.spec.id, self.spec.title, self.spec.paper, error=f"its process ended with {self.process.exitcode}",
                           elapsed_s=time.monotonic() - self.begin)
        self.process.join()
        return found


def _start(spec: Spec, folder: pathlib.Path, open_lab: LabMaker) -> _Running:
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_child, args=(spec, folder, open_lab, theirs), daemon=True)
    process.start()
    theirs.close()
    return _Running(spec, process, ours, time.monotonic())


def _end(running: Sequence[_Running]) -> None:
    for each in running:
        each.process.terminate()
    for each in running:
        each.process.join(END_S)
        if each.process.is_alive():
            each.process.kill()
            each.process.join()


@dataclass
class Made:
    """What make_all did: finished outcomes in the order of the specs, and whether it was interrupted."""

    outcomes: List[Outcome]
    interrupted: bool


def make_all(specs: Sequence[Spec], output: pathlib.Path, jobs: int, open_lab: LabMaker, progress: Progress) -> Made:
    """Makes all figures, the longest first, each in output/ID."""
    waiting = sorted(specs, key=lambda spec: spec.cost_s)
    running: Dict[Any, _Running] = {}
    done: Dict[str, Outcome] = {}
    interrupted = False
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)  # as SIGINT
    progress.began()
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                spec = waiting.pop()
                started = _start(spec, output / spec.id, open_lab)
                running[started.pipe] = started
            for pipe in multiprocessing.connection.wait(list(running), RENEW_S):
                each = running.pop(pipe)
                outcome = done[each.spec.id] = each.outcome()
                progress.finished(each.spec.id, outcome.verdict, outcome.elapsed_s, _elapsed(running), not outcome.error)
            progress.running(_elapsed(running))
    except KeyboardInterrupt:
        interrupted = True
        _end(list(running.values()))
    finally:
        signal.signal(signal.SIGTERM, previous)
        progress.close()
    return Made([done[spec.id] for spec in specs if spec.id in done], interrupted)


def _elapsed(running: Dict[Any, _Running]) -> Dict[str, float]:
    now = time.monotonic()
    return {each.spec.id: now - each.begin for each in running.values()}
