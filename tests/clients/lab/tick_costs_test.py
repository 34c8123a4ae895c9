"""What ticks cost is sorted to their poses, whatever a busy machine skips and loses."""
import unittest

import numpy
from hapticd_lab.tick_costs import TickCosts

from hapticd.v1 import state_pb2


def state(tick, row, cost_us):
    made = state_pb2.State(tick=tick)
    made.devices.add().p_dh_m[:] = row[:3]
    made.timing.last_ns = round(cost_us * 1e3)
    return made


class Sorted(unittest.TestCase):
    def setUp(self):
        self.random = numpy.random.default_rng()
        self.rows = numpy.concatenate((numpy.zeros((200, 7)), self.random.normal(size=(1000, 7)), numpy.ones((100, 7))))

    def play(self, skipped, lost):
        """States of ticks of which the share `skipped` never ran, and of the rest the share `lost` never arrived, each in runs of up to
        300; what each arrived one cost, by its row."""
        states, truth, row, tick = [], {}, 0, 7
        while row < len(self.rows):
            draw, many = self.random.random(), int(self.random.integers(1, 300))
            if draw < skipped:
                tick += many
            elif draw < skipped + lost:
                tick, row = tick + many, row + many
            else:
                for _ in range(min(many, len(self.rows) - row)):
                    truth[row] = float(self.random.integers(1, 1000))
                    states.append(state(tick, self.rows[row], truth[row]))
                    tick, row = tick + 1, row + 1
        return states, truth

    def test_every_state_that_arrives_is_sorted_to_its_own_pose(self):
        for _ in range(50):
            states, truth = self.play(0.2, 0.3)
            costs = TickCosts(self.rows)
            half = len(states) // 2
            costs.take(states[:half])
            costs.take(states[half:])
            moving = {row: cost for row, cost in truth.items() if 200 <= row < 1200}
            found = {row: costs.us[row] for row in range(200, 1200) if not numpy.isnan(costs.us[row])}
            self.assertEqual(found, moving)

    def test_a_state_of_no_pose_is_passed_over(self):
        costs = TickCosts(self.rows)
        costs.take([state_pb2.State(tick=1), state(2, [9.0] * 7, 5.0), state(3, self.rows[0], 6.0)])
        self.assertEqual([costs.us[0], int(numpy.isfinite(costs.us).sum())], [6.0, 1])


if __name__ == "__main__":
    unittest.main()
