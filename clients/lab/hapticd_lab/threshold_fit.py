"""Criterion and noise of an observer with three answers, fitted to answers by maximum likelihood, with intervals of 95 % by the profile of the
likelihood: they hold for few answers too, and are open where the answers do not bound them."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Optional, Sequence, Tuple

import numpy
from scipy import optimize, stats

DROP = 0.5 * float(stats.chi2.ppf(0.95, 1))
LEAST, MOST = 1e-3, 1e3
"""Criterion and noise of ln force are sought between these."""


@dataclass(frozen=True)
class Bounded:
    """A value and its interval; an end that the answers do not bound is 0 or infinite."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Threshold:
    """`criterion`: the difference of ln force from which on it is reported, which is the one told in half of the trials; `sigma`: its noise."""

    criterion: Bounded
    sigma: Bounded


def likelihood(log_ratio: numpy.ndarray, answer: numpy.ndarray, criterion: float, sigma: float) -> float:
    """Logarithm of the probability of the answers: 1 the raised one is stiffer, 0 equal, -1 the reference is."""
    above = stats.norm.cdf((log_ratio - criterion) / sigma)
    below = stats.norm.cdf((-criterion - log_ratio) / sigma)
    equal = numpy.maximum(1.0 - above - below, 0.0)
    share = numpy.where(answer > 0, above, numpy.where(answer < 0, below, equal))
    return float(numpy.log(numpy.maximum(share, 1e-300)).sum())


def _profile(log_ratio: numpy.ndarray, answer: numpy.ndarray, index: int) -> Callable[[float], float]:
    """Largest likelihood by the logarithm of one of criterion (0) and sigma (1)."""
    def at(fixed: float) -> float:
        def lost(other: float) -> float:
            pair = (math.exp(fixed), math.exp(other)) if index == 0 else (math.exp(other), math.exp(fixed))
            return -likelihood(log_ratio, answer, *pair)

        grid = numpy.linspace(math.log(LEAST), math.log(MOST), 40)
        best = int(numpy.argmin([lost(each) for each in grid]))
        ends = (float(grid[max(best - 1, 0)]), float(grid[min(best + 1, len(grid) - 1)]))
        return -float(optimize.minimize_scalar(lost, bounds=ends, method="bounded", options={"xatol": 1e-6}).fun)

    return at


def _crossing(profile: Callable[[float], float], least: float, best: float, end: float) -> Optional[float]:
    """Where the profile falls below `least` between the best place and the end; None if it does not."""
    return float(optimize.brentq(lambda at: profile(at) - least, best, end, xtol=1e-4)) if profile(end) < least else None


def fit(log_ratio: Sequence[float], answer: Sequence[int]) -> Threshold:
    """To answers, at least one."""
    ratios, answers = numpy.asarray(log_ratio, float), numpy.asarray(answer, int)
    best: Tuple[float, float] = (0.0, 0.0)
    start = min(((math.log(c), math.log(s)) for c in (0.05, 0.2, 0.8) for s in (0.1, 0.4, 1.6)),
                key=lambda pair: -likelihood(ratios, answers, math.exp(pair[0]), math.exp(pair[1])))
    inside = (math.log(LEAST), math.log(MOST))
    found = optimize.minimize(lambda pair: -likelihood(ratios, answers, *numpy.exp(numpy.clip(pair, *inside))), start, method="Nelder-Mead",
                              options={"xatol": 1e-6, "fatol": 1e-9, "maxiter": 2000})
    best = tuple(float(each) for each in numpy.clip(found.x, *inside))
    bounded = []
    for index in (0, 1):
        profile = _profile(ratios, answers, index)
        least = -float(found.fun) - DROP
        low, high = (_crossing(profile, least, best[index], end) for end in inside)
        bounded.append(Bounded(math.exp(best[index]), 0.0 if low is None else math.exp(low), math.inf if high is None else math.exp(high)))
    return Threshold(*bounded)
