"""One-way analysis of variance, from groups or from what tables print of them."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy
from scipy import stats


@dataclass(frozen=True)
class Anova:
    """F(between, within) and its p; F is NaN where nothing varies within groups nor between them."""

    between: int
    within: int
    f: float
    p: float


def from_summary(means: Sequence[float], deviations: Sequence[float], count: int) -> Anova:
    """Of groups of `count` each, by their means and sample standard deviations."""
    means, deviations = numpy.asarray(means, float), numpy.asarray(deviations, float)
    between, within = len(means) - 1, len(means) * (count - 1)
    effect = count * float(numpy.sum((means - means.mean()) ** 2)) / between
    noise = float(numpy.mean(deviations ** 2))
    f = effect / noise if noise > 0.0 else numpy.nan if effect == 0.0 else numpy.inf
    return Anova(between, within, f, float(stats.f.sf(f, between, within)))


def of_groups(groups: Sequence[Sequence[float]]) -> Anova:
    """Of groups of equal size, a row each."""
    table = numpy.asarray(groups, float)
    return from_summary(table.mean(axis=1), table.std(axis=1, ddof=1), table.shape[1])
