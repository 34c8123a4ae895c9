"""What hapticd-oracle finds in a recording: whether the tool's whole path stayed free, and what each object's nearest gap was, tick by tick,
by exhaustive search."""
from __future__ import annotations

import pathlib
from dataclasses import dataclass
from typing import Dict, List, Tuple

import numpy

from hapticd_lab import oracle
from hapticd_lab.trace import Trace

CONTACT_M = 25e-6
"""Nearer than this is in contact: the skin of 20 um at most, and what a step leaves."""


@dataclass
class Judgement:
    """Columns as long as the trace that was judged."""

    path_gap_m: numpy.ndarray  # n, smallest gap on the whole committed path of the tick; negative: it went through something
    gap_m: Dict[str, numpy.ndarray]  # n by object, at the committed pose; infinite when further than the oracle looks

    @property
    def penetration_m(self) -> float:
        """How deep the path was in anything at worst; 0 where it never was."""
        return max(0.0, float(-numpy.nanmin(self.path_gap_m)))

    def losses(self) -> List[Tuple[int, str]]:
        """Rows at which the last contact with an object is lost, and the object: where the force may drop."""
        found = []
        for name, gap in self.gap_m.items():
            near = gap <= CONTACT_M
            found += [(int(row) + 1, name) for row in numpy.flatnonzero(near[:-1] & ~near[1:])]
        return sorted(found)


def judge(recording: pathlib.Path, trace: Trace) -> Judgement:
    """The rows of the recording that are those of the trace."""
    columns = oracle.table(oracle.call("path", str(recording)))
    first = int(numpy.searchsorted(columns["tick"], trace.tick[0]))
    rows = slice(first, first + len(trace))
    if not numpy.array_equal(columns["tick"][rows], trace.tick):
        raise oracle.OracleError(f"{recording} lacks ticks of the session")
    gaps = {name[len("gap_of_"):-len("_m")]: numpy.where(numpy.isnan(column[rows]), numpy.inf, column[rows])
            for name, column in columns.items() if name.startswith("gap_of_")}
    return Judgement(columns["path_gap_m"][rows], gaps)
