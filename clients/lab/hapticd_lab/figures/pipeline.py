"""Fig. 2: the stages of a tick, from a session on the real clock, with what each takes."""
from __future__ import annotations

from typing import Any, Dict, List

import numpy
from matplotlib import pyplot

import hapticd
from hapticd.v1 import state_pb2
from hapticd_lab import plots
from hapticd_lab.figure import NUMBER, Figure, Spec, at_most, is_so
from hapticd_lab.player import Daemon

SECONDS = 6
SETTLING_S = 1.0
"""Of the beginning, left out: force comes on, memory is touched for the first time."""
STAGES = ("READ", "COLLISION", "SOLVER", "STRINGS", "SAFETY", "WRITE", "PUBLISH")
"""Those that the daemon measures, in the order of a tick; collision and solver take turns."""
STAGE_TEXT = {
    "READ": "read the device, map its pose to the scene (q_h)",
    "COLLISION": "collision search on both branches: pairs near the tool",
    "SOLVER": "configuration optimisation (q_g), force and torque",
    "STRINGS": "strings' response, touches and releases",
    "SAFETY": "limits of growth and size, passivity",
    "WRITE": "write the wrench to the device",
    "PUBLISH": "events, State, record",
}
STAGE_COLORS = dict(zip(STAGES, ("#56b4e9", "#d55e00", "#e69f00", "#f0e442", "#cc79a7", "#009e73", "#999999")))
IN_PAPER = {
    "READ": "configuration of the haptic tool",
    "COLLISION": "collision detection (two branches)",
    "SOLVER": "optimisation, force model",
    "STRINGS": "response of the string",
    "SAFETY": "not in the paper",
    "WRITE": "feedback force and torque",
    "PUBLISH": "graphic display, sound: here in other processes",
}


def _session() -> List[state_pb2.State]:
    """States of a hand on body and strings at once, on the real clock."""
    with Daemon("--scene", "guqin", "--gesture", "hybrid_contact") as daemon, hapticd.Session(
        daemon.address, keep_states=SECONDS * 1100
    ) as session:
        session.subscribe(1, ("TOOLS", "CONTACTS", "TIMING", "STAGES", "QUALITY"))
        states = list(session.states(SECONDS * 1000, timeout=3.0))
        return [state for state in states if state.t_ns > states[0].t_ns + SETTLING_S * 1e9]


def _table(states: List[state_pb2.State]) -> Dict[str, numpy.ndarray]:
    """Time of every tick by stage, us; "" is the whole tick, thread CPU time."""
    names = {getattr(state_pb2, f"STAGE_{name}"): name for name in STAGES}
    table = {name: numpy.zeros(len(states)) for name in STAGES}
    table[""] = numpy.array([state.timing.last_ns * 1e-3 for state in states])
    for row, state in enumerate(states):
        for stage in state.timing.stages:
            if stage.stage in names:
                table[names[stage.stage]][row] = stage.last_ns * 1e-3
    return table


def _branches(states: List[state_pb2.State]) -> Dict[str, int]:
    """In how many ticks each branch of the collision search found what bears force."""
    found = {"body": 0, "string": 0, "both": 0}
    for state in states:
        kinds = {patch.WhichOneof("object") for patch in state.contacts if any(patch.force_w_n)}
        found["body"] += "body_index" in kinds
        found["string"] += "string_index" in kinds
        found["both"] += {"body_index", "string_index"} <= kinds
    return found


def _draw(table: Dict[str, numpy.ndarray], title: str) -> plots.Picture:
    medians = {name: float(numpy.median(table[name])) for name in STAGES}
    with pyplot.rc_context(plots.STYLE):
        figure, (chain, ticks) = pyplot.subplots(2, 1, constrained_layout=True, figsize=(11.0, 5.6), gridspec_kw={"height_ratios": [1.0, 2.0]})
        figure.suptitle(title, fontsize=10.5, fontweight="bold")
        at, whole = 0.0, sum(medians.values())
        for name in STAGES:
            chain.barh(
                0,
                medians[name],
                left=at,
                color=STAGE_COLORS[name],
                height=0.6,
                label=f"{name.lower()}: {medians[name]:.2g} \N{MICRO SIGN}s, {100 * medians[name] / whole:.0f} %",
            )
            at += medians[name]
        chain.set(yticks=[], xlabel="median of each stage, \N{MICRO SIGN}s; one after the other as in a tick", ylim=(-0.5, 0.5))
        chain.legend(ncol=5, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
        for name in STAGES:
            values = numpy.sort(table[name])
            ticks.plot(values, numpy.arange(1, len(values) + 1) / len(values), color=STAGE_COLORS[name], label=name.lower())
        values = numpy.sort(table[""])
        ticks.plot(values, numpy.arange(1, len(values) + 1) / len(values), color="#222222", label="tick, thread CPU")
        ticks.axvline(plots.PERIOD_US, color="#d1352b", linestyle="--", linewidth=0.9, label="1 ms")
        ticks.set(xscale="log", xlabel="time, \N{MICRO SIGN}s", ylabel="share of ticks that took less")
        ticks.legend(loc="lower right")
    return plots.Picture(figure)


def make(lab: Any, figure: Figure) -> None:
    """Fig. 2."""
    states = _session()
    table, found = _table(states), _branches(states)
    share = {name: float(table[name].sum() / sum(table[each].sum() for each in STAGES)) for name in STAGES}
    _draw(table, f"F2: a tick, stage by stage, {len(states)} ticks of a hand on body and strings").save(lab.folder / "pipeline")
    figure.pictures["pipeline.svg"] = "Above: the stages of a tick in their order, by their medians. Below: how they are distributed"
    figure.tables["Stages of a tick, as the daemon measures them (section STAGES of its States), wall clock"] = [
        ["stage", "what it does", "in the paper's flow chart", "median, us", "p99, us", "share"],
        *(
            [
                name.lower(),
                STAGE_TEXT[name],
                IN_PAPER[name],
                f"{numpy.median(table[name]):.3g}",
                f"{numpy.percentile(table[name], 99):.3g}",
                f"{100 * share[name]:.1f} %",
            ]
            for name in STAGES
        ),
    ]
    work = numpy.array([[state.quality.substeps, state.quality.sphere_tests, state.quality.qp_iterations] for state in states])
    figure.tables["Work of a tick"] = [
        ["", "median", "most"],
        *(
            [name, f"{numpy.median(work[:, i]):.0f}", f"{work[:, i].max()}"]
            for i, name in enumerate(("linearisations", "tests of spheres and bounds", "iterations of the quadratic program"))
        ),
    ]
    under = float((table[""] < plots.PERIOD_US).mean())
    figure.claims += [
        is_so(
            "Every stage of the chart runs in every tick",
            all((table[name] > 0).mean() > 0.99 for name in STAGES),
            ", ".join(f"{name.lower()} in {100 * (table[name] > 0).mean():.1f} %" for name in STAGES),
            "each in over 99 % of the ticks",
        ),
        is_so(
            "Collision is searched on two branches, sphere-tree against sphere-tree and sphere-tree against cylinder",
            found["string"] > 0 and found["body"] > 0,
            f"strings bear force in {found['string']} ticks, bodies in {found['body']}, both at once in {found['both']}",
            "either in some tick",
        ),
        at_most(
            "Time of a tick, median of its thread CPU time",
            float(numpy.median(table[""])),
            plots.PERIOD_US,
            "us",
            f"the text says less than 1 ms in most phases. {100.0 * under:.2f} % of the ticks were within it, "
            f"the longest took {table[''].max():.0f} us, "
            "on the real clock and with whatever else this machine did",
            NUMBER,
        ),
    ]
    figure.notes.append("Collision is searched anew where a step leaves what was looked at: the second table says how often. Nothing is computed from times.")


SPECS = [
    Spec(
        "F2",
        "The pipeline",
        "flow chart of the approach: collision detection in two branches, optimisation, force, response of the string",
        make,
        12.0,
    )
]
