"""F10 to F13: a bunny among two rigid lines, two pillars and a plate."""
from __future__ import annotations

import numpy

from hapticd_lab.figure import NUMBER, Figure, Spec, at_least, at_most, is_so
from hapticd_lab.lab import Lab
from hapticd_lab.player import Setup
from hapticd_lab.row import only_claim, play_row, together_claim, touched_together
from hapticd_lab.trace import Trace

SCENE = "bunny"
TORQUE_RATIO = 3.0
"""Clearly larger, in numbers."""
ZERO_N = 1e-3
"""A force that is zero: a line along x cannot push along x but by rounding and the millinewtons of what is told."""


def _largest_torque(trace: Trace, rows: numpy.ndarray) -> float:
    return float(numpy.linalg.norm(trace.torque_n_m[rows], axis=1).max(initial=0.0))


def _single_region_torque(lab: Lab) -> float:
    """Largest torque of F11's motion, which the others are held against."""
    trace = lab.play(Setup(SCENE), lab.poses("bunny_single_region", SCENE))
    return _largest_torque(trace, trace.touched("line_1"))


def _torque_claim(figure: Figure, lab: Lab, trace: Trace, rows: numpy.ndarray) -> None:
    single = _single_region_torque(lab)
    figure.claims.append(at_least("Torque is clearly larger than with one region (F11): largest over largest", _largest_torque(trace, rows) / single,
                                  TORQUE_RATIO, "", f"{_largest_torque(trace, rows) * 1e3:.1f} against {single * 1e3:.1f} mN m"))


def f10(lab: Lab, figure: Figure) -> None:
    """The scene, and that all of it can be touched."""
    row = play_row(lab, figure, SCENE, "touch_every_part", hands=False)
    figure.claims.append(only_claim(row.paper, "line_1", "line_2", "pillar_1", "pillar_2", "plate"))


def f11(lab: Lab, figure: Figure) -> None:
    """One region."""
    row = play_row(lab, figure, SCENE, "bunny_single_region")
    figure.claims.append(only_claim(row.paper, "line_1"))
    figure.claims.append(at_most("The contact is one region all the time", float(row.paper.regions["line_1"].max()), 1, "regions"))
    force = numpy.linalg.norm(row.paper.force_n, axis=1)
    torque = numpy.linalg.norm(row.paper.torque_n_m, axis=1)
    pressed = force > 0.5
    figure.claims.append(at_most("Torque is small: largest over force times the bunny's half length of 31 mm",
                                 float((torque[pressed] / force[pressed] / 0.0314).max()), 0.1, ""))


def f12a(lab: Lab, figure: Figure) -> None:
    """Two regions of one line."""
    row = play_row(lab, figure, SCENE, "bunny_two_regions")
    figure.claims.append(only_claim(row.paper, "line_1"))
    two = row.paper.regions["line_1"] >= 2
    figure.claims.append(at_least("One line is touched in two regions more than 5 mm apart", float(two.sum()), 100, "ticks"))
    _torque_claim(figure, lab, row.paper, row.paper.touched("line_1"))


def f12b(lab: Lab, figure: Figure) -> None:
    """A line and a pillar."""
    row = play_row(lab, figure, SCENE, "bunny_line_and_pillar")
    figure.claims.append(only_claim(row.paper, "line_1", "pillar_1"))
    figure.claims.append(together_claim(row.paper, "line_1", "pillar_1"))
    _torque_claim(figure, lab, row.paper, touched_together(row.paper, "line_1", "pillar_1"))


def f12c(lab: Lab, figure: Figure) -> None:
    """Wedged between two lines, and twisted."""
    row = play_row(lab, figure, SCENE, "bunny_two_lines")
    figure.claims.append(only_claim(row.paper, "line_1", "line_2"))
    figure.claims.append(together_claim(row.paper, "line_1", "line_2"))
    both = touched_together(row.paper, "line_1", "line_2")
    _torque_claim(figure, lab, row.paper, both)
    torque = numpy.abs(row.paper.torque_n_m)
    most = int(numpy.argmax(numpy.where(both, torque[:, 1], 0.0)))
    figure.claims.append(at_least("Twisted, the torque about y is larger than that about x and z: tau_y over the larger of them",
                                  float(torque[most, 1] / max(torque[most, 0], torque[most, 2])), TORQUE_RATIO, "",
                                  f"at {row.paper.t_s[most]:.3f} s, where tau_y is largest: {torque[most, 1] * 1e3:.1f} mN m"))


def f13(lab: Lab, figure: Figure) -> None:
    """From pillar to line and back."""
    row = play_row(lab, figure, SCENE, "contact_switch")
    trace = row.paper
    figure.claims.append(only_claim(trace, "line_1", "pillar_1"))
    line, pillar = trace.touched("line_1"), trace.touched("pillar_1")
    alone = line & ~pillar
    figure.claims.append(at_most("On the line alone F_x is zero, from the very tick in which the pillar is lost",
                                 float(numpy.abs(trace.force_n[alone, 0]).max(initial=0.0)), ZERO_N, "N", source=NUMBER))
    figure.claims.append(at_least("On the pillar it is not", float(numpy.abs(trace.force_n[pillar, 0]).max(initial=0.0)), 0.1, "N"))
    first = numpy.flatnonzero(alone)
    ways = bool(len(first)) and pillar[:first[0]].any() and pillar[first[-1]:].any()
    figure.claims.append(is_so("Both ways are gone: pillar, line, pillar", ways, "yes" if ways else "no", "yes"))


SPECS = [
    Spec("F10", "The bunny and its frame", "a bunny for a tool; two rigid lines, two pillars and a plate, all of which can be touched", f10, 40.0),
    Spec("F11", "Contact in one region", "no penetration; force and torque continuous; the torque small", f11, 30.0),
    Spec("F12a", "One line in two regions", "no penetration; continuous; torque clearly larger than in F11", f12a, 30.0),
    Spec("F12b", "A line and a pillar", "no penetration; continuous; torque clearly larger than in F11", f12b, 30.0),
    Spec("F12c", "Two lines, wedged and twisted", "no penetration; continuous; a large torque about y", f12c, 30.0),
    Spec("F13", "Switch of contact", "slides on the pillar and switches to the line, and back; F_x zero from the switch; stable", f13, 40.0),
]
