"""What the units of a study come to: a row for each scene and setting, sums over all gestures and speeds; which of them are on the front, where
less error costs more; and the knee of it. Work and errors are the same on every machine, times are not and stand apart."""
from __future__ import annotations

import csv
import math
import pathlib
from dataclasses import dataclass, field
from typing import Any, Dict, List, Sequence

import numpy

from hapticd_lab.tradeoff_plan import BASELINES, Plan
from hapticd_lab.tradeoff_units import read_unit

BINS_PER_OCTAVE = 16
"""Of the histograms that hapticd-oracle measure writes."""
DISCRIMINATION = 0.07
"""Share of a force by which another must differ to be told apart (L. A. Jones, "Matching forces", Perception, 1989)."""
SLACK = 0.02
"""Points whose cost differs by less are of one cost."""
RESAMPLES = 400
CONFIDENCE = 0.975
"""The stated bound is this quantile of the error over gestures drawn anew."""


@dataclass
class Row:
    """A setting in a scene. Errors are shares of the true force, rms over rms."""

    scene: str
    knob: str
    setting: str
    error: float
    bound: float
    contact_error: float
    torque_error: float
    largest_n: float
    pose_rms_m: float
    pose_max_m: float
    turn_max_rad: float
    penetration_m: float
    surface_m: float
    touching: int
    lagging: float
    work_mean: float
    work_p50: float
    work_p99: float
    work_p999: float
    work_max: float
    tests: float
    iterations: float
    sub_steps: float
    times_us: Dict[str, float] = field(default_factory=dict)
    on_front: bool = False


def _ratio(above: float, below: float) -> float:
    return math.sqrt(above / below) if below > 0.0 else (0.0 if above == 0.0 else math.inf)


def quantile(bins: Dict[int, int], share: float) -> float:
    """Upper edge of the bin below which the share lies."""
    total, seen = sum(bins.values()), 0
    for number in sorted(bins):
        seen += bins[number]
        if seen >= share * total:
            return 2.0 ** ((number + 1) / BINS_PER_OCTAVE)
    return 0.0


def _penetration(gaps: Sequence[float | None]) -> float:
    judged = [gap for gap in gaps if gap is not None]
    return max(0.0, -min(judged)) if judged else math.nan


def _merged(all_bins: Sequence[Sequence[Sequence[int]]]) -> Dict[int, int]:
    found: Dict[int, int] = {}
    for bins in all_bins:
        for number, count in bins:
            found[number] = found.get(number, 0) + count
    return found


def resampled_bound(squares: numpy.ndarray) -> float:
    """The error of gestures drawn anew from these, at CONFIDENCE; always the same draws. A row for each gesture: squared error, squared force."""
    if not len(squares) or squares[:, 1].sum() <= 0.0:
        return 0.0
    drawn = numpy.random.Generator(numpy.random.PCG64(1)).integers(0, len(squares), (RESAMPLES, len(squares)))
    sums = squares[drawn].sum(axis=1)
    return float(numpy.sqrt(numpy.quantile(sums[:, 0] / numpy.maximum(sums[:, 1], 1e-300), CONFIDENCE)))


def _row(scene: str, knob: str, setting: str, lines: List[Dict[str, Any]]) -> Row:
    def total(name: str) -> float:
        return math.fsum(line[name] or 0.0 for line in lines)

    def largest(name: str) -> float:
        return max(line[name] or 0.0 for line in lines)

    touching = int(total("touching"))

    def mean(name: str) -> float:
        return math.fsum(line[name] * line["touching"] for line in lines) / max(touching, 1)

    squares = numpy.array([[line["felt_square"], line["truth_square"]] for line in lines])
    work = _merged([line["work_bins"] for line in lines])
    time = _merged([line["timing"]["bins"] for line in lines])
    times = {"p50": quantile(time, 0.5), "p99": quantile(time, 0.99), "max": max(line["timing"]["max_us"] for line in lines),
             "mean": math.fsum(line["timing"]["mean_us"] * line["touching"] for line in lines) / max(touching, 1)}
    return Row(scene, knob, setting, error=_ratio(total("felt_square"), total("truth_square")), bound=resampled_bound(squares),
               contact_error=_ratio(total("contact_square"), total("contact_truth_square")),
               torque_error=_ratio(total("torque_square"), total("torque_truth_square")), largest_n=largest("felt_max_n"),
               pose_rms_m=math.sqrt(total("pose_square") / max(total("ticks"), 1.0)), pose_max_m=largest("pose_max_m"), turn_max_rad=largest("turn_max_rad"),
               penetration_m=_penetration([line["path_gap_m"] for line in lines]), surface_m=largest("surface_m"), touching=touching,
               lagging=total("lagging") / max(touching, 1), work_mean=mean("work_mean"), work_p50=quantile(work, 0.5), work_p99=quantile(work, 0.99),
               work_p999=quantile(work, 0.999), work_max=largest("work_max"), tests=mean("tests_mean"), iterations=mean("iterations_mean"),
               sub_steps=mean("sub_steps_mean"), times_us=times)


def front(costs: Sequence[float], errors: Sequence[float]) -> List[bool]:
    """Whether each point is on the front: none costs less (by more than SLACK) and errs no more."""
    return [not any(other < cost / (1.0 + SLACK) and its <= error for other, its in zip(costs, errors)) for cost, error in zip(costs, errors)]


def knee(costs: Sequence[float], errors: Sequence[float]) -> int:
    """Index of the point of a front that lies farthest below the line between its ends, both scales logarithmic."""
    x, y = numpy.log(numpy.maximum(costs, 1e-12)), numpy.log(numpy.maximum(errors, 1e-12))
    a, b = int(numpy.argmin(x)), int(numpy.argmin(y))
    width, height = x[b] - x[a], y[a] - y[b]
    if width <= 0.0 or height <= 0.0:
        return b
    return int(numpy.argmax((1.0 - (x - x[a]) / width) + (1.0 - (y - y[b]) / height)))


def rows_of(plan: Plan, folder: pathlib.Path) -> List[Row]:
    """All rows, in the order of the plan, their front marked for each scene."""
    rows: List[Row] = []
    for scene in plan.scenes:
        read = [read_unit(folder, unit) for unit in plan.units() if unit.scene == scene]
        knobs = {"usual": {"usual": ""}, **plan.knobs(scene), "baseline": {name: name for name in BASELINES}}
        own = [_row(scene, knob, setting, [unit[setting] for unit in read]) for knob, settings in knobs.items() for setting in settings]
        counted = [row for row in own if row.knob not in ("baseline", "loop rate")]
        for row, on in zip(counted, front([row.work_mean for row in counted], [row.error for row in counted])):
            row.on_front = on
        rows += own
    return rows


RESULTS = ("scene", "knob", "setting", "error", "bound", "contact_error", "torque_error", "largest_n", "pose_rms_m", "pose_max_m", "turn_max_rad",
           "penetration_m", "surface_m", "touching", "lagging", "work_mean", "work_p50", "work_p99", "work_p999", "work_max", "tests", "iterations", "sub_steps", "on_front")


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def write_tables(rows: Sequence[Row], output: pathlib.Path) -> None:
    """results.csv, the same on every machine, and times.csv, this machine's."""
    with open(output / "results.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(RESULTS)
        writer.writerows([_text(getattr(row, name)) for name in RESULTS] for row in rows)
    with open(output / "times.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("scene", "setting", "p50_us", "p99_us", "max_us", "mean_us"))
        writer.writerows([row.scene, row.setting, *(_text(row.times_us[name]) for name in ("p50", "p99", "max", "mean"))] for row in rows)
