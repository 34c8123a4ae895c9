"""The trials of the experiment of Table 1: their plan, and the file of their answers, which loses nothing when it is interrupted."""
from __future__ import annotations

import csv
import io
import os
import pathlib
from dataclasses import dataclass, fields
from typing import Any, Dict, List, Sequence

import numpy

from hapticd_lab.observer import EQUAL, FIRST, SECOND
from hapticd_lab.published import INCREMENTS
from hapticd_lab.string_law import PARAMETERS, StringValues

REFERENCE = StringValues()


@dataclass(frozen=True)
class Trial:
    """One comparison: two strings, called A and B in the order in which they come. Nothing that is shown tells which is raised."""

    trial: int  # from 1
    parameter: str
    increment: float
    repetition: int  # from 1
    stiffer: str  # which of the two is raised: first or second

    @property
    def strings(self) -> Sequence[StringValues]:
        """A and B."""
        raised = REFERENCE.raised(self.parameter, self.increment)
        return (raised, REFERENCE) if self.stiffer == FIRST else (REFERENCE, raised)


@dataclass(frozen=True)
class Row:
    """A trial with its answer, as it is in trials.csv."""

    trial: int
    parameter: str
    increment: float
    repetition: int
    stiffer: str
    answer: str
    correct: int
    reference_value: float
    test_value: float
    peak_a_n: float
    peak_b_n: float
    log_ratio: float
    answered_utc: str
    answer_s: str


COLUMNS = tuple(field.name for field in fields(Row))

CODEBOOK = f"""# What the files of the experiment hold

UTF-8, comma-separated with a heading; R's `read.csv("trials.csv")` and Python's `pandas.read_csv("trials.csv")` read them directly. SI units.

## trials.csv, a row an answered trial, in the order in which they came
| column | meaning |
|---|---|
| trial | number of the trial, the first is 1 |
| parameter | what was raised: T tension (N), E Young's modulus (Pa), R radius (m) |
| increment | by what share: {", ".join(f"{each:g}" for each in INCREMENTS)} |
| repetition | which presentation of this parameter and increment, the first is 1 |
| stiffer | where the raised string was: first (A) or second (B); the participant is not told |
| answer | which was called stiffer: first, second or equal |
| correct | 1 if the answer is where the raised string was, else 0; equal is not correct |
| reference_value, test_value | value of the parameter in the reference and in the raised string |
| peak_a_n, peak_b_n | largest force on the tool while A and B were touched, N |
| log_ratio | ln of the raised string's force over the reference's: of a simulated observer by the peaks; of a person, who presses as he likes, by Eq. 10-12 at 7 mm, lambda 0.25 |
| answered_utc, answer_s | when, ISO 8601, and seconds from the end of B to the answer; empty for a simulated observer |

## ticks/NNN_A.csv, ticks/NNN_B.csv
Every tick of trial NNN while A or B could be touched: tick, t_s, force and torque on the tool (n, n_m), pose of hand (wh) and tool (wg) in the world, and the force of each object that was ever touched.
ticks/wall.csv and ticks/sphere.csv: the familiarisation before the first trial.

## questionnaire.csv, of people only
| column | meaning |
|---|---|
| metric | as in the paper's Table 2 |
| score | 0 to 100, 100 is like a real string |

## experiment.json
How the experiment was set up: seed of the order, repetitions, participant. The same seed gives the same order.
"""


def plan(seed: int, repetitions: int) -> List[Trial]:
    """All trials in random order; the raised string comes first or second by chance. The same seed gives the same plan."""
    random = numpy.random.Generator(numpy.random.PCG64(seed))
    cells = [(parameter, increment, repetition) for parameter in PARAMETERS for increment in INCREMENTS for repetition in range(1, repetitions + 1)]
    first = random.random(len(cells)) < 0.5
    order = numpy.argsort(random.random(len(cells)), kind="stable")
    return [Trial(number, *cells[i], FIRST if first[i] else SECOND) for number, i in enumerate(order, 1)]


class BadTrials(ValueError):
    """trials.csv is not of this experiment; the text says where."""


def _sync_folder(folder: pathlib.Path) -> None:
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


class TrialLog:
    """trials.csv: a line is on the disk before the next trial begins. A line that was cut off when the power ended is taken back with the first
    answer, and its trial is asked again; reading alone changes nothing."""

    def __init__(self, path: pathlib.Path, planned: Sequence[Trial]) -> None:
        self.path = path
        self.rows: List[Row] = []
        data = path.read_bytes() if path.exists() else b""
        self._whole_bytes = data.rfind(b"\n") + 1
        try:
            lines = list(csv.reader(data[:self._whole_bytes].decode("utf-8").splitlines()))
        except UnicodeDecodeError as error:
            raise BadTrials(f"{path}: {error}; restore the file, or start again in another folder") from error
        if lines and tuple(lines[0]) != COLUMNS:
            raise BadTrials(f"{path}:1: the heading is not {','.join(COLUMNS)}; name another folder")
        for number, line in enumerate(lines[1:], 2):
            self.rows.append(self._row(number, line, planned))

    def _row(self, number: int, line: Sequence[str], planned: Sequence[Trial]) -> Row:
        where = f"{self.path}:{number}"
        if len(line) != len(COLUMNS) or len(self.rows) >= len(planned):
            raise BadTrials(f"{where}: not a line of this experiment; restore the file, or start again in another folder")
        trial, cells = planned[len(self.rows)], dict(zip(COLUMNS, line))
        expected = (str(trial.trial), trial.parameter, f"{trial.increment:g}", str(trial.repetition), trial.stiffer)
        if tuple(line[:5]) != expected:
            raise BadTrials(f"{where}: trial {','.join(line[:5])} where the plan has {','.join(expected)}; restore the file, or start again in another folder")
        try:
            return Row(**{each.name: {"int": int, "float": float, "str": str}[str(each.type)](cells[each.name]) for each in fields(Row)})
        except ValueError as error:
            raise BadTrials(f"{where}: {error}; restore the file, or start again in another folder") from error

    def _append(self, cells: Sequence[Any]) -> None:
        """One line, on the disk; the first brings the heading with it."""
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        if self._whole_bytes == 0:
            rows.writerow(COLUMNS)
        rows.writerow(cells)
        with open(self.path, "ab") as file:
            file.truncate(self._whole_bytes)
            file.write(text.getvalue().encode("utf-8"))
            file.flush()
            os.fsync(file.fileno())
        if self._whole_bytes == 0:
            _sync_folder(self.path.parent)
        self._whole_bytes += len(text.getvalue().encode("utf-8"))

    def add(self, trial: Trial, answer: str, peaks_n: Sequence[float], log_ratio: float, answered: Sequence[str] = ("", "")) -> None:
        """The answer to the trial, on the disk when this returns."""
        reference, raised = (getattr(string, PARAMETERS[trial.parameter]) for string in (REFERENCE, REFERENCE.raised(trial.parameter, trial.increment)))
        row = Row(trial.trial, trial.parameter, trial.increment, trial.repetition, trial.stiffer, answer, int(answer == trial.stiffer), reference, raised,
                  peaks_n[0], peaks_n[1], log_ratio, *answered)
        cells = [getattr(row, name) for name in COLUMNS]
        self._append([f"{cell:.10g}" if isinstance(cell, float) else cell for cell in cells])
        self.rows.append(row)


def rates(rows: Sequence[Row]) -> Dict[str, List[float]]:
    """Rate of correct answers, %, by parameter for each increment; NaN where none was asked."""
    def one(parameter: str, increment: float) -> float:
        asked = [row.correct for row in rows if row.parameter == parameter and row.increment == increment]
        return 100.0 * sum(asked) / len(asked) if asked else float("nan")

    return {parameter: [one(parameter, increment) for increment in INCREMENTS] for parameter in PARAMETERS}


def judged(row: Row) -> int:
    """1 the raised string was called stiffer, 0 equal, -1 the reference was."""
    return 0 if row.answer == EQUAL else 1 if row.correct else -1
