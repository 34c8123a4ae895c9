"""Pictures in the layout of the paper's figures: force components, torque components and time cost per tick over time, runs beside each
other with shared axes; below, which objects bear force when. As in the paper x is red, y green, z blue; the line style says it too.
Other modules draw lines over anything with `lines`."""
from __future__ import annotations

import pathlib
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence, Tuple

import matplotlib

matplotlib.use("Agg")
import numpy  # noqa: E402
from matplotlib import lines as lines_module, pyplot, ticker  # noqa: E402

from hapticd_lab.trace import AXES, Trace  # noqa: E402

AXIS_COLORS = ("#d1352b", "#1b8a3a", "#1f5fbf")
AXIS_STYLES = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)))
OBJECT_COLORS = ("#444444", "#e69f00", "#56b4e9", "#cc79a7", "#009e73", "#d55e00", "#0072b2", "#b8a800")
"""Okabe and Ito: told apart by colour-blind eyes too; the name stands beside each strip anyway."""
LEAST_FORCE_N, LEAST_TORQUE_N_M = 0.01, 1e-3
"""Smaller axes would make mountains of rounding."""
TONE_COLOR = "#7a3fa0"
PERIOD_US = 1000.0
"""The tick's millisecond."""
COLUMN_INCHES, NARROW_INCHES = 5.4, 4.2
"""Of a run: beside one other, and beside more, so that letters stay readable when all are scaled to a page."""
WIDTH_INCHES = 10.0
"""Of a page; a single run takes all of it."""
STYLE = {
    "font.family": "sans-serif", "font.size": 9.0, "axes.titlesize": 9.5, "axes.labelsize": 9.0, "legend.fontsize": 8.0,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.linewidth": 0.4, "grid.alpha": 0.5,
    "lines.linewidth": 1.1, "svg.fonttype": "path", "svg.hashsalt": "hapticd", "figure.dpi": 100, "savefig.dpi": 160,
    "agg.path.chunksize": 20000,
}


@dataclass
class Picture:
    """A drawn picture that is not yet in a file."""

    figure: Any

    def save(self, stem: pathlib.Path) -> None:
        """Writes STEM.svg, a text that ends no line with a space, and STEM.png, and lets go of the picture."""
        for kind in ("svg", "png"):
            metadata = {"Date": None} if kind == "svg" else {}
            self.figure.savefig(stem.with_name(f"{stem.name}.{kind}"), metadata=metadata, bbox_inches="tight", pad_inches=0.06)
        svg = stem.with_name(f"{stem.name}.svg")
        svg.write_text("".join(f"{line.rstrip()}\n" for line in svg.read_text(encoding="utf-8").splitlines()), encoding="utf-8")
        pyplot.close(self.figure)


def spans(mask: numpy.ndarray) -> List[Tuple[int, int]]:
    """Ranges [begin, end) of consecutive True."""
    edges = numpy.flatnonzero(numpy.diff(numpy.concatenate(([0], numpy.asarray(mask, int), [0]))))
    return [(int(begin), int(end)) for begin, end in zip(edges[::2], edges[1::2])]


def readable(name: str) -> str:
    """strings[3] and the like as they are; long names shortened."""
    return name if len(name) <= 22 else name[:21] + "\N{HORIZONTAL ELLIPSIS}"


def _components(axis: Any, trace: Trace, table: numpy.ndarray) -> None:
    drawn = numpy.where(numpy.diff(trace.tick, prepend=trace.tick[:1])[:, None] > 1, numpy.nan, table)  # no line over ticks that are missing
    for i, name in enumerate(AXES):
        axis.plot(trace.t_s, drawn[:, i], color=AXIS_COLORS[i], linestyle=AXIS_STYLES[i], label=name)
    axis.axhline(0.0, color="#888888", linewidth=0.5, zorder=0)


def _fit(axis: Any, tables: Sequence[numpy.ndarray], least: float) -> None:
    """The axis that a row of panels shares holds all of their curves, and is no smaller than `least` about zero."""
    low = min([-least, *(float(table.min()) for table in tables if table.size)])
    high = max([least, *(float(table.max()) for table in tables if table.size)])
    axis.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))


def _tones(axis: Any, trace: Trace) -> None:
    tones = [event.body for event in trace.events if event.kind == "tone"]
    if not tones:
        return  # a line without points would pull the layout into the corner
    times = [tone.t_ns * 1e-9 - trace.began_s for tone in tones]
    axis.plot(times, [1.0] * len(times), "v", color=TONE_COLOR, markersize=4.5, transform=axis.get_xaxis_transform(), clip_on=False, zorder=5)
    last = -numpy.inf
    width = float(trace.t_s[-1] - trace.t_s[0]) if len(trace) else 0.0
    for time, tone in zip(times, tones):
        if time - last > 0.03 * width:  # labels that would cover each other are left out
            axis.annotate(f"{tone.string_index + 1}", (time, 1.0), xycoords=axis.get_xaxis_transform(), xytext=(0, 5),
                          textcoords="offset points", ha="center", fontsize=7, color=TONE_COLOR, annotation_clip=False)
            last = time


def _cost(axis: Any, trace: Trace) -> None:
    known = trace.cpu_us > 0.0  # NaN and 0: not measured
    axis.axhline(PERIOD_US, color="#d1352b", linewidth=0.9, linestyle="--")
    axis.plot(trace.t_s, numpy.where(known, trace.cpu_us, numpy.nan), color="#555555", linewidth=0.6)
    text = "not measured: virtual time; dashed: 1 ms"
    if known.any():
        p50, p99, most = numpy.percentile(trace.cpu_us[known], (50, 99, 100))
        under = 100.0 * (trace.cpu_us[known] < PERIOD_US).mean()
        text = f"median {p50:.3g}, p99 {p99:.3g}, max {most:.4g} \N{MICRO SIGN}s, {under:.4g} % under 1 ms (dashed)"
    axis.set_title(text, loc="right", fontsize=7.5, color="#444444")


def _fit_cost(axis: Any, traces: Sequence[Trace]) -> None:
    known = numpy.concatenate([trace.cpu_us[trace.cpu_us > 0.0] for trace in traces])
    axis.set_yscale("log")
    axis.yaxis.set_major_locator(ticker.LogLocator(numticks=6))
    axis.yaxis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_ylim(0.5 * known.min() if known.size else 1.0, 2.0 * max(PERIOD_US, float(known.max(initial=0.0))))


def _strips(axis: Any, trace: Trace, names: Sequence[str]) -> None:
    for row, name in enumerate(names):
        intervals = [(trace.t_s[begin], trace.t_s[end - 1] - trace.t_s[begin] + 1e-3) for begin, end in spans(trace.touched(name))]
        axis.broken_barh(intervals, (row - 0.36, 0.72), color=OBJECT_COLORS[row % len(OBJECT_COLORS)], linewidth=0)
    axis.set_ylim(len(names) - 0.4, -0.6)
    axis.set_yticks(range(len(names)), [readable(name) for name in names])
    axis.grid(axis="y", visible=False)


def touched_names(runs: Dict[str, Trace]) -> List[str]:
    """Objects that bear force in any run, in the order of the first touch."""
    first: Dict[str, float] = {}
    for trace in runs.values():
        for name in trace.object_force_n:
            ticks = numpy.flatnonzero(trace.touched(name))
            if len(ticks):
                first[name] = min(first.get(name, numpy.inf), float(trace.t_s[ticks[0]]))
    return sorted(first, key=lambda name: (first[name], name))


def draw_runs(runs: Dict[str, Trace], title: str) -> Picture:
    """The figure of one or more runs, a column for each. Cost: about 1 s for each 10 000 ticks."""
    names = touched_names(runs)
    heights = [2.0, 2.0, 1.3] + ([max(0.5, 0.3 + 0.19 * len(names))] if names else [])
    with pyplot.rc_context(STYLE):
        figure, table = pyplot.subplots(
            len(heights), len(runs), sharex="col", sharey="row", squeeze=False, constrained_layout=True,
            figsize=(max((COLUMN_INCHES if len(runs) < 3 else NARROW_INCHES) * len(runs), WIDTH_INCHES), sum(heights) + 1.1), gridspec_kw={"height_ratios": heights})
        figure.suptitle(title, fontsize=10.5, fontweight="bold", x=0.01, ha="left")
        for column, (heading, trace) in enumerate(runs.items()):
            axes = table[:, column]
            _components(axes[0], trace, trace.force_n)
            _tones(axes[0], trace)
            _components(axes[1], trace, trace.torque_n_m)
            _cost(axes[2], trace)
            axes[0].set_title(heading, loc="left", fontweight="bold", pad=13.0)
            if names:
                _strips(axes[3], trace, names)
            axes[-1].set_xlabel("time, s")
            if len(trace):
                axes[-1].set_xlim(float(trace.t_s[0]), float(trace.t_s[-1]))
        _fit(table[0, 0], [trace.force_n for trace in runs.values()], LEAST_FORCE_N)
        _fit(table[1, 0], [trace.torque_n_m for trace in runs.values()], LEAST_TORQUE_N_M)
        _fit_cost(table[2, 0], list(runs.values()))
        for axis, label in zip(table[:, 0], ("force, N", "torque, N m", "time per tick, \N{MICRO SIGN}s", "")):
            axis.set_ylabel(label)
        handles = table[0, 0].get_legend_handles_labels()[0][:3]
        handles.append(lines_module.Line2D([], [], color=TONE_COLOR, marker="v", linestyle="", markersize=4.5))
        figure.legend(handles, [*AXES, "tone, with the number of its string"], loc="upper right", ncol=4, handlelength=2.6, frameon=False,
                      borderaxespad=0.2)
    return Picture(figure)


@dataclass
class Line:
    """One curve of `lines`."""

    label: str
    x: Sequence[float]
    y: Sequence[float]
    style: str = "-"
    color: Optional[str] = None


@dataclass
class Panel:
    """One panel of `lines`: labels with units; `bounds`: horizontal lines by label; `marks`: vertical ones by label."""

    x_label: str
    y_label: str
    curves: List[Line]
    title: str = ""
    log_x: bool = False
    log_y: bool = False
    bounds: Optional[Dict[str, float]] = None
    marks: Optional[Dict[str, float]] = None


def _panel(axis: Any, panel: Panel) -> None:
    for i, line in enumerate(panel.curves):
        axis.plot(line.x, line.y, line.style, color=line.color or OBJECT_COLORS[(i + 6) % len(OBJECT_COLORS)], label=line.label, markersize=4)
    for label, value in (panel.bounds or {}).items():
        axis.axhline(value, color="#d1352b", linewidth=0.9, linestyle="--", label=label)
    for label, value in (panel.marks or {}).items():
        axis.axvline(value, color=TONE_COLOR, linewidth=0.8, linestyle=":", label=label)
    axis.set(xlabel=panel.x_label, ylabel=panel.y_label, xscale="log" if panel.log_x else "linear", yscale="log" if panel.log_y else "linear")
    axis.set_title(panel.title, loc="left", fontweight="bold")
    if any(line.label for line in panel.curves) or panel.bounds or panel.marks:
        axis.legend(framealpha=0.8)


def lines(title: str, panels: Sequence[Panel], columns: int = 2) -> Picture:
    """Panels of curves, row by row."""
    columns = min(columns, len(panels))
    rows = -(-len(panels) // columns)
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(rows, columns, squeeze=False, constrained_layout=True, figsize=(max(4.8 * columns, 6.0), 3.2 * rows + 0.5))
        figure.suptitle(title, fontsize=10.5, fontweight="bold")
        for axis, panel in zip(axes.flat, panels):
            _panel(axis, panel)
        for axis in list(axes.flat)[len(panels):]:
            axis.set_visible(False)
    return Picture(figure)
