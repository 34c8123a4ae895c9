"""The arithmetic behind the pages: distances, descents and forces, against values known otherwise."""
import decimal
import math
import unittest

import numpy
from hapticd_lab import sphere_tree
from hapticd_lab.figures import descent, force_triangle, sphere_cylinder


class Distance(unittest.TestCase):
    def test_is_that_to_the_axis_and_lambda_runs_from_a_to_b(self):
        points = numpy.array([[0.0, 0.003, 0.004], [-0.55, 0.0, 0.01], [0.55, 0.02, 0.0], [0.66, 0.0, 0.005], [-0.605, 0.005, 0.0]])
        d, along = sphere_cylinder.equations(points)
        numpy.testing.assert_allclose(d, [0.005, 0.01, 0.02, 0.005, 0.005], rtol=1e-12)
        numpy.testing.assert_allclose(along, [0.5, 0.0, 1.0, 1.1, -0.05], atol=1e-12)

    def test_of_a_sphere_to_a_capsule_is_to_its_nearest_point(self):
        spheres = numpy.array([[0.1, 0.01, 0.0, 0.004], [0.553, 0.004, 0.0, 0.001]])
        expected = [0.01 - 0.004 - 0.00034, 0.005 - 0.001 - 0.00034]
        numpy.testing.assert_allclose(descent.gaps(spheres), expected, rtol=1e-12)


class Descent(unittest.TestCase):
    def tree(self):
        """A root with two bounds, one near the string and one far from it, and a leaf of its own that is near."""
        leaves = numpy.array(
            [[0.0, 0.01, 0.0, 0.009], [0.0, 0.03, 0.0, 0.009], [0.0, 1.0, 0.0, 0.01], [0.0, 1.1, 0.0, 0.01], [0.2, 0.002, 0.0, 0.001]]
        )
        near, far = numpy.array([0.0, 0.02, 0.0, 0.02]), numpy.array([0.0, 1.05, 0.0, 0.06])
        return sphere_tree.Tree(
            "", 0.0, leaves, [[(near, 1), (far, 2), (None, 4)], [(None, 0), (None, 1)], [(None, 2), (None, 3)]], [(3, 0, 0), (5, 0, 0)]
        )

    def test_looks_only_below_what_is_near_and_finds_what_is_near(self):
        levels, leaves = descent.descend(self.tree(), lambda spheres: spheres, 0.005)
        self.assertEqual(leaves, [0, 4])
        self.assertEqual([level.hit.tolist() for level in levels], [[True, False, True], [True, False]])

    def test_a_wider_reach_finds_more(self):
        self.assertEqual(descent.descend(self.tree(), lambda spheres: spheres, 2.0)[1], [0, 1, 2, 3, 4])


class Force(unittest.TestCase):
    def test_agrees_with_the_series_for_small_deflections(self):
        for place in (0.5, 0.25, 0.1):
            exact, printed, inner, lateral = force_triangle.eq_10(1e-6, place)
            first, second = place * 1.1, (1.0 - place) * 1.1
            self.assertAlmostEqual(float(exact) / (30.0 * 1e-6 * (1.0 / first + 1.0 / second)), 1.0, delta=1e-6)
            self.assertAlmostEqual(float(printed / exact), 1.0, delta=1e-10)
            self.assertAlmostEqual(
                float(inner) / (1.9e11 * math.pi * 0.34e-3**2 * 0.5e-12 * (1.0 / first + 1.0 / second) / 1.1), 1.0, delta=1e-6
            )
            self.assertAlmostEqual(float(lateral), 30.0 * 0.5e-12 * abs(1.0 / first**2 - 1.0 / second**2), delta=1e-16)

    def test_is_the_same_from_either_end(self):
        self.assertAlmostEqual(
            force_triangle.eq_10(5e-3, 0.1)[0] / force_triangle.eq_10(5e-3, 0.9)[0], decimal.Decimal(1), delta=decimal.Decimal("1e-15")
        )

    def test_the_sine_is_that_of_the_library(self):
        for x in (0.0, 1e-9, 0.3, -1.2, 3.0):
            self.assertAlmostEqual(float(force_triangle._sin(decimal.Decimal(x))), math.sin(x), delta=1e-16)


if __name__ == "__main__":
    unittest.main()
