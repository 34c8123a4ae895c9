"""The report: one HTML file with everything inside, to be held beside the paper, and the same as Markdown with links to the files."""
from __future__ import annotations

import base64
import mimetypes
import pathlib
import re
from typing import Any, Dict, List, Sequence

import jinja2

from hapticd_lab.figure import DEVIATES, NUMBER, OURS, REPRODUCED, WORDS
from hapticd_lab.outcome import FAILED, Outcome

TEMPLATES = pathlib.Path(__file__).resolve().parent / "templates"
LARGEST_SVG = 600_000
"""Bytes beyond which a plot is embedded as PNG: browsers draw a long path anew at each scroll."""
MARKS = {REPRODUCED: "\N{CHECK MARK}", DEVIATES: "\N{NOT EQUAL TO}", FAILED: "\N{MULTIPLICATION X}"}
SOURCES = {WORDS: "text", NUMBER: "number", OURS: "ours"}


def _data_uri(path: pathlib.Path) -> str:
    kind = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"


def embedded_plot(folder: pathlib.Path, stem: str) -> str:
    """The plot to embed: SVG where it is small."""
    svg = folder / f"{stem}.svg"
    return _data_uri(svg if svg.stat().st_size <= LARGEST_SVG else folder / f"{stem}.png")


def _cell(text: Any) -> str:
    """A text as a cell of a Markdown table."""
    return str(text).replace("\\", "\\\\").replace("|", "\\|").replace("\n", " ").replace("<", "&lt;").replace(">", "&gt;")


def _pretty(text: Any) -> str:
    """Signs as they are printed: mu for micro, and those of bounds."""
    printed = str(text).replace("<=", "\N{LESS-THAN OR EQUAL TO}").replace(">=", "\N{GREATER-THAN OR EQUAL TO}")
    return re.sub(r"\bu([ms])\b", "\N{MICRO SIGN}\\1", printed)


def _is_number(text: str) -> bool:
    """Whether a cell is set to the right."""
    return re.match(r"[-+]?[0-9.]+(e[-+]?\d+)?( ?(%|[a-zA-Z/ ]{1,6}))?$", str(text)) is not None


def _counts(outcomes: Sequence[Outcome]) -> str:
    found = []
    for verdict, words in ((REPRODUCED, "reproduced"), (DEVIATES, "deviate"), (FAILED, "failed")):
        number = sum(outcome.verdict == verdict for outcome in outcomes)
        if verdict == DEVIATES and number == 1:
            words = "deviates"
        if number:
            found.append(f"{number} {words}")
    return ", ".join(found) or "none"


def environment(escape: bool) -> jinja2.Environment:
    """Where the templates are."""
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(TEMPLATES), autoescape=escape, trim_blocks=True, lstrip_blocks=True,
                                     undefined=jinja2.StrictUndefined, keep_trailing_newline=True)
    environment.filters.update(cell=_cell, pretty=_pretty, is_number=_is_number)
    environment.globals.update(marks=MARKS, sources=SOURCES, REPRODUCED=REPRODUCED, DEVIATES=DEVIATES, FAILED=FAILED)
    return environment


def write(outcomes: Sequence[Outcome], facts: Dict[str, str], output: pathlib.Path, wanted: List[str]) -> None:
    """Writes report.html and report.md into `output`. `wanted`: ids that were asked for; those without an outcome are named."""
    made = {outcome.id for outcome in outcomes}
    content = {"outcomes": outcomes, "facts": facts, "counts": _counts(outcomes), "missing": [each for each in wanted if each not in made],
               "plot": lambda outcome: embedded_plot(output / outcome.id, outcome.plot), "embed": lambda outcome, name: _data_uri(output / outcome.id / name)}
    for name, escape in (("report.html", True), ("report.md", False)):
        text = environment(escape).get_template(f"{name}.j2").render(content)
        (output / name).write_text(text, encoding="utf-8")
