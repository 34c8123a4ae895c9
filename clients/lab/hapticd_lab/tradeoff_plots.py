"""Work-precision plots of a study: error over cost, both logarithmic, a mark for each setting and a line along each knob; the front, its knee, the
paper's method and the penalty method, and the force difference that people can feel."""
from __future__ import annotations

import pathlib
from typing import Any, Callable, Dict, List, Sequence

from matplotlib import pyplot

from hapticd_lab.plots import OBJECT_COLORS, STYLE, Picture
from hapticd_lab.tradeoff_table import DISCRIMINATION, Row, knee

LEAST_ERROR = 1e-9
"""Smaller errors are drawn here: rounding."""
MARKS = "osD^vP*X<>"
BASELINE_MARKS = {"paper": ("the paper as printed", "P"), "penalty": ("penalty", "X")}


def _error(row: Row) -> float:
    return max(row.error, LEAST_ERROR)


def _knobs(axis: Any, rows: Sequence[Row], cost: Callable[[Row], float]) -> None:
    by_knob: Dict[str, List[Row]] = {}
    for row in rows:
        if row.knob not in ("usual", "ladder", "baseline"):
            by_knob.setdefault(row.knob, []).append(row)
    for number, (knob, own) in enumerate(by_knob.items()):
        color = OBJECT_COLORS[number % len(OBJECT_COLORS)]
        axis.plot([cost(row) for row in own], [_error(row) for row in own], marker=MARKS[number % len(MARKS)], markersize=4, linewidth=0.8,
                  color=color, alpha=0.85, label=knob)
    for row in by_knob.get("level", ()):
        axis.annotate(row.setting[-1], (cost(row), _error(row)), xytext=(4, 4), textcoords="offset points", fontsize=8, fontweight="bold")


def _front(axis: Any, rows: Sequence[Row], cost: Callable[[Row], float]) -> None:
    own = sorted((row for row in rows if row.on_front), key=cost)
    if not own:
        return
    axis.plot([cost(row) for row in own], [_error(row) for row in own], color="#000000", linewidth=1.6, alpha=0.35, zorder=0, label="front")
    best = own[knee([cost(row) for row in own], [row.error for row in own])]
    axis.plot([cost(best)], [_error(best)], "o", markersize=11, fillstyle="none", color="#000000", label=f"knee: {best.setting}")


def _axis(axis: Any, title: str, label: str) -> None:
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.axhline(DISCRIMINATION, color="#d1352b", linewidth=0.9, linestyle="--", label="7 %: a difference that is felt")
    axis.set_title(title, loc="left", fontweight="bold")
    axis.set_xlabel(label)
    axis.set_ylabel("force error, rms / rms")
    axis.legend(fontsize=6.5, framealpha=0.8, loc="center left", bbox_to_anchor=(1.0, 0.5))


def scene_plot(scene: str, rows: Sequence[Row]) -> Picture:
    """Error over work on the left, over processor time with the other methods on the right."""
    own = [row for row in rows if row.scene == scene]
    ours = [row for row in own if row.knob != "baseline"]
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(1, 2, figsize=(15.0, 4.6), constrained_layout=True)
        _knobs(axes[0], ours, lambda row: max(row.work_mean, 1.0))
        _front(axes[0], ours, lambda row: max(row.work_mean, 1.0))
        _axis(axes[0], f"{scene}: work", "work of a tick in touch, mean (a unit is about a test of a pair)")
        _knobs(axes[1], ours, lambda row: row.times_us["p50"])
        for row in own:
            if row.knob == "baseline":
                name, mark = BASELINE_MARKS[row.setting]
                axes[1].plot([row.times_us["p50"]], [_error(row)], mark, markersize=9, color="#d1352b", label=name)
        _axis(axes[1], f"{scene}: time on this machine", "median processor time of a tick in touch, \N{MICRO SIGN}s")
    return Picture(figure)


def draw(scenes: Sequence[str], rows: Sequence[Row], output: pathlib.Path) -> None:
    """work_precision_SCENE.svg and .png of each scene."""
    for scene in scenes:
        scene_plot(scene, rows).save(output / f"work_precision_{scene}")
