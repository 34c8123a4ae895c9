"""Fig. 6: the search of a sphere-tree against a cylinder, level by level. The contacts of a real session are held against a descent of
the tree's file and against an exhaustive search of its leaves, both done here."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Tuple

import numpy
from matplotlib import pyplot

import hapticd
from hapticd.v1 import state_pb2
from hapticd_lab import plots, shaded, sphere_tree
from hapticd_lab.figure import OURS, Figure, Spec, at_most, is_so
from hapticd_lab.states_of import states_of

TREE, MESH = "hand_500um.tree", "hand.ply"
RADIUS_M, HALF_LENGTH_M, SKIN_M = 0.34e-3, 0.55, 20e-6
SCENE = """name: "descent"
tools { name: "hand" parts { name: "hand" shape { tree: "%s" mesh: "%s" } } pose_wg { p_m: [0, 0.3, 0] } }
strings { name: "C2" p_wa_m: [-0.55, 0, 0] p_wb_m: [0.55, 0, 0] radius_m: 0.00034 frequency_hz: 65.4 }
torque {}
""" % (
    TREE,
    MESH,
)
PRESS_M, ABOVE_M, SPEED_M_PER_S, HELD_TICKS = 1e-3, 0.02, 0.05, 100
MARGIN_M = 5e-3
"""Pairs nearer than this are candidates of the optimisation."""
LISTED_M = 2.0 * SKIN_M
"""Pairs nearer than this are listed in a State, whether they bear force or not."""
ROUNDING_M = 1e-7
"""Orientations in States are 32-bit numbers; over the length of a hand that is 20 nm."""
RED, PALE = numpy.array([0.85, 0.15, 0.12]), numpy.array([0.72, 0.78, 0.86])


@dataclass
class Level:
    """What the descent looked at on one level: spheres (n x 4, tool frame) and which of them meet the cylinder."""

    spheres: numpy.ndarray
    hit: numpy.ndarray


def gaps(spheres: numpy.ndarray) -> numpy.ndarray:
    """Gaps of spheres (n x 4, W) to the string, from its two ends' capsule."""
    nearest = numpy.zeros((len(spheres), 3))
    nearest[:, 0] = numpy.clip(spheres[:, 0], -HALF_LENGTH_M, HALF_LENGTH_M)
    return numpy.linalg.norm(spheres[:, :3] - nearest, axis=1) - spheres[:, 3] - RADIUS_M


def descend(tree: sphere_tree.Tree, placed: Any, reach_m: float) -> Tuple[List[Level], List[int]]:
    """Level by level from the root: a sphere whose gap is beyond `reach_m` is not looked into. Returns what was looked at, and the leaves
    that are within it. `placed`: tool frame to world."""
    levels, leaves, front = [], [], [0]
    while front:
        slots = [slot for node in front for slot in tree.nodes[node]]
        spheres = numpy.array([tree.leaves[target] if bound is None else bound for bound, target in slots])
        hit = gaps(placed(spheres)) <= reach_m
        levels.append(Level(spheres, hit))
        leaves += [target for (bound, target), met in zip(slots, hit) if met and bound is None]
        front = [target for (bound, target), met in zip(slots, hit) if met and bound is not None]
    return levels, sorted(leaves)


def _play(tree: sphere_tree.Tree) -> state_pb2.State:
    """The hand is pressed onto the string with its lowest leaf; the State of the last tick."""
    lowest = tree.leaves[numpy.argmin(tree.leaves[:, 1] - tree.leaves[:, 3])]
    end = numpy.array([0.0, RADIUS_M + lowest[3] - lowest[1] - PRESS_M, -lowest[2]])
    down = numpy.arange(ABOVE_M, 0.0, -SPEED_M_PER_S * 1e-3)
    poses = numpy.vstack([end + [0.0, height, 0.0] for height in down] + [end] * HELD_TICKS)
    return states_of(SCENE, poses, ("TOOLS", "CONTACTS", "QUALITY"))[-1]


def _placing(tool: state_pb2.ToolState) -> Any:
    w, x, y, z = numpy.asarray(tool.q_wg, float) / numpy.linalg.norm(tool.q_wg)
    turn = numpy.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return lambda spheres: numpy.hstack([spheres[:, :3] @ turn.T + numpy.asarray(tool.p_wg_m), spheres[:, 3:]])


def _draw(levels: List[Level], placed: Any, tree: sphere_tree.Tree) -> plots.Picture:
    eye = shaded.view(0.75, 0.2)
    beads = numpy.zeros((1200, 4))
    beads[:, 0], beads[:, 3] = numpy.linspace(-0.3, 0.3, 1200), 3.0 * RADIUS_M  # drawn thicker than it is
    with pyplot.rc_context(plots.STYLE):
        figure, axes = pyplot.subplots(1, len(levels) + 1, constrained_layout=True, figsize=(3.6 * (len(levels) + 1), 3.6))
        figure.suptitle("F6: descent of the hand's sphere-tree against a string", fontsize=10.5, fontweight="bold")
        extent = shaded.window(placed(levels[0].spheres), eye)
        for at, axis in enumerate(axes):
            axis.set_axis_off()
            level = levels[min(at, len(levels) - 1)]
            spheres = level.spheres if at < len(levels) else tree.leaves
            hit = level.hit if at < len(levels) else gaps(placed(tree.leaves)) <= MARGIN_M
            colors = numpy.vstack([numpy.where(hit[:, None], RED, PALE), numpy.tile([0.2, 0.2, 0.2], (len(beads), 1))])
            axis.imshow(shaded.draw_spheres(numpy.vstack([placed(spheres), beads]), colors, eye, extent, 640), interpolation="antialiased")
            axis.set_title(
                f"step {at + 1}: {len(hit)} looked at, {hit.sum()} near" if at < len(levels) else f"all {len(hit)} leaves, {hit.sum()} near",
                fontsize=8.5,
            )
    return plots.Picture(figure)


def _listed(state: state_pb2.State) -> Dict[int, Tuple[float, float]]:
    """Gap (m) and force (N) of the daemon's contacts with the string, by leaf."""
    found: Dict[int, Tuple[float, float]] = {}
    for patch in state.contacts:
        table = hapticd.contacts(patch)
        for leaf, gap_m, force_n in zip(table["tool_sphere"], table["gap_m"], table["force_n"]):
            found[int(leaf)] = (float(gap_m), float(force_n))
    return found


def make(lab: Any, figure: Figure) -> None:
    """Fig. 6."""
    tree = sphere_tree.read_tree(sphere_tree.model_path(TREE))
    state = _play(tree)
    placed = _placing(state.tools[0])
    levels, found = descend(tree, placed, MARGIN_M)
    exact = gaps(placed(tree.leaves))
    every = numpy.flatnonzero(exact <= MARGIN_M).tolist()
    listed = _listed(state)
    looked = sum(len(level.hit) for level in levels)
    missing = [leaf for leaf in range(len(exact)) if exact[leaf] < LISTED_M - ROUNDING_M and leaf not in listed]
    extra = [leaf for leaf, (_, force_n) in listed.items() if exact[leaf] > LISTED_M + ROUNDING_M and force_n == 0.0]
    worst = max((abs(gap_m - exact[leaf]) for leaf, (gap_m, _) in listed.items()), default=numpy.nan)
    _draw(levels, placed, tree).save(lab.folder / "descent")
    figure.pictures[
        "descent.png"
    ] = "Spheres that were looked at; red: within the margin of the string (drawn three times as thick as it is), and looked into"
    figure.tables["The descent"] = [
        ["step", "spheres looked at", "within the margin"],
        *([str(k + 1), str(len(level.hit)), str(int(level.hit.sum()))] for k, level in enumerate(levels)),
        ["all", str(looked), f"{len(found)} leaves"],
    ]
    figure.claims += [
        is_so(
            "Descending finds the very leaves that an exhaustive search finds",
            found == every and len(found) > 0,
            f"{len(found)} and {len(every)} leaves",
            "the same leaves, at least one",
            f"within {1e3 * MARGIN_M:.0f} mm of the string, the margin within which pairs are candidates of the optimisation",
        ),
        at_most("It looks at fewer spheres than there are leaves", looked, len(tree.leaves) - 1, "spheres"),
        is_so(
            "The contacts of the daemon are the leaves that touch",
            not missing and not extra and len(listed) > 0,
            f"{len(listed)} listed, {len(missing)} missing, {len(extra)} too many",
            "none missing, none too many",
            f"a session through the protocol, the hand pressed onto the string; listed are pairs nearer than {1e6 * LISTED_M:.0f} um",
        ),
        at_most(
            "Their gaps are those computed here from the tree's file and the pose of the graphic tool: difference",
            1e6 * worst,
            1e6 * ROUNDING_M,
            "um",
            source=OURS,
        ),
    ]
    figure.notes.append(
        f"In this tick the daemon tested {state.quality.sphere_tests} pairs in all of its queries, over {state.quality.substeps} linearisations."
    )


SPECS = [
    Spec(
        "F6",
        "Hierarchical collision detection",
        "the sphere-tree is searched level by level; the spheres in collision with the cylinder are marked",
        make,
        8.0,
    )
]
