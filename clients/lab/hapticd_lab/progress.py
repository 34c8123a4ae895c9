"""Progress of a long run on stderr: a line for each figure that is done, with the time left; on a terminal also one that is renewed."""
from __future__ import annotations

import sys
from typing import Dict, List, Sequence, Set, TextIO, Tuple

TRUST = 10.0
"""Seconds of work, as estimated, that weigh as much as all that was measured: the first figure alone says little about the rest."""


def duration(seconds: float) -> str:
    """For people: 8 s, 1 min 20 s, 2 h 5 min."""
    whole = max(0, round(seconds))
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s" if whole % 60 else f"{whole // 60} min"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def pace(done: Sequence[Tuple[float, float]]) -> float:
    """How much longer things take here than they are said to: of pairs (said, measured), in seconds."""
    said = sum(cost for cost, _ in done)
    measured = sum(elapsed for _, elapsed in done)
    return (measured + TRUST) / (said + TRUST)


def time_left(waiting: Sequence[float], running: Sequence[Tuple[float, float]], done: Sequence[Tuple[float, float]], jobs: int) -> float:
    """Seconds until all is done: costs of what waits, (cost, elapsed) of what runs and of what is done. What takes longer than
    expected is taken to be nearly done."""
    factor = pace(done)
    rest = [max(factor * cost - elapsed, 0.05 * factor * cost) for cost, elapsed in running]
    work = sum(rest) + factor * sum(waiting)
    longest = max([*rest, *(factor * cost for cost in waiting)], default=0.0)
    return max(work / max(jobs, 1), longest)


class Progress:
    """Writes to `out`; without a terminal nothing but whole lines of plain text."""

    def __init__(self, costs: Dict[str, float], jobs: int, out: TextIO = sys.stderr) -> None:
        self._costs, self._jobs, self._out = costs, jobs, out
        self._done: Set[str] = set()
        self._measured: List[Tuple[float, float]] = []
        self._terminal = out.isatty()

    def _left(self, running: Dict[str, float]) -> float:
        waiting = [cost for name, cost in self._costs.items() if name not in self._done and name not in running]
        return time_left(waiting, [(self._costs[name], elapsed) for name, elapsed in running.items()], self._measured, self._jobs)

    def _line(self, text: str, end: str = "\n") -> None:
        self._out.write(("\r\x1b[K" if self._terminal else "") + text + end)
        self._out.flush()

    def began(self, things: str = "figures") -> None:
        """Before the first figure, or whatever else is counted."""
        self._line(f"{len(self._costs)} {things} in {self._jobs} {'process' if self._jobs == 1 else 'processes'}, "
                   f"about {duration(self._left({}))}")

    def finished(self, name: str, outcome: str, elapsed: float, running: Dict[str, float], counts: bool = True) -> None:
        """A figure is done; `running`: the others by name, with the seconds they have run. `counts`: its time says something about the
        others'; that of one that failed does not."""
        self._done.add(name)
        if counts:
            self._measured.append((self._costs[name], elapsed))
        count, total = len(self._done), len(self._costs)
        rest = f"; about {duration(self._left(running))} left" if count < total else ""
        self._line(f"[{count:{len(str(total))}}/{total}] {name} {outcome}, {duration(elapsed)}{rest}")

    def running(self, running: Dict[str, float]) -> None:
        """Now and then; seen on a terminal only."""
        if self._terminal:
            names = " ".join(f"{name} {duration(elapsed)}" for name, elapsed in running.items())
            self._line(f"[{len(self._done)}/{len(self._costs)}] {names}; about {duration(self._left(running))} left", "")

    def close(self) -> None:
        """The last line stays as it is."""
        if self._terminal:
            self._line("", "")
