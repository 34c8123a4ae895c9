"""Fig. 5: the string as a cylinder of changing diameter, from a press and a sudden release through the protocol, against Eq. 9."""
from __future__ import annotations

from typing import Any, Tuple

import numpy

from hapticd.v1 import event_pb2, state_pb2
from hapticd_lab import plots
from hapticd_lab.figure import OURS, WORDS, Figure, Spec, at_least, at_most, is_so
from hapticd_lab.player import Setup
from hapticd_lab.trace import Trace

SCENE, STRING, RADIUS_M, LENGTH_M = "single_string", "C2", 0.34e-3, 1.1
TOUCH_M = 5.34e-3
"""Height of the finger's centre where it begins to touch the string."""
DEPTH_M, ABOVE_M = 2e-3, 8e-3
PRESS_M_PER_S, NEAR_M = 0.01, 0.5e-3
"""Slow, so that the press itself leaves no ringing that would add to that of the release; it begins so near."""
RELEASE_M_PER_S = 1.204
"""The paper's fastest tap."""
SLOWER_M_PER_S = (0.05, 0.2, 0.5)
HELD_S, RINGING_S = 0.5, 2.0
DEFLECTION_ERROR_UM = 1.0
DECAY_ERROR = 1e-3
AMPLITUDE_ERROR = 0.02
"""Of the closed form for a linear release: ours is integrated tick by tick."""


def _poses(release_m_per_s: float, ringing_s: float) -> numpy.ndarray:
    """From above the middle of the string straight down, held, and straight up."""
    down = numpy.arange(TOUCH_M + NEAR_M, TOUCH_M - DEPTH_M, -PRESS_M_PER_S * 1e-3)
    held = numpy.full(round(HELD_S * 1e3), TOUCH_M - DEPTH_M)
    up = numpy.arange(TOUCH_M - DEPTH_M, TOUCH_M + ABOVE_M, release_m_per_s * 1e-3)
    y = numpy.concatenate([down, held, up, numpy.full(round(ringing_s * 1e3), TOUCH_M + ABOVE_M)])
    poses = numpy.zeros((len(y), 7))
    poses[:, 1], poses[:, 3] = y, 1.0
    return poses


def _release(trace: Trace) -> Tuple[Any, float]:
    """The event of the release, and its instant in the trace."""
    event = next(
        event.body for event in trace.events if event.kind == "string_radius" and event.body.phase == event_pb2.STRING_RADIUS_PHASE_RELEASE
    )
    return event, event.t_ns * 1e-9 - trace.began_s


def _draw(trace: Trace, ringing: numpy.ndarray, law_m: numpy.ndarray, released_s: float) -> plots.Picture:
    radius_mm = trace.radius_m[STRING] * 1e3
    awake = radius_mm > 0.0
    x = numpy.linspace(-LENGTH_M / 2, LENGTH_M / 2, 201)
    event, _ = _release(trace)
    shapes = [
        plots.Line(
            f"{1e3 * after:.0f} ms after the release",
            x,
            1e3 * (RADIUS_M + event.r_max_m * numpy.cos(numpy.pi * x / LENGTH_M) * numpy.exp(-after / event.decay_s)),
            color=color,
        )
        for after, color in ((0.0, "#0072b2"), (0.25, "#56b4e9"), (1.0, "#e69f00"))
    ]
    return plots.lines(
        "F5: the string as a cylinder of changing diameter",
        [
            plots.Panel(
                "time, s",
                "radius that is drawn, mm",
                [
                    plots.Line("State of every tick", trace.t_s[awake], radius_mm[awake], color="#56b4e9"),
                    plots.Line("R + r_max exp(-t/T_d), Eq. 9", trace.t_s[ringing], law_m[ringing] * 1e3, "--", "#d55e00"),
                ],
                "Radius over time",
                bounds={"R of the string": RADIUS_M * 1e3},
                marks={"release": released_s},
            ),
            plots.Panel("along the string, m", "radius that is drawn, mm", shapes, "Envelope along the string, lowest mode"),
        ],
    )


def _slow_releases(lab: Any, figure: Figure) -> None:
    """What is left ringing after slower releases: the largest deflection all the same."""
    rows, worst = [["speed of the release, m/s", "deflection, mm", "amplitude, mm", "their ratio"]], 0.0
    for speed in (*SLOWER_M_PER_S, RELEASE_M_PER_S):
        trace = lab.play(Setup(SCENE), _poses(speed, 0.1))
        event, released_s = _release(trace)
        largest_m = float((trace.radius_m[STRING] - RADIUS_M)[trace.t_s < released_s].max())
        ratio = event.r_max_m / largest_m
        worst = max(worst, abs(ratio - 1.0))
        rows.append([f"{speed:g}", f"{1e3 * largest_m:.3f}", f"{1e3 * event.r_max_m:.3f}", f"{ratio:.3f}"])
    figure.tables["Slower releases leave as much ringing"] = rows
    figure.claims.append(
        at_most(
            "r_max is the largest deflection before the release, at any speed of it: difference",
            worst,
            AMPLITUDE_ERROR,
            "",
        )
    )


def make(lab: Any, figure: Figure) -> None:
    """Fig. 5."""
    trace = lab.play(Setup(SCENE), _poses(RELEASE_M_PER_S, RINGING_S), timed=True)
    figure.runs["paper"] = trace
    event, released_s = _release(trace)
    law_m = RADIUS_M + event.r_max_m * numpy.exp(-(trace.t_s - released_s) / event.decay_s)
    radius_m, phase = trace.radius_m[STRING], trace.string_phase[STRING]
    pressed = trace.touched(STRING) & (trace.t_s < released_s)
    ringing = phase == state_pb2.STRING_PHASE_RINGING
    _draw(trace, ringing, law_m, released_s).save(lab.folder / "radius")
    figure.pictures["radius.svg"] = "The radius that clients draw, as States have it, and Eq. 9 computed from the event of the release alone"
    # Eq. 13 with k_s = 1, less what a tool in motion keeps clear.
    delta_m = numpy.linalg.norm(trace.p_wg_m - trace.p_wh_m, axis=1) - trace.gap_m
    largest_m = float((radius_m - RADIUS_M)[pressed].max())
    fitted_s = -1.0 / numpy.polyfit(trace.t_s[ringing], numpy.log(radius_m[ringing] - RADIUS_M), 1)[0]
    apart_m = float(numpy.linalg.norm(trace.contact_m[STRING][pressed][:, 1:], axis=1).max())
    tones = sum(each.kind == "tone" for each in trace.events)
    figure.claims += [
        at_most(
            "Pressed, the radius is R plus the deflection of Eq. 13: difference",
            float(numpy.abs(radius_m - RADIUS_M - delta_m)[pressed].max()) * 1e6,
            DEFLECTION_ERROR_UM,
            "um",
            "delta = |p_g - p_h| / k_s, k_s = 1",
        ),
        at_least(
            "Released suddenly, it starts at r_max, the largest deflection before: ratio",
            event.r_max_m / largest_m,
            0.9,
            "",
            f"{1e3 * largest_m:.3f} mm pressed, let go at {RELEASE_M_PER_S} m/s; what a release leaves ringing depends on its speed, see the table",
        ),
        at_most(
            "It decays as Eq. 9: largest difference of the streamed radius from R + r_max exp(-t/T_d), of r_max",
            float(numpy.abs(radius_m - law_m)[ringing].max()) / event.r_max_m,
            DECAY_ERROR,
            "",
            f"over {ringing.sum()} ticks; r_max {1e3 * event.r_max_m:.3f} mm, T_d {event.decay_s:g} s",
        ),
        at_most(
            "Time constant fitted to the streamed radius against T_d: relative difference",
            abs(fitted_s / event.decay_s - 1.0),
            DECAY_ERROR,
            "",
            f"fitted {fitted_s:.4f} s",
        ),
        is_so(
            "The cylinder that is collided with changes its diameter too",
            apart_m > 0.9 * float(radius_m[pressed].max()),
            f"collides {1e3 * apart_m:.3f} mm from the axis while {1e3 * radius_m[pressed].max():.3f} mm are drawn",
            "as drawn",
            "a deviation on purpose: a collision radius that grows with the press pushes the finger out, which presses more. "
            "It diverges for k_s <= 1, and switched "
            "while touched it jumps the force by 1 N for each mm. Ours stays R",
            WORDS,
        ),
        is_so("The release is heard once", tones == 1, f"{tones} {'tone' if tones == 1 else 'tones'}", "1 tone", source=OURS),
    ]
    _slow_releases(lab, figure)


SPECS = [
    Spec(
        "F5",
        "A string of changing diameter",
        "the cylinder's radius grows with the press, starts at r_max on release and decays as Eq. 9",
        make,
        12.0,
    )
]
