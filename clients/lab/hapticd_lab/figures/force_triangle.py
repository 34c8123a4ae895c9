"""Fig. 9: external and internal force on a string, Eq. 10 to 13, from presses through the protocol, against the equations in 50 digits."""
from __future__ import annotations

import decimal
from typing import Any, Dict, Tuple

import numpy
from matplotlib import pyplot

from hapticd_lab import plots
from hapticd_lab.figure import Figure, Spec, at_most
from hapticd_lab.states_of import states_of

decimal.getcontext().prec = 50
SCENE = "single_string"
TENSION_N, YOUNG_PA, RADIUS_M, LENGTH_M = 30.0, 1.9e11, 0.34e-3, 1.1
"""The paper's reference values; the length is that of the scene, more than 1000 times the radius."""
PI = decimal.Decimal("3.1415926535897932384626433832795028841971693993751")
PLACES = (0.5, 0.25, 0.1)
TOUCH_M, DEEPEST_M, SPEED_M_PER_S = 5.34e-3, 10e-3, 0.02
LEAST_M = 1e-6
"""Below it the difference of two positions has too few digits left."""
LAW_ERROR = 1e-6
"""Forces in States are 32-bit numbers: 6e-8."""
LATERAL_SHARE = 0.05
COLORS = dict(zip(PLACES, ("#0072b2", "#e69f00", "#009e73")))


def eq_10(delta_m: float, place: float) -> Tuple[decimal.Decimal, decimal.Decimal, decimal.Decimal, decimal.Decimal]:
    """|F_r| with exact sines, |F_r| as printed, |F_i|, and the lateral force that the paper leaves out; N."""
    one, delta, length = decimal.Decimal(1), decimal.Decimal(delta_m), decimal.Decimal(repr(LENGTH_M))
    tension, share = decimal.Decimal(repr(TENSION_N)), decimal.Decimal(repr(place))
    first, second = ((share * length) ** 2 + delta**2).sqrt(), (((one - share) * length) ** 2 + delta**2).sqrt()
    area = PI * decimal.Decimal(repr(RADIUS_M)) ** 2
    inner = decimal.Decimal(repr(YOUNG_PA)) * area * (first + second - length) / length
    whole = tension + inner
    printed = whole * (_sin(delta / first) + _sin(delta / second))
    return whole * (delta / first + delta / second), printed, inner, abs(whole * (share * length / first - (one - share) * length / second))


def _sin(x: decimal.Decimal) -> decimal.Decimal:
    term, total, n = x, x, 1
    while term != 0 and abs(term) > abs(total) * decimal.Decimal("1e-48"):
        n += 2
        term = -term * x * x / (n * (n - 1))
        total += term
    return total


def press(place: float) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """A finger pressed onto the string from above at lambda = `place`: displacement of the hand from the finger (n x 3), force (n x 3)."""
    y = numpy.arange(TOUCH_M + 1e-3, TOUCH_M - DEEPEST_M, -SPEED_M_PER_S * 1e-3)
    poses = numpy.column_stack([numpy.full(len(y), (place - 0.5) * LENGTH_M), y, numpy.zeros(len(y))])
    tools = [state.tools[0] for state in states_of(SCENE, poses, ("TOOLS",))]
    apart = numpy.array([numpy.subtract(tool.p_wg_m, tool.p_wh_m) for tool in tools])
    # Less what a tool in motion keeps clear, which is not felt.
    clear = numpy.array([tool.minimum_gap_m for tool in tools])
    apart *= numpy.maximum(0.0, 1.0 - clear / numpy.maximum(numpy.linalg.norm(apart, axis=1), 1e-12))[:, None]
    force = numpy.array([tool.wrench_h_w[:3] for tool in tools])
    pressed = numpy.linalg.norm(apart, axis=1) > LEAST_M
    return apart[pressed], force[pressed]


def _draw_triangle(axis: Any) -> None:
    """The string at lambda = 0.25, much too deep, with the forces at the finger."""
    a, b, p = numpy.array([0.0, 0.0]), numpy.array([1.0, 0.0]), numpy.array([0.25, -0.16])
    axis.plot([a[0], b[0]], [0.0, 0.0], ":", color="#888888")
    axis.plot([a[0], p[0], b[0]], [a[1], p[1], b[1]], color="#7a5a20", linewidth=1.6)
    legs = [(end - p) / numpy.linalg.norm(end - p) for end in (a, b)]
    for leg, at in zip(legs, ((0.06, -0.15), (0.52, -0.16))):
        axis.annotate("", p + 0.22 * leg, p, arrowprops={"arrowstyle": "-|>", "color": "#0072b2", "lw": 1.6})
        axis.annotate("|T| + |F_i|", at, ha="center", color="#0072b2", fontsize=8)
    up = 0.22 * (legs[0][1] + legs[1][1])
    axis.annotate("", p + [0.0, up], p, arrowprops={"arrowstyle": "-|>", "color": "#d1352b", "lw": 1.8})
    axis.annotate("|F_r|", p + [0.015, up], color="#d1352b", fontsize=9)
    for at, name in ((a, "A"), (b, "B")):
        axis.annotate(name, at + [0.0, 0.03], ha="center")
    axis.plot([p[0]] * 2, [0.0, p[1]], ":", color="#888888")
    axis.annotate("\N{GREEK SMALL LETTER DELTA}", (p[0] - 0.025, -0.03), fontsize=9)
    axis.set(xlim=(-0.12, 1.1), ylim=(-0.3, 0.2), title="Forces at the finger (not to scale)")
    axis.set_axis_off()


def _draw(measured: Dict[float, Tuple[numpy.ndarray, numpy.ndarray]]) -> plots.Picture:
    with pyplot.rc_context(plots.STYLE):
        figure, (triangle, curves) = pyplot.subplots(1, 2, constrained_layout=True, figsize=(11.0, 3.8))
        figure.suptitle("F9: the force of a pressed string", fontsize=10.5, fontweight="bold")
        _draw_triangle(triangle)
        for place, (apart, force) in measured.items():
            delta = numpy.linalg.norm(apart, axis=1)
            law = [float(eq_10(each, place)[0]) for each in delta]
            curves.plot(
                1e3 * delta[::20],
                numpy.linalg.norm(force, axis=1)[::20],
                "o",
                markersize=3,
                color=COLORS[place],
                label=f"session, \N{GREEK SMALL LETTER LAMDA} = {place}",
            )
            curves.plot(1e3 * delta, law, color=COLORS[place], linewidth=0.9)
            curves.plot(1e3 * delta, TENSION_N * delta / (LENGTH_M * place * (1.0 - place)), ":", color=COLORS[place], linewidth=0.9)
        curves.plot([], [], color="#444444", linewidth=0.9, label="Eq. 10 to 12")
        curves.plot([], [], ":", color="#444444", linewidth=0.9, label="tension alone")
        curves.set(xlabel="deflection, mm", ylabel="force, N")
        curves.legend()
    return plots.Picture(figure)


def _tables(figure: Figure) -> float:
    """What the equations say; the largest share of the force that the lateral force has."""
    rows, worst = [["lambda", "deflection, mm", "|F_r|, N", "of it F_i's", "as printed, sin(delta/L1)", "lateral, left out"]], 0.0
    for place in PLACES:
        for delta_m in (1e-3, 5e-3, 10e-3):
            exact, printed, inner, lateral = eq_10(delta_m, place)
            worst = max(worst, float(lateral / exact))
            rows.append(
                [
                    f"{place}",
                    f"{1e3 * delta_m:.0f}",
                    f"{exact:.4f}",
                    f"{100 * inner / (inner + decimal.Decimal(repr(TENSION_N))):.2f} %",
                    f"{1_000_000 * (printed / exact - 1):.1f} ppm",
                    f"{100 * lateral / exact:.2f} %",
                ]
            )
    figure.tables["Eq. 10 to 12 with the paper's T, E and R"] = rows
    return worst


def make(lab: Any, figure: Figure) -> None:
    """Fig. 9."""
    measured = {place: press(place) for place in PLACES}
    for place, (apart, force) in measured.items():
        delta, size = numpy.linalg.norm(apart, axis=1), numpy.linalg.norm(force, axis=1)
        error = max(abs(float(decimal.Decimal(float(each)) / eq_10(float(at), place)[0] - 1)) for at, each in zip(delta, size))
        aside = numpy.degrees(numpy.arccos(numpy.clip((apart * force).sum(axis=1) / (delta * size), -1.0, 1.0))).max()
        figure.claims += [
            at_most(
                f"At lambda = {place} the force is Eq. 10 to 12, delta from Eq. 13: largest relative difference",
                error,
                LAW_ERROR,
                "",
                f"{len(delta)} ticks of a press to {1e3 * delta.max():.1f} mm, from {1e3 * size.min():.2g} mN to {size.max():.2f} N; "
                "the equations in 50 digits, sines exact, k_s = 1",
            ),
            at_most(f"At lambda = {place} it points against the deflection: angle", float(aside), 1e-3, "degrees"),
        ]
    _draw(measured).save(lab.folder / "triangle")
    figure.pictures[
        "triangle.svg"
    ] = "Left: the triangle of forces. Right: the force in sessions (dots), by Eq. 10 to 12 (lines), and of the tension alone (dotted)"
    figure.claims.append(
        at_most(
            "The lateral force that is left out is small: largest share of the force",
            100.0 * _tables(figure),
            100.0 * LATERAL_SHARE,
            "%",
            "the paper calls it very small; option lateral_force of a scene renders it",
        )
    )
    figure.notes.append(
        "Eq. 10 is printed with sin(delta/L1), where delta/L1 is the sine already; ours takes the exact sine. The table has the difference."
    )


SPECS = [
    Spec(
        "F9",
        "External and internal force on a string",
        "balance of the pre-tension, the internal axial force and the repulsive force, Eq. 10 to 13",
        make,
        10.0,
    )
]
