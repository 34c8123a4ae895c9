"""The presentations of S4.3: paths go where they should, and neighbours are marked by the 7 % alone."""
import math
import unittest

import numpy
from hapticd_lab import selection
from hapticd_lab.figures import differentiation
from hapticd_lab.figures.differentiation import ALONG, CROSS, DEPTH_M, GESTURES, PLACES, SPEEDS_M_PER_S, STRINGS, Cell, Pair, neighbours, path

REFERENCE = STRINGS["reference"]
TOUCH_M = 5e-3 + 3.4e-4


class Paths(unittest.TestCase):
    def test_every_gesture_goes_as_deep_at_every_speed_and_place_and_no_faster_than_asked(self):
        for gesture in GESTURES:
            for speed in SPEEDS_M_PER_S:
                for place in PLACES:
                    poses, over = path(gesture, speed, place, REFERENCE)
                    played = poses[:over, :3]
                    self.assertLess(numpy.linalg.norm(numpy.diff(played, axis=0), axis=1).max(), speed * 1e-3 * (1.0 + 1e-9))
                    right_over = played[numpy.abs(played[:, 2]) < 1e-12]
                    self.assertAlmostEqual(TOUCH_M - right_over[:, 1].min(), DEPTH_M, 12)

    def test_a_slide_goes_along_a_crossing_across_and_both_begin_at_the_place(self):
        for gesture, axis in ((ALONG, 0), (CROSS, 2)):
            poses, over = path(gesture, 0.3, 0.2, REFERENCE)
            self.assertAlmostEqual(poses[0, 0], -0.3 * 1.1, 12)
            self.assertGreater(numpy.ptp(poses[:over, axis]), 0.02)
            self.assertEqual(numpy.ptp(poses[:over, 2 - axis]), 0.0)

    def test_a_raised_string_is_played_by_the_same_motion_from_where_it_is_met(self):
        for name, string in STRINGS.items():
            for gesture in GESTURES:
                poses, _ = path(gesture, 0.6, 0.4, string)
                again, _ = path(gesture, 0.6, 0.4, REFERENCE)
                lower = string.radius_m - REFERENCE.radius_m
                if name[0] != "R" or gesture != CROSS:
                    self.assertLess(numpy.abs(poses[:, :3] - again[:, :3] - [0.0, lower, 0.0]).max(), 1e-12, (name, gesture))


class Neighbours(unittest.TestCase):
    def cells(self, **more):
        return {(g, v, p, s): Cell(g, v, p, s, 1.0, 1e-3, 0.1, math.nan) for g in GESTURES for v in SPEEDS_M_PER_S for p in PLACES for s in STRINGS}

    def test_each_pair_differs_in_one_thing_and_none_is_missing(self):
        pairs = neighbours(self.cells())
        self.assertEqual(len(pairs), 3 * 4 * (4 * 5 + 5 * 4) + 3 * 25 * 3)
        for pair in pairs:
            self.assertEqual(sum(a != b for a, b in zip(pair.one, pair.other)), 1)
        self.assertEqual(len({(pair.one, pair.other) for pair in pairs}), len(pairs))

    def test_less_than_seven_percent_apart_is_imperceptible_and_silence_beside_silence_too(self):
        def mark(change):
            return Pair("speed", (), (), {"force": change}).imperceptible("force")
        self.assertEqual([mark(change) for change in (0.0, 0.0699, -0.0699, 0.07, -0.08, math.inf, math.nan)], [True, True, True, False, False, False, True])

    def test_changes_are_from_one_to_the_other(self):
        cells = self.cells()
        key = ("tap", 0.1, 0.3, "reference")
        cells[(*key[:3], "T + 50 %")] = Cell(*key[:3], "T + 50 %", 1.5, 0.0, 0.2, math.nan)
        pair = next(pair for pair in neighbours(cells) if pair.one == key and pair.differs_in == "T + 50 %")
        self.assertEqual(pair.changes, {"force": 0.5, "r_max": -1.0, "level": 1.0})

    def test_it_is_among_the_figures(self):
        self.assertEqual([spec.make for spec in selection.chosen(selection.offered(), ["S4.3"])], [differentiation.make])


if __name__ == "__main__":
    unittest.main()
