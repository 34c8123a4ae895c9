"""The offset between two clocks against clocks made up here and in tests/protocol/data/clock_cases.json, whose offset and skew are therefore
known."""
import json
import pathlib
import random
import unittest

import support
from hapticd.clock import OffsetEstimator

SECOND = 1_000_000_000
CASES = pathlib.Path(__file__).resolve().parents[2] / "protocol/data/clock_cases.json"


def server_clock(ours_ns, offset_ns, skew):
    return int(ours_ns * (1 + skew)) + offset_ns


class Offset(unittest.TestCase):
    def exchanges(self, estimator, seed, offset_ns, skew, count=150, every_ns=200_000_000, there_ns=300_000, back_ns=300_000):
        """Exchanges over a road with delays of up to that much each way; returns our time of the last."""
        chance = random.Random(seed)
        now = 0
        for number in range(count):
            now = SECOND + number * every_ns
            arrived = now + chance.randrange(1000, there_ns)
            left = arrived + chance.randrange(1000, 50_000_000)
            back = left + chance.randrange(1000, back_ns)
            estimator.add(now, server_clock(arrived, offset_ns, skew), server_clock(left, offset_ns, skew), back)
        return now

    def test_is_within_its_own_error_however_unequal_the_ways(self):
        for seed in range(support.scaled(2000)):
            chance = random.Random(seed)
            estimator = OffsetEstimator()
            offset = chance.randrange(-10**15, 10**15)
            self.exchanges(estimator, seed, offset, 0.0, 20, there_ns=chance.choice((2000, 10**6, 10**8)), back_ns=chance.choice((2000, 10**6, 10**8)))
            estimate = estimator.estimate()
            self.assertLessEqual(abs(estimate.offset_ns - offset), estimate.error_ns + 1, f"seed {seed}")

    def test_finds_a_skew_of_200_ppm_within_2_ppm(self):
        for skew in (2e-4, -2e-4, 0.0):
            estimator = OffsetEstimator()
            self.exchanges(estimator, 1, 5 * SECOND, skew)
            self.assertLess(abs(estimator.estimate().skew - skew), 2e-6)

    def test_is_that_of_every_case_that_the_clients_share(self):
        cases = json.loads(CASES.read_text())
        self.assertGreater(len(cases), 8)
        for case in cases:
            with self.subTest(case["behaviour"]):
                estimator = OffsetEstimator()
                for exchange in case["exchanges"]:
                    estimator.add(*exchange)
                estimate = estimator.estimate(case["now_ns"])
                self.assertEqual(estimate is not None, "offset_ns" in case)
                if estimate is not None:
                    self.assertLessEqual(abs(estimate.offset_ns - case["offset_ns"]), case["offset_error_ns"])
                    self.assertLessEqual(abs(estimate.skew - case["skew"]), case["skew_error"])

    def test_nothing_is_known_before_the_first_exchange(self):
        self.assertIsNone(OffsetEstimator().estimate())

    def test_an_echo_that_is_repeated_adds_nothing(self):
        estimator = OffsetEstimator()
        estimator.add(1000, 5000, 5000, 2000)
        first = estimator.estimate()
        estimator.add(1000, 5000, 6000, 2500)
        self.assertEqual(estimator.estimate(), first)


if __name__ == "__main__":
    unittest.main()
