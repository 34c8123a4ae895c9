"""A measured session as a CSV file: instants, the pose of the fingertip, and the wrench on the finger. A file that cannot be used is refused
with its line and what to do about it."""
from __future__ import annotations

import csv
import math
import pathlib
from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence

import numpy

REQUIRED = ("t_s", "p_x_m", "p_y_m", "p_z_m", "force_x_n", "force_y_n", "force_z_n")
ORIENTATION = ("q_w", "q_x", "q_y", "q_z")
TORQUE = ("torque_x_n_m", "torque_y_n_m", "torque_z_n_m")
PHASE = "phase"
FREE, PRESS, RING = "free", "press", "ring"
PHASES = (FREE, PRESS, RING)
"""Not touched; pressed while it does not vibrate; touched while it vibrates."""
UNIT_TOLERANCE = 0.01
"""Of a quaternion's length."""

HEADING_HELP = f"""The file is CSV with a heading; columns in any order, others are ignored; lines that begin with # are comments:
  {','.join(REQUIRED)}
time, place of the fingertip's centre (or of the contact, with --tip-radius 0) and force of the string on the finger, all in one frame.
Optional: {','.join(ORIENTATION)} orientation, needed by --tip; {','.join(TORQUE)} torque, checked but not used: a string pressed at a
point gives none; {PHASE} with {', '.join(PHASES)}: not touched, pressed at rest, touched while it vibrates. Without it the first touch
is taken for {PRESS}, later ones for {RING}; where forces are small against their noise, or it was pressed twice at rest, say it."""


class BadFile(ValueError):
    """The text has file, line and remedy."""


@dataclass
class Measured:
    """n samples in order of time. `phase` is empty where the file does not say."""

    t_s: numpy.ndarray  # n
    place_m: numpy.ndarray  # n x 3
    force_n: numpy.ndarray  # n x 3, on the finger
    orientation: Optional[numpy.ndarray]  # n x 4, w x y z
    torque_n_m: Optional[numpy.ndarray]  # n x 3
    phase: List[str]

    def __len__(self) -> int:
        return len(self.t_s)


def _refuse(path: pathlib.Path, line: int, what: str, remedy: str) -> BadFile:
    return BadFile(f"{path}:{line}: {what}; {remedy}")


def _check_heading(path: pathlib.Path, line: int, heading: Sequence[str]) -> None:
    missing = [name for name in REQUIRED if name not in heading]
    if missing:
        raise _refuse(path, line, f"the heading has no {', '.join(missing)}", f"name the columns {','.join(REQUIRED)}")
    twice = sorted({name for name in heading if heading.count(name) > 1})
    if twice:
        raise _refuse(path, line, f"the heading has {', '.join(twice)} more than once", "leave one")
    for group in (ORIENTATION, TORQUE):
        there = [name for name in group if name in heading]
        if there and len(there) < len(group):
            raise _refuse(path, line, f"the heading has {', '.join(there)} alone", f"give all of {','.join(group)}, or none")


def _number(path: pathlib.Path, line: int, name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _refuse(path, line, f"{name} is {text!r}, which is not a finite number", "correct it, or leave the line out")
    return value


class _Reader:
    """Row after row into columns."""

    def __init__(self, path: pathlib.Path, line: int, heading: Sequence[str]) -> None:
        self._path, self._heading = path, list(heading)
        self.names = [name for name in (*REQUIRED, *ORIENTATION, *TORQUE) if name in heading]
        self.columns: Dict[str, List[float]] = {name: [] for name in self.names}
        self.phase: List[str] = []
        _check_heading(path, line, heading)

    def take(self, line: int, row: Sequence[str]) -> None:
        if len(row) != len(self._heading):
            raise _refuse(self._path, line, f"{len(row)} fields where the heading has {len(self._heading)}", "complete the line, or leave it out")
        cells = dict(zip(self._heading, row))
        for name in self.names:
            self.columns[name].append(_number(self._path, line, name, cells[name]))
        times = self.columns["t_s"]
        if len(times) > 1 and times[-1] <= times[-2]:
            raise _refuse(self._path, line, f"t_s goes from {times[-2]:g} to {times[-1]:g}", "sort the lines by time, each instant once")
        if self.names[len(REQUIRED):len(REQUIRED) + 1] == ["q_w"]:
            length = math.sqrt(sum(self.columns[name][-1] ** 2 for name in ORIENTATION))
            if abs(length - 1.0) > UNIT_TOLERANCE:
                raise _refuse(self._path, line, f"the quaternion's length is {length:g}", "give unit quaternions, w first")
        if PHASE in cells:
            if cells[PHASE] not in PHASES:
                raise _refuse(self._path, line, f"{PHASE} is {cells[PHASE]!r}", f"use {', '.join(PHASES)}")
            self.phase.append(cells[PHASE])

    def measured(self) -> Measured:
        def table(names: Sequence[str]) -> numpy.ndarray:
            return numpy.array([self.columns[name] for name in names], float).reshape(len(names), -1).T

        return Measured(numpy.array(self.columns["t_s"], float), table(REQUIRED[1:4]), table(REQUIRED[4:7]),
                        table(ORIENTATION) if "q_w" in self.names else None, table(TORQUE) if TORQUE[0] in self.names else None, self.phase)


def read(path: pathlib.Path) -> Measured:
    """Reads the file. BadFile where it cannot be used, OSError where it cannot be opened."""
    reader = None
    with open(path, newline="", encoding="utf-8-sig") as file:
        try:
            rows = csv.reader(file)
            for row in rows:
                if not row or row[0].lstrip().startswith("#"):
                    continue
                cells = [cell.strip() for cell in row]
                if reader is None:
                    reader = _Reader(path, rows.line_num, cells)
                else:
                    reader.take(rows.line_num, cells)
        except (UnicodeDecodeError, csv.Error) as error:
            raise _refuse(path, rows.line_num + 1, f"this is not CSV text ({error})", "save it as CSV in UTF-8") from error
    if reader is None:
        raise _refuse(path, 1, "the file has no heading", f"begin it with {','.join(REQUIRED)}")
    return reader.measured()
