"""Verdicts: of claims with bounds, of what is not a number, and of figures."""
import math
import unittest

import numpy
from hapticd_lab.figure import DEVIATES, OURS, REPRODUCED, WORDS, Figure, at_least, at_most, is_so

GOOD = at_most("good", 1.0, 2.0, "N")
BAD = at_most("bad", 3.0, 2.0, "N")


class Claims(unittest.TestCase):
    def test_a_bound_that_is_met_exactly_holds(self):
        self.assertEqual(at_most("", 2.0, 2.0, "N").verdict, REPRODUCED)
        self.assertEqual(at_least("", 2.0, 2.0, "N").verdict, REPRODUCED)

    def test_beyond_the_bound_it_deviates(self):
        self.assertEqual(at_most("", math.nextafter(2.0, 3.0), 2.0, "N").verdict, DEVIATES)
        self.assertEqual(at_least("", math.nextafter(2.0, 1.0), 2.0, "N").verdict, DEVIATES)

    def test_what_is_not_a_number_never_holds(self):
        for bound in (at_most, at_least):
            self.assertEqual(bound("", math.nan, 2.0, "N").verdict, DEVIATES)
            self.assertEqual(bound("", 2.0, math.nan, "N").verdict, DEVIATES)

    def test_the_texts_have_number_and_unit(self):
        claim = at_least("force", 12.3456, 0.5, "N", "why")
        self.assertEqual((claim.measured, claim.demanded, claim.note, claim.source), ("12.35 N", ">= 0.5 N", "why", WORDS))
        self.assertEqual(at_most("ratio", 0.5, 1.0, "").measured, "0.5")

    def test_a_source_is_kept(self):
        self.assertEqual(at_most("", 1.0, 2.0, "N", source=OURS).source, OURS)
        self.assertEqual(is_so("", True, "a", "a", source=OURS).source, OURS)

    def test_truth_values_of_numpy_are_truth_values(self):
        self.assertIs(is_so("", numpy.bool_(True), "", "").held, True)
        self.assertIs(at_most("", numpy.float64(1.0), 2.0, "").held, True)


class Figures(unittest.TestCase):
    def verdict(self, *claims):
        return Figure("F1", "", "", claims=list(claims)).verdict

    def test_every_claim_must_hold(self):
        self.assertEqual(self.verdict(GOOD, GOOD), REPRODUCED)
        self.assertEqual(self.verdict(GOOD, BAD), DEVIATES)

    def test_without_a_claim_nothing_is_reproduced(self):
        self.assertEqual(self.verdict(), DEVIATES)


if __name__ == "__main__":
    unittest.main()
