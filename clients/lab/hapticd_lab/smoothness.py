"""Whether force and torque are smooth, by numbers: change per tick against what the motion of the hand explains, error against the
reference, ripple. Slips, ticks in which an object is lost, are left out and listed."""
from __future__ import annotations

from dataclasses import dataclass
from typing import List, Sequence

import numpy
from scipy import signal

from hapticd_lab.trace import Trace

SLACK = 1.1
LEAST_CHANGE_N = 0.15
RIPPLE_HZ = 30.0
SLIP_TICKS = 2
"""A slip is the tick of the loss and the one after: G may take two ticks to the other side."""


@dataclass
class Smoothness:
    """Change of the force per tick: `change_n` and `bound_n` (n, first 0), `used`: rows that count."""

    change_n: numpy.ndarray
    bound_n: numpy.ndarray
    used: numpy.ndarray

    @property
    def worst(self) -> float:
        """Largest change over its bound."""
        return float((self.change_n / self.bound_n)[self.used].max(initial=0.0))

    def beyond(self, times: float) -> List[int]:
        """Rows that count whose change is more than so many times its bound, the largest first."""
        ratio = numpy.where(self.used, self.change_n / self.bound_n, 0.0)
        return [int(row) for row in numpy.argsort(-ratio) if ratio[row] > times]

    @property
    def worst_row(self) -> int:
        return int(numpy.argmax(numpy.where(self.used, self.change_n / self.bound_n, 0.0)))


def slip_mask(count: int, rows: Sequence[int]) -> numpy.ndarray:
    """n, True in slips."""
    mask = numpy.zeros(count, bool)
    for row in rows:
        mask[row:row + SLIP_TICKS] = True
    return mask


def turn_rad(trace: Trace) -> numpy.ndarray:
    """n, angle that H turns by in each tick."""
    dots = numpy.abs(numpy.sum(trace.q_wh[1:] * trace.q_wh[:-1], axis=1))
    return numpy.concatenate(([0.0], 2.0 * numpy.arccos(numpy.minimum(dots, 1.0))))


def lever_m(trace: Trace) -> float:
    """Longest way from the tool's origin to a contact."""
    levers = [numpy.linalg.norm((points - trace.p_wg_m)[trace.touched(name)], axis=1) for name, points in trace.contact_m.items()]
    return max((float(each.max(initial=0.0)) for each in levers), default=0.0)


def ringing_n_per_s(trace: Trace) -> numpy.ndarray:
    """n, the fastest that the vibration forces of all ringing strings may change: sum of k_v r omega, with r the envelope since the
    release and k_v the largest stiffness a string has in contact."""
    rates = numpy.zeros(len(trace))
    now = trace.t_s + trace.began_s
    for event in trace.events:
        if event.kind == "tone":
            tone = event.body
            age = now - tone.t_ns * 1e-9
            envelope = numpy.where(age >= -1e-3, tone.amplitude_m * numpy.exp(-numpy.maximum(age, 0.0) / tone.decay_s), 0.0)
            rates += trace.contact_stiffness_n_per_m * envelope * 2.0 * numpy.pi * tone.frequency_hz
    return rates


def force_changes(trace: Trace, slip_rows: Sequence[int]) -> Smoothness:
    """|dF| <= max(0.15 N, 1.1 kt |v| dt) + 1.1 k_v r omega dt, v the speed of the fastest contact point of H."""
    period = float(numpy.median(numpy.diff(trace.t_s)))
    change = numpy.concatenate(([0.0], numpy.linalg.norm(numpy.diff(trace.force_n, axis=0), axis=1)))
    way = numpy.concatenate(([0.0], numpy.linalg.norm(numpy.diff(trace.p_wh_m, axis=0), axis=1))) + turn_rad(trace) * lever_m(trace)
    bound = numpy.maximum(LEAST_CHANGE_N, SLACK * trace.kt_n_per_m * way) + SLACK * ringing_n_per_s(trace) * period
    return Smoothness(change, bound, ~slip_mask(len(trace), slip_rows))


def torque_changes(trace: Trace, slip_rows: Sequence[int]) -> Smoothness:
    """The same of the torque: what the force may change by times its lever, and 1.1 kr times the turn."""
    force = force_changes(trace, slip_rows)
    change = numpy.concatenate(([0.0], numpy.linalg.norm(numpy.diff(trace.torque_n_m, axis=0), axis=1)))
    bound = force.bound_n * max(lever_m(trace), trace.length_m) + SLACK * trace.kt_n_per_m * trace.length_m ** 2 * turn_rad(trace)
    return Smoothness(change, bound, force.used)


def reference_error_n(trace: Trace, reference: Trace, slip_rows: Sequence[int]) -> numpy.ndarray:
    """n, |F - F_ref| of the contact, before the safety stage; 0 in slips."""
    error = numpy.linalg.norm(trace.unlimited_force_n - reference.unlimited_force_n, axis=1)
    error[slip_mask(len(trace), slip_rows)] = 0.0
    return error


def ripple(trace: Trace, rows: slice) -> float:
    """Rms above 30 Hz over the mean of |F| in these rows."""
    force = numpy.linalg.norm(trace.force_n[rows], axis=1)
    period = float(numpy.median(numpy.diff(trace.t_s)))
    sections = signal.butter(4, RIPPLE_HZ, "highpass", fs=1.0 / period, output="sos")
    return float(numpy.sqrt(numpy.mean(signal.sosfiltfilt(sections, force) ** 2)) / force.mean())


def longest_touch(trace: Trace, name: str, margin: int = 100) -> slice:
    """Rows of the longest unbroken contact with an object, less `margin` rows at both ends."""
    edges = numpy.flatnonzero(numpy.diff(numpy.concatenate(([0], trace.touched(name).astype(int), [0]))))
    spans: List = sorted(zip(edges[::2], edges[1::2]), key=lambda span: span[1] - span[0])
    begin, end = spans[-1] if spans else (0, 0)
    return slice(int(begin) + margin, int(end) - margin)
