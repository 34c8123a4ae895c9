"""The server's clock relative to ours: PROTOCOL.md section 7. All times in ns; offset = server's clock minus ours."""
from __future__ import annotations

from collections import deque
from typing import Deque, NamedTuple, Optional, Tuple

EXCHANGES = 8
"""The offset is that of the shortest round trip among this many."""
SKEW_SPAN_NS = 30_000_000_000
"""The skew is fitted over this long a time."""
SHORTEST_SPAN_NS = 5_000_000_000
"""Over a shorter time the skew drowns in the error of the offsets, and is taken to be 0."""


class ClockEstimate(NamedTuple):
    """`error_ns` bounds the error of `offset_ns`; `skew` is how much faster the server's clock runs, 1e-6 = 1 us per s."""

    offset_ns: int
    error_ns: int
    round_trip_ns: int
    skew: float


class OffsetEstimator:
    """Feed it every exchange; it keeps the best of the last eight and 30 s of them for the skew."""

    def __init__(self) -> None:
        self._recent: Deque[Tuple[int, int]] = deque(maxlen=EXCHANGES)
        self._history: Deque[Tuple[int, int]] = deque()
        self._newest_echo = 0

    def add(self, echoed_ns: int, received_ns: int, sent_ns: int, arrived_ns: int) -> None:
        """One exchange: the four instants in the order in which they happened. An echo seen before adds nothing."""
        if echoed_ns <= self._newest_echo:
            return
        self._newest_echo = echoed_ns
        round_trip = (arrived_ns - echoed_ns) - (sent_ns - received_ns)
        offset = ((received_ns - echoed_ns) + (sent_ns - arrived_ns)) // 2
        self._recent.append((round_trip, offset))
        self._history.append((arrived_ns, offset))
        while arrived_ns - self._history[0][0] > SKEW_SPAN_NS:
            self._history.popleft()

    def estimate(self) -> Optional[ClockEstimate]:
        """The estimate, or None before the first exchange."""
        if not self._recent:
            return None
        round_trip, offset = min(self._recent)
        return ClockEstimate(offset, max(round_trip, 0) // 2, round_trip, self._skew())

    def _skew(self) -> float:
        """Slope of the least-squares line through the offsets."""
        count = len(self._history)
        if self._history[-1][0] - self._history[0][0] < SHORTEST_SPAN_NS:
            return 0.0
        t0, y0 = self._history[0]
        t_mean = sum(t - t0 for t, _ in self._history) / count
        y_mean = sum(y - y0 for _, y in self._history) / count
        squares = sum((t - t0 - t_mean) ** 2 for t, _ in self._history)
        products = sum((t - t0 - t_mean) * (y - y0 - y_mean) for t, y in self._history)
        return products / squares if squares else 0.0
