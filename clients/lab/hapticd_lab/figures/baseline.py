"""M1: the paper as printed, and a penalty method, on the same motions as ours: what each lets through, how it jumps, what it gives."""
from __future__ import annotations

from typing import Any, Dict, List

import numpy

from hapticd_lab import oracle, plots
from hapticd_lab.figure import OURS, Figure, Spec, at_most
from hapticd_lab.figures.guqin import at_speed
from hapticd_lab.lab import Lab
from hapticd_lab.player import Setup
from hapticd_lab.row import DEEPEST_M
from hapticd_lab.trace import Trace

METHODS = {"the paper as printed, collision radius R": ("paper", "--breathing", "none"), "penalty": ("penalty",)}
BREATHING = "the paper as printed, collision radius as drawn"
"""Its radius grows with what rings; that diverges, so it is shown in one motion alone."""
BREATHING_MOTION = "tap at 0.4 m/s"
MOTIONS = (("bunny", "bunny_single_region"), ("bunny", "bunny_two_regions"), ("bunny", "bunny_line_and_pillar"), ("bunny", "bunny_two_lines"),
           ("bunny", "contact_switch"), ("guqin", "slide_on_body"), ("guqin", "press"), ("guqin", "lift_from_beneath"), ("guqin", "sweep"),
           ("guqin", "slide_along"), ("guqin", "extreme_presses"), ("guqin", "static_then_vibrating"))
LONGEST_TICKS = 6000
"""Of a motion: exhaustive search takes long beside the body."""
SWEEP_SPEEDS = (2.0, 8.0)
TAP_SPEEDS = (0.1, 0.4, 1.204, 10.0, 100.0)
NOTICEABLE = 0.07
"""Share of a force that people tell apart."""
HEADING = ["motion", "method", "passes through strings and lines", "deepest path in anything, um", "largest change of force in a tick, N",
           "largest force, N", "energy given to the hand, mJ"]


def given_j(trace: Trace) -> float:
    """Most that the force gave along the way of H, turning left out."""
    return float(numpy.cumsum(numpy.sum(trace.force_n[:-1] * numpy.diff(trace.p_wh_m, axis=0), axis=1)).max(initial=0.0))


def _ours(motion: str, trace: Trace, penetration_m: float) -> List[str]:
    jumps = numpy.linalg.norm(numpy.diff(trace.force_n, axis=0), axis=1)
    return [motion, "hapticd", "0", f"{penetration_m * 1e6:.3f}", f"{jumps.max():.3f}", f"{numpy.linalg.norm(trace.force_n, axis=1).max():.2f}",
            f"{given_j(trace) * 1e3:.3f}"]


def _others(motion: str, name: str, columns: Dict[str, numpy.ndarray]) -> List[str]:
    popped = sum(int(column.sum()) for heading, column in columns.items() if heading.startswith("popped_"))
    force = numpy.sqrt(sum(columns[f"force_{axis}_n"] ** 2 for axis in "xyz"))
    return [motion, name, str(popped), f"{max(0.0, -columns['path_gap_m'].min()) * 1e6:.1f}", f"{columns['force_jump_n'].max():.3f}",
            f"{force.max():.2f}", f"{columns['port_j'].max() * 1e3:.3f}"]


def _compare(lab: Lab, scene: str, motion: str, poses: numpy.ndarray) -> Dict[str, Any]:
    """Rows of the table, and the numbers that the plot and the claims are made of."""
    trace = lab.play(Setup(scene), poses, "compared")
    penetration = lab.judge("compared", trace).penetration_m
    rows, numbers = [_ours(motion, trace, penetration)], {"hapticd": penetration}
    for name, method in METHODS.items():
        columns = oracle.baseline(lab.recording("compared"), *method)
        rows.append(_others(motion, name, columns))
        numbers[name] = max(0.0, -float(columns["path_gap_m"].min()))
    if motion == BREATHING_MOTION:
        rows.append(_others(motion, BREATHING, oracle.baseline(lab.recording("compared"), "paper", "--breathing", "released")))
    return {"rows": rows, "depth_m": numbers}


def _tank_table(lab: Lab, figure: Figure) -> None:
    """F_v with and without its energy tank, in the tick and against what is noticed."""
    lab.play(Setup("guqin"), lab.poses("static_then_vibrating", "guqin"), "vibrating")
    rows = [["energy tank", "largest F_v, N", "rms of F_v over the force, first 0.2 s of the touch, %", "energy given to the hand, mJ"]]
    share = {}
    for tank in ("on", "off"):
        columns = oracle.baseline(lab.recording("vibrating"), "paper", "--tank", tank, "--breathing", "none")
        ringing = numpy.flatnonzero(columns["f_v_n"] != 0.0)
        touch = slice(ringing[0], ringing[0] + 200)
        share[tank] = float(numpy.sqrt(numpy.mean(columns["f_v_n"][touch] ** 2)) / columns["f_r_n"][touch].mean())
        rows.append([tank, f"{numpy.abs(columns['f_v_n']).max():.3f}", f"{100.0 * share[tank]:.1f}", f"{columns['port_j'].max() * 1e3:.3f}"])
    figure.tables["The vibration force with and without the energy tank, in the paper's model"] = rows
    verb = "is noticed" if abs(share["off"] - share["on"]) > NOTICEABLE else "is not noticed"
    figure.notes.append(f"The tank takes {100.0 * abs(share['off'] - share['on']):.1f} points of the force from the vibration: by the line of "
                        f"{100.0 * NOTICEABLE:.0f} % at which people tell forces apart, that {verb}.")


def compare(lab: Lab, figure: Figure) -> None:
    """The motions of F11 to F18, and sweep and tap at several speeds."""
    table, depths = [HEADING], []
    for scene, gesture in lab.some(MOTIONS):
        found = _compare(lab, scene, gesture.replace("_", " "), lab.poses(gesture, scene)[:LONGEST_TICKS])
        table += found["rows"]
        depths.append(found["depth_m"]["hapticd"])
    for speed in lab.some(SWEEP_SPEEDS):
        found = _compare(lab, "guqin", f"sweep at {speed:g} m/s", lab.poses(at_speed(lab, "sweep", speed), "guqin"))
        table += found["rows"]
        depths.append(found["depth_m"]["hapticd"])
    by_speed: Dict[str, List[float]] = {name: [] for name in ("hapticd", *METHODS)}
    tap_speeds = lab.some(TAP_SPEEDS)
    for speed in tap_speeds:
        found = _compare(lab, "guqin", f"tap at {speed:g} m/s", lab.poses(at_speed(lab, "tap", speed), "guqin"))
        table += found["rows"]
        for name, depth in found["depth_m"].items():
            by_speed[name].append(depth)
    figure.tables["Ours, the paper as printed and a penalty method on the same poses"] = table
    figure.claims.append(at_most("hapticd's tool never enters anything, in any of the motions and at any speed",
                                 max(depths + by_speed["hapticd"]) * 1e6, DEEPEST_M * 1e6, "um", source=OURS))
    plots.lines("M1: how deep the path is in the string, by speed of the tap", [plots.Panel(
        "speed, m/s", "deepest path, um", [plots.Line(name, tap_speeds, [max(depth * 1e6, 1e-3) for depth in column], "o-") for name, column in by_speed.items()],
        log_x=True, log_y=True)]).save(lab.folder / "depth")
    figure.pictures["depth.svg"] = "Deepest place of the path in anything, by speed of the tap; 0.001 um stands for none"
    _tank_table(lab, figure)


SPECS = [Spec("M1", "Ours, the printed method, a penalty method", "what the paper's text says of pop-through and stability, for the method as its equations "
              "print it", compare, 300.0)]
