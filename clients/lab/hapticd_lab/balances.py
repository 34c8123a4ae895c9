"""Whether a step of the force is a snap from one balance to another. A body that is not convex holds a tool at several places for the same hand.
As the hand goes on, the place where the tool is ceases to be a balance, and it falls to the next one: whatever solves the statics steps there.
A snap is known by the hand alone, without the solver: just before it the tool stays for as long as the hand does, and with the hand back there
from beyond it, it does not come back."""
from __future__ import annotations

from dataclasses import dataclass
from typing import List

import numpy

from hapticd_lab.lab import Lab
from hapticd_lab.player import Setup

HELD_TICKS = 400
BEYOND_TICKS = 3
"""How far the hand goes on before it comes back: enough to be over the step, too little for another."""
STILL_N = 0.02
APART = 0.5
"""Two balances differ by this share of the step, at least."""


@dataclass
class Balances:
    """What a hand that rests just before a step feels: `drift_n` over the time it rests, coming from before, and `apart_n` between coming from
    before and from beyond the step."""

    row: int
    step_n: float
    drift_n: float
    apart_n: float

    @property
    def is_snap(self) -> bool:
        return self.drift_n < STILL_N and self.apart_n > APART * self.step_n


def path_to(poses: numpy.ndarray, row: int, beyond: int) -> numpy.ndarray:
    """To the pose before `row`, by way of the `beyond` poses after it and back by the same, and there for a while."""
    out = poses[:row + beyond]
    back = poses[row:row + beyond][::-1]
    return numpy.concatenate([out, back, numpy.repeat(poses[row - 1:row], HELD_TICKS, axis=0)])


def look_for_balances(lab: Lab, setup: Setup, poses: numpy.ndarray, rows: List[int]) -> List[Balances]:
    """Of the steps of the force that the rows begin with, before the safety stage, which would tire of a hand that rests."""
    found = []
    for row in rows:
        before = lab.play(setup, path_to(poses, row, 0)).unlimited_force_n
        beyond = lab.play(setup, path_to(poses, row, BEYOND_TICKS)).unlimited_force_n
        found.append(Balances(row, float(numpy.linalg.norm(beyond[row] - beyond[row - 1])),
                              float(numpy.linalg.norm(before[-1] - before[row - 1])), float(numpy.linalg.norm(before[-1] - beyond[-1]))))
    return found
