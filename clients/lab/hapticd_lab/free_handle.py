"""A handle that nobody holds, in closed loop through the protocol: hands off is the worst case of stability, and the device is computed here, so
that hapticd can be told less delay than there is."""
from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import List

import numpy

import hapticd
from hapticd_lab.player import CONTACTS, ENGAGE_S, SECTIONS, Daemon, Setup, load
from hapticd_lab.states import build_trace
from hapticd_lab.trace import Trace

PERIOD_S = 1e-3
STEPS = 20
"""Of the handle's motion in a tick."""
UP = 1
"""Axis of X_DH that the handle is free in; the others are guided."""


@dataclass(frozen=True)
class Handle:
    """What moves: a mass with viscous damping, pulled down by `weight_n`; forces act `delay_ticks` late and are held for a tick."""

    mass_kg: float
    damping_n_s_per_m: float
    weight_n: float
    delay_ticks: int

    @property
    def stable_n_per_m(self) -> float:
        """Largest stiffness that is stable: b / (T / 2 + t_d) (Colgate and Schenkel 1997, the delay added to the hold)."""
        return self.damping_n_s_per_m / (PERIOD_S * (0.5 + self.delay_ticks))

    def moved(self, height_m: float, speed_m_per_s: float, force_n: float) -> tuple:
        """Height and speed after a tick of this force."""
        step = PERIOD_S / STEPS
        for _ in range(STEPS):
            speed_m_per_s += step * (force_n - self.weight_n - self.damping_n_s_per_m * speed_m_per_s) / self.mass_kg
            height_m += step * speed_m_per_s
        return height_m, speed_m_per_s


def play_free(setup: Setup, start: numpy.ndarray, handle: Handle, ticks: int) -> Trace:
    """The handle is let go at X_DH = `start`, of 7, and falls on what is below it."""
    with Daemon("--clock", "virtual", "--device", "scripted", "--scene", "wall") as daemon:
        with hapticd.Session(daemon.address) as session:
            session.acquire("hapticd-lab")
            load(session, setup)
            session.subscribe(1, SECTIONS, CONTACTS)
            session.run(poses=[start] * int(ENGAGE_S * 1e3), tool_id=setup.tool_id)
            pose, speed = numpy.array(start, float), 0.0
            late = deque([0.0] * handle.delay_ticks)
            states: List = []
            for _ in range(ticks):
                states += session.run(poses=[pose], tool_id=setup.tool_id).states
                late.append(float(states[-1].tools[0].wrench_h_w[UP]))
                pose = pose.copy()
                pose[UP], speed = handle.moved(pose[UP], speed, late.popleft())
            return build_trace(session.scene, states, [], setup.tool_id)
