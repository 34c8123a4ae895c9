"""S4.3: whether speed, place, gesture and the string's T, E and R make a difference that can be felt or heard: 5 speeds, 5 places, 3 gestures
and 4 strings, each through the protocol. What Eq. 8-13 put in an order is held to it."""
from __future__ import annotations

import csv
import itertools
import math
import pathlib
from dataclasses import dataclass, fields
from typing import Any, Callable, Dict, List, Sequence, Tuple

import numpy

from hapticd.v1 import event_pb2, scene_pb2
from hapticd_lab import plots
from hapticd_lab.figure import NUMBER, OURS, Figure, Spec, at_least, at_most, is_so
from hapticd_lab.lab import Lab
from hapticd_lab.stimulus import TIP_RADIUS_M, Bench
from hapticd_lab.string_law import StringValues, force_n
from hapticd_lab.trace import Trace

SPEEDS_M_PER_S = (0.05, 0.1, 0.3, 0.6, 1.2)
PLACES = (0.1, 0.2, 0.3, 0.4, 0.5)
TAP, ALONG, CROSS = "tap", "slide along", "cross"
GESTURES = (TAP, ALONG, CROSS)
REFERENCE = StringValues()
STRINGS: Dict[str, StringValues] = {"reference": REFERENCE, **{f"{parameter} + 50 %": REFERENCE.raised(parameter, 0.5) for parameter in "TER"}}
FREQUENCY_HZ = 65.4
DEPTH_M = 0.004
"""Of all gestures: less than the fingertip, so that crossing goes over the string."""
PERCEPTIBLE = 0.07
"""Smaller differences of force are not felt, by Weber's fraction of force as literature gives it."""
SLID_M, CROSSED_M, CLEAR_M, NEAR_M = 0.04, 0.012, 0.012, 0.001
BACK_M_PER_S, LISTEN_M_PER_S = 1.0, 0.2
LISTEN_DEPTH_M, LISTEN_S = 0.001, 0.25
FORCE_ERROR = 0.01
FREQUENCY_ERROR = 0.01
AUDIBLE_M = 2e-4
"""A smaller vibration is not looked for on the force."""
AMPLITUDE_ERROR = 0.05


@dataclass(frozen=True)
class Cell:
    """One presentation and what came of it. NaN: nothing sounded."""

    gesture: str
    speed_m_per_s: float
    place: float
    string: str
    peak_n: float
    r_max_m: float
    level: float
    frequency_hz: float


Key = Tuple[str, float, float, str]
Cells = Dict[Key, Cell]


def _legs(points: Sequence[Tuple[Sequence[float], float]]) -> numpy.ndarray:
    """Places along straight legs, a row each ms: (end, speed) after the first point, whose speed is not used."""
    rows = [numpy.asarray(points[0][0], float)[None, :]]
    for (begin, _), (end, speed) in zip(points[:-1], points[1:]):
        begin, end = numpy.asarray(begin, float), numpy.asarray(end, float)
        count = max(1, math.ceil(round(float(numpy.linalg.norm(end - begin)) / (speed * 1e-3), 6)))  # rounding adds no tick
        rows.append(begin + (end - begin) * numpy.arange(1, count + 1)[:, None] / count)
    return numpy.concatenate(rows)


def path(gesture: str, speed: float, place: float, string: StringValues) -> Tuple[numpy.ndarray, int]:
    """(poses, row at which the gesture is over and the finger returns to listen). The deepest place is a pose of its own at every speed."""
    x, touch = (place - 0.5) * string.length_m, TIP_RADIUS_M + string.radius_m
    above, deep = touch + NEAR_M, touch - DEPTH_M
    legs = {TAP: [((x, above, 0.0), speed), ((x, deep, 0.0), speed), ((x, above, 0.0), speed)],
            ALONG: [((x, above, 0.0), speed), ((x, deep, 0.0), speed), ((x + SLID_M, deep, 0.0), speed), ((x + SLID_M, above, 0.0), speed)],
            CROSS: [((x, deep, -CROSSED_M), speed), ((x, deep, 0.0), speed), ((x, deep, CROSSED_M), speed)]}[gesture]
    played = _legs(legs)
    clear, listen = touch + CLEAR_M, touch - LISTEN_DEPTH_M
    last = played[-1]
    back = _legs([(last, 1.0), ((last[0], clear, last[2]), BACK_M_PER_S), ((x, clear, 0.0), BACK_M_PER_S), ((x, listen, 0.0), LISTEN_M_PER_S)])
    places = numpy.concatenate((played, back[1:], numpy.repeat(back[-1:], round(LISTEN_S * 1e3), axis=0)))
    poses = numpy.zeros((len(places), 7))
    poses[:, :3], poses[:, 3] = places, 1.0
    return poses, len(played)


def _frequency_hz(trace: Trace) -> float:
    """Of the strongest vibration on the force while the finger listens, beyond the string's repulsion."""
    rows = slice(len(trace) - round(LISTEN_S * 1e3), len(trace))
    wave = (trace.unlimited_force_n - sum(trace.object_force_n.values(), numpy.zeros((len(trace), 3))))[rows, 1]
    if numpy.ptp(wave) == 0.0:
        return math.nan
    spectrum = numpy.abs(numpy.fft.rfft((wave - wave.mean()) * numpy.hanning(len(wave)), 32 * len(wave)))
    return float(numpy.fft.rfftfreq(32 * len(wave), 1e-3)[spectrum.argmax()])


def play(bench: Bench, key: Key, change: Callable[[scene_pb2.Scene], None] | None = None) -> Tuple[Cell, Trace]:
    """One presentation."""
    gesture, speed, place, name = key
    poses, over = path(gesture, speed, place, STRINGS[name])
    trace = bench.present(STRINGS[name], poses, sounding=True, change=change)
    until = trace.t_s[over - 1] + 0.02 + trace.began_s
    heard: List[Any] = [event for event in trace.events if event.body.t_ns * 1e-9 <= until]
    amplitude = max((event.body.r_max_m for event in heard if event.kind == "string_radius" and event.body.phase == event_pb2.STRING_RADIUS_PHASE_RELEASE),
                    default=0.0)
    level = max((event.body.level for event in heard if event.kind == "tone"), default=0.0)
    peak = float(numpy.linalg.norm(trace.force_n[:over], axis=1).max())
    return Cell(*key, peak, amplitude, level, _frequency_hz(trace) if amplitude > AUDIBLE_M else math.nan), trace


def _ratios(cells: Cells, of: Callable[[Cell], float], name: str, gestures: Sequence[str] = GESTURES) -> Tuple[float, float]:
    """(smallest, largest) ratio of a raised string to the reference, in all of these gestures, speeds and places."""
    ratios = [of(cells[(*key[:3], name)]) / of(cell) for key, cell in cells.items() if key[3] == "reference" and key[0] in gestures and of(cell) > 0.0]
    return min(ratios), max(ratios)


def _string_claims(figure: Figure, cells: Cells) -> None:
    for name in list(STRINGS)[1:]:
        low, high = _ratios(cells, lambda cell: cell.peak_n, name)
        figure.claims.append(at_least(f"{name}: more force at the same depth, whatever gesture, speed and place: smallest ratio", low, 1.0 + 1e-6, "",
                                      f"up to {high:.3f}"))
        alike = GESTURES if name[0] in "TE" else (TAP, ALONG)
        low, high = _ratios(cells, lambda cell: cell.level, name, alike)
        figure.claims.append(at_least(f"{name}: a louder tone after the same deflection ({', '.join(alike)}): smallest ratio of levels", low, 1.0, "",
                                      f"up to {high:.3f}; level is the string's force at the amplitude that rings on" + (
                                          "" if name[0] in "TE" else "; a thicker string is crossed at other angles, so that its deflection is another one"), OURS))
    low, _ = _ratios(cells, lambda cell: cell.peak_n, "T + 50 %")
    figure.claims.append(at_least("T is felt everywhere: smallest change of force at + 50 %", 100.0 * (low - 1.0), 100.0 * PERCEPTIBLE, "%", source=NUMBER))
    _, high = _ratios(cells, lambda cell: cell.peak_n, "E + 50 %")
    figure.claims.append(is_so("E is felt in no gesture in the middle of the string, as in the paper", all(
        cells[(*key[:3], "E + 50 %")].peak_n / cell.peak_n - 1.0 < PERCEPTIBLE for key, cell in cells.items() if key[3] == "reference" and key[2] == 0.5),
        f"largest change anywhere {100.0 * (high - 1.0):.1f} %", f"below {100.0 * PERCEPTIBLE:.0f} %", source=NUMBER))


def _place_and_speed_claims(figure: Figure, cells: Cells) -> None:
    falling = [cells[(g, v, far, s)].peak_n / cells[(g, v, near, s)].peak_n for g in GESTURES for v in SPEEDS_M_PER_S for s in STRINGS
               for near, far in zip(PLACES[:-1], PLACES[1:])]
    figure.claims.append(at_most("Nearer to an end the string is stiffer: largest ratio of force to that one place nearer", max(falling), 1.0 - 1e-6, ""))
    spread = max(max(cells[(g, v, p, s)].peak_n for v in SPEEDS_M_PER_S) / min(cells[(g, v, p, s)].peak_n for v in SPEEDS_M_PER_S) - 1.0
                 for g in GESTURES for p in PLACES for s in STRINGS)
    figure.claims.append(at_most("Eq. 10 has no speed: force at the same depth and place, largest change with speed", 100.0 * spread, 100.0 * FORCE_ERROR, "%"))
    exact = max(abs(cell.peak_n / float(force_n(STRINGS[key[3]], DEPTH_M, key[2])) - 1.0) for key, cell in cells.items() if key[0] == TAP)
    figure.claims.append(at_most("Largest force of a tap against Eq. 10-12 at its depth", 100.0 * exact, 100.0 * FORCE_ERROR, "%", source=OURS))
    largest = min(cells[(TAP, SPEEDS_M_PER_S[-1], p, s)].r_max_m for p in PLACES for s in STRINGS) / DEPTH_M
    figure.claims.append(at_least("r_max is the largest deflection before the release, as in the paper, where that is fast: r_max over it, taps at "
                                  f"{SPEEDS_M_PER_S[-1]} m/s", largest, 1.0 - FORCE_ERROR, "", "", NUMBER))
    apart = max(abs(cells[(g, SPEEDS_M_PER_S[-1], p, s)].r_max_m / cells[(g, SPEEDS_M_PER_S[0], p, s)].r_max_m - 1.0)
                for g in (TAP, ALONG) for p in PLACES for s in STRINGS)
    figure.claims.append(at_most("r_max is the same at the highest and at the lowest speed, taps and slides: largest difference", apart, AMPLITUDE_ERROR, "",
                                 source=NUMBER))


def _pitch_claims(bench: Bench, figure: Figure, cells: Cells) -> None:
    heard = [cell.frequency_hz for cell in cells.values() if math.isfinite(cell.frequency_hz)]
    worst = max(abs(each / FREQUENCY_HZ - 1.0) for each in heard)
    figure.claims.append(at_most("The strongest vibration on the force is the string's tuning: largest difference", 100.0 * worst, 100.0 * FREQUENCY_ERROR, "%",
                                 f"in {len(heard)} of {len(cells)} presentations something rings; a scene's tuning holds whatever T, E and R are", OURS))
    density = REFERENCE.tension_n / (2.0 * REFERENCE.length_m * FREQUENCY_HZ) ** 2
    found = {}
    for name, string in STRINGS.items():
        def untuned(scene: scene_pb2.Scene, string: StringValues = string) -> None:
            scene.strings[0].ClearField("frequency_hz")
            scene.strings[0].linear_density_kg_per_m = density * (string.radius_m / REFERENCE.radius_m) ** 2

        found[name] = play(bench, (TAP, SPEEDS_M_PER_S[-1], 0.5, name), untuned)[0].frequency_hz
    expected = {name: FREQUENCY_HZ * math.sqrt(string.tension_n / REFERENCE.tension_n) * REFERENCE.radius_m / string.radius_m for name, string in STRINGS.items()}
    worst = max(abs(found[name] / expected[name] - 1.0) for name in STRINGS)
    figure.claims.append(at_most("Without a tuning, of one material: T + 50 % rings higher, R + 50 % lower, E the same: largest difference from sqrt(T / mu) / 2 L",
                                 100.0 * worst, 100.0 * FREQUENCY_ERROR, "%", ", ".join(f"{name} {value:.2f} Hz" for name, value in found.items()), OURS))


AXES = {"speed": (1, SPEEDS_M_PER_S), "place": (2, PLACES)}


QUANTITIES = {"force": "peak_n", "r_max": "r_max_m", "level": "level"}


@dataclass(frozen=True)
class Pair:
    """Two presentations that differ in one thing alone, and by what share each quantity changes from one to the other; NaN from 0 to 0."""

    differs_in: str
    one: Key
    other: Key
    changes: Dict[str, float]

    def imperceptible(self, quantity: str) -> bool:
        """Less than 7 % apart; nothing in both is no difference either."""
        return not abs(self.changes[quantity]) >= PERCEPTIBLE


def _change(one: float, other: float) -> float:
    return other / one - 1.0 if one > 0.0 else math.nan if other == 0.0 else math.inf


def neighbours(cells: Cells) -> List[Pair]:
    """All pairs of neighbours in speed and in place, and each raised string beside the reference."""
    found = []
    for key, cell in cells.items():
        beside = []
        for axis, (index, values) in AXES.items():
            at = values.index(key[index])
            if at + 1 < len(values):
                beside.append((axis, (*key[:index], values[at + 1], *key[index + 1:])))
        if key[3] == "reference":
            beside += [(name, (*key[:3], name)) for name in list(STRINGS)[1:]]
        for axis, other in beside:
            found.append(Pair(axis, key, other, {name: _change(getattr(cell, field), getattr(cells[other], field)) for name, field in QUANTITIES.items()}))
    return found


def _write(folder: pathlib.Path, cells: Cells, pairs: Sequence[Pair]) -> None:
    with open(folder / "differentiation.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        names = [field.name for field in fields(Cell)]
        rows.writerow(names)
        rows.writerows([[getattr(cell, name) for name in names] for cell in cells.values()])
    with open(folder / "neighbours.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(("differs_in", *(f"{name}_{end}" for end in ("one", "other") for name in ("gesture", "speed_m_per_s", "place", "string")),
                       *(f"{name}_{what}" for name in QUANTITIES for what in ("change", "mark"))))
        for pair in pairs:
            marks = itertools.chain.from_iterable((f"{pair.changes[name]:.6g}", "imperceptible" if pair.imperceptible(name) else "") for name in QUANTITIES)
            rows.writerow([pair.differs_in, *pair.one, *pair.other, *marks])


def _tables(figure: Figure, cells: Cells, pairs: Sequence[Pair]) -> None:
    table = [["differs in", "neighbours", *(f"imperceptible, {name} less than 7 % apart" for name in QUANTITIES), "in all three", "largest change of force"]]
    for axis in (*list(STRINGS)[1:], *AXES):
        members = [pair for pair in pairs if pair.differs_in == axis]
        table.append([axis, str(len(members)), *(str(sum(pair.imperceptible(name) for pair in members)) for name in QUANTITIES),
                      str(sum(all(pair.imperceptible(name) for name in QUANTITIES) for pair in members)),
                      f"{100.0 * max(abs(pair.changes['force']) for pair in members):.1f} %"])
    figure.tables["Neighbours that differ in one thing"] = table
    for gesture in GESTURES:
        rows = [["speed, m/s", *(f"lambda {place:g}" for place in PLACES)]]
        for speed in SPEEDS_M_PER_S:
            line = [cells[(gesture, speed, place, "reference")] for place in PLACES]
            rows.append([f"{speed:g}", *(f"{each.peak_n:.2f} N, {1e3 * each.r_max_m:.2f} mm, {each.level:.3f}" for each in line)])
        figure.tables[f"Reference string, {gesture}: largest force, r_max, level"] = rows


def _draw(lab: Lab, figure: Figure, cells: Cells) -> None:
    panels = [plots.Panel("lambda", "largest force, N", [plots.Line(name, PLACES, [cells[(TAP, 0.6, place, name)].peak_n for place in PLACES], "o-") for name in STRINGS],
                          f"tap {1e3 * DEPTH_M:g} mm deep"),
              plots.Panel("speed, m/s", "r_max, mm", [plots.Line(gesture, SPEEDS_M_PER_S, [1e3 * cells[(gesture, speed, 0.3, "reference")].r_max_m
                                                                                          for speed in SPEEDS_M_PER_S], "o-") for gesture in GESTURES],
                          "reference, lambda 0.3", log_x=True)]
    plots.lines("S4.3: what makes a difference", panels).save(lab.folder / "differences")
    figure.pictures["differences.svg"] = "Force by place and string; what rings on by speed and gesture"


def make(lab: Lab, figure: Figure) -> None:
    """All presentations."""
    cells: Cells = {}
    with Bench() as bench:
        for key in itertools.product(GESTURES, SPEEDS_M_PER_S, PLACES, STRINGS):
            cells[key], trace = play(bench, key)
            if key[1:] == (0.6, 0.3, "reference"):
                figure.runs[key[0]] = trace
        _string_claims(figure, cells)
        _place_and_speed_claims(figure, cells)
        _pitch_claims(bench, figure, cells)
    pairs = neighbours(cells)
    _write(lab.folder, cells, pairs)
    _tables(figure, cells, pairs)
    _draw(lab, figure, cells)
    figure.notes.append(f"{len(cells)} presentations, in differentiation.csv; {len(pairs)} pairs that differ in one thing alone, in neighbours.csv. All gestures go "
                        f"{1e3 * DEPTH_M:g} mm deep; after each the finger touches the string lightly to feel what rings on.")


SPECS = [Spec("S4.3", "What makes a difference", "T, E, R, place and speed give diverse sensations; those that differ too little are marked", make, 60.0)]
