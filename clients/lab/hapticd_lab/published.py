"""Tables 1 and 2 of the paper and the analyses of variance in its text, as printed. Rates and scores in %."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Tuple

PARTICIPANTS = 7
REPETITIONS = 3
INCREMENTS = (0.3, 0.4, 0.5)


@dataclass(frozen=True)
class Rates:
    """Rate of correct identification by increment: means and standard deviations over the participants."""

    means: Tuple[float, float, float]
    deviations: Tuple[float, float, float]


TABLE_1: Dict[str, Rates] = {
    "T": Rates((47.7, 52.4, 66.7), (26.5, 32.7, 27.4)),
    "E": Rates((38.0, 42.9, 42.9), (23.2, 37.2, 25.4)),
    "R": Rates((23.7, 33.3, 62.1), (25.2, 27.4, 12.9)),
}


@dataclass(frozen=True)
class PrintedAnova:
    """One-way, over the increments of those indices."""

    levels: Tuple[int, ...]
    degrees: Tuple[int, int]
    f: float
    p: float


ANOVAS: Dict[str, PrintedAnova] = {
    "T": PrintedAnova((0, 2), (1, 12), 6.153, 0.029),
    "E": PrintedAnova((0, 1, 2), (2, 18), 0.064, 0.938),
    "R": PrintedAnova((0, 1, 2), (2, 18), 5.462, 0.014),
}


@dataclass(frozen=True)
class Scores:
    """Scores of players 1 to 4, and mean and standard deviation as printed."""

    players: Tuple[float, float, float, float]
    mean: float
    deviation: float


TABLE_2: Dict[str, Scores] = {
    "Thin string sensation": Scores((90, 90, 90, 90), 90.0, 0.0),
    "String smoothness": Scores((100, 90, 95, 50), 83.8, 22.9),
    "Elastic sensation": Scores((90, 30, 95, 60), 68.8, 30.1),
    "Diameter constancy": Scores((100, 60, 90, 90), 85.0, 17.3),
    "Decayed vibration": Scores((90, 90, 80, 100), 90.0, 8.2),
}
