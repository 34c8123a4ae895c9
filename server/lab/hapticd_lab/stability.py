"""Whether a hand on a device and the scene are stable together: no lasting vibration of the contact force, and no more energy given to the
hand than was put in."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy
from scipy import signal

from hapticd_lab.trace import Trace

BAND_HZ = (20.0, 400.0)
"""Below it the hand moves by itself; tremor is at 9 Hz."""
MOST_N = 0.02
WINDOW_S = 0.1
LASTING_WINDOWS = 3
AROUND_SLIP_S = 0.05
PASSIVITY_J = 0.004
"""What the safety stage lets pass before it intervenes."""


@dataclass
class Stability:
    """`vibration_n`: the largest rms in the band that lasts; `energy_j`: most net energy given to the hand; `allowed_j`: what it may be:
    the safety stage's margin, and the modal energy of the strings that sounded."""

    vibration_n: float
    energy_j: float
    allowed_j: float

    @property
    def stable(self) -> bool:
        return self.vibration_n <= MOST_N and self.energy_j <= self.allowed_j


def contact_force(trace: Trace) -> numpy.ndarray:
    """n x 3, rendered force without F_v: what is rendered less what it has beyond the sum of all objects' forces."""
    touched = sum(trace.object_force_n.values(), numpy.zeros((len(trace), 3)))
    return trace.force_n - (trace.unlimited_force_n - touched)


def losses(trace: Trace) -> Sequence[int]:
    """Rows in which an object begins or ceases to bear force: where the force may jump."""
    rows = []
    for name in trace.object_force_n:
        rows += list(numpy.flatnonzero(numpy.diff(trace.touched(name).astype(int))) + 1)
    return sorted(rows)


def measure(trace: Trace, string_energy_j: float) -> Stability:
    """Of a session with a simulated hand. `string_energy_j`: what its strings rang with, all releases together."""
    period = float(numpy.median(numpy.diff(trace.t_s)))
    window = max(1, round(WINDOW_S / period))
    sections = signal.butter(4, BAND_HZ, "bandpass", fs=1.0 / period, output="sos")
    band = signal.sosfiltfilt(sections, contact_force(trace), axis=0)
    quiet = numpy.ones(len(trace), bool)
    around = round(AROUND_SLIP_S / period)
    for row in losses(trace):
        quiet[max(0, row - around):row + around] = False
    squares = numpy.where(quiet, numpy.sum(band ** 2, axis=1), 0.0)
    count = len(trace) // window
    weights = quiet[:count * window].reshape(count, window).sum(axis=1)
    sums = squares[:count * window].reshape(count, window).sum(axis=1)
    rms = numpy.sqrt(numpy.divide(sums, weights, out=numpy.zeros(count), where=weights > window // 2))
    lasting = [float(rms[k:k + LASTING_WINDOWS].min()) for k in range(count - LASTING_WINDOWS + 1)]
    return Stability(max(lasting, default=0.0), float(trace.port_j.max() - trace.port_j[0]), PASSIVITY_J + string_energy_j)


def modal_energy_j(tension_n: float, amplitude_m: float, length_m: float) -> float:
    """E0 = pi^2 T r^2 / (4 L) of a string that rings in its fundamental."""
    return numpy.pi ** 2 * tension_n * amplitude_m ** 2 / (4.0 * length_m)
