"""A simulated person who is asked which of two strings is stiffer: Weber's law with noise and three answers. The person feels the logarithm of
the ratio of two peak forces, with noise of standard deviation sigma; beyond the criterion either way one of them is called stiffer, between them
they are called equal."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy
from scipy import stats

FIRST, SECOND, EQUAL = "first", "second", "equal"
ANSWERS = (FIRST, SECOND, EQUAL)
FELT_DEPTH_M, FELT_PLACE = 0.007, 0.25
"""Where and how deep the simulated person presses."""


@dataclass(frozen=True)
class WeberObserver:
    """`sigma`: noise of ln(F2/F1); `criterion`: its size from which on a difference is reported. As fixed for all comparisons with the
    paper; a study may take others."""

    sigma: float = 0.40
    criterion: float = 0.225

    def rate_correct(self, log_ratio: Any) -> Any:
        """How often the stiffer one of two is named, log_ratio = |ln(F2/F1)|."""
        return stats.norm.cdf((numpy.abs(log_ratio) - self.criterion) / self.sigma)

    def answer(self, first_n: float, second_n: float, noise: float) -> str:
        """The answer to two peak forces; `noise`: a draw from the standard normal distribution."""
        felt = math.log(second_n / first_n) + self.sigma * noise
        return EQUAL if abs(felt) < self.criterion else SECOND if felt > 0.0 else FIRST
