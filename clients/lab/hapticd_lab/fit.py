"""Fits the paper's equations (Eq. 8-13) to a measured session with one string: tension T, E A (E or R where the other is known), and from
touches of the vibrating string k_v, T_d and omega, with intervals of 95 %, residuals, a plot and a report."""
from __future__ import annotations

import argparse
import csv
import pathlib
import sys
from typing import List, Optional, Sequence

import numpy

from hapticd_lab import string_fit
from hapticd_lab.length import length
from hapticd_lab.measured import HEADING_HELP, RING, BadFile, Measured, read
from hapticd_lab.string_fit import Fit, Geometry, TooLittle

SUMMARY = "fit the string's parameters to measured forces"
__doc__ += f"""

{HEADING_HELP}

Give the string's ends with --a and --b, or take them with its radius from a scene. E and R enter the force only as E A = E pi R^2: with
--radius (or a scene) E follows; with --tip-radius alone R follows from where contact begins, as exactly as the places are known; with
neither only E A is told. k_v and r_max enter only as a product: r_max is taken as the largest deflection before the release.

DIR gets parameters.csv, residuals.csv, fit.svg, fit.png, report.md and codebook.md.

Exit code: 0 fitted; 1 the file is refused, with line and remedy, or has too little for a fit, and what is missing is said."""

CODEBOOK = """# What the files hold

SI units, UTF-8, comma-separated with a heading; R's `read.csv` and Python's `pandas.read_csv` read them directly. An empty field: not known.

## parameters.csv, a row a parameter
| column | meaning |
|---|---|
| parameter | T tension, EA axial stiffness, contact_distance axis to fingertip centre at first touch, E Young's modulus, R radius, k_v_r_max amplitude of the vibration force at the release, r_max largest deflection before it, k_v stiffness of the vibration force, T_d decay time to 1/e, omega and f frequency |
| unit | of value, low_95 and high_95 |
| value | estimate |
| low_95, high_95 | interval that holds the truth in 95 of 100 such measurements |
| how | fitted, given or derived; or why it is not known |

## residuals.csv, a row a sample that was used
| column | meaning |
|---|---|
| sample | number of the sample in the file, the first is 1 |
| t_s | instant, s |
| touch, phase | number of the touch, the first is 1; press or ring |
| lambda | place along the string, 0 at A, 1 at B |
| deflection_m | deflection by the fitted contact distance, m |
| force_n, model_n | force along the touch's direction, measured and of the model, N |
| residual_n | model less measured, N |
| across_n | measured force across that direction, which the model does not have, N |
"""


def describe(parser: argparse.ArgumentParser) -> None:
    """Its options."""
    parser.add_argument("file", type=pathlib.Path, metavar="FILE", help="what was measured, CSV")
    parser.add_argument("--output", type=pathlib.Path, metavar="DIR", required=True, help="where everything goes; made if it is not there")
    parser.add_argument("--a", type=length, nargs=3, metavar=("X", "Y", "Z"), help="the string's end A, m, in the frame of the file")
    parser.add_argument("--b", type=length, nargs=3, metavar=("X", "Y", "Z"), help="its end B")
    parser.add_argument("--radius", type=length, metavar="R", help="its radius, m, where it is known")
    parser.add_argument("--scene", metavar="NAME", help="take the ends and the radius from a scene, by name or file")
    parser.add_argument("--string", metavar="STRING", default="0", help="which of its strings, by name or number from 0 (default: 0)")
    parser.add_argument("--tip-radius", type=length, metavar="r", help="radius of the fingertip, m; 0 where the file has the point of contact")
    parser.add_argument("--tip", type=length, nargs=3, metavar=("X", "Y", "Z"),
                        help="where the fingertip is in the tool whose pose is in the file, m (default: at its origin); needs q_w,q_x,q_y,q_z")


def _scene_string(scene: str, wanted: str) -> Geometry:
    import hapticd
    from hapticd_lab import player  # what starts hapticd is needed by --scene alone
    with player.Daemon("--clock", "virtual", "--scene", "wall") as daemon, hapticd.Session(daemon.address) as session:
        session.acquire("hapticd-lab fit")
        try:
            strings = list(session.load_scene(scene).scene.strings)
        except hapticd.RequestError as error:
            raise BadFile(f"--scene {scene}: {error}") from error
    for index, string in enumerate(strings):
        if wanted in (string.name, str(index)):
            return Geometry(numpy.array(string.p_wa_m), numpy.array(string.p_wb_m), string.radius_m)
    raise BadFile(f"{scene} has no string {wanted}; it has {', '.join(string.name for string in strings) or 'none'}")


def geometry_of(options: argparse.Namespace) -> Geometry:
    """The string as the options say it. BadFile says what is missing."""
    for name in ("radius", "tip_radius"):
        value = getattr(options, name)
        if value is not None and not (0.0 <= value <= 1.0 and (value > 0.0 or name == "tip_radius")):
            raise BadFile(f"--{name.replace('_', '-')} {value:g}: give metres, above 0 and at most 1")
    if options.scene is not None:
        if options.a or options.b:
            raise BadFile("--scene has the ends: leave --a and --b out")
        found = _scene_string(options.scene, options.string)
        return Geometry(found.a_m, found.b_m, found.radius_m if options.radius is None else options.radius, options.tip_radius)
    if options.a is None or options.b is None:
        raise BadFile("say where the string is: --a X Y Z --b X Y Z, or --scene NAME --string N")
    geometry = Geometry(numpy.array(options.a), numpy.array(options.b), options.radius, options.tip_radius)
    if not 0.0 < geometry.length_m < 1e7:
        raise BadFile("A and B are the same place: give the string's two ends")
    return geometry


def tip_places(path: pathlib.Path, measured: Measured, tip: Optional[Sequence[float]]) -> numpy.ndarray:
    """n x 3, the fingertip's centre: p + R(q) tip."""
    if tip is None:
        return measured.place_m
    if measured.orientation is None:
        raise BadFile(f"{path}:1: --tip needs the orientation; add the columns q_w,q_x,q_y,q_z")
    axis, arm = measured.orientation[:, 1:], numpy.broadcast_to(numpy.asarray(tip, float), measured.place_m.shape)
    once = numpy.cross(axis, arm) + measured.orientation[:, :1] * arm
    return measured.place_m + arm + 2.0 * numpy.cross(axis, once)


def _write_parameters(path: pathlib.Path, fit: Fit) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(("parameter", "unit", "value", "low_95", "high_95", "how"))
        for each in fit.estimates:
            numbers = [f"{value:.10g}" for value in (each.value, each.low, each.high)] if each.known else [""] * 3
            rows.writerow((each.name, each.unit, *numbers, each.how))


def _write_residuals(path: pathlib.Path, fit: Fit, measured: Measured) -> None:
    touch_of = numpy.zeros(len(measured), int)
    for number, touch in enumerate(fit.touches, 1):
        touch_of[touch.rows] = number
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(("sample", "t_s", "touch", "phase", "lambda", "deflection_m", "force_n", "model_n", "residual_n", "across_n"))
        for i, row in enumerate(fit.rows):
            touch = int(touch_of[row])
            numbers = (fit.place[i], fit.deflection_m[i], fit.measured_n[i], fit.model_n[i], fit.model_n[i] - fit.measured_n[i], fit.across_n[i])
            rows.writerow((int(row) + 1, f"{measured.t_s[row]:.9g}", touch, fit.touches[touch - 1].phase, *(f"{value:.9g}" for value in numbers)))


def _draw(stem: pathlib.Path, fit: Fit, measured: Measured) -> None:
    from hapticd_lab import plots
    t_s = measured.t_s[fit.rows]
    ring = numpy.zeros(len(measured), bool)
    for touch in fit.touches:
        ring[touch.rows] |= touch.phase == RING
    ring = ring[fit.rows]
    order = numpy.argsort(fit.deflection_m[~ring], kind="stable")
    millimetres = 1e3 * fit.deflection_m[~ring][order]
    residual = 1e3 * (fit.model_n - fit.measured_n)
    panels = [plots.Panel("deflection, mm", "force, N", [plots.Line("measured", millimetres, fit.measured_n[~ring][order], "."),
                                                         plots.Line("fitted", millimetres, fit.model_n[~ring][order], "-")], "pressed at rest"),
              plots.Panel("time, s", "model - measured, mN", [plots.Line("", t_s, residual, ".")], "residuals")]
    if ring.any():
        panels.append(plots.Panel("time, s", "force, N", [plots.Line("measured", t_s[ring], fit.measured_n[ring], "."),
                                                          plots.Line("fitted", t_s[ring], fit.model_n[ring], "-")], "touched while it vibrates"))
    plots.lines("Measured forces and Eq. 8-13", panels).save(stem)


def report_text(name: str, fit: Fit) -> str:
    """The report, Markdown."""
    lines: List[str] = [f"# {name}: the string's parameters", "", "| parameter | value | 95 % interval | unit | |", "|---|---|---|---|---|"]
    for each in fit.estimates:
        number = f"{each.value:.6g} | {each.low:.6g} to {each.high:.6g}" if each.known else "not known | "
        lines.append(f"| {each.name} | {number} | {each.unit} | {each.how} |")
    residual = fit.model_n - fit.measured_n
    lines += ["", f"{len(fit.rows)} samples in {len(fit.touches)} touches; residuals {1e3 * fit.sigma_n:.3g} mN rms, largest "
              f"{1e3 * numpy.abs(residual).max():.3g} mN; force across the touches' directions {1e3 * numpy.sqrt(numpy.mean(fit.across_n ** 2)):.3g} mN rms.",
              "", "Correlations of what was fitted: " + "; ".join(f"{pair} {value:.3f}" for pair, value in fit.correlations.items()) + "."]
    if fit.inflation > 1.0:
        lines += ["", f"Residuals follow each other: intervals are {numpy.sqrt(fit.inflation):.2f} times as wide as for independent ones. "
                  "The model, the geometry or the sensor's own motion leaves something over: look at the plot."]
    doubtful = [each.name for each in fit.estimates if each.known and each.low < 0.0 < each.high]
    if doubtful:
        lines += ["", f"Not told from 0 by this measurement: {', '.join(doubtful)}. Press deeper, or measure longer."]
    return "\n".join([*lines, "", "What cannot be told apart: E and R, but for their product E pi R^2 and where contact begins; k_v and r_max, but for "
                      "their product; the phase of the vibration is fitted for each touch and not reported.", "", "![fit](fit.svg)", ""])


def run(options: argparse.Namespace) -> int:
    """The command; its exit code."""
    try:
        geometry = geometry_of(options)
        measured = read(options.file)
        found = string_fit.fit(measured, tip_places(options.file, measured, options.tip), geometry)
    except BadFile as refused:
        print(f"hapticd-lab fit: {refused}", file=sys.stderr)
        return 1
    except TooLittle as missing:
        print(f"hapticd-lab fit: {options.file}: {missing}", file=sys.stderr)
        return 1
    options.output.mkdir(parents=True, exist_ok=True)
    _write_parameters(options.output / "parameters.csv", found)
    _write_residuals(options.output / "residuals.csv", found, measured)
    (options.output / "codebook.md").write_text(CODEBOOK, encoding="utf-8")
    text = report_text(options.file.name, found)
    (options.output / "report.md").write_text(text, encoding="utf-8")
    _draw(options.output / "fit", found, measured)
    for each in found.estimates:
        print(f"{each.name:17} {each.value:.6g} {each.unit} ({each.low:.6g} to {each.high:.6g})" if each.known else f"{each.name:17} not known: {each.how}")
    print(options.output / "report.md")
    return 0
