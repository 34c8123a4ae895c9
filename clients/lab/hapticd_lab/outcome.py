"""What is left of a figure once its folder is written: what the report needs, small enough to go from process to process."""
from __future__ import annotations

import csv
import pathlib
import re
from dataclasses import dataclass, field
from typing import Dict, Iterable, List

from hapticd_lab import plots
from hapticd_lab.figure import DEVIATES, REPRODUCED, Claim, Figure, Spec

FAILED = "failed"
"""Not a verdict: the figure could not be made."""

CLAIM_COLUMNS = ("figure", "claim", "measured", "demanded", "verdict", "value", "unit", "source", "note")


@dataclass
class Outcome:
    """Files are named as in the figure's folder DIR/ID. `error`: why it could not be made, for people, with where it happened."""

    id: str
    title: str
    paper: str
    claims: List[Claim] = field(default_factory=list)
    notes: List[str] = field(default_factory=list)
    pictures: Dict[str, str] = field(default_factory=dict)
    tables: Dict[str, List[List[str]]] = field(default_factory=dict)
    traces: Dict[str, str] = field(default_factory=dict)
    plot: str = ""
    videos: List[str] = field(default_factory=list)
    verdict: str = FAILED
    elapsed_s: float = 0.0
    error: str = ""

    def count(self, verdict: str) -> int:
        """How many claims have that verdict."""
        return sum(claim.verdict == verdict for claim in self.claims)

    @property
    def deviations(self) -> List[str]:
        """Texts of the claims that do not hold."""
        return [claim.text for claim in self.claims if claim.verdict == DEVIATES]

    @property
    def counts(self) -> str:
        """12 of 14 claims hold."""
        if not self.claims:
            return "none"
        return f"{self.count(REPRODUCED)} of {len(self.claims)} claims hold"


def file_name(heading: str) -> str:
    """A heading as a name of a file."""
    return re.sub(r"[^a-z0-9]+", "_", heading.lower()).strip("_") or "run"


def write_claims(path: pathlib.Path, outcomes: Iterable[Outcome]) -> None:
    """One row a claim; `value` is the number behind `measured` in full, empty where there is none."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(CLAIM_COLUMNS)
        for outcome in outcomes:
            for claim in outcome.claims:
                value = "" if claim.value != claim.value else repr(float(claim.value))
                rows.writerow([outcome.id, claim.text, claim.measured, claim.demanded, claim.verdict, value, claim.unit, claim.source, claim.note])


def write_figure(figure: Figure, spec: Spec, folder: pathlib.Path) -> Outcome:
    """Writes traces, plot and claims of a figure that was made into its folder."""
    outcome = Outcome(figure.id, figure.title, figure.paper, figure.claims, figure.notes, figure.pictures, figure.tables,
                      verdict=figure.verdict)
    for heading, trace in figure.runs.items():
        outcome.traces[heading] = f"{file_name(heading)}.csv"
        trace.write_csv(folder / outcome.traces[heading])
    if figure.runs:
        outcome.plot = "plot"
        plots.draw_runs(figure.runs, f"{spec.id}: {figure.title}").save(folder / outcome.plot)
    write_claims(folder / "claims.csv", [outcome])
    outcome.videos = sorted(path.name for path in folder.glob("*.webm"))
    return outcome
