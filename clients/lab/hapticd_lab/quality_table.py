"""The levels of quality, chosen from what a study measured: each on the front of all that could have been chosen, with the error it is bound to and the
work it is; and what is claimed of them, held against the measurements."""
from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Dict, List, Sequence, Tuple

from hapticd_lab.tradeoff_plan import Plan
from hapticd_lab.tradeoff_table import Row, front

DEFAULT = "ladder 32/1"
"""The contact problem's own default is level 3."""
MOST_ERROR = 0.2
"""A rung whose force may be further off in the worst scene, three times what is felt, is no level, however cheap."""
LEAST_ERROR = 1e-7
"""Errors below are rounding of the truth, which has a tolerance too."""
LEAST_STATED = 5e-4
"""No smaller bound is stated: once in some hundred gestures a tool slips another way, whatever the solver does, and no study is long enough to tell how
often. Gestures held out have shown 2.6e-4 where twelve of the study had 2e-5 at most."""
WORSE = 1.05
"""More quality may have this much more error: gestures end up elsewhere."""
LEAST_COST_SPAN, LEAST_ERROR_SPAN = 10.0, 100.0
PENETRATION_M = 1e-6


@dataclass(frozen=True)
class Claim:
    """What is said of the levels, and what was measured."""

    text: str
    measured: str
    holds: bool


@dataclass(frozen=True)
class Point:
    """A setting over all scenes: the bound of its error in the worst of them, and its work as a share of the default's, mean of logarithms."""

    name: str
    error: float
    work: float

    @property
    def knobs(self) -> Tuple[int, float]:
        """Sub-steps and stop tolerance in um, of a rung of the ladder."""
        steps, tolerance = self.name.removeprefix("ladder ").split("/")
        return int(steps), float(tolerance)


class NoLevels(ValueError):
    """The study does not say what levels should be."""


def points(rows: Sequence[Row], names: Sequence[str], unit: str) -> List[Point]:
    """Settings over all scenes that have gestures in touch; work in that of the setting `unit`."""
    by_scene: Dict[str, Dict[str, Row]] = {}
    for row in rows:
        by_scene.setdefault(row.scene, {})[row.setting] = row
    scenes = [own for own in by_scene.values() if own[unit].touching > 0]
    if not scenes:
        raise NoLevels("no gesture touches anything: play more of them, or in other scenes")
    return [Point(name, max(max(own[name].bound, LEAST_ERROR) for own in scenes),
                  math.exp(math.fsum(math.log(own[name].work_mean / own[unit].work_mean) for own in scenes) / len(scenes))) for name in names]


def _front_of(candidates: Sequence[Point]) -> List[Point]:
    return [point for point, good in zip(candidates, front([p.work for p in candidates], [p.error for p in candidates])) if good]


def choose(candidates: Sequence[Point]) -> List[Point]:
    """Five rungs, from the cheapest to the most exact of the front, the default the fourth; those between spread evenly, over error and work alike."""
    on = [point for point in _front_of(candidates) if point.error <= MOST_ERROR]
    default = next((point for point in on if point.name == DEFAULT), None)
    if default is None:
        raise NoLevels(f"the default, {DEFAULT}, is not on the front of {', '.join(p.name for p in on)}: change the default first")
    lowest = min(on, key=lambda p: (p.work, p.error))
    beyond = [p for p in on if p.error < default.error and p.knobs[0] >= default.knobs[0] and p.knobs[1] <= default.knobs[1]]
    highest = min(beyond, key=lambda p: (p.error, p.work), default=default)
    between = [p for p in on if default.error < p.error < lowest.error and lowest.work < p.work < default.work]

    def goes_up(chain: Sequence[Point]) -> bool:
        return all(a.knobs[0] <= b.knobs[0] and a.knobs[1] >= b.knobs[1] and a.error > b.error and a.work < b.work for a, b in zip(chain, chain[1:]))

    def apart(a: Point, b: Point) -> float:
        return math.log(a.error / b.error) / math.log(lowest.error / default.error) + math.log(b.work / a.work) / math.log(default.work / lowest.work)

    def unevenness(chain: Sequence[Point]) -> float:
        steps = [apart(a, b) for a, b in zip(chain, chain[1:])]
        return max(steps) - min(steps)

    chains = [(lowest, a, b, default, highest) for a, b in itertools.permutations(between, 2) if goes_up((lowest, a, b, default, highest))]
    if not chains:
        raise NoLevels(f"no five rungs go up in work and down in error among {', '.join(p.name for p in on)}")
    return list(min(chains, key=lambda chain: unevenness(chain[:4])))


def _settings(rows: Sequence[Row], *knobs: str) -> List[str]:
    return list(dict.fromkeys(row.setting for row in rows if row.knob in knobs))


def _up(value: float) -> str:
    """Two digits, never less than the value."""
    digits = 1 - math.floor(math.log10(value))
    return f"{math.ceil(value * 10 ** digits - 1e-9) / 10 ** digits:.2g}"


def text_of(plan: Plan, rows: Sequence[Row]) -> str:
    """core/scene/quality_levels.inc."""
    names = _settings(rows, "ladder")
    if not names:
        raise NoLevels("a quick study has no ladder to choose levels from: leave out --quick")
    levels = choose(points(rows, names, DEFAULT))
    lines = ["// Levels of quality, 0 first: sub-steps, stop tolerance (m), bound of the force error (rms over rms, in",
             "// the worst scene), work of a tick in touch as a share of the default's. Written by", "//   hapticd-lab tradeoff --write-levels",
             f"// from {plan.gestures} gestures in each of {', '.join(plan.scenes)}", f"// at {' and '.join(f'{v:g}' for v in plan.speeds)} m/s; never by hand."]
    for level in levels:
        steps, tolerance_um = level.knobs
        lines.append(f"{{{steps}, {tolerance_um * 1e-6:g}, {_up(max(level.error, LEAST_STATED))}, {level.work:.3g}}},")
    return "\n".join(lines) + "\n"


def _order_claim(rows: Sequence[Row]) -> Claim:
    worst, where = 0.0, ""
    by = {(row.scene, row.setting): row for row in rows if row.knob == "level"}
    for (scene, setting), row in by.items():
        below = by.get((scene, f"level {int(setting[-1]) - 1}"))
        if below is not None and row.touching > 0:
            ratio = max(row.error, LEAST_ERROR) / max(below.error, LEAST_ERROR)
            if ratio > worst:
                worst, where = ratio, f" ({setting} in {scene})"
    return Claim("more quality never has more than 5 % more error", f"{worst:.3g} times at most{where}", worst <= WORSE)


def _spans(rows: Sequence[Row]) -> List[Claim]:
    most_exact = {row.scene: row for row in rows if row.setting == "level 4"}
    found = []
    for least in rows:
        if least.knob in ("level", "leaves") and least.setting.endswith("level 0") and least.touching > 0:
            most = most_exact[least.scene]
            found.append((most.work_p99 / least.work_p99, max(least.error, LEAST_ERROR) / max(most.error, LEAST_ERROR), least, most))
    cost, _, least, most = max(found, key=lambda each: each[0])
    _, error, off, exact = max(found, key=lambda each: each[1])
    return [Claim("levels, those of geometry included, span 10 times the cost, at the p99 of the work of ticks in touch",
                  f"{cost:.3g} times, from {least.setting} to {most.setting} in {least.scene} (p99.9: {most.work_p999 / least.work_p999:.3g}, "
                  f"median: {most.work_p50 / least.work_p50:.3g})", cost >= LEAST_COST_SPAN),
            Claim("and 100 times the error", f"{error:.3g} times, from {off.setting} to {exact.setting} in {off.scene}", error >= LEAST_ERROR_SPAN)]


def claims_of(rows: Sequence[Row]) -> List[Claim]:
    """All claims about the levels that the rows can tell of."""
    found = [_order_claim(rows), *_spans(rows)]
    names = _settings(rows, "ladder", "level")
    on = {point.name for point in _front_of(points(rows, names, "level 3"))}
    off = [name for name in names if name.startswith("level") and name not in on]
    found.append(Claim("every level is on the front of all rungs, the default among them", f"off it: {', '.join(off) or 'none'}", not off))
    deepest = max((row.penetration_m for row in rows if row.knob != "baseline" and not math.isnan(row.penetration_m)), default=0.0)
    found.append(Claim("nothing is entered on the way, with any setting", f"{1e6 * deepest:.2g} um", deepest <= PENETRATION_M))
    return found
