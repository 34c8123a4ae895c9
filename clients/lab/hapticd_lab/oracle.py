"""The programs that are called: hapticd itself, and hapticd-oracle, the arithmetic in C++ that judges a session from outside."""
from __future__ import annotations

import csv
import io
import os
import pathlib
import shutil
import subprocess
from typing import Dict

import numpy


SHOWN_WORDS = 8
"""Of a command that failed; a study's have a hundred."""


class OracleError(RuntimeError):
    """hapticd-oracle refused; the text is what it said."""


def find_program(name: str) -> str:
    """A program of ours: named by the environment (HAPTICD for hapticd, HAPTICD_ORACLE for hapticd-oracle...), else on the PATH, where the
    launcher puts its own folder first."""
    found = os.environ.get(name.upper().replace("-", "_")) or shutil.which(name)
    if found is None:
        raise FileNotFoundError(f"{name} is not installed: put it on the PATH, or name it in {name.upper().replace('-', '_')}")
    return found


def call(*arguments: str) -> str:
    """What hapticd-oracle prints."""
    done = subprocess.run([find_program("hapticd-oracle"), *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        shown = [*arguments[:SHOWN_WORDS], *(["..."] if len(arguments) > SHOWN_WORDS else [])]
        raise OracleError(f"hapticd-oracle {' '.join(shown)}: {done.stderr.strip() or done.returncode}")
    return done.stdout


def table(text: str) -> Dict[str, numpy.ndarray]:
    """Columns by name of a table with a heading."""
    rows = list(csv.reader(io.StringIO(text)))
    columns = numpy.array([[float(value or "nan") for value in row] for row in rows[1:]]).reshape(-1, len(rows[0]))
    return {name: columns[:, i] for i, name in enumerate(rows[0])}


def poses(gesture: str | pathlib.Path, scene: str | pathlib.Path, rate_hz: float = 1000.0, tool_id: int = 0) -> numpy.ndarray:
    """X_DH along a gesture, n x 7 (position, quaternion w x y z), by the loader of the daemon."""
    columns = table(call("poses", str(gesture), "--scene", str(scene), "--rate", f"{rate_hz:g}", "--tool", str(tool_id)))
    return numpy.column_stack([column for name, column in columns.items() if name != "t_s"])


def baseline(recording: pathlib.Path, method: str, *options: str) -> Dict[str, numpy.ndarray]:
    """Another method on the poses of a recording: "paper", as it is printed, or "penalty". Columns as hapticd-oracle baseline writes them,
    a row for each tick."""
    return table(call("baseline", "--method", method, *options, str(recording)))
