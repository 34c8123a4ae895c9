"""Fig. 7: a sphere against a cylinder, the two cases of the projection (Eq. 1 to 4), and what the end of a string feels like. The gaps and
places that the daemon finds are held against the paper's equations, evaluated here."""
from __future__ import annotations

from typing import Any, List, Tuple

import numpy
from matplotlib import patches, pyplot

from hapticd.v1 import state_pb2
from hapticd_lab import plots
from hapticd_lab.figure import OURS, WORDS, Figure, Spec, at_least, at_most, is_so
from hapticd_lab.states_of import states_of

SCENE, END_M, R_STRING_M, R_TOOL_M = "single_string", 0.55, 0.34e-3, 5e-3
A, B = numpy.array([-END_M, 0.0, 0.0]), numpy.array([END_M, 0.0, 0.0])
SUM_M = R_STRING_M + R_TOOL_M
ROUNDING_M = 1e-9
"""Gaps in States are 32-bit numbers."""
LAMBDA_ROUNDING = 1e-7
KT_N_PER_M, LEAST_CHANGE_N = 1000.0, 0.15
HELD_TICKS = 3
"""A gap is that before the last step of a tick: each pose is held until the tool stands."""
SLIDE_M_PER_S, PRESS_M = 0.1, 1e-3


def equations(p_m: numpy.ndarray) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """d (m) and lambda of sphere centres (n x 3): Eq. 2, with the division by |AB|^2 that its print lacks, and Eq. 3."""
    along = B - A
    d = numpy.linalg.norm(numpy.cross(p_m - A, along), axis=1) / numpy.linalg.norm(along)
    return d, (p_m - A) @ along / (along @ along)


def _spiral() -> numpy.ndarray:
    """Free poses round the string, from one end's far side to the other's; the gap swings between 0.1 and 4 mm. Tool centres, n x 3."""
    s = numpy.linspace(0.0, 1.0, 3000)
    gap = 2.05e-3 - 1.95e-3 * numpy.cos(40.0 * numpy.pi * s)
    angle = 26.0 * numpy.pi * s
    return numpy.column_stack([-0.553 + 1.106 * s, (SUM_M + gap) * numpy.sin(angle), (SUM_M + gap) * numpy.cos(angle)])


def _slide_off() -> numpy.ndarray:
    """Pressed onto the string near its end, along it, and over the end."""
    down = numpy.arange(SUM_M + 5e-4, SUM_M - PRESS_M, -1e-5)
    along = numpy.arange(0.5, END_M + 0.012, SLIDE_M_PER_S * 1e-3)
    return numpy.vstack(
        [
            numpy.column_stack([numpy.full(len(down), along[0]), down, numpy.zeros(len(down))]),
            numpy.column_stack([along, numpy.full(len(along), SUM_M - PRESS_M), numpy.zeros(len(along))]),
        ]
    )


def _centres(states: List[state_pb2.State]) -> numpy.ndarray:
    return numpy.array([state.tools[0].p_wg_m for state in states])


def _claim_gaps(figure: Figure) -> None:
    states = states_of(SCENE, numpy.repeat(_spiral(), HELD_TICKS, axis=0), ("TOOLS",))[HELD_TICKS - 1 :: HELD_TICKS]
    centres, gap = _centres(states), numpy.array([state.tools[0].minimum_gap_m for state in states])
    d, along = equations(centres)
    inside = (along >= 0.0) & (along <= 1.0)
    ends = numpy.minimum(numpy.linalg.norm(centres - A, axis=1), numpy.linalg.norm(centres - B, axis=1))
    figure.claims += [
        at_most(
            "Case 1, the projection falls on the cylinder: the gap is d - (r_T + r_c), d by Eq. 2: difference",
            float(numpy.abs(gap - (d - SUM_M))[inside].max()) * 1e6,
            ROUNDING_M * 1e6,
            "um",
            f"{inside.sum()} poses round the string. Eq. 2 is printed without its division by |AB|^2",
        ),
        at_least("Case 2, the projection falls beyond an end: poses looked at", int((~inside).sum()), 10, "poses"),
        at_most(
            "Case 2: the gap is that to the end of the axis: difference",
            float(numpy.abs(gap - (ends - SUM_M))[~inside].max()) * 1e6,
            ROUNDING_M * 1e6,
            "um",
            "a deviation on purpose: the paper's Eq. 4 wants lambda in [0, 1], with a small margin. Ours is a capsule, whose distance has no edge",
            OURS,
        ),
    ]


def _claim_slide(figure: Figure) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """The claims about contact; lambda and force (n x 3) of the slide over the end."""
    poses = _slide_off()
    states = states_of(SCENE, poses, ("TOOLS", "STRINGS"))
    centres, force = _centres(states), numpy.array([state.tools[0].wrench_h_w[:3] for state in states])
    _, along = equations(centres)
    touched = numpy.array(
        [any(each.phase in (state_pb2.STRING_PHASE_TOUCHED, state_pb2.STRING_PHASE_PRESSED) for each in state.strings) for state in states]
    )
    said = numpy.array([getattr(state.strings[0], "lambda") for state in states if state.strings])
    place = numpy.clip(along[[bool(state.strings) for state in states]], 0.0, 1.0)
    pressing = touched[[bool(state.strings) for state in states]]
    change = numpy.linalg.norm(numpy.diff(force, axis=0), axis=1)
    bound = max(LEAST_CHANGE_N, 1.1 * KT_N_PER_M * SLIDE_M_PER_S * 1e-3)
    at_end = float(numpy.linalg.norm(force[numpy.searchsorted(along, 1.0) - 1]))
    figure.claims += [
        at_most(
            "The place of the contact is Eq. 3: difference of lambda",
            float(numpy.abs(said - place)[pressing].max()),
            LAMBDA_ROUNDING,
            "",
            f"{pressing.sum()} ticks pressed",
        ),
        is_so(
            "Beyond the end the sphere can still touch the string",
            bool((touched & (along > 1.0)).any()),
            f"touched up to {1e3 * END_M * 2 * (along[touched].max() - 1.0):.2f} mm beyond the end",
            "touched beyond lambda = 1",
        ),
        at_most(
            "Sliding over the end, it is not distorted: largest change of the force in a tick",
            float(change.max()),
            bound,
            "N",
            f"a flat end would take {at_end:.2f} N away in one tick; its margin only moves the place where that happens",
            WORDS,
        ),
    ]
    return along, force


def _draw_cases(axis: Any) -> None:
    axis.add_patch(patches.Rectangle((0.0, -0.1), 1.0, 0.2, color="#c9b48a"))
    axis.add_patch(patches.Wedge((1.0, 0.0), 0.1, -90.0, 90.0, color="#e4d9bf"))
    axis.add_patch(patches.Wedge((0.0, 0.0), 0.1, 90.0, 270.0, color="#e4d9bf"))
    axis.plot([0.0, 1.0], [0.0, 0.0], "-.", color="#555555", linewidth=0.8)
    for at, color, name in ((0.4, "#0072b2", "case 1"), (1.12, "#d55e00", "case 2")):
        axis.add_patch(patches.Circle((at, 0.34), 0.22, fill=False, color=color, linewidth=1.3))
        foot = min(at, 1.0)
        axis.plot([at, at], [0.34, 0.0], ":", color=color)
        axis.plot([at, foot], [0.34, 0.0], color=color)
        axis.annotate(name, (at, 0.62), ha="center", color=color)
        axis.annotate("D", (at, -0.03), ha="center", va="top", fontsize=8, color=color)
    for at, name in ((0.0, "A, \N{GREEK SMALL LETTER LAMDA} = 0"), (1.0, "B, \N{GREEK SMALL LETTER LAMDA} = 1")):
        axis.annotate(name, (at, -0.22), ha="center", fontsize=8)
    axis.set(xlim=(-0.3, 1.5), ylim=(-0.35, 0.75), aspect="equal", title="What is measured: d to the axis, or to its end (light: the caps)")
    axis.set_axis_off()


def make(lab: Any, figure: Figure) -> None:
    """Fig. 7."""
    _claim_gaps(figure)
    along, force = _claim_slide(figure)
    beyond_mm = 1e3 * 2.0 * END_M * (along - 1.0)
    near = beyond_mm > -8.0
    with pyplot.rc_context(plots.STYLE):
        picture, (cases, curve) = pyplot.subplots(1, 2, constrained_layout=True, figsize=(11.0, 3.6))
        picture.suptitle("F7: a sphere against a cylinder, both cases", fontsize=10.5, fontweight="bold")
        _draw_cases(cases)
        for i, name in enumerate("xyz"):
            curve.plot(beyond_mm[near], force[near, i], color=plots.AXIS_COLORS[i], linestyle=plots.AXIS_STYLES[i], label=f"F_{name}, ours")
        flat = numpy.where(along <= 1.0, force[:, 1], 0.0)
        curve.plot(beyond_mm[near], flat[near], color="#777777", linewidth=1.3, label="F_y with a flat end")
        curve.axvline(0.0, color="#7a3fa0", linestyle=":", linewidth=0.8)
        curve.set(
            xlabel="place of the tool's centre beyond the end, mm", ylabel="force, N", title=f"Sliding over the end at {SLIDE_M_PER_S} m/s"
        )
        curve.legend()
    plots.Picture(picture).save(lab.folder / "cases")
    figure.pictures[
        "cases.svg"
    ] = "Left: the two cases. Right: the force while a pressed finger slides over the end of a string; grey, what a flat end would do"


SPECS = [
    Spec("F7", "Sphere and cylinder", "two cases: the projection of the sphere's centre falls on the cylinder, or beyond its end", make, 8.0)
]
