"""The force on a hand at rest and in motion is that of the exact statics (statics.py), in every kind of contact, at every quality from 2 on."""
import sys
import unittest

import comparison
import kinds
import played


class Equilibrium(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.player = played.Player()
        cls.player.__enter__()
        cls.seed = comparison.new_seed()

    @classmethod
    def tearDownClass(cls):
        cls.player.__exit__(None, None, None)

    def judge(self, make, fixed, new):
        seeds = [(seed, fixed) for seed in comparison.FIXED_SEEDS] + [(self.seed, new)]
        for setting, errors in comparison.compare(self.player, make, seeds, comparison.SETTINGS).items():
            print(f"{make.__name__}, {setting}: worst {1e3 * errors.worst:.3f} mN, {100 * errors.share:.4f} % rms of "
                  f"{len(errors.force)} forces", flush=True)
            with self.subTest(kind=make.__name__, setting=setting, new_seed=self.seed):
                self.assertEqual(errors.failures(), [])

    def test_a_hand_at_rest_feels_the_exact_force(self):
        for make in kinds.RESTING:
            self.judge(make, 6, 3)

    def test_a_hand_held_by_axes_that_differ_feels_the_exact_force_of_a_string(self):
        self.judge(kinds.uneven_string, 4, 2)

    def test_a_moving_hand_feels_the_exact_force_of_every_place(self):
        for make in kinds.MOVING:
            self.judge(make, 2, 1)

    def test_nothing_is_felt_where_nothing_overlaps(self):
        self.judge(kinds.zero_overlap, 6, 3)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
