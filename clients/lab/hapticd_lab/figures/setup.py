"""F14: the player's device, and that the test of stability can fail."""
from __future__ import annotations

import numpy

from hapticd.v1 import scene_pb2
from hapticd_lab import stability
from hapticd_lab.figure import OURS, Figure, Spec, is_so
from hapticd_lab.free_handle import Handle, play_free
from hapticd_lab.lab import Lab
from hapticd_lab.player import Hand, Setup
from hapticd_lab.trace import Trace

SCENE = "guqin"
GESTURE = "slide_on_body"
PRESSED = 6000
"""Row of the gesture that presses the body."""
ABOVE_M = 0.003
"""The handle is let go so high above where the gesture presses the body."""
HANDLE = Handle(mass_kg=0.159, damping_n_s_per_m=1.0, weight_n=1.0, delay_ticks=2)
"""The Phantom Premium without its Coulomb friction, 2 ms late."""
CLAMP = 0.5
"""Share of the stable stiffness that hapticd grants (core/safety/stiffness_clamp.h)."""
TICKS = 4000
SETTLED_S = 2.0
TOO_STIFF = 4.0


def _stability(trace: Trace) -> stability.Stability:
    """Once the handle has had time to come to rest. It cannot slip, so every loss of contact is a bounce and counts."""
    return stability.measure(trace, 0.0, trace.t_s > SETTLED_S)


def _add_control(lab: Lab, figure: Figure) -> None:
    """A handle that nobody holds is laid on the body, at stiffnesses about the clamp's. hapticd is told of no delay, so it grants them all."""
    clamp = CLAMP * HANDLE.stable_n_per_m
    start = numpy.array(lab.poses(GESTURE, SCENE)[PRESSED])
    start[1] += ABOVE_M
    table = figure.tables["A handle of 1 N that nobody holds, laid on the body, 2 ms late"] = [
        ["stiffness, N/m", "of the clamp's", "lasting vibration, mN", "largest force after 2 s, N", "bounces after 2 s", "stable"]]
    stable = {}
    for factor in (0.25, 1.0, TOO_STIFF):
        def coupling(scene: scene_pb2.Scene, stiffness: float = factor * clamp) -> None:
            scene.tools[0].coupling.kt_n_per_m = stiffness

        trace = play_free(Setup(SCENE, "PAPER", coupling), start, HANDLE, TICKS)
        found = _stability(trace)
        stable[factor] = found.stable
        late = trace.t_s > SETTLED_S
        bounces = sum(late[row] for row in stability.switches(trace)) // 2
        table.append([f"{factor * clamp:.0f}", f"{factor:g}", f"{max(found.resting_n, found.sliding_n) * 1e3:.2f}",
                      f"{numpy.linalg.norm(trace.force_n[late], axis=1).max():.2f}", str(bounces), "yes" if found.stable else "no"])
        if factor == TOO_STIFF:
            figure.runs["nobody holds it, four times the clamp"] = trace
    calm = stable[1.0] and stable[0.25]
    figure.claims.append(is_so("At the stiffness clamp a handle that nobody holds comes to rest on the body", calm, "yes" if calm else "no", "yes"))
    figure.claims.append(is_so("Control: at four times the clamp the same test fails", not stable[TOO_STIFF],
                               "it passes" if stable[TOO_STIFF] else "it fails", "it fails", "the clamp is half of b / (T / 2 + t_d), hands off", OURS))


def f14(lab: Lab, figure: Figure) -> None:
    """A simulated hand on a simulated Phantom Premium 3.0, and the handle alone, which four times the clamp is too stiff for."""
    _add_control(lab, figure)
    figure.runs["simulated Phantom Premium 3.0, light hand"] = lab.play_hand(Setup(SCENE, "PAPER"), lab.gesture(GESTURE), Hand())
    figure.notes.append("The paper's player holds a Phantom Premium 3.0 6DoF. hapticd's simulated device has its data sheet's numbers (those that the "
                        "sheet lacks are marked as guesses in deploy/devices), held by an arm of mass, spring, damper and tremor.")

SPECS = [Spec("F14", "The player's device", "a player holds a Phantom Premium 3.0 6DoF; the interaction is stable", f14, 15.0)]
