"""Reproduces figures of the paper: each as sessions with a real hapticd in lockstep, measured, plotted and judged.

Every figure gets a folder DIR/ID with the trace of each run (CSV), the plot (SVG and PNG) and its claims (CSV); all together
get DIR/report.html, to be held beside the paper, report.md, claims.csv and machine.txt.

Exit code: 0 every claim that can be checked holds; 3 some claim deviates, the report says why; 1 a figure could not be made, or
the command cannot be obeyed; 130 interrupted, what was finished is there."""
from __future__ import annotations

import argparse
import os
import pathlib
import sys
from typing import Any, List, Optional

from hapticd_lab import filming, machine, report, selection, worker
from hapticd_lab.figure import DEVIATES, Spec
from hapticd_lab.outcome import FAILED, Outcome, write_claims
from hapticd_lab.progress import Progress, duration

SUMMARY = "reproduce figures of the paper"


def describe(parser: argparse.ArgumentParser) -> None:
    """Its options."""
    parser.add_argument("id", nargs="*", metavar="ID", help="a figure, such as F15a, or a group, such as F15")
    parser.add_argument("--all", action="store_true", help="all figures")
    parser.add_argument("--list", action="store_true", help="list the figures and what must be seen in each")
    parser.add_argument("--output", type=pathlib.Path, metavar="DIR", help="where everything goes; made if it is not there")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="figures at once (default: the number of cores)")
    parser.add_argument("--variations", type=int, metavar="N", help="of the motions, speeds, hands and delays that a figure goes through so many "
                        "of each kind, spread evenly (default: all)")
    parser.add_argument("--video", nargs="+", default=[], metavar="ID", help="also write WebM videos of these figures, which are made too")


def _list(specs: List[Spec]) -> int:
    for spec in specs:
        print(f"{spec.id:5} {spec.title}: {spec.paper} ({duration(spec.cost_s)})")
    return 0


def _refuse(why: str) -> int:
    print(f"hapticd-lab repro: {why}. See hapticd-lab repro --help.", file=sys.stderr)
    return 1


def exit_code(outcomes: List[Outcome], interrupted: bool) -> int:
    """As the help says."""
    if interrupted:
        return 130
    if any(outcome.verdict == FAILED for outcome in outcomes):
        return 1
    return 3 if any(outcome.verdict == DEVIATES for outcome in outcomes) else 0


def _lab_opener(variations: Optional[int]) -> worker.LabMaker:
    def open_lab(_: Spec, folder: pathlib.Path) -> Any:
        from hapticd_lab.lab import Lab  # what starts hapticd is needed by the processes that make figures alone
        return Lab(folder, variations)
    return open_lab


def run(options: argparse.Namespace) -> int:
    """The command; its exit code."""
    offered = selection.offered()
    if options.list:
        return _list(offered)
    names = options.id + options.video
    if not names and not options.all:
        return _refuse("name figures, or say --all")
    if options.output is None:
        return _refuse("say where everything goes: --output DIR")
    if options.jobs < 1:
        return _refuse("--jobs needs a number above 0")
    if options.variations is not None and options.variations < 1:
        return _refuse("--variations needs a number above 0")
    try:
        named = selection.chosen(offered, names)
        to_film = selection.chosen(offered, options.video)
        specs = [filming.filmed(spec) if spec in to_film else spec for spec in (offered if options.all else named)]
    except selection.UnknownFigure as unknown:
        return _refuse(str(unknown))
    options.output.mkdir(parents=True, exist_ok=True)
    facts = machine.facts()
    machine.write(facts, options.output / "machine.txt")
    made = worker.make_all(specs, options.output, options.jobs, _lab_opener(options.variations), Progress({spec.id: spec.cost_s for spec in specs}, options.jobs))
    write_claims(options.output / "claims.csv", made.outcomes)
    report.write(made.outcomes, facts, options.output, [spec.id for spec in specs])
    _say(made, options.output, [spec.id for spec in specs])
    return exit_code(made.outcomes, made.interrupted)


def _say(made: worker.Made, output: pathlib.Path, ids: List[str]) -> None:
    for outcome in made.outcomes:
        why = f" ({outcome.error})" if outcome.error else ""
        print(f"{outcome.id:5} {outcome.verdict:18} {outcome.counts if outcome.claims else ''}{why}".rstrip())
    print(f"{output / 'report.html'}")
    if made.interrupted:
        finished = {outcome.id for outcome in made.outcomes}
        missing = ", ".join(each for each in ids if each not in finished)
        print(f"hapticd-lab: interrupted; the report has the {len(finished)} of {len(ids)} figures that are finished. Missing: {missing}",
              file=sys.stderr)
