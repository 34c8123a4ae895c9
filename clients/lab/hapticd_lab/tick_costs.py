"""What the ticks of a motion cost on the real clock, where a busy machine skips ticks and loses States."""
from __future__ import annotations

from typing import Iterable

import numpy

from hapticd.v1 import state_pb2


class TickCosts:
    """`us`: for each pose, the thread CPU time of the tick that was given it, us; NaN where no State told."""

    def __init__(self, rows: numpy.ndarray) -> None:
        """rows: n x 7, X_DH in the order they are played, a row a tick at most."""
        self.us = numpy.full(len(rows), numpy.nan)
        self._p_m = rows[:, :3]
        self._row = 0
        again = (self._p_m[1:] == self._p_m[:-1]).all(axis=1)
        self._held = numpy.append(again, False) | numpy.insert(again, 0, False)
        self._known_row, self._known_tick = 0, 0

    def take(self, states: Iterable[state_pb2.State]) -> None:
        """Of States in their order, some of which a busy machine may have lost, until the last pose is reached."""
        for state in states:
            if not state.devices:
                continue
            # Since the last row that is known for sure, no more rows than ticks have been played; which row of a held pose it is, no
            # State tells.
            ahead = slice(self._row, self._known_row + state.tick - self._known_tick + 1)
            place = numpy.asarray(state.devices[0].p_dh_m)
            found = numpy.flatnonzero((self._p_m[ahead] == place).all(axis=1) & numpy.isnan(self.us[ahead]))
            if not len(found):
                continue
            self._row += int(found[0])
            self.us[self._row] = state.timing.last_ns * 1e-3
            if not self._held[self._row]:
                self._known_row, self._known_tick = self._row, state.tick
            if self._row == len(self.us) - 1:
                break
