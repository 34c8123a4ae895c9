"""What the reproduction of a figure is: who makes it, what was measured, what is claimed of it, and the verdict."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Callable, Dict, List

from hapticd_lab.trace import Trace

REPRODUCED = "reproduced"
DEVIATES = "deviates"

WORDS = "words"
"""Source of a claim: the paper's text says it in words; the bound in numbers is ours."""
NUMBER = "number"
"""The paper's text says it with the number."""
OURS = "ours"
"""The paper does not ask for it."""


@dataclass(frozen=True)
class Claim:
    """One sentence with a number. `demanded` says the bound in words, `held` whether it was met. `note`: why it deviates, or where the
    bound comes from. `source`: WORDS, NUMBER or OURS."""

    text: str
    measured: str
    demanded: str
    held: bool
    value: float = math.nan
    unit: str = ""
    note: str = ""
    source: str = WORDS

    @property
    def verdict(self) -> str:
        return REPRODUCED if self.held else DEVIATES


def at_most(text: str, value: float, bound: float, unit: str, note: str = "", source: str = WORDS) -> Claim:
    """value <= bound; NaN never is."""
    return Claim(text, f"{value:.4g} {unit}".strip(), f"<= {bound:.4g} {unit}".strip(), bool(value <= bound), value, unit, note, source)


def at_least(text: str, value: float, bound: float, unit: str, note: str = "", source: str = WORDS) -> Claim:
    """value >= bound; NaN never is."""
    return Claim(text, f"{value:.4g} {unit}".strip(), f">= {bound:.4g} {unit}".strip(), bool(value >= bound), value, unit, note, source)


def is_so(text: str, held: bool, measured: str, demanded: str, note: str = "", source: str = WORDS) -> Claim:
    """What is no number."""
    return Claim(text, measured, demanded, bool(held), note=note, source=source)


@dataclass
class Figure:
    """A figure as it was reproduced. `runs`: traces by column heading ("paper", "deflecting"...), plotted side by side in the layout of
    the paper; `pictures`: further files in the figure's folder, file name to caption; `tables`: caption to rows, the first of them the
    heading; `notes`: paragraphs for the reader."""

    id: str
    title: str
    paper: str
    runs: Dict[str, Trace] = field(default_factory=dict)
    claims: List[Claim] = field(default_factory=list)
    notes: List[str] = field(default_factory=list)
    pictures: Dict[str, str] = field(default_factory=dict)
    tables: Dict[str, List[List[str]]] = field(default_factory=dict)

    @property
    def verdict(self) -> str:
        """Reproduced only when it has a claim, and every claim holds."""
        return REPRODUCED if self.claims and all(claim.held for claim in self.claims) else DEVIATES


@dataclass(frozen=True)
class Spec:
    """A figure that can be made. `id` as on the command line, such as F15a; `paper`: what must be seen, in our words; `make` gets a
    `Lab` (lab.py) and the Figure to fill in; `cost_s`: about how long it takes, for the time left."""

    id: str
    title: str
    paper: str
    make: Callable[["Lab", Figure], None]  # noqa: F821
    cost_s: float = 10.0
