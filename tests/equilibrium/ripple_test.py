"""The judge of ripple is red where there is one, on random slides from a fixed seed and from a new one."""
import sys
import unittest

import comparison
import mesh_statics
import numpy as np
import ripple

SLIDES = 5
MESH = ripple.ROOT / "deploy/models/guqin_body.ply"


class Ripple(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.seed = comparison.new_seed()
        cls.tip = ripple.Tip()
        cls.statics = mesh_statics.Statics(mesh_statics.Mesh(MESH), cls.tip)
        cls.slides = [slide for seed in (*comparison.FIXED_SEEDS, cls.seed) for slide in ripple.draw(cls.statics, seed, SLIDES)]

    def test_the_judge_sees_a_ripple_that_is_put_on_the_truth(self):
        plays = [(slide.truth, slide.hand[list(slide.chosen)] + slide.truth / ripple.KT_N_PER_M) for slide in self.slides]
        exact = ripple.judge(self.statics, self.slides, plays)
        self.assertLess(max(exact["rms_mn"], exact["rms_deg"], exact["sunk_um"]), 0.01)
        waves = [1 + 0.02 * np.sin(0.4 * np.arange(len(slide.truth)))[:, None] for slide in self.slides]
        rippled = ripple.judge(self.statics, self.slides, [(force * wave, p - 5e-6 * force) for (force, p), wave in zip(plays, waves)])
        self.assertGreater(rippled["rms_mn"], 10)
        self.assertGreater(rippled["sunk_um"], 3)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
