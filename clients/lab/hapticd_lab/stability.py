"""Whether a hand on a device and the scene are stable together: no lasting vibration of the contact force, and no more energy given to the
hand than was put in."""
from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional

import numpy
from scipy import signal

from hapticd_lab.trace import Trace

BAND_HZ = (20.0, 400.0)
"""Below it the hand moves by itself; tremor is at 9 Hz."""
MOST_N = 0.02
WINDOW_S = 0.1
LASTING_WINDOWS = 3
AROUND_SLIP_S = 0.05
RESTING_M_PER_S = 0.005
"""Slower than this on the average of a window, the hand rests."""
PASSIVITY_J = 0.004
"""What the safety stage lets pass before it intervenes."""


@dataclass
class Stability:
    """`resting_n`, `sliding_n`: the largest rms in the band that lasts, while the hand rests and while it moves; `energy_j`: most net energy
    given to the hand; `allowed_j`: what it may be: the safety stage's margin, and the modal energy of the strings that sounded; `limited`: ticks in
    which the safety stage had to take energy out."""

    resting_n: float
    sliding_n: float
    energy_j: float
    allowed_j: float
    limited: int

    @property
    def stable(self) -> bool:
        return max(self.resting_n, self.sliding_n) <= MOST_N and self.energy_j <= self.allowed_j and self.limited == 0


def contact_force(trace: Trace) -> numpy.ndarray:
    """n x 3, rendered force without F_v: what is rendered less what it has beyond the sum of all objects' forces."""
    touched = sum(trace.object_force_n.values(), numpy.zeros((len(trace), 3)))
    return trace.force_n - (trace.unlimited_force_n - touched)


def switches(trace: Trace) -> List[int]:
    """Rows in which an object begins or ceases to bear force: where the force may jump."""
    rows = []
    for name in trace.object_force_n:
        rows += list(numpy.flatnonzero(numpy.diff(trace.touched(name).astype(int))) + 1)
    return sorted(rows)


def _lasting(squares: numpy.ndarray, counts: numpy.ndarray, window: int) -> float:
    """Largest rms over windows that is kept up for LASTING_WINDOWS of them; windows of which less than half counts are 0."""
    count = len(squares) // window
    weights = counts[:count * window].reshape(count, window).sum(axis=1)
    sums = numpy.where(counts, squares, 0.0)[:count * window].reshape(count, window).sum(axis=1)
    rms = numpy.sqrt(numpy.divide(sums, weights, out=numpy.zeros(count), where=weights > window // 2))
    return max((float(rms[k:k + LASTING_WINDOWS].min()) for k in range(count - LASTING_WINDOWS + 1)), default=0.0)


def apart_from_switches(trace: Trace) -> numpy.ndarray:
    """n, True but around the ticks in which an object begins or ceases to bear force."""
    quiet = numpy.ones(len(trace), bool)
    around = round(AROUND_SLIP_S / float(numpy.median(numpy.diff(trace.t_s))))
    for row in switches(trace):
        quiet[max(0, row - around):row + around] = False
    return quiet


def measure(trace: Trace, string_energy_j: float, quiet: Optional[numpy.ndarray] = None) -> Stability:
    """Of a session with a hand or a free handle. `string_energy_j`: what its strings rang with, all releases together; `quiet`: n, rows that
    count, else those apart from switches."""
    period = float(numpy.median(numpy.diff(trace.t_s)))
    window = max(1, round(WINDOW_S / period))
    sections = signal.butter(4, BAND_HZ, "bandpass", fs=1.0 / period, output="sos")
    squares = numpy.sum(signal.sosfiltfilt(sections, contact_force(trace), axis=0) ** 2, axis=1)
    if quiet is None:
        quiet = apart_from_switches(trace)
    places = numpy.stack([numpy.convolve(column, numpy.ones(window) / window, "same") for column in trace.p_wh_m.T], axis=1)
    resting = numpy.linalg.norm(numpy.gradient(places, period, axis=0), axis=1) < RESTING_M_PER_S
    return Stability(_lasting(squares, quiet & resting, window), _lasting(squares, quiet & ~resting, window),
                     float(trace.port_j.max() - trace.port_j[0]), PASSIVITY_J + string_energy_j,
                     sum("PASSIVITY_LIMITED" in flags for flags in trace.flags))


def modal_energy_j(tension_n: float, amplitude_m: float, length_m: float) -> float:
    """E0 = pi^2 T r^2 / (4 L) of a string that rings in its fundamental."""
    return numpy.pi ** 2 * tension_n * amplitude_m ** 2 / (4.0 * length_m)
