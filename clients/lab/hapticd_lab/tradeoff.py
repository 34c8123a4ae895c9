"""Measures what accuracy costs: every knob of the solver alone, and the levels of quality, over seeded gestures in shipped scenes, against the
same input computed with 400 sub-steps; beside them the paper's method as printed and a penalty method.

DIR gets results.csv (errors and work counts, the same on every machine), times.csv and machine.txt (this machine's), plots (SVG, PNG), report.html and
report.md; and units/, a file for each gesture that is done: run again, a study that was ended goes on from them.

A large study is shared among machines by --shard K/N, each with an output of its own; hapticd-lab tradeoff --merge DIR... --output DIR puts them
together, and the numbers are those of one run on one machine. What was played is then the shards' to say, not the options'.

Exit code: 0 done; 1 the command cannot be obeyed, or a unit failed; 130 interrupted, what was finished is there."""
from __future__ import annotations

import argparse
import os
import pathlib
import subprocess
import sys
from typing import Sequence

from hapticd_lab import machine, quality_table, tradeoff_instructions, tradeoff_report, tradeoff_table
from hapticd_lab.oracle import OracleError, find_program
from hapticd_lab.quality_table import NoLevels
from hapticd_lab.tradeoff_plan import FINEST_SCENE, GESTURES, HELD_OUT, QUICK_GESTURES, QUICK_SCENES, QUICK_SPEEDS, SCENES, SPEEDS, Plan
from hapticd_lab.tradeoff_units import BadStudy, claim, gather, give_back, missing, plan_of_shards, play_all, shard_of

SUMMARY = "measure speed against accuracy"


def describe(parser: argparse.ArgumentParser) -> None:
    """Its options."""
    parser.add_argument("--output", type=pathlib.Path, metavar="DIR", default=pathlib.Path("study"),
                        help="where everything goes; made if it is not there (default: study)")
    parser.add_argument("--scene", action="append", metavar="NAME",
                        help=f"a scene; may be repeated (default: {', '.join(SCENES)}, and {FINEST_SCENE} where its trees have been made)")
    parser.add_argument("--quick", action="store_true", help="few scenes, gestures and settings: to see whether all works")
    parser.add_argument("--gestures", type=int, metavar="N", help=f"of each scene and speed (default: {GESTURES})")
    parser.add_argument("--levels-only", action="store_true", help="the levels, and what they are chosen from, without the other knobs: half of the time")
    parser.add_argument("--held-out", action="store_true", help="gestures that no table of levels was made from, and the levels alone")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="gestures at once (default: the number of cores)")
    part = parser.add_mutually_exclusive_group()
    part.add_argument("--shard", metavar="K/N", help="play every N-th gesture alone, from the K-th on, and make no report")
    part.add_argument("--merge", nargs="+", type=pathlib.Path, default=[], metavar="DIR", help="outputs of shards to put together; nothing is played")
    parser.add_argument("--instructions", action="store_true", help="count instructions of the levels, too, by callgrind, which takes minutes")
    parser.add_argument("--write-levels", type=pathlib.Path, metavar="FILE", help="write the table of quality levels, core/scene/quality_levels.inc")


def _trouble_with(scene: str) -> str:
    """Why it cannot be played, as hapticd-model says; empty: it can."""
    explained = subprocess.run([find_program("hapticd-model"), "explain", scene], capture_output=True, text=True, check=False)
    return "" if explained.returncode == 0 else explained.stderr.strip().splitlines()[0]


def _usual_scenes() -> Sequence[str]:
    trouble = _trouble_with(FINEST_SCENE)
    if not trouble:
        return (*SCENES, FINEST_SCENE)
    print(f"without {FINEST_SCENE}: {trouble}", file=sys.stderr)
    return SCENES


def _named_scenes(scenes: Sequence[str]) -> Sequence[str]:
    """BadStudy where one of them cannot be played."""
    for scene in scenes:
        trouble = _trouble_with(scene)
        if trouble:
            raise BadStudy(f"--scene: {trouble}")
    return scenes


def plan_of(options: argparse.Namespace) -> Plan:
    """What the options ask for. BadStudy where that cannot be played."""
    if options.merge:
        return plan_of_shards(options.merge)
    scenes = tuple(_named_scenes(options.scene) if options.scene else QUICK_SCENES if options.quick else _usual_scenes())
    gestures = options.gestures or (QUICK_GESTURES if options.quick else GESTURES)
    return Plan(scenes, gestures, QUICK_SPEEDS if options.quick else SPEEDS, options.quick, 1 + (HELD_OUT if options.held_out else 0),
                options.held_out or options.levels_only)


def _play(options: argparse.Namespace, plan: Plan) -> None:
    units = shard_of(plan.units(), options.shard) if options.shard else plan.units()
    claim(options.output, plan)
    if options.merge:
        gather(options.merge, options.output)
        return
    try:
        play_all(units, plan, options.output, options.jobs)
    except OracleError:
        give_back(options.output)
        raise


def run(options: argparse.Namespace) -> int:
    """The command; its exit code."""
    if options.jobs < 1 or (options.gestures is not None and options.gestures < 1):
        print("hapticd-lab tradeoff: --jobs and --gestures want a number above 0", file=sys.stderr)
        return 1
    try:
        plan = plan_of(options)
        _play(options, plan)
        if options.shard:
            return 0
        left = missing(plan, options.output)
        if left:
            raise BadStudy(f"{len(left)} of {len(plan.units())} units are not there: {', '.join(unit.name for unit in left[:5])}...; "
                           "name all shards, or run those that were ended again")
        rows = tradeoff_table.rows_of(plan, options.output)
        tradeoff_table.write_tables(rows, options.output)
        facts = machine.facts()
        machine.write(facts, options.output / "machine.txt")
        counts = tradeoff_instructions.count(plan) if options.instructions else {}
        tradeoff_report.write(plan, rows, counts, facts, options.output)
        if options.write_levels:
            options.write_levels.write_text(quality_table.text_of(plan, rows), encoding="utf-8")
    except (BadStudy, NoLevels, OracleError) as error:
        print(f"hapticd-lab tradeoff: {error}", file=sys.stderr)
        return 1
    print(options.output / "report.html")
    return 0
