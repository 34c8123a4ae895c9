"""T2: one objective measure for each of the five metrics that the paper's players scored; and a string that is spoilt on purpose, which the same
measure has to find."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Optional

import numpy

from hapticd.v1 import scene_pb2
from hapticd_lab import smoothness
from hapticd_lab.figure import OURS, Figure, Spec, at_most, is_so
from hapticd_lab.lab import Lab
from hapticd_lab.player import Setup
from hapticd_lab.published import TABLE_2
from hapticd_lab.string_law import StringValues, force_n
from hapticd_lab.trace import Trace

SCENE = "single_string"
TIP_M = 0.005
RADIUS_M = 3.4e-4
LENGTH_M = 1.1
TOUCH_M = TIP_M + RADIUS_M
DEPTH_M = 0.002
STRETCHED_M = 0.006
ABOVE_M = 0.012
RAD_PER_S = 2.0
M_PER_S = 0.1
WARM_UP = 100
"""Rows after the first touch that are left out: the finger arrives."""

Change = Optional[Callable[[scene_pb2.Scene], None]]


def _poses(points: numpy.ndarray) -> numpy.ndarray:
    return numpy.column_stack((points, numpy.ones(len(points)), numpy.zeros((len(points), 3))))


def _line(start: numpy.ndarray, end: numpy.ndarray, speed: float) -> numpy.ndarray:
    count = max(1, round(float(numpy.linalg.norm(end - start)) / speed * 1e3))
    return start + (end - start) * numpy.arange(1, count + 1)[:, None] / count


def _down_to(depth_m: float, x_m: float = 0.0) -> numpy.ndarray:
    return _line(numpy.array([x_m, ABOVE_M, 0.0]), numpy.array([x_m, TOUCH_M - depth_m, 0.0]), M_PER_S)


def orbit() -> numpy.ndarray:
    """Down on the middle of the string, and once round it."""
    angles = numpy.linspace(0.0, 2.0 * numpy.pi, round(2.0 * numpy.pi / RAD_PER_S * 1e3))
    around = (TOUCH_M - DEPTH_M) * numpy.column_stack((numpy.zeros_like(angles), numpy.cos(angles), numpy.sin(angles)))
    return _poses(numpy.concatenate((_down_to(DEPTH_M), around)))


def along() -> numpy.ndarray:
    """Down on the string at three tenths, and along it to seven tenths."""
    start, end = numpy.array([-0.2 * LENGTH_M, TOUCH_M - DEPTH_M, 0.0]), numpy.array([0.2 * LENGTH_M, TOUCH_M - DEPTH_M, 0.0])
    return _poses(numpy.concatenate((_down_to(DEPTH_M, start[0]), _line(start, end, M_PER_S))))


def press() -> numpy.ndarray:
    """Deep down on the middle, slowly."""
    return _poses(_line(numpy.array([0.0, ABOVE_M, 0.0]), numpy.array([0.0, TOUCH_M - STRETCHED_M, 0.0]), 0.02))


def pluck_and_touch() -> numpy.ndarray:
    """Pressed, let go at once, and touched again from above while it rings."""
    pressed, above = numpy.array([0.0, TOUCH_M - 0.002, 0.0]), numpy.array([0.0, ABOVE_M, 0.0])
    again = numpy.array([0.0, TOUCH_M - 0.0015, 0.0])
    return _poses(numpy.concatenate((_down_to(0.002), numpy.repeat(pressed[None], 100, 0), _line(pressed, above, 1.2), _line(above, again, 0.1),
                                     numpy.repeat(again[None], 1500, 0))))


def pressed_rows(trace: Trace) -> slice:
    """Rows from a while after the first touch on."""
    touched = numpy.flatnonzero(numpy.any([trace.touched(name) for name in trace.object_force_n], axis=0))
    return slice(int(touched[0]) + WARM_UP, int(touched[-1]) + 1) if len(touched) else slice(0, 0)


def distance_um(trace: Trace) -> numpy.ndarray:
    """Of the finger's middle from the axis, beyond what touch is and what a tool in motion keeps clear."""
    return (numpy.hypot(trace.p_wg_m[:, 1], trace.p_wg_m[:, 2]) - trace.gap_m - TOUCH_M)[pressed_rows(trace)] * 1e6


def thinness(trace: Trace) -> float:
    """Largest error over its bound, while going round: of the normal (1 degree, from where the hand is) and of the distance (1 um)."""
    rows = pressed_rows(trace)
    out = trace.p_wh_m[rows, 1:] / numpy.linalg.norm(trace.p_wh_m[rows, 1:], axis=1, keepdims=True)
    force = trace.unlimited_force_n[rows]
    cosines = numpy.sum(force[:, 1:] * out, axis=1) / numpy.linalg.norm(force, axis=1)
    angle = numpy.degrees(numpy.arccos(numpy.clip(cosines, -1.0, 1.0))).max(initial=0.0)
    return max(float(angle), float(numpy.abs(distance_um(trace)).max(initial=0.0)))


def ripple_percent(trace: Trace) -> float:
    """Rms of the force above 30 Hz over its mean, sliding along."""
    return 100.0 * smoothness.ripple(trace, pressed_rows(trace))


def law_error_percent(trace: Trace) -> float:
    """Largest difference of force and deflection from Eq. 10, over 1 mm of deflection."""
    deflection = numpy.linalg.norm(trace.p_wh_m - trace.p_wg_m, axis=1) - trace.gap_m
    rows = (numpy.arange(len(trace)) >= pressed_rows(trace).start) & (deflection > 1e-3)
    expected = force_n(StringValues(radius_m=RADIUS_M, length_m=LENGTH_M), deflection[rows], 0.5)
    measured = numpy.linalg.norm(trace.unlimited_force_n[rows], axis=1)
    return 100.0 * float(numpy.abs(measured / expected - 1.0).max(initial=0.0))


def diameter_um(trace: Trace) -> float:
    """Largest difference of the distance from its mean, sliding along."""
    distances = distance_um(trace)
    return float(numpy.abs(distances - distances.mean()).max(initial=0.0)) if len(distances) else numpy.inf


def frequency_error_percent(trace: Trace) -> float:
    """Of the vibration on the force, from the tuning of the installed scene, 65.4 Hz: by the peak of the windowed spectrum."""
    wave = (trace.unlimited_force_n - sum(trace.object_force_n.values()))[:, 1]
    felt = numpy.flatnonzero(numpy.abs(wave) > 1e-4)
    if len(felt) < 500:
        return numpy.inf
    wave = wave[felt[0]:felt[0] + 1000]
    spectrum = numpy.abs(numpy.fft.rfft(wave * numpy.hanning(len(wave)), 64 * len(wave)))
    frequencies = numpy.fft.rfftfreq(64 * len(wave), 1e-3)
    near = (frequencies > 30.0) & (frequencies < 120.0)
    return 100.0 * abs(float(frequencies[near][spectrum[near].argmax()]) / 65.4 - 1.0)


def _coarse_finger(scene: scene_pb2.Scene) -> None:
    spheres = scene.tools[0].parts[0].shape.spheres
    spheres.centre_m[:] = [0.0, 0.002, 0.0, 0.0, -0.002, 0.0, 0.0, 0.0, 0.002, 0.0, 0.0, -0.002]
    spheres.radius_m[:] = [0.003] * 4


def _string_of_beads(scene: scene_pb2.Scene) -> None:
    beads = numpy.arange(-0.3, 0.3, 0.0025)
    body = scene.bodies.add(name="beads")
    body.shape.spheres.centre_m.extend(numpy.column_stack((beads, numpy.zeros((len(beads), 2)))).ravel())
    body.shape.spheres.radius_m.append(RADIUS_M)
    scene.strings[0].p_wa_m[1] = scene.strings[0].p_wb_m[1] = -1.0


def _wrong_modulus(scene: scene_pb2.Scene) -> None:
    scene.strings[0].youngs_modulus_pa *= 1.5


def _tapered(scene: scene_pb2.Scene) -> None:
    for piece in range(8):
        start = -0.28 + 0.07 * piece
        scene.lines.add(name=f"piece_{piece}", points_w_m=[start, 0.0, 0.0, start + 0.07, 0.0, 0.0], radius_m=RADIUS_M + 5e-6 * piece)
    scene.strings[0].p_wa_m[1] = scene.strings[0].p_wb_m[1] = -1.0


def _out_of_tune(scene: scene_pb2.Scene) -> None:
    scene.strings[0].frequency_hz *= 1.005


@dataclass(frozen=True)
class Metric:
    """A metric of Table 2, what is measured for it, and how a string is spoilt so that it fails."""

    name: str
    measured: str
    poses: Callable[[], numpy.ndarray]
    value: Callable[[Trace], float]
    bound: float
    unit: str
    spoilt: str
    spoil: Change


METRICS = (
    Metric("Thin string sensation", "once round the string: the worse of the normal's error in degrees and the distance's in um", orbit, thinness, 1.0, "",
           "a finger of four coarse spheres", _coarse_finger),
    Metric("String smoothness", "sliding along it: rms of the force above 30 Hz over its mean", along, ripple_percent, 2.0, "%",
           "beads in place of the string", _string_of_beads),
    Metric("Elastic sensation", "pressing it 6 mm: error of force over deflection against Eq. 10", press, law_error_percent, 1.0, "%",
           "a modulus half as large again", _wrong_modulus),
    Metric("Diameter constancy", "sliding along it: distance from the axis, largest difference from its mean", along, diameter_um, 1.0, "um",
           "a string that tapers by 35 um", _tapered),
    Metric("Decayed vibration", "touching it while it rings: error of the frequency on the force", pluck_and_touch, frequency_error_percent, 0.1, "%",
           "a string half a per cent out of tune", _out_of_tune),
)


def t2(lab: Lab, figure: Figure) -> None:
    """All five, sound and spoilt."""
    table = [["metric", "players' scores, mean and deviation", "measured", "bound", "sound", "spoilt", "how it was spoilt"]]
    for metric in METRICS:
        trace = lab.play(Setup(SCENE), metric.poses())
        sound = metric.value(trace)
        spoilt = metric.value(lab.play(Setup(SCENE, "PAPER", metric.spoil), metric.poses()))
        figure.claims.append(at_most(f"{metric.name}: {metric.measured}", sound, metric.bound, metric.unit))
        figure.claims.append(is_so(f"{metric.name}: the measure finds a string that is spoilt", spoilt > metric.bound, f"{spoilt:.4g} {metric.unit}".strip(),
                                   f"> {metric.bound:g} {metric.unit}".strip(), metric.spoilt, OURS))
        printed = TABLE_2[metric.name]
        table.append([metric.name, f"{printed.mean} \N{PLUS-MINUS SIGN} {printed.deviation}", metric.measured, f"{metric.bound:g} {metric.unit}".strip(),
                      f"{sound:.3g}", f"{spoilt:.3g}", metric.spoilt])
        figure.runs[metric.name] = trace
    figure.tables["Measures beside the players' scores of 0 to 100"] = table
    figure.notes.append("The paper's players scored what they felt; how near a string comes to these bounds says nothing of what they would score.")


SPECS = [Spec("T2", "The players' five metrics", "high scores for thinness, smoothness, elasticity, constant diameter and decayed vibration", t2, 8.0)]
