"""The exact statics against closed forms, against its own starting points and against chance; and what the comparison makes of a skin."""
import math
import sys
import unittest

import comparison
import kinds
import numpy as np
import statics

CENTRE = np.eye(3)
TIP, RADIUS = kinds.TIP, kinds.STRING_RADIUS
TOP = TIP + RADIUS
ONE = [((0, 0, 0), TIP)]
ALONG_X = ((-0.55, 0, 0), (0.55, 0, 0), RADIUS)


def down(scene, x, y, z, steps=6):
    """The rest under a hand that comes straight down to (x, y, z)."""
    return statics.follow(scene, [(np.array([x, y + (0.008 - 0.008 * k / steps), z]), CENTRE) for k in range(steps + 1)])[-1]


class ClosedForms(unittest.TestCase):
    def test_on_a_line_the_force_is_kt_times_the_overlap_along_the_line_of_centres(self):
        scene = statics.Scene(ONE, lines=[ALONG_X])
        for y, z in ((0.005, 0.0), (0.003, 1e-3), (0.0011, -2.5e-3)):
            distance = math.hypot(y, z)
            truth = 1000.0 * (TOP - distance) * np.array([0, y, z]) / distance
            np.testing.assert_allclose(down(scene, 0.1, y, z).force, truth, atol=1e-9)

    def test_between_two_lines_it_is_held_where_both_are_touched(self):
        for half in (1e-3, 3e-3, 5e-3):
            scene = statics.Scene(ONE, lines=[((-0.5, 0, z), (0.5, 0, z), RADIUS) for z in (half, -half)])
            height = math.sqrt(TOP**2 - half**2)
            rest = down(scene, 0.0, height - 3e-3, 1e-4)
            np.testing.assert_allclose(rest.force, [0, 3.0, -0.1], atol=1e-9)

    def test_through_a_lever_the_torques_balance(self):
        arm, depth = 0.06, 2e-3
        scene = statics.Scene([((arm, 0, 0), TIP)], lines=[((0, 0, -0.5), (0, 0, 0.5), RADIUS)])
        rest = down(scene, -arm, TOP - depth, 0.0)
        self.assertAlmostEqual(rest.torque[2] / (scene.kr * statics.rotation_vector(rest.R_G)[2]), 1.0, 9)
        lever = rest.R_G @ np.array([arm, 0, 0])
        np.testing.assert_allclose(np.cross(lever, rest.force), rest.torque, atol=1e-9)
        contact = rest.p_G + lever
        np.testing.assert_allclose(np.linalg.norm(contact[:2]), TOP, atol=1e-12)

    def test_in_the_middle_of_a_string_the_two_legs_touch_the_tip_and_bear_it(self):
        string = statics.String(ALONG_X[0], ALONG_X[1], RADIUS, 30.0, 190e9 * math.pi * RADIUS**2)
        scene = statics.Scene(ONE, strings=[string])
        for depth in (0.5e-3, 2e-3, 4e-3):
            low, high = 0.0, 0.1
            for _ in range(200):
                angle = 0.5 * (low + high)
                ext = 1.1 * (1 / math.cos(angle) - 1)
                # The slope of the energy over the height: the legs bear the tip beside their vertex.
                force = 2 * (30.0 + string.axial * ext / 1.1) * math.sin(angle) / (1 - TOP * math.sin(angle) / 0.55)
                height = TOP / math.cos(angle) - 0.55 * math.tan(angle)
                low, high = (angle, high) if force < 1000.0 * (height - (TOP - depth)) else (low, angle)
            np.testing.assert_allclose(down(scene, 0.0, TOP - depth, 0.0).force, [0, force, 0], atol=1e-7)

    def test_a_string_pulls_by_its_energy(self):
        random = np.random.default_rng(4)
        string = statics.String((0.1, 0.2, 0.3), (0.7, 0.1, 0.2), RADIUS, 25.0, 3e4)
        for _ in range(20):
            p = string.a + random.uniform(0.02, 0.98) * (string.b - string.a) + random.uniform(-5e-3, 5e-3, 3)
            legs = np.linalg.norm(p - string.a) + np.linalg.norm(string.b - p) - string.length
            energy, gradient = string.energy(p)
            self.assertAlmostEqual(energy, 25.0 * legs + 3e4 * legs**2 / (2 * string.length), 12)
            h = 1e-6
            slopes = [(string.energy(p + h * e)[0] - string.energy(p - h * e)[0]) / (2 * h) for e in np.eye(3)]
            np.testing.assert_allclose(gradient, slopes, atol=1e-6)


class Convergence(unittest.TestCase):
    def test_every_rest_balances_touches_and_enters_nothing(self):
        for make in kinds.RESTING + kinds.MOVING:
            for _, _, rests in kinds.draw(make, 5, 1):
                for rest in rests:
                    self.assertLess(rest.balance, statics.BALANCE_N)
                    self.assertLess(rest.worst_touch, statics.TOUCHING_M)
                    self.assertGreater(rest.smallest_gap, -statics.TOUCHING_M)
                    self.assertGreater(min(rest.touching.values(), default=0.0), -1e-6)

    def test_another_way_to_the_same_place_ends_in_the_same_rest(self):
        for make in kinds.RESTING:
            for case, _, (rest,) in kinds.draw(make, 6, 1):
                for steps in (4, 13):
                    _, (other,) = case.truths(steps=steps)
                    np.testing.assert_allclose(other.force, rest.force, atol=1e-6, err_msg=case.kind)

    def test_no_place_nearby_that_enters_nothing_has_less_energy(self):
        random = np.random.default_rng(7)
        for make in kinds.RESTING:
            for case, _, (rest,) in kinds.draw(make, 8, 1):
                p, w = case.corners[-1]
                problem = statics.Problem(case.scene, (p, statics.rotation(w)), rest.vertices)
                x = np.concatenate((rest.x[:6], np.zeros(problem.size - 6)))
                energy = problem.energy(x)[0]
                tried = 0
                for _ in range(3000):
                    near = x + random.normal(size=problem.size) * 10 ** random.uniform(-4, -0.5)
                    if problem.gaps(near)[0].min() >= 0:
                        tried += 1
                        self.assertGreater(problem.energy(near)[0] - energy, -1e-12, case.kind)
                self.assertGreater(tried, 20, case.kind)

    def test_a_balance_that_would_slip_off_is_refused(self):
        scene = statics.Scene(ONE, lines=[ALONG_X])
        with self.assertRaises(statics.NoRest):
            # Past the axis of the line the tip stands on its far side of the saddle.
            statics.solve(scene, (np.array([0.0, -1e-3, 0.0]), CENTRE), [0, 6.34, 0, 0, 0, 0])


class Controls(unittest.TestCase):
    """What the comparison would not let pass."""

    def test_surfaces_20_um_too_fat_are_red_in_every_kind(self):
        for make in kinds.RESTING + kinds.MOVING + [kinds.zero_overlap]:
            errors = comparison.fattened(make, 9, 2, 20e-6)
            print(f"{make.__name__}: 20 um are worth {1e3 * errors.worst:.2f} mN, {100 * errors.share:.2f} % rms")
            self.assertNotEqual(errors.failures(), [], make.__name__)

    def test_surfaces_a_tenth_of_a_micrometre_too_fat_are_green(self):
        for make in kinds.RESTING:
            self.assertEqual(comparison.fattened(make, 9, 2, 1e-7).failures(), [], make.__name__)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
