"""Puts experiments of several participants together: rates of correct answers and scores of the questionnaire, with means and standard deviations,
analyses of variance, and a threshold fitted to all answers, beside the paper's Tables 1 and 2.

DIRs are the folders that hapticd-lab experiment wrote, one for each participant, all trials answered. --output gets rates.csv, scores.csv, group.md
and codebook.md; R's read.csv and Python's pandas.read_csv read the tables directly.

Exit code: 0 done; 1 a folder is refused, and why is said."""
from __future__ import annotations

import argparse
import csv
import json
import pathlib
import sys
from dataclasses import dataclass
from typing import Dict, List, Sequence

import numpy

from hapticd_lab import anova, threshold_fit
from hapticd_lab.published import ANOVAS, INCREMENTS, PARTICIPANTS, TABLE_1, TABLE_2
from hapticd_lab.string_law import PARAMETERS
from hapticd_lab.trials import BadTrials, Row, TrialLog, judged, plan, rates

SUMMARY = "put experiments of several participants together"
LEAST_PARTICIPANTS = 2

CODEBOOK = """# What the files of a group hold

## rates.csv, a row for each participant, parameter and increment
participant: folder of the experiment; parameter: T, E or R; increment: share by which it was raised; rate: correct answers, %; trials: how many were asked.

## scores.csv, a row for each participant and metric
participant: folder of the experiment; metric: as in the paper's Table 2; score: 0 to 100, 100 is like a real string.
"""


@dataclass(frozen=True)
class Member:
    """One participant."""

    name: str
    rows: List[Row]
    scores: Dict[str, float]


def describe(parser: argparse.ArgumentParser) -> None:
    """Its options."""
    parser.add_argument("folder", type=pathlib.Path, nargs="+", metavar="DIR", help="an experiment of one participant")
    parser.add_argument("--output", type=pathlib.Path, metavar="DIR", required=True, help="where everything goes; made if it is not there")


def read_member(folder: pathlib.Path) -> Member:
    """The folder of one experiment. BadTrials says what is missing."""
    settings_path = folder / "experiment.json"
    if not settings_path.exists():
        raise BadTrials(f"{folder} has no experiment.json: name folders that hapticd-lab experiment wrote")
    try:
        settings = json.loads(settings_path.read_text(encoding="utf-8"))
        planned = plan(settings["seed"], settings["repetitions"])
    except (ValueError, KeyError, TypeError) as error:
        raise BadTrials(f"{settings_path}: {error!r}; restore the file, or leave the folder out") from error
    rows = TrialLog(folder / "trials.csv", planned).rows if (folder / "trials.csv").exists() else []
    if len(rows) < len(planned):
        raise BadTrials(f"{folder} has {len(rows)} of {len(planned)} trials: go on with hapticd-lab experiment --output {folder} --resume, or leave it out")
    return Member(str(folder), rows, _read_scores(folder / "questionnaire.csv"))


def _read_scores(path: pathlib.Path) -> Dict[str, float]:
    if not path.exists():
        return {}
    found = {}
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.DictReader(file)
        for row in rows:
            try:
                found[row["metric"]] = float(row["score"])
            except (KeyError, TypeError, ValueError) as error:
                raise BadTrials(f"{path}:{rows.line_num}: {error!r}; restore the file, or leave the folder out") from error
    return found


def _spread(values: Sequence[float]) -> str:
    return f"{numpy.mean(values):.1f} \N{PLUS-MINUS SIGN} {numpy.std(values, ddof=1):.1f}" if len(values) > 1 else f"{values[0]:.1f}" if values else "none"


def _rate_lines(members: Sequence[Member]) -> List[str]:
    found = [rates(member.rows) for member in members]
    lines = ["| raised | +30 % | +40 % | +50 % | paper +30 % | paper +40 % | paper +50 % |", "|---|---|---|---|---|---|---|"]
    for name, printed in TABLE_1.items():
        ours = [_spread([one[name][level] for one in found]) for level in range(len(INCREMENTS))]
        theirs = [f"{mean} \N{PLUS-MINUS SIGN} {deviation}" for mean, deviation in zip(printed.means, printed.deviations)]
        lines.append(f"| {name} | {' | '.join(ours + theirs)} |")
    lines += ["", "| raised | levels | one-way analysis of this group | printed | recomputed from the printed table |", "|---|---|---|---|---|"]
    for name, printed in ANOVAS.items():
        here = anova.of_groups([[one[name][level] for one in found] for level in printed.levels])
        again = anova.from_summary([TABLE_1[name].means[i] for i in printed.levels], [TABLE_1[name].deviations[i] for i in printed.levels], PARTICIPANTS)
        levels = ", ".join(f"{100.0 * INCREMENTS[level]:.0f} %" for level in printed.levels)
        lines.append(f"| {name} | {levels} | {_anova_text(here)} | F{printed.degrees} = {printed.f}, p = {printed.p} | {_anova_text(again)} |")
    return lines


def _anova_text(found: anova.Anova) -> str:
    return f"F({found.between}, {found.within}) = {found.f:.3f}, p = {found.p:.3f}"


def _score_lines(members: Sequence[Member]) -> List[str]:
    asked = [member for member in members if member.scores]
    lines = ["", f"Questionnaire of {len(asked)} of them, mean and standard deviation:", "", "| metric | this group | paper's four players |", "|---|---|---|"]
    return lines + [f"| {name} | {_spread([member.scores[name] for member in asked if name in member.scores])} | "
                    f"{printed.mean} \N{PLUS-MINUS SIGN} {printed.deviation} |" for name, printed in TABLE_2.items()]


def group_text(members: Sequence[Member]) -> str:
    """The group beside the paper, Markdown."""
    rows = [row for member in members for row in member.rows]
    threshold = threshold_fit.fit([row.log_ratio for row in rows], [judged(row) for row in rows])
    lines = [f"# {len(members)} participants, {len(rows)} trials", "", "Rate of correct identification, %, mean and standard deviation over the participants:", ""]
    lines += _rate_lines(members) + _score_lines(members)
    for name, each in (("criterion", threshold.criterion), ("noise", threshold.sigma)):
        lines += ["", f"Three-answer Weber model of all answers together, {name} of ln force: {each.value:.3f} ({each.low:.3f} to {each.high:.3f})."]
    return "\n".join([*lines, ""])


def _write(output: pathlib.Path, members: Sequence[Member]) -> None:
    with open(output / "rates.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(("participant", "parameter", "increment", "rate", "trials"))
        for member in members:
            found = rates(member.rows)
            for parameter in PARAMETERS:
                for level, increment in enumerate(INCREMENTS):
                    trials = sum(row.parameter == parameter and row.increment == increment for row in member.rows)
                    table.writerow((member.name, parameter, f"{increment:g}", f"{found[parameter][level]:.10g}", trials))
    with open(output / "scores.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(("participant", "metric", "score"))
        table.writerows((member.name, metric, f"{score:g}") for member in members for metric, score in member.scores.items())


def run(options: argparse.Namespace) -> int:
    """The command; its exit code."""
    try:
        if len({folder.resolve() for folder in options.folder}) < max(LEAST_PARTICIPANTS, len(options.folder)):
            raise BadTrials(f"a group is {LEAST_PARTICIPANTS} participants or more, each named once")
        members = [read_member(folder) for folder in options.folder]
    except BadTrials as refused:
        print(f"hapticd-lab group: {refused}", file=sys.stderr)
        return 1
    options.output.mkdir(parents=True, exist_ok=True)
    _write(options.output, members)
    (options.output / "codebook.md").write_text(CODEBOOK, encoding="utf-8")
    text = group_text(members)
    (options.output / "group.md").write_text(text, encoding="utf-8")
    print(text)
    return 0
