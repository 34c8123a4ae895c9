"""A tip that slides over the body of the Guqin feels at most a third of the ripple that the union of the spheres has, in force and in
direction, and sinks into the mesh no further; on random slides from a fixed seed and from a new one."""
import sys
import unittest

import comparison
import mesh_statics
import numpy as np
import played
import ripple

SLIDES = 5
# Of the rms of the same slides over the tree of the same balls that do not blend.
SHARE = 1 / 3
# How far a tip may sink into the mesh, um: rounding, and what hides between the samples of a fit.
SUNK_UM = 1.0
UNION = "guqin_body_250um.tree"


class Ripple(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.seed = comparison.new_seed()
        cls.tip = ripple.Tip()
        cls.tree, mesh = ripple.body_of("guqin")
        cls.statics = mesh_statics.Statics(mesh_statics.Mesh(ripple.ROOT / "deploy/models" / mesh), cls.tip)
        cls.slides = [slide for seed in (*comparison.FIXED_SEEDS, cls.seed) for slide in ripple.draw(cls.statics, seed, SLIDES)]

    def test_the_judge_sees_a_ripple_that_is_put_on_the_truth(self):
        plays = [(slide.truth, slide.hand[list(slide.chosen)] + slide.truth / ripple.KT_N_PER_M) for slide in self.slides]
        exact = ripple.judge(self.statics, self.slides, plays)
        self.assertLess(max(exact["rms_mn"], exact["rms_deg"], exact["sunk_um"]), 0.01)
        waves = [1 + 0.02 * np.sin(0.4 * np.arange(len(slide.truth)))[:, None] for slide in self.slides]
        rippled = ripple.judge(self.statics, self.slides, [(force * wave, p - 5e-6 * force) for (force, p), wave in zip(plays, waves)])
        self.assertGreater(rippled["rms_mn"], 10)
        self.assertGreater(rippled["sunk_um"], 3)

    def test_the_body_of_the_guqin_has_a_third_of_the_ripple_of_its_balls(self):
        with played.Player() as player:
            union, blend = (ripple.judge(self.statics, self.slides, [ripple.play(player, slide, self.tip, tree) for slide in self.slides])
                            for tree in (UNION, self.tree))
        print(f"union {union}\nblend {blend}", flush=True)
        for what in ("rms_mn", "rms_deg"):
            self.assertLess(blend[what], SHARE * union[what], (what, self.seed))
        self.assertLess(blend["sunk_um"], SUNK_UM, self.seed)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
