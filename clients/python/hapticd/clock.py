"""The server's clock relative to ours: PROTOCOL.md section 7. All times in ns; offset = server's clock minus ours."""
from __future__ import annotations

import math
from collections import deque
from typing import Deque, NamedTuple, Optional, Tuple

EXCHANGES = 8
"""The offset is that of the shortest round trip among this many."""
SKEW_SPAN_NS = 30_000_000_000
"""The skew is fitted over this long a time."""
SHORTEST_SPAN_NS = 5_000_000_000
"""Over a shorter time the skew drowns in the error of the offsets, and is taken to be 0."""
FEWEST_POINTS = 8
"""No line is fitted to fewer exchanges."""
MOST_SKEW = 500e-6
"""No two machines differ by more: what an offset may have drifted by while the skew is unknown."""
LEAST_SKEW_ERROR = 1e-6
"""What the error of a skew is at least: quartz wanders that much within the span."""


class ClockEstimate(NamedTuple):
    """At one instant. `error_ns` bounds the error of `offset_ns`; `skew` is how much faster the server's clock runs, 1e-6 = 1 us per s."""

    offset_ns: int
    error_ns: int
    round_trip_ns: int
    skew: float


class _Exchange(NamedTuple):
    """The shortest round trip comes first; `at_ns` is the middle, by our clock."""

    round_trip_ns: int
    at_ns: int
    offset_ns: int


class OffsetEstimator:
    """Feed it every exchange. It believes the shortest round trip of the last eight, and carries its offset on with the skew that least
    squares over 30 s of those give. proto/wire/clock_estimate.cpp does the same."""

    def __init__(self) -> None:
        self._recent: Deque[_Exchange] = deque(maxlen=EXCHANGES)
        self._chosen: Deque[_Exchange] = deque()
        self._newest_echo = 0
        self._heard_ns = 0
        self._skew, self._skew_error = 0.0, MOST_SKEW

    def add(self, echoed_ns: int, received_ns: int, sent_ns: int, arrived_ns: int) -> None:
        """One exchange: the four instants in the order in which they happened. An echo seen before, and times that contradict each other,
        add nothing."""
        round_trip = (arrived_ns - echoed_ns) - (sent_ns - received_ns)
        if echoed_ns <= self._newest_echo or arrived_ns < echoed_ns or sent_ns < received_ns or round_trip < 0:
            return
        self._newest_echo, self._heard_ns = echoed_ns, arrived_ns
        offset = ((received_ns - echoed_ns) + (sent_ns - arrived_ns)) // 2
        self._recent.append(_Exchange(round_trip, echoed_ns + (arrived_ns - echoed_ns) // 2, offset))
        best = min(self._recent)
        if not self._chosen or best.at_ns > self._chosen[-1].at_ns:
            self._chosen.append(best)
        while self._chosen[-1].at_ns - self._chosen[0].at_ns > SKEW_SPAN_NS:
            self._chosen.popleft()
        self._skew, self._skew_error = self._fit()

    def estimate(self, now_ns: Optional[int] = None) -> Optional[ClockEstimate]:
        """The estimate at `now_ns` of our clock, by default when the last exchange arrived; None before the first one."""
        if not self._recent:
            return None
        best = min(self._recent)
        age = (self._heard_ns if now_ns is None else now_ns) - best.at_ns
        error = best.round_trip_ns // 2 + 1 + round(self._skew_error * abs(age))
        return ClockEstimate(best.offset_ns + round(self._skew * age), error, best.round_trip_ns, self._skew)

    def _fit(self) -> Tuple[float, float]:
        """Slope of the least-squares line through the chosen offsets, and three standard errors of it."""
        first, last, count = self._chosen[0], self._chosen[-1], len(self._chosen)
        if count < FEWEST_POINTS or last.at_ns - first.at_ns < SHORTEST_SPAN_NS:
            return 0.0, MOST_SKEW
        times = [float(each.at_ns - first.at_ns) for each in self._chosen]
        offsets = [float(each.offset_ns - first.offset_ns) for each in self._chosen]
        t_mean, y_mean = sum(times) / count, sum(offsets) / count
        squares = sum((t - t_mean) ** 2 for t in times)
        slope = sum((t - t_mean) * (y - y_mean) for t, y in zip(times, offsets)) / squares
        residual = sum((y - y_mean - slope * (t - t_mean)) ** 2 for t, y in zip(times, offsets))
        return min(max(slope, -MOST_SKEW), MOST_SKEW), LEAST_SKEW_ERROR + 3.0 * math.sqrt(residual / (count - 2.0) / squares)
