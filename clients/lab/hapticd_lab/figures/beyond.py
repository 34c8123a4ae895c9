"""S1.2 and S4.4: what the paper names as further uses, and the gestures its players asked for."""
from __future__ import annotations

import numpy

from hapticd_lab import balances, smoothness
from hapticd_lab.figure import OURS, Figure, Spec, at_least, at_most, is_so
from hapticd_lab.figures.guqin import tones
from hapticd_lab.lab import Lab, beyond
from hapticd_lab.player import Setup
from hapticd_lab.row import BEYOND, DEEPEST_M, PAPER, Row, play_row

GESTURES = {"tiao": ["G2"], "gou": ["F2"], "mo": ["G2"], "hammer": ["G2"], "pull": ["G2"], "slide": ["G2", "G2"]}
"""Installed gestures, and the strings that sound, in order."""
SNAP_TIMES = 4.0
"""Smaller steps are also those of a balance that is about to end, where the tool goes ever farther for the same way of the hand."""


def cabin(lab: Lab, figure: Figure) -> None:
    """Pipes and cables in an aircraft cabin."""
    row = play_row(lab, figure, "cabin", "reach_through_cabin", hands=False, every_tick=False)
    touched = [name for name in row.paper.object_force_n if row.paper.touched(name).any()]
    figure.claims.append(at_least("The hand is pushed about by many objects", float(len(touched)), 10, "objects"))
    figure.claims.append(at_most("Out in the open again, the tool is at the hand: distance", float(numpy.linalg.norm(
        row.paper.p_wh_m[-1] - row.paper.p_wg_m[-1])) * 1e6, 1.0, "um", source=OURS))
    add_snap_claim(lab, figure, row)


def add_snap_claim(lab: Lab, figure: Figure, row: Row) -> None:
    """Where the force steps although nothing is lost."""
    measured = smoothness.force_changes(row.paper, row.slip_rows)
    found = balances.look_for_balances(lab, Setup("cabin", "PAPER"), row.poses, measured.beyond(SNAP_TIMES))
    figure.tables[f"Steps of the force of more than {SNAP_TIMES:g} times their bound, with the hand at rest before and back from beyond them"] = [
        ["time, s", "step, N", "over its bound", "drift at rest before it, mN", "between the two balances, N"]] + [
        [f"{row.paper.t_s[each.row]:.3f}", f"{each.step_n:.3f}", f"{(measured.change_n / measured.bound_n)[each.row]:.2f}",
         f"{each.drift_n * 1e3:.2f}", f"{each.apart_n:.3f}"] for each in found]
    wrong = [f"{row.paper.t_s[each.row]:.3f} s" for each in found if not each.is_snap]
    left = measured.beyond(0.0)[len(found):]
    rest = float((measured.change_n / measured.bound_n)[left[0]]) if left else 0.0
    figure.claims.append(is_so(f"Each step of more than {SNAP_TIMES:g} times its bound is a snap between two balances of the same hand", not wrong,
                               "; ".join(wrong) or f"yes, {len(found)}; the largest other one is {rest:.2f} times its bound", "yes", source=OURS))


def players(lab: Lab, figure: Figure) -> None:
    """Pick, wipe, hammer, pull, slide."""
    table = [["gesture", "model", "strings that sound", "level", "largest force, N", "path in anything, um"]]
    deepest, wrong = 0.0, []
    for name, strings in lab.some(list(GESTURES.items())):
        poses = lab.poses(name, "guqin")
        for heading, setup in ((PAPER, Setup("guqin")), (BEYOND, beyond("guqin"))):
            trace = lab.play(setup, poses, name)
            played = [trace.strings[tone.string_index].name for tone in tones(trace)]
            entered = lab.judge(name, trace).penetration_m
            deepest = max(deepest, entered)
            if played != strings:
                wrong.append(f"{name} ({heading}): {' '.join(played) or 'none'}")
            table.append([name, heading, " ".join(played) or "none", ", ".join(f"{tone.level:.3f}" for tone in tones(trace)),
                          f"{numpy.linalg.norm(trace.force_n, axis=1).max():.2f}", f"{entered * 1e6:.3f}"])
            figure.runs.setdefault(f"{name}, {heading}", trace)
    figure.tables["The gestures that the players asked for"] = table
    figure.claims.append(is_so("Each gesture sounds the string that it is meant for, as often as meant, in both models", not wrong, "; ".join(wrong) or "yes", "yes"))
    figure.claims.append(at_most("The tool's path never enters anything", deepest * 1e6, DEEPEST_M * 1e6, "um"))


SPECS = [
    Spec("S1.2", "Pipes and cables", "pipes and cables in a cluttered environment such as an aircraft cabin", cabin, 80.0),
    Spec("S4.4", "The players' gestures", "picking, wiping, hammering, pulling, sliding, which the players missed", players, 30.0),
]
