"""What the levels of a string cost and err, as part of a study: the force of a ringing string on a finger that comes back to it, and its pitch."""
from __future__ import annotations

import csv
import json
import pathlib
from typing import Any, Dict, List, Sequence

from matplotlib import pyplot

from hapticd_lab import oracle
from hapticd_lab.plots import OBJECT_COLORS, STYLE, Picture
from hapticd_lab.tradeoff_table import DISCRIMINATION

TOUCH = ("name", "modes", "model_error", "model_max_n", "played_error", "played_max_n")
PITCH = ("frequency_hz", "pluck_lambda", "deflection_m", "truth_cents", "error_cents", "error_with_glide_cents")
PRESS = ("strings", "solved", "error", "max_n")
PLOT = "string_models"


def measured() -> List[Dict[str, Any]]:
    """The lines of hapticd-oracle strings: the same on every machine but for "timing"."""
    return [json.loads(line) for line in oracle.call("strings").splitlines()]


def _of(lines: Sequence[Dict[str, Any]], kind: str) -> List[Dict[str, Any]]:
    return [line for line in lines if line["measured"] == kind]


def _draw(touches: Sequence[Dict[str, Any]], output: pathlib.Path) -> None:
    with pyplot.rc_context(STYLE):
        figure, axis = pyplot.subplots(figsize=(8.0, 4.6), constrained_layout=True)
        modal = [line for line in touches if line["modes"] > 0]
        for error, style in (("model_error", "-o"), ("played_error", ":s")):
            axis.plot([line["timing"]["median_ns"] for line in modal], [line[error] for line in modal], style, markersize=4, linewidth=0.9,
                      color=OBJECT_COLORS[0], label="4 to 64 modes" if error == "model_error" else None)
        for line, mark in zip((line for line in touches if line["modes"] == 0), "DX"):
            axis.plot([line["timing"]["median_ns"]], [line["model_error"]], mark, markersize=8, color="#d1352b", label=f"{line['name']} (as printed)")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.axhline(DISCRIMINATION, color="#d1352b", linewidth=0.9, linestyle="--", label="7 %: a difference that is felt")
        axis.set_title("string under a finger: the model (solid), and as it is played (dotted)", loc="left", fontweight="bold")
        axis.set_xlabel("median time of a touched tick on this machine, ns")
        axis.set_ylabel("force error, rms / rms")
        axis.legend(fontsize=7)
    Picture(figure).save(output / PLOT)


def _write(path: pathlib.Path, columns: Sequence[str], lines: Sequence[Dict[str, Any]]) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([f"{line[name]:.6g}" if isinstance(line[name], float) else line[name] for name in columns] for line in lines)


def write(output: pathlib.Path) -> Dict[str, Any]:
    """strings_touch.csv, strings_pitch.csv, strings_press.csv and their plot; what a report's template shows of them."""
    lines = measured()
    touches, pitches, presses = _of(lines, "touch"), _of(lines, "pitch"), _of(lines, "press")
    _write(output / "strings_touch.csv", TOUCH, touches)
    _write(output / "strings_pitch.csv", PITCH, pitches)
    _write(output / "strings_press.csv", PRESS, presses)
    _draw(touches, output)
    shown = [[line["name"], f"{100 * line['model_error']:.3g} %", f"{1e3 * line['model_max_n']:.3g}", f"{100 * line['played_error']:.3g} %",
              f"{1e3 * line['played_max_n']:.3g}", f"{line['timing']['median_ns']:.0f}"] for line in touches]
    heard = [[f"{line['frequency_hz']:.4g}", f"{line['pluck_lambda']:g}", f"{1e3 * line['deflection_m']:g}", f"{line['truth_cents']:.1f}",
              f"{line['error_cents']:.1f}", f"{line['error_with_glide_cents']:.1f}"] for line in pitches]
    pressed = [[f"{line['strings']}", line["solved"], f"{100 * line['error']:.3g} %", f"{1e3 * line['max_n']:.3g}", f"{line['timing']['median_ns']:.0f}"]
               for line in presses]
    return {"plot": PLOT, "touches": shown, "pitches": heard, "presses": pressed,
            "press_headings": ("strings pressed at once", "solved", "force error", "largest, mN", "median of a tick, ns"),
            "touch_headings": ("level", "error of the model", "largest, mN", "error as played", "largest, mN", "median of a touched tick, ns"),
            "pitch_headings": ("tuning, Hz", "plucked at", "by, mm", "truth above the tuning, cents", "error, cents", "error with glide, cents")}
